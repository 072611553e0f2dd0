//! Time and temperature counted from the gauge zero.

use super::table::ReadingTable;

/// What has passed since the first accepted reading on a reading's gauge zero; `None` where it was not recorded.
///
/// The moment of zeroing itself is not in a table. The difference is the same for all readings of one zero and goes into its offset.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SinceZero {
    /// Time, s.
    pub time_s: Option<f64>,
    /// Temperature, K.
    pub warming_k: Option<f64>,
}

impl ReadingTable {
    /// Time and temperature since its gauge zero for each reading, in the order of the readings.
    #[must_use]
    pub fn since_zero(&self) -> Vec<SinceZero> {
        let count = self
            .readings
            .iter()
            .map(|reading| reading.zero as usize + 1);
        // Time of the earliest reading on each zero, with its temperature.
        let mut first: Vec<Option<(f64, Option<f64>)>> = vec![None; count.max().unwrap_or(0)];
        for reading in &self.readings {
            let Some(time_s) = reading.time_s.filter(|_| reading.is_accepted()) else {
                continue;
            };
            let known = &mut first[reading.zero as usize];
            if known.is_none_or(|(earliest_s, _)| time_s < earliest_s) {
                *known = Some((time_s, reading.temperature_deg_c));
            }
        }
        let since = |now: Option<f64>, then: Option<f64>| Some(now? - then?);
        self.readings
            .iter()
            .map(|reading| {
                let (zero_s, zero_deg_c) = first[reading.zero as usize].unzip();
                SinceZero {
                    time_s: since(reading.time_s, zero_s),
                    warming_k: since(reading.temperature_deg_c, zero_deg_c.flatten()),
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::readings::read_readings;

    #[test]
    fn each_zero_has_a_clock_and_a_thermometer_of_its_own() {
        let text = "pose,direction,repeat,force_N,displacement_um,t_s,temp_degC,status\n\
            P1,x,1,0,0,9,19.0,superseded\n\
            P1,x,1,0,0,10,20.0,accepted\n\
            P1,x,1,-10,-200,25,20.5,accepted\n\
            P1,x,2,0,0,100,21.0,accepted\n\
            P1,x,2,-10,-200,115,,accepted\n";
        let table = read_readings("r.csv", text.as_bytes()).unwrap();
        let since = table.since_zero();
        let times: Vec<f64> = since.iter().filter_map(|s| s.time_s).collect();
        assert_eq!(times, [-1.0, 0.0, 15.0, 0.0, 15.0]);
        let warming: Vec<Option<f64>> = since.iter().map(|s| s.warming_k).collect();
        assert_eq!(warming, [Some(-1.0), Some(0.0), Some(0.5), Some(0.0), None]);
        let bare = "pose,direction,repeat,force_N,displacement_um\nP1,x,1,-10,-200\n";
        let table = read_readings("r.csv", bare.as_bytes()).unwrap();
        assert_eq!(table.since_zero()[0].time_s, None);
    }
}
