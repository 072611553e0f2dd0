//! Profiles of patterns that belong to no law: over the load, its sign and branch, repeats, time.

use stiffbench_units_and_text::test_point::Branch;

use super::stratum::Stratum;
use crate::mismatch::observed::Observations;

/// A profile: what it is called under, and its values.
pub(crate) struct Profile {
    pub(crate) stratum: Stratum,
    /// Whether it is tried in proportion to the compliance too.
    pub(crate) scaled: bool,
    /// One a reading.
    pub(crate) values: Vec<f64>,
}

/// All profiles that these observations can show.
pub(crate) fn profiles(observations: &Observations) -> Vec<Profile> {
    let details = Details::of(observations);
    let mut out = Vec::new();
    load_profiles(&details, &mut out);
    repeat_profiles(&details, &mut out);
    time_profiles(&details, &mut out);
    if observations.recorded.hold {
        let (f, h) = (&details.load, &details.hold);
        let curved = |i: usize| f[i] * f[i].abs() * h[i];
        out.push(details.profile(Stratum::RepeatTime, true, |i| f[i] * h[i]));
        out.push(details.profile(Stratum::RepeatTime, true, curved));
    }
    out
}

/// What profiles are made of, one value a reading.
struct Details {
    /// Force over the largest.
    load: Vec<f64>,
    /// Whether the cell is loaded both ways.
    both_ways: Vec<bool>,
    /// 1 while unloading.
    unloading: Vec<f64>,
    /// Largest force of the run so far, over the largest of all.
    largest_so_far: Vec<f64>,
    /// Repeat, from 0.
    repeat: Vec<f64>,
    /// Time since the zero over the longest.
    within: Vec<f64>,
    /// Clock over the length of the session.
    clock: Vec<f64>,
    /// Logarithm of the time under load.
    hold: Vec<f64>,
    /// Longest time since a zero, s.
    longest_s: f64,
}

impl Details {
    fn of(observations: &Observations) -> Self {
        let loads = &observations.loads;
        let readings = &observations.readings;
        let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let largest = most(&mut loads.iter().map(|load| load.force_n.abs())).max(f64::MIN_POSITIVE);
        let longest_s = most(&mut loads.iter().map(|load| load.since_zero_s));
        let end = most(&mut readings.iter().filter_map(|r| r.time_s)).max(f64::MIN_POSITIVE);
        let unloading = |branch| f64::from(u8::from(branch == Branch::Unloading));
        let repeat = |run: usize| f64::from(observations.runs[run].repeat) - 1.0;
        let mut largest_so_far = vec![0.0; loads.len()];
        for run in &observations.runs {
            let mut most: f64 = 0.0;
            for reading in run.readings.clone() {
                most = most.max(loads[reading].force_n.abs() / largest);
                largest_so_far[reading] = most;
            }
        }
        let mut both_ways = vec![false; loads.len()];
        for cell in &observations.cells {
            let both = observations.is_loaded_both_ways(cell.readings.clone());
            both_ways[cell.readings.clone()].fill(both);
        }
        Self {
            largest_so_far,
            both_ways,
            load: loads.iter().map(|load| load.force_n / largest).collect(),
            unloading: readings.iter().map(|r| unloading(r.branch)).collect(),
            repeat: readings.iter().map(|r| repeat(r.run)).collect(),
            within: loads
                .iter()
                .map(|load| load.since_zero_s / longest_s.max(f64::MIN_POSITIVE))
                .collect(),
            clock: readings
                .iter()
                .map(|reading| reading.time_s.unwrap_or(0.0) / end)
                .collect(),
            hold: loads
                .iter()
                .map(|load| (1.0 + load.hold_s.max(0.0)).log10())
                .collect(),
            longest_s,
        }
    }

    /// # Arguments
    /// - `value`: its value at a reading.
    fn profile(&self, stratum: Stratum, scaled: bool, value: impl Fn(usize) -> f64) -> Profile {
        Profile {
            stratum,
            scaled,
            values: (0..self.load.len()).map(value).collect(),
        }
    }
}

/// Profiles over the load, its sign and its branch.
fn load_profiles(details: &Details, out: &mut Vec<Profile>) {
    let f = &details.load;
    out.push(details.profile(Stratum::CellSlope, false, |i| f[i]));
    let shapes: [fn(f64) -> f64; 5] = [
        |f| f * f.abs(),
        |f| f * f * f,
        |f| f.abs().sqrt().copysign(f),
        |f| if f == 0.0 { 0.0 } else { f.signum() },
        |f| (std::f64::consts::TAU * f).sin(),
    ];
    for shape in shapes {
        out.push(details.profile(Stratum::LoadStep, true, |i| shape(f[i])));
    }
    // In a cell that is loaded one way these are its slope and its curve.
    if details.both_ways.contains(&true) {
        let shapes: [fn(f64) -> f64; 2] = [f64::abs, |f| f * f];
        for shape in shapes {
            let value = |i: usize| {
                if details.both_ways[i] {
                    shape(f[i])
                } else {
                    0.0
                }
            };
            out.push(details.profile(Stratum::Sign, true, value));
        }
    }
    if details.unloading.contains(&1.0) {
        let shapes: [fn(f64) -> f64; 3] = [|_| 1.0, |f| f, |f| 4.0 * f * (1.0 - f.abs())];
        for shape in shapes {
            let value = |i: usize| details.unloading[i] * shape(f[i]);
            out.push(details.profile(Stratum::Branch, true, value));
        }
        // What stays when the load comes off: parts that seat, a permanent set.
        let shapes: [fn(f64) -> f64; 2] = [|most| most, f64::sqrt];
        for shape in shapes {
            let value = |i: usize| shape(details.largest_so_far[i]);
            out.push(details.profile(Stratum::Branch, true, value));
        }
    }
}

/// Profiles over the repeats.
fn repeat_profiles(details: &Details, out: &mut Vec<Profile>) {
    if details.repeat.iter().all(|repeat| *repeat == 0.0) {
        return;
    }
    let trends: [fn(f64) -> f64; 3] = [|r| f64::from(u8::from(r == 0.0)), |r| (-r).exp(), |r| r];
    for trend in trends {
        let value = |i: usize| details.load[i] * trend(details.repeat[i]);
        out.push(details.profile(Stratum::RepeatTime, true, value));
    }
}

/// Profiles over the time within a run, and over the clock: a drift whose rate changes over the session.
fn time_profiles(details: &Details, out: &mut Vec<Profile>) {
    if details.longest_s == 0.0 {
        return;
    }
    let trends: [fn(f64) -> f64; 2] = [|t| t, |t| t * t];
    let (f, w, t) = (&details.load, &details.within, &details.clock);
    for trend in trends {
        out.push(details.profile(Stratum::RepeatTime, false, |i| trend(w[i])));
    }
    out.push(details.profile(Stratum::RepeatTime, true, |i| f[i] * w[i]));
    let slow: [fn(f64) -> f64; 3] = [
        |t| t - 0.5,
        |t| (std::f64::consts::TAU * t).sin(),
        |t| (std::f64::consts::TAU * t).cos(),
    ];
    for trend in slow {
        out.push(details.profile(Stratum::RepeatTime, false, |i| w[i] * trend(t[i])));
        out.push(details.profile(Stratum::RepeatTime, true, |i| f[i] * trend(t[i])));
    }
}
