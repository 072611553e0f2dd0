//! The list of model parameters that a fit moves, keeps or ties: what `fit` and the baseline of `mismatch` have in common.

mod choice;
mod spring_scales;

pub use choice::{ChosenParameter, FitRole, ParameterChoice};
pub(crate) use spring_scales::{FIRST_SPRING, ScaleCell, SpringScales, UNLOADED, bears_no_load};
