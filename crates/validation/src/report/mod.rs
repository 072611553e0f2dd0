//! Results of validation as text tables, JSON and figures.
//!
//! A result is a struct: JSON is its fields, and its schema is in [`schemas()`].

mod faults;
mod prove;
mod reference;
mod reference_summary;
mod schemas;
mod table_iv;

pub use faults::{FaultEffect, FaultReport, FaultTrialReport, GaugeTallyReport, SustainReport};
pub use prove::*;
pub use reference::{ReferencePose, ReferenceReport, ReferenceRow, reference_report};
pub use reference_summary::{
    PaperReferenceSummary, ReferenceExport, ReferenceFactors, ReferencePoseSummary,
    ReferenceRowSummary, ReferenceRun, ReferenceSummary,
};
pub use schemas::schemas;
