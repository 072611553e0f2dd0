//! How often something is found where nothing is missing, and how often intervals hold what they promise.

use std::fmt;
use stiffbench::analysis::Failure;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_diagnosis::mismatch::SearchOptions;

use super::answer_text::diagnosis_words;
use super::session::{SessionTexts, ValidationSession, fewer_readings};
use super::share::Share;
use super::trial_bench::{NoiseKind, TrialBench, factors_covered, is_alarm, seed_of};

/// What is special about a bench of the calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Variant {
    /// Nothing: loading and unloading, five repeats, all poses, normal errors.
    Plain,
    /// Loading only.
    #[serde(rename = "loading only")]
    LoadingOnly,
    /// Skewed errors.
    #[serde(rename = "skewed errors")]
    Skewed,
    /// Displacement gauge of 10 µm, errors of 6 µm.
    #[serde(rename = "10 um gauge, errors of 6 um")]
    Coarse,
    /// Displacement gauge of 10 µm, errors of a micrometre or two.
    #[serde(rename = "10 um gauge, errors of 1 to 2 um")]
    CoarseQuiet,
    /// Three repeats.
    #[serde(rename = "three repeats")]
    ThreeRepeats,
    /// One pose.
    #[serde(rename = "one pose")]
    OnePose,
}

impl Variant {
    /// All, in the order of tables.
    pub const ALL: [Self; 7] = [
        Self::Plain,
        Self::LoadingOnly,
        Self::Skewed,
        Self::Coarse,
        Self::CoarseQuiet,
        Self::ThreeRepeats,
        Self::OnePose,
    ];

    fn noise(self) -> NoiseKind {
        match self {
            Self::Skewed => NoiseKind::Skewed,
            Self::Coarse => NoiseKind::Coarse,
            Self::CoarseQuiet => NoiseKind::CoarseQuiet,
            _ => NoiseKind::Normal,
        }
    }
}

/// In words.
impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// A plan with what is special about it.
#[derive(Debug)]
pub struct CalibrationPlan {
    /// What is special.
    pub variant: Variant,
    /// Robot, mechanism and plan.
    pub session: ValidationSession,
}

/// Trials of one plan.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CalibrationRow {
    /// What is special.
    pub variant: Variant,
    /// Robot and mechanism.
    pub bench: String,
    /// Trials in which something was found.
    pub alarms: Share,
    /// Identified factors inside their 95 % intervals.
    #[serde(rename = "factors_in_intervals")]
    pub factors: Share,
    /// Each false alarm.
    #[serde(rename = "said")]
    pub false_alarms: Vec<FalseAlarm>,
}

/// A false alarm.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FalseAlarm {
    /// Seed of the trial, in decimal: it has more digits than a JSON number keeps.
    pub seed: String,
    /// What was said.
    pub said: String,
}

/// Plans for the calibration, from the sessions of a folder: what was measured, never what was found.
///
/// # Arguments
/// - `each`: benches of each variant but the plain one, which has all (`None`) or as many.
///
/// # Errors
/// If a session cannot be read.
pub fn calibration_plans(
    texts: &[SessionTexts],
    each: Option<usize>,
) -> Result<Vec<CalibrationPlan>, Failure> {
    let sessions: Vec<ValidationSession> = texts
        .iter()
        .map(ValidationSession::read)
        .collect::<Result<_, _>>()?;
    let full = places_of_benches(&sessions, is_full);
    let loading = places_of_benches(&sessions, |session| !has_unloading(session));
    let mut plans = Vec::new();
    for (number, variant) in Variant::ALL.into_iter().enumerate() {
        let places = if variant == Variant::LoadingOnly {
            &loading
        } else {
            &full
        };
        let count = match (variant, each) {
            (Variant::Plain, None) => places.len(),
            (_, each) => each.unwrap_or(2).min(places.len()),
        };
        for step in 0..count {
            // Another variant begins at another bench, so that all benches come in turn.
            let place = match (variant, each) {
                (Variant::Plain, None) => places[step],
                _ => places[(2 * number + step * 3) % places.len()],
            };
            let cut = match variant {
                Variant::ThreeRepeats => fewer_readings(&texts[place], None, Some(3))?,
                Variant::OnePose => fewer_readings(&texts[place], Some(1), None)?,
                _ => texts[place].clone(),
            };
            plans.push(CalibrationPlan {
                variant,
                session: ValidationSession::read(&cut)?,
            });
        }
    }
    Ok(plans)
}

/// The first session of each robot and mechanism that has a property.
pub(super) fn places_of_benches(
    sessions: &[ValidationSession],
    property: impl Fn(&ValidationSession) -> bool,
) -> Vec<usize> {
    let mut benches: Vec<String> = Vec::new();
    let mut places = Vec::new();
    for (place, session) in sessions.iter().enumerate() {
        if property(session) && !benches.contains(&session.bench()) {
            benches.push(session.bench());
            places.push(place);
        }
    }
    places
}

pub(super) fn has_unloading(session: &ValidationSession) -> bool {
    let readings = &session.observations.readings;
    let unloading = stiffbench_units_and_text::test_point::Branch::Unloading;
    readings.iter().any(|reading| reading.branch == unloading)
}

/// Loading and unloading, four poses and five repeats, no long holds.
pub(super) fn is_full(session: &ValidationSession) -> bool {
    let observations = &session.observations;
    let holds = observations.readings.iter().any(|r| r.hold_number > 0);
    let five = observations.cells.iter().all(|cell| cell.runs.len() >= 5);
    has_unloading(session) && !holds && five && observations.poses.len() >= 4
}

/// Counts false alarms and coverage; the same for any number of threads.
///
/// # Arguments
/// - `trials`: in all, spread evenly over the plans; at least one each.
/// - `earlier`: sessions of the same bench before each trial, which tell the noise too.
/// - `done`: called after each trial.
///
/// # Errors
/// If a trial cannot be computed.
pub fn calibrate(
    plans: &[CalibrationPlan],
    (trials, earlier): (usize, usize),
    seed: u64,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<CalibrationRow>, Failure> {
    plans
        .iter()
        .enumerate()
        .map(|(number, plan)| {
            let share = trials / plans.len() + usize::from(number < trials % plans.len());
            let own = seed_of(&[seed, 100, number as u64]);
            calibrate_plan(plan, (share.max(1), earlier), own, done)
        })
        .collect()
}

fn calibrate_plan(
    plan: &CalibrationPlan,
    (trials, earlier): (usize, usize),
    seed: u64,
    done: &(dyn Fn() + Sync),
) -> Result<CalibrationRow, Failure> {
    let options = SearchOptions {
        seed,
        ..SearchOptions::default()
    };
    let bench = TrialBench::new(&plan.session, plan.variant.noise(), &options, earlier, seed)?;
    let (truth, diagnosis) = &bench.first;
    let mut counted = vec![(
        seed,
        is_alarm(diagnosis).then(|| diagnosis_words(diagnosis)),
        factors_covered(truth, diagnosis),
    )];
    done();
    let others: Vec<_> = (1..trials as u64)
        .into_par_iter()
        .map(|trial| {
            let own = seed_of(&[seed, trial]);
            let truth = bench.truth(own);
            let diagnosis = bench
                .earlier(&truth, own)
                .and_then(|earlier| bench.diagnose(&truth, &earlier, own));
            done();
            // A trial without a diagnosis is no reason to lose all others; it counts against the tool.
            match diagnosis {
                Ok(diagnosis) => {
                    let words = is_alarm(&diagnosis).then(|| diagnosis_words(&diagnosis));
                    (own, words, factors_covered(&truth, &diagnosis))
                }
                Err(error) => (
                    own,
                    Some(format!("no diagnosis: {error}")),
                    Share::default(),
                ),
            }
        })
        .collect();
    counted.extend(others);
    Ok(CalibrationRow {
        variant: plan.variant,
        bench: plan.session.bench(),
        alarms: Share::of(&counted, |(_, words, _)| words.is_some()),
        factors: counted
            .iter()
            .fold(Share::default(), |sum, (_, _, share)| sum.with(*share)),
        false_alarms: counted
            .into_iter()
            .filter_map(|(seed, words, _)| {
                words.map(|said| FalseAlarm {
                    seed: seed.to_string(),
                    said,
                })
            })
            .collect(),
    })
}
