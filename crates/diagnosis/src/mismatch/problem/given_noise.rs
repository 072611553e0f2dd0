//! Noise of which a record of the instruments gives a part.

use super::diagnosis_problem::DiagnosisProblem;
use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::{EstimatedNoise, KnownNoise, NoiseBasis};
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

/// The noise of readings with a given standard deviation of a single one.
///
/// # Arguments
/// - `reading_sd_m`: standard deviation of a reading, the step of its gauge included, m.
///
/// # Errors
/// [`MismatchError::Empty`] if there is no noise to be found, else those of the baseline.
pub fn given_noise(
    baseline: &dyn Baseline,
    observations: &Observations,
    reading_sd_m: f64,
) -> Result<GivenNoise, MismatchError> {
    let bench = DiagnosisProblem::new(baseline, observations);
    let seen = bench.state_of(bench.start(), KnownNoise::Nothing)?.noise;
    let mut noise = seen;
    noise.noise.reading_sd_m = reading_sd_m;
    let is_from_fit = noise.basis == NoiseBasis::Fit;
    // What is given has no uncertainty, and none in common with the rest.
    for other in 0..3 {
        noise.covariance[0][other] = 0.0;
        noise.covariance[other][0] = 0.0;
    }
    if !is_from_fit {
        noise.basis = NoiseBasis::Stated;
    } else if !observations.has_series() {
        // Of one load a run what is given is all: the rest would be what the model lacks.
        noise = EstimatedNoise::known(ReadingNoise {
            run_slope_sd: 0.0,
            ..noise.noise
        });
    }
    Ok(GivenNoise {
        noise,
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
