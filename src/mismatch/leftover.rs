//! Patterns that belong to no law: what is left when the laws have been tried, and where it sits.
//!
//! Each pattern is a profile (over load, branch, repeat, time) on a group of readings (all, a direction, a pose, a cell), in displacement
//! or in proportion to the compliance. An effect outside the library shows in some of them; their maximum is calibrated like a law's.

use crate::test_point::{Branch, Direction};

use super::observations::{Observations, ObservedCell};
use super::space::{Space, dot};

/// A row of the decomposition of the residuals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Stratum {
    /// One set of factors does not serve all cells.
    CellSlope,
    /// Curvature, dead zone, steps over the load.
    LoadStep,
    /// Loading and unloading differ.
    Branch,
    /// Trend over repeats or the clock.
    RepeatTime,
    /// Positive and negative loads differ.
    Sign,
    /// Size of the noise, outliers, functions of the reading.
    Rest,
}

impl Stratum {
    /// All strata, in the order of the method.
    pub const ALL: [Self; 6] = [
        Self::CellSlope,
        Self::LoadStep,
        Self::Branch,
        Self::RepeatTime,
        Self::Sign,
        Self::Rest,
    ];

    /// Name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::CellSlope => "cell-slope",
            Self::LoadStep => "load-step",
            Self::Branch => "branch",
            Self::RepeatTime => "repeat-time",
            Self::Sign => "sign",
            Self::Rest => "rest",
        }
    }
}

/// The readings a pattern acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PatternGroup {
    pub(super) pose: Option<usize>,
    pub(super) direction: Option<Direction>,
}

impl PatternGroup {
    fn holds(&self, cell: &ObservedCell) -> bool {
        self.pose.is_none_or(|pose| pose == cell.pose)
            && self.direction.is_none_or(|d| d == cell.direction)
    }
}

/// A pattern, white, and of unit length when projected.
#[derive(Debug, Clone)]
pub(super) struct Pattern {
    pub(super) stratum: Stratum,
    pub(super) group: PatternGroup,
    /// Unit vectors: one, or two for a sine and cosine; not projected.
    pub(super) units: Vec<Vec<f64>>,
    /// Largest change of a reading for a unit along the first vector, m.
    pub(super) size_m: f64,
}

/// A profile: what it is called under, and its value at a reading.
struct Profile {
    stratum: Stratum,
    /// Whether it is tried in proportion to the compliance too.
    scaled: bool,
    value: Box<dyn Fn(usize) -> f64>,
}

/// A pattern shorter than this share of its length before projection is absorbed by the fit.
const ABSORBED: f64 = 1e-3;

/// All patterns that these observations can show.
pub(super) fn patterns(
    observations: &Observations,
    compliance: &[f64],
    space: &Space,
) -> Vec<Pattern> {
    use rayon::prelude::*;
    let profiles = profiles(observations);
    let groups = groups(observations);
    // The values are worked out first: a boxed closure does not pass between threads.
    let mut values: Vec<(Stratum, PatternGroup, Vec<f64>)> = Vec::new();
    for profile in &profiles {
        let plain: Vec<f64> = (0..observations.len()).map(&profile.value).collect();
        for scaled in [false, true].into_iter().filter(|s| !s || profile.scaled) {
            let scale = |reading: usize| if scaled { compliance[reading] } else { 1e-6 };
            for group in &groups {
                let mut values_m = vec![0.0; observations.len()];
                for cell in observations.cells.iter().filter(|cell| group.holds(cell)) {
                    for reading in cell.readings.clone() {
                        values_m[reading] = scale(reading) * plain[reading];
                    }
                }
                values.push((profile.stratum, *group, values_m));
            }
        }
    }
    let mut out: Vec<Pattern> = values
        .into_par_iter()
        .filter_map(|(stratum, group, values)| pattern(space, stratum, group, &[values]))
        .collect();
    out.extend(period_patterns(observations, space));
    out.extend(order_patterns(observations, space));
    out
}

/// Readings in a run from which on a rhythm in their order is looked for.
const ENOUGH_FOR_A_RHYTHM: usize = 32;

/// Most frequencies that are looked for.
const FREQUENCIES: usize = 200;

/// Sines and cosines of the place in the run: something that repeats itself with the readings.
fn order_patterns(observations: &Observations, space: &Space) -> Vec<Pattern> {
    use rayon::prelude::*;
    let longest = observations
        .runs
        .iter()
        .map(|run| run.readings.len())
        .max()
        .unwrap_or(0);
    if longest < ENOUGH_FOR_A_RHYTHM {
        return Vec::new();
    }
    let all = PatternGroup {
        pose: None,
        direction: None,
    };
    let count = (longest / 2).min(FREQUENCIES);
    (1..count)
        .into_par_iter()
        .filter_map(|number| {
            let cycles = 0.5 * number as f64 / count as f64;
            let turn = |phase: f64| -> Vec<f64> {
                (0..observations.len())
                    .map(|reading| {
                        let first = observations.runs[observations.readings[reading].run]
                            .readings
                            .start;
                        let place = (reading - first) as f64;
                        1e-6 * (std::f64::consts::TAU * cycles * place + phase).sin()
                    })
                    .collect()
            };
            let values = [turn(0.0), turn(std::f64::consts::FRAC_PI_2)];
            pattern(space, Stratum::Rest, all, &values)
        })
        .collect()
}

fn pattern(
    space: &Space,
    stratum: Stratum,
    group: PatternGroup,
    values: &[Vec<f64>],
) -> Option<Pattern> {
    let mut units: Vec<Vec<f64>> = Vec::new();
    let mut projected: Vec<Vec<f64>> = Vec::new();
    let mut size_m = 0.0;
    for values in values {
        let mut white = space.white(values);
        let before = dot(&white, &white).sqrt();
        let mut left = white.clone();
        space.project(&mut left);
        for (unit, other) in units.iter().zip(&projected) {
            let share = dot(other, &left);
            subtract(&mut left, share, other);
            subtract(&mut white, share, unit);
        }
        let after = dot(&left, &left).sqrt();
        if !(after > ABSORBED * before && after > 0.0) {
            return None;
        }
        for value in left.iter_mut().chain(&mut white) {
            *value /= after;
        }
        projected.push(left);
        if units.is_empty() {
            let largest = values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            size_m = largest / after;
        }
        units.push(white);
    }
    Some(Pattern {
        stratum,
        group,
        units,
        size_m,
    })
}

fn subtract(vector: &mut [f64], share: f64, other: &[f64]) {
    for (value, other) in vector.iter_mut().zip(other) {
        *value -= share * other;
    }
}

fn groups(observations: &Observations) -> Vec<PatternGroup> {
    let mut groups = vec![PatternGroup {
        pose: None,
        direction: None,
    }];
    let directions = Direction::ALL
        .into_iter()
        .filter(|d| observations.cells.iter().any(|cell| cell.direction == *d));
    groups.extend(directions.map(|direction| PatternGroup {
        pose: None,
        direction: Some(direction),
    }));
    if observations.poses.len() > 1 {
        groups.extend((0..observations.poses.len()).map(|pose| PatternGroup {
            pose: Some(pose),
            direction: None,
        }));
    }
    groups.extend(observations.cells.iter().map(|cell| PatternGroup {
        pose: Some(cell.pose),
        direction: Some(cell.direction),
    }));
    groups
}

fn profiles(observations: &Observations) -> Vec<Profile> {
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
    /// 1 while unloading.
    unloading: Vec<f64>,
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
        Self {
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
    if load.iter().any(|f| *f > 0.0) && load.iter().any(|f| *f < 0.0) {
        let shapes: [fn(f64) -> f64; 2] = [f64::abs, |f| f * f];
        for shape in shapes {
            let f = load.clone();
            add(out, Stratum::Sign, true, move |i| shape(f[i]));
        }
    }
    if details.unloading.contains(&1.0) {
        let shapes: [fn(f64) -> f64; 3] = [|_| 1.0, |f| f, |f| 4.0 * f * (1.0 - f.abs())];
        for shape in shapes {
            let (f, b) = (load.clone(), details.unloading.clone());
            add(out, Stratum::Branch, true, move |i| b[i] * shape(f[i]));
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

/// Sines and cosines of the reading, in all cells together and in each pose: periods of gauges, and half of them for their harmonics.
fn period_patterns(observations: &Observations, space: &Space) -> Vec<Pattern> {
    use rayon::prelude::*;
    let range_m = observations
        .displacement_m
        .iter()
        .map(|d| d.abs())
        .fold(0.0, f64::max);
    let allowed = super::candidate::SHORTEST_PERIOD_M..0.7 * range_m;
    let nominal = super::candidate::NOMINAL_PERIODS_M;
    let mut periods: Vec<f64> = nominal
        .into_iter()
        .chain(nominal.map(|p| 0.5 * p))
        .collect();
    periods.retain(|period| allowed.contains(period));
    periods.sort_by(f64::total_cmp);
    periods.dedup();
    let group = |pose| PatternGroup {
        pose,
        direction: None,
    };
    let poses = observations.poses.len();
    let each = (0..poses).filter(|_| poses > 1).map(Some);
    let groups: Vec<PatternGroup> = std::iter::once(None).chain(each).map(group).collect();
    let wanted: Vec<(f64, PatternGroup)> = periods
        .iter()
        .flat_map(|period| groups.iter().map(|group| (*period, *group)))
        .collect();
    wanted
        .into_par_iter()
        .filter_map(|(period, group)| {
            let turn = |phase: f64| -> Vec<f64> {
                (0..observations.len())
                    .map(|reading| {
                        let cell = &observations.cells[observations.cell_of(reading)];
                        if group.pose.is_some_and(|pose| pose != cell.pose) {
                            return 0.0;
                        }
                        let read = observations.displacement_m[reading];
                        let at = observations.loads[reading].position_m.unwrap_or(read);
                        1e-6 * (std::f64::consts::TAU * at / period + phase).sin()
                    })
                    .collect()
            };
            let values = [turn(0.0), turn(std::f64::consts::FRAC_PI_2)];
            pattern(space, Stratum::Rest, group, &values)
        })
        .collect()
}

/// Chance that white residuals follow each other as closely as these; `None` if no run is long enough for the question.
///
/// Sum of the products of neighbours within runs over the square root of the sum of their squares: normal for many readings
/// (Bartlett, J. R. Stat. Soc. Suppl. 8 (1946)). What the fit of a run's zero and slope takes away only lowers it.
pub(super) fn autocorrelation_p(observations: &Observations, residuals: &[f64]) -> Option<f64> {
    let long = || {
        observations
            .runs
            .iter()
            .filter(|run| run.readings.len() >= ENOUGH_FOR_A_RHYTHM)
    };
    long().next()?;
    let (mut sum, mut squares) = (0.0, 0.0);
    for run in long() {
        for pair in residuals[run.readings.clone()].windows(2) {
            let product = pair[0] * pair[1];
            sum += product;
            squares += product * product;
        }
    }
    (squares > 0.0).then(|| crate::statistics::normal_upper_tail(sum / squares.sqrt()))
}

impl Pattern {
    /// The same, as a sign that what is left belongs to no particular stratum.
    pub(super) fn of_the_rest(self) -> Self {
        Self {
            stratum: Stratum::Rest,
            ..self
        }
    }

    /// Drop of the weighted squares of residuals that are projected.
    pub(super) fn gain(&self, residuals: &[f64]) -> f64 {
        self.units
            .iter()
            .map(|unit| dot(unit, residuals).powi(2))
            .sum()
    }
}
