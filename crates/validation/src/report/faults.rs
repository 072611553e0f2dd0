//! Sessions with faults, and streaming for long, for programs.

use schemars::JsonSchema;
use serde::Serialize;

/// What became of sessions with faults.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct FaultReport {
    /// How many sessions.
    pub sessions: usize,
    /// Those that went on by themselves.
    pub went_on: usize,
    /// Those that stopped and were resumed.
    pub resumed: usize,
    /// Those that never ended.
    pub stuck: usize,
    /// Those with a false reading.
    pub false_readings: usize,
    /// Each session.
    pub trials: Vec<FaultTrialReport>,
}

/// A fault in a phase of a session.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct FaultTrialReport {
    /// The fault.
    pub fault: &'static str,
    /// The phase.
    pub phase: &'static str,
    /// What it did.
    pub effect: FaultEffect,
    /// How often the session had to be taken up again.
    pub resumes: usize,
    /// What it reported.
    pub said: Vec<String>,
}

/// What a fault did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub enum FaultEffect {
    /// The session went on by itself.
    #[serde(rename = "went on")]
    Survived,
    /// It stopped with its reasons, and went on when it was taken up again.
    #[serde(rename = "resumed")]
    Resumed,
    /// It never ended.
    #[serde(rename = "STUCK")]
    Stuck,
    /// A reading was accepted that is not what the bench shows.
    #[serde(rename = "FALSE")]
    FalseReading,
}

impl std::fmt::Display for FaultEffect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.serialize(f)
    }
}

/// What came of two gauges that streamed.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SustainReport {
    /// Time, s.
    pub seconds: f64,
    /// The force gauge.
    pub force: GaugeTallyReport,
    /// The displacement gauge.
    pub displacement: GaugeTallyReport,
    /// Processor time, percent of one core; `null` where the system does not report it.
    pub processor_percent: Option<f64>,
    /// Resident memory at the start, kB.
    #[serde(rename = "resident_start_kB")]
    pub resident_start_kb: Option<u64>,
    /// Resident memory at the end, kB.
    #[serde(rename = "resident_end_kB")]
    pub resident_end_kb: Option<u64>,
    /// Why these are `null`.
    pub reason: Option<&'static str>,
}

/// Values of one gauge.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct GaugeTallyReport {
    /// Sent.
    pub sent: u64,
    /// Received.
    pub received: u64,
    /// Sent and not received.
    pub lost: u64,
    /// Received after a later one.
    pub out_of_order: u64,
    /// Rejected packets.
    pub rejected: u64,
}
