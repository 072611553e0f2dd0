//! Profiles of patterns that belong to no law: over the load, its sign and branch, repeats, time.

use stiffbench_units_and_text::test_point::Branch;

use super::observations::Observations;
use super::stratum::Stratum;

/// A profile: what it is called under, and its value at a reading.
pub(super) struct Profile {
    pub(super) stratum: Stratum,
    /// Whether it is tried in proportion to the compliance too.
    pub(super) scaled: bool,
    pub(super) value: Box<dyn Fn(usize) -> f64>,
}

/// All profiles that these observations can show.
pub(super) fn profiles(observations: &Observations) -> Vec<Profile> {
    let details = Details::of(observations);
    let mut out = Vec::new();
    load_profiles(&details, &mut out);
    repeat_profiles(&details, &mut out);
    time_profiles(&details, &mut out);
    if observations.recorded.hold {
        let (f, h) = (details.load.clone(), details.hold.clone());
        add(&mut out, Stratum::RepeatTime, true, move |i| f[i] * h[i]);
        let (f, h) = (details.load, details.hold);
        add(&mut out, Stratum::RepeatTime, true, move |i| {
            f[i] * f[i].abs() * h[i]
        });
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
            let of_cell = &loads[cell.readings.clone()];
            let both = of_cell.iter().any(|load| load.force_n > 0.0)
                && of_cell.iter().any(|load| load.force_n < 0.0);
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
}

fn add(
    out: &mut Vec<Profile>,
    stratum: Stratum,
    scaled: bool,
    value: impl Fn(usize) -> f64 + 'static,
) {
    out.push(Profile {
        stratum,
        scaled,
        value: Box::new(value),
    });
}

/// Profiles over the load, its sign and its branch.
fn load_profiles(details: &Details, out: &mut Vec<Profile>) {
    let load = &details.load;
    let f = load.clone();
    add(out, Stratum::CellSlope, false, move |i| f[i]);
    let shapes: [fn(f64) -> f64; 5] = [
        |f| f * f.abs(),
        |f| f * f * f,
        |f| f.abs().sqrt().copysign(f),
        |f| if f == 0.0 { 0.0 } else { f.signum() },
        |f| (std::f64::consts::TAU * f).sin(),
    ];
    for shape in shapes {
        let f = load.clone();
        add(out, Stratum::LoadStep, true, move |i| shape(f[i]));
    }
    // In a cell that is loaded one way these are its slope and its curve.
    if details.both_ways.contains(&true) {
        let shapes: [fn(f64) -> f64; 2] = [f64::abs, |f| f * f];
        for shape in shapes {
            let (f, both) = (load.clone(), details.both_ways.clone());
            let value = move |i: usize| if both[i] { shape(f[i]) } else { 0.0 };
            add(out, Stratum::Sign, true, value);
        }
    }
    if details.unloading.contains(&1.0) {
        let shapes: [fn(f64) -> f64; 3] = [|_| 1.0, |f| f, |f| 4.0 * f * (1.0 - f.abs())];
        for shape in shapes {
            let (f, b) = (load.clone(), details.unloading.clone());
            add(out, Stratum::Branch, true, move |i| b[i] * shape(f[i]));
        }
        // What stays when the load comes off: parts that seat, a permanent set.
        let shapes: [fn(f64) -> f64; 2] = [|most| most, f64::sqrt];
        for shape in shapes {
            let most = details.largest_so_far.clone();
            add(out, Stratum::Branch, true, move |i| shape(most[i]));
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
        let (f, r) = (details.load.clone(), details.repeat.clone());
        add(out, Stratum::RepeatTime, true, move |i| f[i] * trend(r[i]));
    }
}

/// Profiles over the time within a run, and over the clock: a drift whose rate changes over the session.
fn time_profiles(details: &Details, out: &mut Vec<Profile>) {
    if details.longest_s == 0.0 {
        return;
    }
    let trends: [fn(f64) -> f64; 2] = [|t| t, |t| t * t];
    for trend in trends {
        let t = details.within.clone();
        add(out, Stratum::RepeatTime, false, move |i| trend(t[i]));
    }
    let (f, t) = (details.load.clone(), details.within.clone());
    add(out, Stratum::RepeatTime, true, move |i| f[i] * t[i]);
    let slow: [fn(f64) -> f64; 3] = [
        |t| t - 0.5,
        |t| (std::f64::consts::TAU * t).sin(),
        |t| (std::f64::consts::TAU * t).cos(),
    ];
    for trend in slow {
        let (w, t) = (details.within.clone(), details.clock.clone());
        add(out, Stratum::RepeatTime, false, move |i| w[i] * trend(t[i]));
        let (f, t) = (details.load.clone(), details.clock.clone());
        add(out, Stratum::RepeatTime, true, move |i| f[i] * trend(t[i]));
    }
}
