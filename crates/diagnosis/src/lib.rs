//! Model and measurement together.
//!
//! - [`fit`]: parameters from measured or reference stiffness, jointly or by the paper's steps, and from load cases.
//! - [`search`]: what a linear model lacks: rows, columns and a covariance.
//! - [`mismatch`]: what the fitted structure cannot explain, and which physics would.
//! - [`distribution`]: what a robot does over its workspace.

pub mod distribution;
pub mod fit;
pub mod mismatch;
pub mod parameters;
pub mod search;

#[cfg(test)]
mod tests;
