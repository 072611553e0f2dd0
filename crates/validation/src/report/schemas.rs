//! The JSON schemas of results.

use schemars::Schema;

use stiffbench::report::schema_of;

use super::{
    FaultReport, ProveReport, RecordingsReport, ReferenceExport, ReferenceRun, ReferenceSummary,
    SustainReport,
};

/// The schema of `data` of each kind of result.
#[must_use]
pub fn schemas() -> Vec<(&'static str, Schema)> {
    vec![
        ("prove", schema_of::<ProveReport>()),
        ("recordings", schema_of::<RecordingsReport>()),
        ("reference-compare", schema_of::<ReferenceSummary>()),
        ("reference-export", schema_of::<ReferenceExport>()),
        ("reference-run", schema_of::<ReferenceRun>()),
        ("session-faults", schema_of::<FaultReport>()),
        ("trace-sustain", schema_of::<SustainReport>()),
    ]
}
