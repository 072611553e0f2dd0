//! Results of validation as text tables, JSON and figures.
//!
//! A result is a struct: JSON is its fields, and its schema is in [`schemas()`].

mod faults;
mod prove;
mod reference;
mod schemas;
mod table_iv;

pub use faults::{FaultEffect, FaultReport, FaultTrialReport, GaugeTallyReport, SustainReport};
pub use prove::*;
pub use reference::{
    PaperReferenceSummary, ReferenceExport, ReferenceFactors, ReferencePoseSummary,
    ReferenceRowSummary, ReferenceRun, ReferenceSummary, reference_summary,
};
pub use schemas::schemas;
