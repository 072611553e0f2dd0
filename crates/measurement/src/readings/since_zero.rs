//! Time and temperature counted from the gauge zero.

use stiffbench_numeric::statistics::median;

use super::table::ReadingTable;

/// What has passed since a reading's gauge was zeroed; `None` where it was not recorded.
///
/// The moment of zeroing is not in a table. It is taken to lie before the first accepted reading on the zero by the median time
/// between the readings on it: the first load is set and settles like the others. A fast drift has moved on by then, in every run alike.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SinceZero {
    /// Time, s.
    pub time_s: Option<f64>,
    /// Temperature since the first accepted reading, K.
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
        // Times of the readings on each zero, with their temperatures.
        let mut times = vec![Vec::new(); count.max().unwrap_or(0)];
        for reading in self.accepted() {
            if let Some(time_s) = reading.time_s {
                times[reading.zero as usize].push((time_s, reading.temperature_deg_c));
            }
        }
        let zeros: Vec<_> = times.into_iter().map(moment_of_zero).collect();
        let since = |now: Option<f64>, then: Option<f64>| Some(now? - then?);
        self.readings
            .iter()
            .map(|reading| {
                let (zero_s, zero_deg_c) = zeros[reading.zero as usize].unzip();
                SinceZero {
                    time_s: since(reading.time_s, zero_s),
                    warming_k: since(reading.temperature_deg_c, zero_deg_c.flatten()),
                }
            })
            .collect()
    }
}

/// When a gauge was zeroed, s, and the temperature of the first reading on the zero; `None` without readings.
fn moment_of_zero(mut readings: Vec<(f64, Option<f64>)>) -> Option<(f64, Option<f64>)> {
    readings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut apart: Vec<f64> = readings.windows(2).map(|two| two[1].0 - two[0].0).collect();
    let (first_s, first_deg_c) = *readings.first()?;
    Some((first_s - median(&mut apart).unwrap_or(0.0), first_deg_c))
}

#[cfg(test)]
mod tests {
    use crate::readings::{ReadOptions, read_readings};

    #[test]
    fn each_zero_has_a_clock_and_a_thermometer_of_its_own() {
        let text = "pose,direction,repeat,force_N,displacement_um,t_s,temp_degC,status\n\
            P1,x,1,0,0,9,19.0,superseded\n\
            P1,x,1,0,0,10,20.0,accepted\n\
            P1,x,1,-10,-200,25,20.5,accepted\n\
            P1,x,2,0,0,100,21.0,accepted\n\
            P1,x,2,-10,-200,115,,accepted\n";
        let table = read_readings("r.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
        let since = table.since_zero();
        let times: Vec<f64> = since.iter().filter_map(|s| s.time_s).collect();
        // Readings on either zero are 15 s apart.
        assert_eq!(times, [14.0, 15.0, 30.0, 15.0, 30.0]);
        let warming: Vec<Option<f64>> = since.iter().map(|s| s.warming_k).collect();
        assert_eq!(warming, [Some(-1.0), Some(0.0), Some(0.5), Some(0.0), None]);
        let bare = "pose,direction,repeat,force_N,displacement_um\nP1,x,1,-10,-200\n";
        let table = read_readings("r.csv", bare.as_bytes(), &ReadOptions::default()).unwrap();
        assert_eq!(table.since_zero()[0].time_s, None);
    }
}
