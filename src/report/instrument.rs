//! Gauges for programs: descriptions, values, ports, traces.

use std::env::consts::OS;
use std::path::{Path, PathBuf};

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::Serialize;

use crate::instrument::description::{
    CommandEffect, DescriptionStatus, Expect, GaugeCommand, LineSettings, ModemLines, Physical,
    SignConvention, Timing, UnitSource,
};
use crate::instrument::port::{Binding, PortInfo};
use crate::instrument::probe::ProbeFinding;
use crate::instrument::{Channel, CommandRole, InstrumentDescription, Rejected, Sample, raw_text};

/// The known gauges.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct InstrumentList {
    /// One entry a description.
    pub instruments: Vec<InstrumentSummary>,
}

/// What a gauge is.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct InstrumentSummary {
    /// Name of the description.
    pub name: String,
    /// What it is.
    pub text: String,
    /// What it measures.
    pub channel: Channel,
    /// Where the description comes from.
    pub status: DescriptionStatus,
    /// Whether a part of it is tried only.
    pub experimental: bool,
    /// Whether it runs with `--allow-unverified` only.
    pub needs_allow_unverified: bool,
    /// Why there is no serial port on this system.
    pub tty_note: Option<String>,
    /// The same for each system.
    pub no_tty: IndexMap<String, String>,
    /// File of a description of the user.
    pub file: Option<String>,
}

/// Everything in the description of a gauge.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct InstrumentReport {
    /// What it is.
    #[serde(flatten)]
    pub summary: InstrumentSummary,
    /// Settings of the line.
    pub line: LineSettings,
    /// States of the modem lines.
    pub modem: ModemLines,
    /// Deadlines and pauses.
    pub timing: Timing,
    /// Where packets end, in words.
    pub framing: String,
    /// The packets, in words.
    pub packets: Vec<String>,
    /// The sign of its values.
    pub sign: SignConvention,
    /// Where the unit comes from.
    pub unit: UnitReport,
    /// Range and resolution.
    pub physical: Physical,
    /// The commands by their role.
    pub commands: IndexMap<&'static str, CommandReport>,
    /// What to know.
    pub notes: Vec<String>,
    /// The sources of the description.
    pub sources: Vec<String>,
    /// The description as TOML.
    pub toml: String,
}

/// Where the unit of a gauge comes from.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct UnitReport {
    /// From where.
    pub from: UnitSource,
    /// The units that it can have.
    pub choices: Vec<String>,
}

/// A command of a gauge.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CommandReport {
    /// Its bytes, as text.
    pub bytes: String,
    /// What answers it.
    pub expects: Expect,
    /// What it does.
    pub effect: CommandEffect,
}

impl InstrumentSummary {
    /// The summary of a description, with its file if it is the user's.
    #[must_use]
    pub fn new(description: &InstrumentDescription, file: Option<&Path>) -> Self {
        let no_tty = description.no_tty_notes();
        Self {
            name: description.name.clone(),
            text: description.text.clone(),
            channel: description.channel,
            status: description.status,
            experimental: description.experimental,
            needs_allow_unverified: description.is_unverified(),
            tty_note: description.no_tty(OS).map(str::to_owned),
            no_tty: no_tty
                .map(|(system, note)| (system.to_owned(), note.to_owned()))
                .collect(),
            file: file.map(|path| path.display().to_string()),
        }
    }
}

impl InstrumentReport {
    /// Everything in a description, with its text.
    #[must_use]
    pub fn new(
        summary: InstrumentSummary,
        description: &InstrumentDescription,
        toml: &str,
    ) -> Self {
        let choices = description.unit_choices().into_iter();
        let commands = CommandRole::ALL.into_iter().filter_map(|role| {
            let command = description.command(role)?;
            Some((role.key(), CommandReport::from(command)))
        });
        Self {
            summary,
            line: description.line.clone(),
            modem: description.modem,
            timing: *description.timing(),
            framing: description.framing_text(),
            packets: description.packets.clone(),
            sign: description.sign,
            unit: UnitReport {
                from: description.unit_source(),
                choices: choices.map(str::to_owned).collect(),
            },
            physical: description.physical.clone(),
            commands: commands.collect(),
            notes: description.notes.clone(),
            sources: description.sources.clone(),
            toml: toml.to_owned(),
        }
    }
}

impl From<&GaugeCommand> for CommandReport {
    fn from(command: &GaugeCommand) -> Self {
        Self {
            bytes: raw_text(&command.bytes).into(),
            expects: command.expects,
            effect: command.effect,
        }
    }
}

/// Bytes decoded by a description.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DecodeReport {
    /// Name of the description.
    pub instrument: String,
    /// The values.
    pub samples: Vec<Sample>,
    /// The packets that are none.
    pub rejected: Vec<Rejected>,
}

/// A value of a gauge with its time.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct TimedValue {
    /// When it came, s.
    pub t_s: f64,
    /// The value.
    #[serde(flatten)]
    pub value: Sample,
}

/// A value of one of two gauges.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ChannelValue {
    /// The value.
    #[serde(flatten)]
    pub value: TimedValue,
    /// The gauge.
    pub channel: Channel,
}

/// A packet without a value, with its time.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct TimedPacket {
    /// When it came, s.
    pub t_s: f64,
    /// The packet.
    #[serde(flatten)]
    pub packet: Rejected,
}

impl From<&Sample> for TimedValue {
    fn from(sample: &Sample) -> Self {
        Self {
            t_s: sample.at_s,
            value: sample.clone(),
        }
    }
}

impl From<&Rejected> for TimedPacket {
    fn from(rejected: &Rejected) -> Self {
        Self {
            t_s: rejected.at_s,
            packet: rejected.clone(),
        }
    }
}

/// Values of a gauge, read now.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReadReport {
    /// Name of the description.
    pub instrument: String,
    /// What the gauge says it is.
    pub identity: Option<String>,
    /// For how long it was read, s.
    pub seconds: f64,
    /// The values.
    pub samples: Vec<TimedValue>,
    /// The packets that are none.
    pub rejected: Vec<TimedPacket>,
    /// What happened.
    pub notes: Vec<String>,
}

/// A trace: the bytes of a line.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct TraceReport {
    /// Name of the instrument description.
    pub instrument: Option<String>,
    /// Which gauge of the bench.
    pub channel: Option<String>,
    /// Unit, where the gauge does not send one.
    pub unit: Option<String>,
    /// The port.
    pub port: Option<String>,
    /// Settings of the line.
    pub line: Option<String>,
    /// UTC of time 0.
    pub started: Option<String>,
    /// Seconds of the trace in a real one.
    pub speed: f64,
    /// Whether it has an end mark.
    pub complete: bool,
    /// Number of bytes from the gauge.
    pub bytes_received: usize,
    /// Number of bytes to the gauge.
    pub bytes_sent: usize,
    /// What happened, in order.
    pub entries: Vec<TraceLine>,
}

/// An entry of a trace.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct TraceLine {
    /// When, s.
    pub t_s: f64,
    /// What kind of entry.
    pub kind: &'static str,
    /// The bytes or words.
    pub what: String,
}

/// The values in a trace.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct TraceValues {
    /// The values.
    pub samples: Vec<TimedValue>,
    /// The packets that are none.
    pub rejected: Vec<TimedPacket>,
}

/// The values of replayed traces.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReplayReport {
    /// The values in the order of their times.
    pub samples: Vec<ChannelValue>,
}

/// A recorded trace.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RecordReport {
    /// The file.
    pub file: PathBuf,
    /// Number of values.
    pub values: usize,
    /// Number of packets that are none.
    pub rejected: usize,
    /// Whether the file holds all of them.
    pub complete: bool,
}

/// The serial ports.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PortList {
    /// One entry a port.
    pub ports: Vec<PortReport>,
}

/// A gauge that is bound to a port.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct BoundGauge {
    /// What it measures.
    pub channel: Channel,
    /// Its description.
    pub instrument: String,
}

/// A serial port, and what is on it if it was probed.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PortReport {
    /// The port.
    #[serde(flatten)]
    pub port: PortInfo,
    /// The gauges that the bindings file has on it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bound: Vec<BoundGauge>,
    /// What answers; absent if it was not probed.
    #[serde(flatten)]
    pub probe: Option<ProbeReport>,
}

/// What a probe of a port gave.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum ProbeReport {
    /// The port was opened.
    Answered {
        /// Descriptions that fit, the best first.
        instruments: Vec<ProbeFinding>,
        /// The one that fits clearly.
        r#match: Option<String>,
    },
    /// It could not be probed.
    Failed {
        /// Why.
        problem: String,
    },
}

/// A gauge bound to a port.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct BindingReport {
    /// Which gauge of the bench.
    pub channel: Channel,
    /// The gauge and its port.
    pub binding: Binding,
    /// The bindings file.
    pub file: PathBuf,
}
