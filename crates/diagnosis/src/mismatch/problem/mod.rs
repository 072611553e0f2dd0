//! A baseline and laws fitted to readings: predictions, fits, and the noise that a fit leaves.
//!
//! The values of a law are bounded by what is plausible at its place (`place_scales.rs`).
//!
//! Owner: [`DiagnosisProblem`]. It imports `observed`, `baselines` and `noise`.

mod diagnosis_problem;
mod given_noise;
mod linearised;
mod memo;
mod model;
mod place_scales;
mod predictor;
mod refit;
mod stated;

pub(crate) use diagnosis_problem::DiagnosisProblem;
pub use diagnosis_problem::SearchOptions;
pub use given_noise::{GivenNoise, given_noise, noise_alone};
pub(crate) use linearised::{LinearisedModel, end_effect_m};
pub(crate) use memo::{Memo, StateKey, key_of, once, stands_anywhere};
pub(crate) use model::{FittedModel, Model, State, kinked};
pub(crate) use place_scales::{KINDS, PlaceScales, plausible_bounds};
pub(crate) use predictor::ReadingPredictor;
pub(crate) use refit::{ValueProfile, WarmStart, WeightedFit};
pub(crate) use stated::Stated;
