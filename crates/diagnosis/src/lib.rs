//! Model and measurement together.
//!
//! - [`fit`]: fitting factors from measured or reference stiffness, jointly or by the paper's steps.
//! - [`mismatch`]: what the fitted structure cannot explain, and which physics would.
//! - [`distribution`]: what a robot does over its workspace.

pub mod distribution;
pub mod fit;
pub mod mismatch;
pub mod parameters;
