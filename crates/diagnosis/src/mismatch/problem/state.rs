//! A model as it stands during the search: fitted, with the noise that it leaves.

use super::refit::FittedModel;
use crate::mismatch::noise::{EstimatedNoise, NoiseCovariance};

/// A fitted model with its noise.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) fitted: FittedModel,
    pub(crate) noise: EstimatedNoise,
    pub(crate) whitening: NoiseCovariance,
}
