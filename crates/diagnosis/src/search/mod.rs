//! Search for what a linear model lacks: rows, columns, and a covariance that is still to be estimated.
//!
//! It knows rows, a baseline of columns, candidates (one column, or a few shapes of one, within bounds) in families, and a covariance. It has
//! never heard of a robot. What makes columns of physics, and rows of readings, is [`crate::mismatch`]; other problems do the same.
//!
//! - [`WhiteSpace`]: rows made white, the baseline projected out.
//! - [`ScoreEngine`]: scores of shapes and their null samples, fast ([`Batched`]) or plain (in tests).
//! - [`CriticalValues`]: how large a score must be, from null samples of whole families.
//! - [`forward_selection`]: terms added one at a time, with swaps, to any [`ForwardProblem`].
//! - `FittedRows`: what a fit leaves of rows, and by how much single ones are off the fit to all others.
//! - `Information`: what rows say, made or planned: expected standard errors, and which further rows are worth most.
//! - [`log_bayes`], [`under_known_covariance`], [`distinguishable`]: what a score is worth.

mod batched;
pub(crate) mod constants;
mod covariance;
mod critical_values;
mod engine;
mod evidence;
mod fitted_rows;
mod forward;
mod information;
mod null_noise;
mod precision;
mod serial_correlation;
mod symmetric_root;
#[cfg(test)]
mod tests;
mod vectors;
mod white_space;

pub use batched::Batched;
pub use constants::{
    DESIGN_LENGTH, DISTINGUISHABLE, LAW_LEVEL, MOST_READINGS_OF_A_PART, NULL_SAMPLES,
    STRONG_EVIDENCE, UNEXPLAINED_LEVEL,
};
pub use covariance::{Covariance, LowRankBlock};
pub use critical_values::{CriticalValues, NullDistribution};
pub use engine::{
    BestAmplitude, Moments, NullMaxima, NullShape, NullShapes, PairMoments, ScoreEngine,
    without_duplicates,
};
pub use evidence::{chance_of_any, distinguishable, log_bayes, under_known_covariance};
pub(crate) use fitted_rows::{DeletedRows, FittedRows, Shift, up_to_last_bad};
pub use forward::{Evidence, ForwardProblem, Selection, forward_selection, rivals};
pub(crate) use information::{Information, Projected};
#[cfg(test)]
pub(crate) use null_noise::put_drawn;
pub use null_noise::{DrawResiduals, NullNoise};
pub use precision::{Precision, SparseRows};
pub use serial_correlation::{MOST_STATES, RowCorrelation, RowErrors, RowStates};
#[cfg(test)]
pub(crate) use tests::Plain;
pub use vectors::{
    RowVector, dot, largest, norm, push_orthonormal, push_orthonormal_rows, subtract, take_out,
};
pub use white_space::WhiteSpace;
