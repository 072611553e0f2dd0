//! The promises of this crate, tested from outside.

#![expect(
    clippy::unwrap_used,
    reason = "a test stops at what is not as it must be"
)]

mod fit_coverage;
mod fit_recovery;
mod fit_springs;
mod map_questions;
mod mismatch_specimens;
mod missing_members;
mod stiffness_map;
mod support;
