//! The JSON schemas of results.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};

use crate::stiffness::StiffnessTable;

use super::{
    BindingReport, ComparisonReport, ComplianceReport, DecodeReport, DemoReport, DesignSummary,
    DiagnosisResult, EmulationReport, FigureReport, FitReport, InstrumentList, InstrumentReport,
    InstrumentSummary, JournalReport, MapResult, MobilityReport, PaperSummary, PlanReport,
    PortList, ReadReport, RecordReport, ReplayReport, RobotCheck, RobotReport, RunReport,
    SessionLog, ShardReport, SignificanceReport, SimulationReport, StatusReport, TraceReport,
    TraceValues, VerifyReport, WorkspaceReport,
};

/// The schema of `data` of each kind of result.
#[must_use]
pub fn schemas() -> Vec<(&'static str, Schema)> {
    vec![
        ("compare", of::<ComparisonReport>()),
        ("demo", of::<DemoReport>()),
        ("design", of::<DesignSummary>()),
        ("diagnosis", of::<DiagnosisResult>()),
        ("emulate", of::<EmulationReport>()),
        ("fit", of::<FitReport>()),
        ("instrument", of::<InstrumentReport>()),
        ("instrument-check", of::<InstrumentSummary>()),
        ("instrument-decode", of::<DecodeReport>()),
        ("instrument-list", of::<InstrumentList>()),
        ("instrument-read", of::<ReadReport>()),
        ("map", of::<MapResult>()),
        ("map-shard", of::<ShardReport>()),
        ("paper", of::<PaperSummary>()),
        ("plot", of::<FigureReport>()),
        ("port-binding", of::<BindingReport>()),
        ("ports", of::<PortList>()),
        ("robot", of::<RobotReport>()),
        ("robot-check", of::<RobotCheck>()),
        ("robot-compliance", of::<ComplianceReport>()),
        ("robot-mobility", of::<MobilityReport>()),
        ("robot-workspace", of::<WorkspaceReport>()),
        ("session-log", of::<SessionLog>()),
        ("session-plan", of::<PlanReport>()),
        ("session-recover", of::<JournalReport>()),
        ("session-run", of::<RunReport>()),
        ("session-status", of::<StatusReport>()),
        ("session-verify", of::<VerifyReport>()),
        ("significance", of::<SignificanceReport>()),
        ("simulate", of::<SimulationReport>()),
        ("stiffness", of::<StiffnessTable>()),
        ("trace", of::<TraceReport>()),
        ("trace-decode", of::<TraceValues>()),
        ("trace-record", of::<RecordReport>()),
        ("trace-replay", of::<ReplayReport>()),
    ]
}

/// The schema of what a type is written as.
fn of<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    settings.into_generator().into_root_schema_for::<T>()
}
