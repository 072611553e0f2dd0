//! From readings to a diagnosis, through all rooms.

use super::baselines::Baseline;
use super::candidates::{
    CandidateMemo, Candidates, ConfigurationSizes, Depth, LawCriticalValues, changing_sizes,
    fitted_beginnings, log_bayes_over, scored_beginnings,
};
use super::error::MismatchError;
use super::observed::Observations;
use super::problem::{DiagnosisProblem, SearchOptions};
use super::unexplained::{Located, located_at_start};
use super::verdict::{Diagnosis, conclude};
use stiffbench_beams::physics::TestObject;
use stiffbench_beams::physics::laws::SHORTEST_PERIOD_M;

/// Finds what a baseline cannot explain, and which physics would.
///
/// # Arguments
/// - `known`: limits computed before for the same robot and plan; computed here if `None`.
///
/// # Returns
/// The diagnosis, and the limits for the next session of the same robot and plan.
///
/// # Errors
/// [`MismatchError`].
pub fn diagnose(
    baseline: &dyn Baseline,
    observations: &Observations,
    options: &SearchOptions,
    known: Option<&LawCriticalValues>,
) -> Result<(Diagnosis, LawCriticalValues), MismatchError> {
    let (diagnosis, critical, ()) =
        diagnose_and(baseline, observations, options, known, |_| Ok(()))?;
    Ok((diagnosis, critical))
}

/// The same, and states where the baseline without effects fails, as [`super::locate`] does.
///
/// # Errors
/// [`MismatchError`].
pub fn diagnose_and_locate(
    baseline: &dyn Baseline,
    observations: &Observations,
    options: &SearchOptions,
) -> Result<(Diagnosis, LawCriticalValues, Located), MismatchError> {
    let located = |problem: &DiagnosisProblem<'_>| located_at_start(problem, options);
    diagnose_and(baseline, observations, options, None, located)
}

/// Diagnoses, and asks something else of the same bench, which keeps what it has computed.
fn diagnose_and<T>(
    baseline: &dyn Baseline,
    observations: &Observations,
    options: &SearchOptions,
    known: Option<&LawCriticalValues>,
    ask: impl FnOnce(&DiagnosisProblem<'_>) -> Result<T, MismatchError>,
) -> Result<(Diagnosis, LawCriticalValues, T), MismatchError> {
    if observations.is_empty() {
        return Err(MismatchError::Empty);
    }
    let on = |observations| {
        DiagnosisProblem::new(baseline, observations).with_known_effects(&options.known_effects)
    };
    let on_path = on(observations).readings_on_path(options)?;
    let observations = on_path.as_ref().unwrap_or(observations);
    let changing = changing_sizes(&on(observations), options)?;
    let (sizes, observations) = match &changing {
        Some((sizes, scaled)) => (*sizes, scaled),
        None => (ConfigurationSizes::Common, observations),
    };
    let (at_start, begun_again, moved_on);
    let begun = scored_beginnings(&on(observations), options)?;
    let observations = begun.as_ref().unwrap_or(observations);
    let rough = on(observations);
    let positions = rough.positions_at_start(options)?;
    let asked = ask(&rough)?;
    at_start = observations.with_positions(&positions);
    let mut bench = rough.with_positions(&at_start);
    let mut memo = CandidateMemo::default();
    let (mut found, critical) =
        Candidates::new(&bench, &memo).search(options, known, Depth::OneByOne)?;
    begun_again = fitted_beginnings(&bench, &found.after)?;
    if let Some(readings) = &begun_again {
        let (again, others) = (on(readings), CandidateMemo::default());
        let (other, _) =
            Candidates::new(&again, &others).search(options, Some(&critical), Depth::OneByOne)?;
        if log_bayes_over((&again, &other.after), (&bench, &found.after))? > 0.0 {
            (bench, memo, found) = (again, others, other);
        }
    }
    if observations.is_recording() {
        (found, _) =
            Candidates::new(&bench, &memo).search(options, Some(&critical), Depth::Pairs)?;
    }
    let candidates = |problem| Candidates::new(problem, &memo);
    if observations.object != TestObject::Robot {
        let diagnosis = Diagnosis {
            sizes,
            ..conclude(candidates(&bench), &found, &critical)?
        };
        return Ok((diagnosis, critical, asked));
    }
    // What was found moved the gauge too: where it stood is computed again, and with it what its period would explain.
    let moved = bench.positions(&found.after)?;
    if !shifts_a_period(&positions, &moved) {
        return Ok((
            conclude(candidates(&bench), &found, &critical)?,
            critical,
            asked,
        ));
    }
    moved_on = bench.observations.with_positions(&moved);
    let bench = bench.with_positions(&moved_on);
    let (found, critical) = candidates(&bench).search(options, Some(&critical), Depth::OneByOne)?;
    Ok((
        conclude(candidates(&bench), &found, &critical)?,
        critical,
        asked,
    ))
}

/// Whether positions differ by so much, m, that the shortest period searched for is in another phase: by 0.3 rad.
fn shifts_a_period(before: &[f64], after: &[f64]) -> bool {
    let shifts = before.iter().zip(after).map(|(a, b)| (a - b).abs());
    shifts.fold(0.0, f64::max) > 0.05 * SHORTEST_PERIOD_M
}
