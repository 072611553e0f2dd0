//! The JSON schemas of results.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};

use crate::stiffness::StiffnessReport;

use super::{
    BindingReport, ComparisonReport, CompletedWords, CompletionScript, ComplianceReport,
    DecodeReport, DemoReport, DiagnosisSummary, EmulationReport, FitReport, InstrumentList,
    InstrumentReport, InstrumentSummary, JournalReport, ManualPage, MapResult, MobilityReport,
    ModelExportReport, PaperReport, PlanReport, PortList, ReadReport, RecordReport, ReplayReport,
    RobotReport, RunReport, SessionLog, SessionReplayReport, ShardReport, SignificanceReport,
    SimulationReport, StatusReport, TraceReport, TraceValues, UndoReport, VectorStiffnessReport,
    VerifyReport,
};

/// The schema of `data` of each kind of result.
#[must_use]
pub fn schemas() -> Vec<(&'static str, Schema)> {
    vec![
        ("compare", schema_of::<ComparisonReport>()),
        ("complete", schema_of::<CompletedWords>()),
        ("completions", schema_of::<CompletionScript>()),
        ("config", schema_of::<super::ConfigReport>()),
        ("config-schema", schema_of::<Schema>()),
        ("demo", schema_of::<DemoReport>()),
        ("design", schema_of::<crate::mismatch::DesignReport>()),
        ("diagnosis", schema_of::<DiagnosisSummary>()),
        ("doctor", schema_of::<super::DoctorReport>()),
        ("emulate", schema_of::<EmulationReport>()),
        ("error", schema_of::<super::ErrorReport>()),
        ("explain", schema_of::<super::ExplainResult>()),
        ("export", schema_of::<super::DataExportReport>()),
        ("fit", schema_of::<FitReport>()),
        ("import", schema_of::<super::ImportReport>()),
        ("instrument", schema_of::<InstrumentReport>()),
        ("instrument-check", schema_of::<InstrumentSummary>()),
        ("instrument-decode", schema_of::<DecodeReport>()),
        ("instrument-list", schema_of::<InstrumentList>()),
        ("instrument-read", schema_of::<ReadReport>()),
        ("instrument-schema", schema_of::<Schema>()),
        ("man", schema_of::<ManualPage>()),
        ("map", schema_of::<MapResult>()),
        ("map-shard", schema_of::<ShardReport>()),
        ("model-export", schema_of::<ModelExportReport>()),
        ("paper", schema_of::<PaperReport>()),
        ("port-binding", schema_of::<BindingReport>()),
        ("ports", schema_of::<PortList>()),
        ("prediction", schema_of::<super::PredictionReport>()),
        ("report", schema_of::<super::page::ReportPage>()),
        ("report-text", schema_of::<super::page::PrintedText>()),
        ("report-verify", schema_of::<super::page::PageCheck>()),
        ("robot", schema_of::<RobotReport>()),
        ("robot-check", schema_of::<crate::analysis::RobotCheck>()),
        ("robot-compliance", schema_of::<ComplianceReport>()),
        ("robot-mobility", schema_of::<MobilityReport>()),
        ("robot-new", schema_of::<super::NewRobotReport>()),
        ("robot-schema", schema_of::<Schema>()),
        ("session-log", schema_of::<SessionLog>()),
        ("session-plan", schema_of::<PlanReport>()),
        ("session-recover", schema_of::<JournalReport>()),
        ("session-replay", schema_of::<SessionReplayReport>()),
        ("session-run", schema_of::<RunReport>()),
        ("session-status", schema_of::<StatusReport>()),
        ("session-undo", schema_of::<UndoReport>()),
        ("session-verify", schema_of::<VerifyReport>()),
        ("significance", schema_of::<SignificanceReport>()),
        ("simulate", schema_of::<SimulationReport>()),
        ("stiffness", schema_of::<StiffnessReport>()),
        ("stiffness-vectors", schema_of::<VectorStiffnessReport>()),
        ("trace", schema_of::<TraceReport>()),
        ("trace-decode", schema_of::<TraceValues>()),
        ("trace-record", schema_of::<RecordReport>()),
        ("trace-replay", schema_of::<ReplayReport>()),
    ]
}

/// The schema of what a type is written as.
#[must_use]
pub fn schema_of<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    settings.into_generator().into_root_schema_for::<T>()
}
