//! Where a model fails: the residuals split into strata, each tested against the scatter that belongs to it.
//!
//! ```text
//!   contrast        beyond                      against
//!   cell-slope      factors                     slopes of runs within their cell
//!   repeat          cell slopes                 slopes of runs
//!   cell-offset     slopes of runs              zeros of runs within their cell
//!   clock           zeros and slopes of runs    readings within their run, level, branch and hold
//!   sign            the same, clock, holds      the same; slopes of runs, if no run has both signs
//!   curve           the same, sign              the same
//!   load-step       the same, curves            the same
//!   loop            the same, levels of load    the same
//!   branch          the same, loops             the same
//!   hold            all but holds               the same
//! ```
//!
//! Everything is computed on white readings with the derivatives to the model's parameters taken out. The contrasts are orthogonal to
//! what they are tested against, so with normal noise each ratio is exactly F, whatever the size of the noise; within runs also whatever
//! the scatter of zeros and slopes, which are taken out whole. Errors of a coarse gauge come back in every repeat: there the chances of the
//! ratios and of the periods are counted among drawn and rounded readings. The family is all tests together, by Holm's step-down (Scand. J.
//! Statist. 6 (1979) 65), which needs no independence.

mod bases;
mod columns;
mod components;
mod contrasts;
mod decomposition;
mod extremes;
mod levels;
mod map;
mod results;
mod tails;
mod testing;
#[cfg(test)]
pub(crate) mod tests;

use crate::mismatch::baselines::{Baseline, prior_sd};
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::EstimatedNoise;
use crate::mismatch::observed::Observations;
use crate::mismatch::problem::{DiagnosisProblem, SearchOptions, State};

pub use crate::search::constants::STRATUM_LEVEL;
pub use map::MapEntry;
pub(crate) use tails::holm;

pub use results::{
    Contrast, ExplainedShare, Located, Spot, StratumTest, SuspectComponent, Untested,
};

use columns::Setting;
use decomposition::Decomposition;

/// Says where a baseline without effects fails.
///
/// # Errors
/// [`MismatchError`].
pub fn locate(
    baseline: &dyn Baseline,
    observations: &Observations,
    options: &SearchOptions,
) -> Result<Located, MismatchError> {
    if observations.is_empty() {
        return Err(MismatchError::Empty);
    }
    let problem = DiagnosisProblem::new(baseline, observations);
    located_at_start(&problem.with_known_effects(&options.known_effects), options)
}

/// Says where the model without effects fails.
pub(crate) fn located_at_start(
    problem: &DiagnosisProblem<'_>,
    options: &SearchOptions,
) -> Result<Located, MismatchError> {
    let state = problem.state_of(problem.start(), options.noise)?;
    located(problem, &state, options.noise.given())
}

/// The tests of what a state leaves, without those for single readings and periods.
pub(crate) fn stratum_tests(
    problem: &DiagnosisProblem<'_>,
    state: &State,
) -> Result<Vec<StratumTest>, MismatchError> {
    let decomposition = decomposition(problem, state)?;
    let white = decomposition.white(&problem.raw_residuals(&state.fitted.model)?);
    Ok(decomposition.ratio_tests(&white, &[], problem.rounded(state)?.as_ref()))
}

fn decomposition<'s>(
    problem: &'s DiagnosisProblem<'_>,
    state: &'s State,
) -> Result<Decomposition<'s>, MismatchError> {
    let model = &state.fitted.model;
    let columns = problem.free_columns(model)?;
    let slope_m = problem.slope(model)?.slope_m;
    Ok(Decomposition::new(&Setting {
        observations: problem.observations,
        whitening: &state.whitening,
        columns: &columns,
        prior_sd: &prior_sd(problem.baseline),
        slope_m: &slope_m,
    }))
}

/// Says where a state fails.
///
/// # Arguments
/// - `known`: the noise, if it was known beforehand.
pub(crate) fn located(
    problem: &DiagnosisProblem<'_>,
    state: &State,
    known: Option<&EstimatedNoise>,
) -> Result<Located, MismatchError> {
    let model = &state.fitted.model;
    let decomposition = decomposition(problem, state)?;
    let predicted = problem.predicted(model)?;
    // Where the gauge stood, if that is known, else where the model says.
    let loads = problem.observations.loads.iter().zip(&predicted);
    let positions_m: Vec<f64> = loads
        .map(|(load, predicted)| load.position_m.unwrap_or(*predicted))
        .collect();
    let residual_m = problem.less(predicted);
    let white = decomposition.white(&residual_m);
    let rounded = problem.rounded(state)?;
    let periods = decomposition.periods(&positions_m);
    let (tests, untested) = decomposition.tests(&white, &periods, known, rounded.as_ref());
    let slopes = passes(&tests, &[Contrast::CellSlope]);
    let shapes = passes(
        &tests,
        &[
            Contrast::Curve,
            Contrast::LoadStep,
            Contrast::Loop,
            Contrast::Branch,
        ],
    );
    let parts = if slopes || shapes {
        components::parts(problem, state)?
    } else {
        components::SuspectComponents::default()
    };
    Ok(Located {
        slope_components: if slopes {
            decomposition.slope_components(&parts, &white)
        } else {
            Vec::new()
        },
        shape_components: if shapes {
            decomposition.shape_components(&parts, &white)
        } else {
            Vec::new()
        },
        map: map::entries(problem.observations, &residual_m, &white),
        tests,
        untested,
    })
}

fn passes(tests: &[StratumTest], contrasts: &[Contrast]) -> bool {
    tests
        .iter()
        .any(|test| contrasts.contains(&test.contrast) && test.p_family <= STRATUM_LEVEL)
}
