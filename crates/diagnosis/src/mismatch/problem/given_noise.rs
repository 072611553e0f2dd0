//! Noise of which a record of the instruments gives a part.

use super::diagnosis_problem::DiagnosisProblem;
use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::{EstimatedNoise, KnownNoise, StatedScatter};
use crate::mismatch::observed::{Observations, ReadingNoise};

/// Noise whose part of single readings is given, for example by the records of the instruments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GivenNoise {
    /// The noise to search with: no record states how gauge zeros and slopes of runs scatter, so these stay as the readings show them, or as the
    /// fit leaves them where nothing is repeated.
    pub noise: EstimatedNoise,
    /// Standard deviation of a reading as the readings themselves show it, m; much larger than what is given, the record is too good.
    pub seen_sd_m: f64,
}

/// The noise of readings with a given scatter of a single one.
///
/// # Errors
/// [`MismatchError::Empty`] if there is no noise to be found, else those of the baseline.
pub fn given_noise(
    baseline: &dyn Baseline,
    observations: &Observations,
    stated: StatedScatter,
) -> Result<GivenNoise, MismatchError> {
    let problem = DiagnosisProblem::new(baseline, observations);
    let seen = problem
        .state_of(problem.start(), KnownNoise::Nothing)?
        .noise;
    Ok(GivenNoise {
        noise: seen.with_stated(stated, observations.has_series()),
        seen_sd_m: seen.noise.reading_sd_m,
    })
}

/// The noise of a session by its own readings, for [`Observations::joined`].
///
/// # Errors
/// [`MismatchError::Empty`] if there is no noise to be found, else those of the baseline.
pub fn noise_alone(
    baseline: &dyn Baseline,
    observations: &Observations,
) -> Result<ReadingNoise, MismatchError> {
    let problem = DiagnosisProblem::new(baseline, observations);
    let state = problem.state_of(problem.start(), KnownNoise::Nothing)?;
    Ok(state.noise.noise)
}
