//! Noise of which a record of the instruments gives a part.

use super::diagnosis_problem::DiagnosisProblem;
use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::{EstimatedNoise, KnownNoise, NoiseBasis};
use crate::mismatch::observed::{Observations, ReadingNoise};

/// What is stated of the scatter of single readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedScatter {
    /// Standard deviation of a reading, the step of its gauge included, m.
    pub displacement_sd_m: f64,
    /// Standard deviation of the force, beside its step, N; `None` as the readings show it.
    pub force_sd_n: Option<f64>,
}

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
    let mut noise = seen;
    // Rotations scatter as they are seen to.
    noise.noise.gauges.rotation_ratio *= seen.noise.reading_sd_m / stated.displacement_sd_m;
    noise.noise.reading_sd_m = stated.displacement_sd_m;
    if let Some(force_sd_n) = stated.force_sd_n {
        noise.noise.gauges.force_sd_n = force_sd_n;
    }
    let is_from_fit = noise.basis == NoiseBasis::Fit;
    // What is given has no uncertainty, and none in common with the rest.
    for other in 0..3 {
        noise.covariance[0][other] = 0.0;
        noise.covariance[other][0] = 0.0;
    }
    let is_all = !observations.has_series() && (is_from_fit || stated.force_sd_n.is_some());
    if !is_from_fit && !is_all {
        noise.basis = NoiseBasis::Stated;
    } else if is_all {
        // Of one load a run the slope is the scatter of the force; without repeats the rest would be what the model lacks.
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
