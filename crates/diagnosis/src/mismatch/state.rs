//! A model as it stands during the search: fitted, with the noise that it leaves.

use super::estimated_noise::EstimatedNoise;
use super::noise::NoiseCovariance;
use super::refit::FittedModel;

/// A fitted model with its noise.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) fitted: FittedModel,
    pub(super) noise: EstimatedNoise,
    pub(super) whitening: NoiseCovariance,
}
