//! The JSON schemas of results.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};

/// The schema of `data` of each kind of result.
#[must_use]
pub fn schemas() -> Vec<(&'static str, Schema)> {
    vec![
        ("compare", schema_of::<super::ComparisonReport>()),
        ("complete", schema_of::<super::CompletedWords>()),
        ("completions", schema_of::<super::CompletionScript>()),
        ("config", schema_of::<super::ConfigReport>()),
        ("config-schema", schema_of::<Schema>()),
        ("demo", schema_of::<super::DemoReport>()),
        ("design", schema_of::<crate::mismatch::DesignReport>()),
        ("diagnosis", schema_of::<super::DiagnosisSummary>()),
        ("doctor", schema_of::<super::DoctorReport>()),
        ("emulate", schema_of::<super::EmulationReport>()),
        ("error", schema_of::<super::ErrorReport>()),
        ("explain", schema_of::<super::ExplainResult>()),
        ("export", schema_of::<super::DataExportReport>()),
        ("fit", schema_of::<super::FitReport>()),
        ("import", schema_of::<super::ImportReport>()),
        ("instrument", schema_of::<super::InstrumentReport>()),
        ("instrument-check", schema_of::<super::InstrumentSummary>()),
        ("instrument-decode", schema_of::<super::DecodeReport>()),
        ("instrument-list", schema_of::<super::InstrumentList>()),
        ("instrument-read", schema_of::<super::ReadReport>()),
        ("instrument-schema", schema_of::<Schema>()),
        ("man", schema_of::<super::ManualPage>()),
        ("map", schema_of::<super::MapResult>()),
        ("map-shard", schema_of::<super::ShardReport>()),
        ("model-export", schema_of::<super::ModelExportReport>()),
        ("port-binding", schema_of::<super::BindingReport>()),
        ("ports", schema_of::<super::PortList>()),
        ("prediction", schema_of::<super::PredictionReport>()),
        ("report", schema_of::<super::page::ReportPage>()),
        ("report-text", schema_of::<super::page::PrintedText>()),
        ("report-verify", schema_of::<super::page::PageCheck>()),
        ("robot", schema_of::<super::RobotReport>()),
        ("robot-check", schema_of::<crate::analysis::RobotCheck>()),
        ("robot-compliance", schema_of::<super::ComplianceReport>()),
        ("robot-mobility", schema_of::<super::MobilityReport>()),
        ("robot-new", schema_of::<super::NewRobotReport>()),
        ("robot-schema", schema_of::<Schema>()),
        ("session-log", schema_of::<super::SessionLog>()),
        ("session-plan", schema_of::<super::PlanReport>()),
        ("session-recover", schema_of::<super::JournalReport>()),
        ("session-replay", schema_of::<super::SessionReplayReport>()),
        ("session-run", schema_of::<super::RunReport>()),
        ("session-status", schema_of::<super::StatusReport>()),
        ("session-undo", schema_of::<super::UndoReport>()),
        ("session-verify", schema_of::<super::VerifyReport>()),
        ("significance", schema_of::<super::SignificanceReport>()),
        ("simulate", schema_of::<super::SimulationReport>()),
        (
            "stiffness",
            schema_of::<crate::stiffness::StiffnessReport>(),
        ),
        (
            "stiffness-vectors",
            schema_of::<super::VectorStiffnessReport>(),
        ),
        ("trace", schema_of::<super::TraceReport>()),
        ("trace-decode", schema_of::<super::TraceValues>()),
        ("trace-record", schema_of::<super::RecordReport>()),
        ("trace-replay", schema_of::<super::ReplayReport>()),
    ]
}

/// The schema of what a type is written as.
#[must_use]
pub fn schema_of<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    settings.into_generator().into_root_schema_for::<T>()
}
