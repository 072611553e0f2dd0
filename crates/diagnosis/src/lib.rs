//! Model and measurement together.
//!
//! - [`fit`]: fitting factors from measured or reference stiffness, jointly or by the paper's steps.
//! - [`elastostatics`]: the same from loads and displacements as vectors, one load a pose.
//! - [`search`]: what a linear model lacks: rows, columns and a covariance.
//! - [`mismatch`]: what the fitted structure cannot explain, and which physics would.
//! - [`distribution`]: what a robot does over its workspace.

pub mod distribution;
pub mod elastostatics;
pub mod fit;
pub mod mismatch;
pub mod parameters;
pub mod search;
