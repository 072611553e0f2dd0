//! What is said of a session in the end: the verdict with its grade, findings with intervals, detection limits.
//!
//! The verdict and its grade are decided in `grade.rs`, function `decide`; `conclusion.rs` gathers what it rests on.
//!
//! Owner: [`Diagnosis`]. It imports all rooms but `design`.

mod conclusion;
mod detection;
mod diagnosis;
mod found_model;
mod grade;
mod opposite_slips;
mod part_model;
mod stated_values;
mod trace;

pub(crate) use conclusion::conclude;
pub use diagnosis::{
    DetectionLimit, Diagnosis, FactorChange, Finding, Impossible, KnownEffect, Rival,
};
pub use grade::{Verdict, VerdictGrade};
pub use opposite_slips::reading_between_slips;
pub use part_model::{PartBand, PartConfiguration, PartModel};
pub use stated_values::{EstimatedValue, ValueInterval};
pub use trace::{DiagnosisTrace, EffectTrace, ReadingTrace, trace};
