//! Noise that is known from elsewhere, or a part of it.

use super::baseline::Baseline;
use super::earlier_noise::EarlierNoise;
use super::error::MismatchError;
use super::observations::Observations;
use super::restricted_likelihood::EstimatedNoise;
use super::state::Bench;

/// What is known of the noise before the readings are looked at.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum KnownNoise {
    /// Nothing: the readings alone tell it.
    #[default]
    Nothing,
    /// How earlier sessions on the same bench scattered: the readings tell it together with them.
    Earlier(EarlierNoise),
    /// All: the readings are not asked.
    Given(EstimatedNoise),
}

impl KnownNoise {
    /// The noise, where the readings are not asked.
    pub(super) fn given(&self) -> Option<&EstimatedNoise> {
        match self {
            Self::Given(noise) => Some(noise),
            Self::Nothing | Self::Earlier(_) => None,
        }
    }

    /// What earlier sessions tell of it.
    pub(super) fn earlier(&self) -> Option<&EarlierNoise> {
        match self {
            Self::Earlier(noise) => Some(noise),
            Self::Nothing | Self::Given(_) => None,
        }
    }
}

/// Noise whose part of single readings is given, for example by the records of the instruments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GivenNoise {
    /// The noise to search with: no record states how gauge zeros and slopes of runs scatter, so these stay as the readings show them.
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
    let bench = Bench::new(baseline, observations);
    let seen = bench
        .settle(bench.start(), KnownNoise::Nothing)?
        .ok_or(MismatchError::Empty)?
        .noise;
    let mut noise = seen;
    noise.noise.reading_sd_m = reading_sd_m;
    // What is given has no uncertainty, and none in common with the rest.
    for other in 0..3 {
        noise.covariance[0][other] = 0.0;
        noise.covariance[other][0] = 0.0;
    }
    Ok(GivenNoise {
        noise,
        seen_sd_m: seen.noise.reading_sd_m,
    })
}
