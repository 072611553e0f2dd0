//! The measurement that confirms or refutes what a diagnosis says: one finding alone, that nothing is missing, or nothing yet.

use crate::mismatch::diagnosis::Finding;
use crate::mismatch::error::MismatchError;
use crate::mismatch::observations::Observations;
use crate::search::constants::CAN_TELL;
use stiffbench_beams::physics::{Effect, title};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::Branch;

use super::bench::DesignBench;
use super::next::{Coverage, coverages};
use super::plans::{LoadingPlan, ProposedMeasurement, loadings};
use super::separation::{CellGram, Effects};

/// What a finding is compared with where nothing else explains the readings as well.
const NOTHING: &str = "nothing";

/// For each finding the quickest new measurement that shows its effect by itself, or its absence: one that would be expected to, with a log
/// likelihood ratio of 5, and without the readings in which it was found.
///
/// What happened in one run does not happen again, and what has no size in these poses is not seen in them: for such findings there is none.
///
/// # Errors
/// [`MismatchError::UnknownPose`] if a measured pose is not among those at hand; [`MismatchError::Robot`].
pub(super) fn confirmations(
    bench: &DesignBench<'_>,
    done: &Observations,
    findings: &[Finding],
    base: &Procedure,
) -> Result<Vec<ProposedMeasurement>, MismatchError> {
    let lasting = findings
        .iter()
        .filter(|finding| !finding.effect.law.is_of_one_run());
    let lasting: Vec<Effect> = lasting.map(|finding| finding.effect.clone()).collect();
    if lasting.is_empty() {
        return Ok(Vec::new());
    }
    let done = bench.in_order(done)?;
    let effects = Effects::plain(lasting.clone());
    let mut best: Vec<Option<ProposedMeasurement>> = vec![None; lasting.len()];
    for loading in loadings(base) {
        let everywhere = Procedure {
            poses: Some(bench.poses.to_vec()),
            directions: LoadDirection::axes(),
            ..loading.procedure.clone()
        };
        let cells = bench.cells(&effects, &bench.observations(&everywhere)?, true)?;
        for coverage in coverages(bench, &done) {
            let covered: Vec<&CellGram> =
                cells.iter().filter(|cell| coverage.covers(cell)).collect();
            let projected = bench.whole(&effects, covered).projected();
            let (words, procedure) = coverage.of(bench, &loading);
            let minutes = procedure.minutes(&bench.pace, coverage.poses.len());
            for (place, effect) in lasting.iter().enumerate() {
                let others = (0..lasting.len()).filter(|other| *other != place);
                let alone = others.fold(projected.clone(), |rest, other| rest.without(other));
                let expected = 0.5 * alone.square(place);
                let known = best[place].as_ref();
                if expected >= CAN_TELL && known.is_none_or(|known| minutes < known.minutes) {
                    best[place] = Some(ProposedMeasurement {
                        plan: words.clone(),
                        separates: [title(effect.law, &effect.place), NOTHING.to_owned()],
                        expected_log_lr: Some(expected),
                        log_lr_now: 0.0,
                        minutes,
                        procedure: Some(procedure.clone()),
                        weight: 1.0 / lasting.len() as f64,
                    });
                }
            }
        }
    }
    Ok(best.into_iter().flatten().collect())
}

/// What would show most of what a session could not: the way of loading that it lacks, else the poses that it did not measure.
///
/// # Arguments
/// - `done`: the readings already made, in the order of the poses at hand.
/// - `decided`: whether they were enough to decide; if not, the same poses with enough repeats come first.
///
/// # Errors
/// [`MismatchError::UnknownPose`] if a measured pose is not among those at hand.
pub(super) fn further(
    bench: &DesignBench<'_>,
    done: &Observations,
    base: &Procedure,
    decided: bool,
) -> Result<Option<ProposedMeasurement>, MismatchError> {
    let done = bench.in_order(done)?;
    let all = loadings(base);
    let named = |name: &str| all.iter().find(|loading| loading.procedure.name == name);
    let coverages = coverages(bench, &done);
    let [measured, others @ ..] = &coverages[..] else {
        return Ok(None);
    };
    let unloaded = done
        .readings
        .iter()
        .any(|one| one.branch == Branch::Unloading);
    let new = others.iter().find(|other| {
        other
            .poses
            .iter()
            .all(|pose| !measured.poses.contains(pose))
    });
    let (coverage, loading): (&Coverage, Option<&LoadingPlan>) = match new {
        _ if !decided => (measured, named("sweeps")),
        _ if !unloaded => (measured, named("load-unload")),
        Some(new) => (new, named("again")),
        None => (measured, named("both-signs")),
    };
    let separates = if decided {
        ["that nothing is missing", NOTHING]
    } else {
        ["missing physics", "the scatter of readings"]
    };
    Ok(loading.map(|loading| {
        let (plan, procedure) = coverage.of(bench, loading);
        ProposedMeasurement {
            plan,
            separates: separates.map(str::to_owned),
            expected_log_lr: None,
            log_lr_now: 0.0,
            minutes: procedure.minutes(&bench.pace, coverage.poses.len()),
            procedure: Some(procedure),
            weight: 1.0,
        }
    }))
}
