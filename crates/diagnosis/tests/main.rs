//! The promises of this crate, tested from outside.

#![expect(
    clippy::unwrap_used,
    reason = "a test stops at what is not as it must be"
)]

mod bad_load_case_values;
mod elastic_calibration;
mod fit_coverage;
mod fit_recovery;
mod fit_springs;
mod load_case_diagnosis;
mod load_case_fit;
mod map_questions;
mod mismatch_specimens;
mod missing_members;
mod position_coverage;
mod six_springs;
mod stiffness_map;
