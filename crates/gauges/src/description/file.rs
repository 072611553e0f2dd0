//! The instrument description as it stands in a file, schema `stiffbench/instrument/1`: its keys and their meaning.
//!
//! These types mirror the TOML text and carry the JSON Schema that is published from it (`docs/instrument-description.schema.json`). What a
//! file means as a whole is checked by [`super::InstrumentDescription::parse`].

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::Deserialize;

use stiffbench_units_and_text::toml_text::remove_null;

use super::entries::{FieldEntry, RegistersEntry};
use super::keywords::{
    DescriptionStatus, Measured, ReplyMeaning, SignMeaning, Trouble, UnitSource,
};
use super::{CommandEffect, Expect, Flow, Parity};

/// The only schema known to this version.
pub const SCHEMA: &str = "stiffbench/instrument/1";

/// The JSON Schema of instrument descriptions (draft 2020-12), for editors that complete and check TOML.
#[must_use]
pub fn json_schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(DescriptionFile).to_value();
    if let Some(object) = schema.as_object_mut() {
        let title = format!("instrument description, {SCHEMA}");
        object.insert("title".to_owned(), title.into());
    }
    schema["properties"]["schema"]["const"] = SCHEMA.into();
    remove_null(&mut schema);
    schema
}

/// Text by text, in the order of the file.
pub(super) type NamedTexts = IndexMap<String, String>;

/// One model of gauge: how it is spoken to, and what its bytes mean.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct DescriptionFile {
    /// `stiffbench/instrument/1`.
    pub(super) schema: String,
    /// Name by which the gauge is chosen: vendor-model, lower case.
    pub(super) name: String,
    /// What it is, in one line.
    pub(super) text: String,
    /// What it measures.
    pub(super) channel: Measured,
    /// How far the description can be trusted.
    pub(super) status: DescriptionStatus,
    /// Known in part only; the user is informed.
    #[serde(default)]
    pub(super) experimental: bool,
    /// Where the facts were read.
    #[serde(default)]
    pub(super) sources: Vec<String>,
    /// What the operator should know before using it.
    #[serde(default)]
    pub(super) notes: Vec<String>,
    /// Systems (`linux`, `macos`, `windows`) on which the gauge makes no serial port, and what to do there.
    #[serde(default)]
    pub(super) no_tty: NamedTexts,
    /// The serial line.
    pub(super) line: LineEntry,
    /// Times and counts.
    #[serde(default)]
    pub(super) timing: TimingEntry,
    /// What is sent to it.
    #[serde(default)]
    pub(super) commands: CommandsEntry,
    /// How packets are distinguished.
    pub(super) framing: FramingEntry,
    /// What the sign means.
    pub(super) sign: SignEntry,
    /// Where the unit comes from.
    pub(super) unit: UnitEntry,
    /// What it can measure.
    #[serde(default)]
    pub(super) physical: PhysicalEntry,
    /// Packets that carry a value, in the order in which they are tried.
    pub(super) value: Vec<ValueEntry>,
    /// Packets that report an error; tried before all others.
    #[serde(default)]
    pub(super) error: Vec<ErrorEntry>,
    /// Packets that answer a command.
    #[serde(default)]
    pub(super) reply: Vec<ReplyEntry>,
}

/// Settings of the serial line.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct LineEntry {
    /// Bits per second.
    pub(super) baud: u32,
    /// Other speeds to try.
    #[serde(default)]
    pub(super) alternatives: Vec<u32>,
    /// 7 or 8; 8 if absent.
    #[serde(default = "eight")]
    pub(super) data_bits: u8,
    /// None if absent.
    #[serde(default)]
    pub(super) parity: Parity,
    /// 1 or 2; 1 if absent.
    #[serde(default = "one")]
    pub(super) stop_bits: u8,
    /// None if absent.
    #[serde(default)]
    pub(super) flow: Flow,
    /// Level of DTR while open; left to the system if absent.
    #[serde(default)]
    pub(super) dtr: Option<bool>,
    /// Level of RTS while open; left to the system if absent.
    #[serde(default)]
    pub(super) rts: Option<bool>,
    /// Wait after opening, s; 0.1 if absent.
    #[serde(default = "tenth")]
    pub(super) settle_s: f64,
}

fn eight() -> u8 {
    8
}

fn one() -> u8 {
    1
}

fn tenth() -> f64 {
    0.1
}

/// Times and counts; what is absent takes the default named with it.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
pub(super) struct TimingEntry {
    /// A reply that takes longer does not come, s; 0.5.
    pub(super) reply_deadline_s: Option<f64>,
    /// Silence after which the line counts as drained after an error, s; 0.1.
    pub(super) drain_s: Option<f64>,
    /// Tries beyond the first; 2.
    pub(super) retries: Option<u32>,
    /// Least time between two commands, s; 0.
    pub(super) gap_s: Option<f64>,
    /// Most values a second; 10.
    pub(super) most_per_s: Option<f64>,
    /// Values to leave out after the port was opened, a wake or a change of unit; 1.
    pub(super) discard_after_open: Option<u32>,
    /// Silence that is reported to the operator, s; 3.
    pub(super) silent_after_s: Option<f64>,
}

/// Commands by role, and what ends each.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
pub(super) struct CommandsEntry {
    /// Put behind every `send`; nothing if absent.
    #[serde(default)]
    pub(super) terminator: String,
    /// One value, now.
    pub(super) read: Option<CommandEntry>,
    /// Begin to send values unasked.
    pub(super) stream_start: Option<CommandEntry>,
    /// Stop that.
    pub(super) stream_stop: Option<CommandEntry>,
    /// Zero here.
    pub(super) zero: Option<CommandEntry>,
    /// Who are you.
    pub(super) identify: Option<CommandEntry>,
    /// Which unit.
    pub(super) query_unit: Option<CommandEntry>,
    /// Newton or millimetre, please.
    pub(super) set_unit: Option<CommandEntry>,
    /// Which mode.
    pub(super) query_mode: Option<CommandEntry>,
    /// The mode of running values, please.
    pub(super) set_mode: Option<CommandEntry>,
    /// Do not switch off.
    pub(super) keep_awake: Option<CommandEntry>,
    /// Forget what was half received.
    pub(super) resynchronise: Option<CommandEntry>,
}

/// One command: `send` or `bytes`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct CommandEntry {
    /// Text, to which the terminator is added.
    pub(super) send: Option<String>,
    /// Bytes, sent as they are.
    pub(super) bytes: Option<Vec<u8>>,
    /// In place of the terminator of all commands.
    pub(super) terminator: Option<String>,
    /// What the gauge answers.
    pub(super) expects: Expect,
    /// What the command does to the gauge; reads if absent.
    #[serde(default)]
    pub(super) effect: CommandEffect,
    /// The value is the running one, whatever the display holds or peak it shows.
    #[serde(default)]
    pub(super) running: bool,
    /// What divides the answer into words, for `refuse`; nothing if absent.
    pub(super) separator: Option<String>,
    /// Words of the answer with which values must not be used, and why.
    #[serde(default)]
    pub(super) refuse: NamedTexts,
}

/// How packets are distinguished: one of these tables.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum FramingEntry {
    /// An end mark behind each.
    Line(LineFraming),
    /// A count of bytes and silence.
    Fixed(FixedFraming),
    /// A mark in front of each, and a count of bytes.
    Start(StartFraming),
    /// Silence.
    Idle(IdleFraming),
    /// Modbus RTU.
    Modbus(ModbusFraming),
}

/// Packets with an end mark.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct LineFraming {
    /// End marks; each of them ends a packet.
    pub(super) end: Vec<String>,
    /// Most bytes of a packet without its end; 80 if absent.
    pub(super) longest: Option<usize>,
    /// Silence after which the rest of a packet does not come any more, s; 0.2 if absent.
    pub(super) idle_s: Option<f64>,
}

/// Packets of one length without any mark.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct FixedFraming {
    /// Bytes of a packet.
    pub(super) length: usize,
    /// Silence that ends a packet, s; 0.05 if absent.
    pub(super) idle_s: Option<f64>,
}

/// Packets with a start mark and a length.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct StartFraming {
    /// First bytes of each packet.
    pub(super) mark: Vec<u8>,
    /// Bytes of a packet with its mark.
    pub(super) length: usize,
    /// Silence after which the rest of a packet does not come any more, s; 0.2 if absent.
    pub(super) idle_s: Option<f64>,
}

/// Packets that end by silence.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct IdleFraming {
    /// Silence that ends a packet, s; 0.05 if absent.
    pub(super) idle_s: Option<f64>,
    /// Most bytes of a packet; 80 if absent.
    pub(super) longest: Option<usize>,
}

/// Replies to one Modbus request, with their check sum.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct ModbusFraming {
    /// Address of the gauge; 1 if absent.
    pub(super) slave: Option<u8>,
    /// Function of the request, 3 or 4; 3 if absent.
    pub(super) function: Option<u8>,
    /// Registers asked for.
    pub(super) registers: u8,
    /// Silence after which the rest of a packet does not come any more, s; 0.05 if absent.
    pub(super) idle_s: Option<f64>,
}

/// What the sign of a force gauge means, and of a displacement gauge: `ask`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct SignEntry {
    /// How a push on the plunger or adapter arrives.
    pub(super) compression: SignMeaning,
    /// The sign can be taken away or turned at the panel.
    #[serde(default)]
    pub(super) removable: bool,
}

/// Where the unit of a value comes from.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct UnitEntry {
    /// Where it comes from.
    pub(super) from: UnitSource,
    /// The unit, where it is fixed.
    pub(super) fixed: Option<String>,
    /// What stands in packets and answers, and the unit that it means.
    #[serde(default)]
    pub(super) codes: NamedTexts,
    /// Units that may be configured; all of the codes, or all of the quantity, if absent.
    #[serde(default)]
    pub(super) choices: Vec<String>,
}

/// What the gauge can measure.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
pub(super) struct PhysicalEntry {
    /// Largest value for which the gauge is built, in one or more units.
    #[serde(default)]
    pub(super) capacity: IndexMap<String, f64>,
    /// A value beyond this (in size) is no value, in one or more units.
    #[serde(default)]
    pub(super) plausible: IndexMap<String, f64>,
    /// Step of the last digit, by unit.
    #[serde(default)]
    pub(super) resolution: IndexMap<String, f64>,
    /// Digits behind the point, by unit: a packet with another count is no value.
    #[serde(default)]
    pub(super) decimals: IndexMap<String, Vec<u8>>,
}

/// A packet that carries a value: `fields`, or `registers` with Modbus framing.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct ValueEntry {
    /// What the packet is, in words.
    #[serde(default)]
    pub(super) text: String,
    /// Its fields, in order; together they cover the packet without its end mark.
    #[serde(default)]
    pub(super) fields: Vec<FieldEntry>,
    /// Where the value stands in the registers.
    pub(super) registers: Option<RegistersEntry>,
}

/// A packet that reports an error.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct ErrorEntry {
    /// What is wrong.
    pub(super) meaning: Trouble,
    /// In words, and what the operator can do.
    pub(super) text: String,
    /// Its fields, in order.
    pub(super) fields: Vec<FieldEntry>,
    /// It comes without the end mark of other packets; its fields must all be fixed.
    #[serde(default)]
    pub(super) bare: bool,
}

/// A packet that answers a command.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct ReplyEntry {
    /// What it answers.
    pub(super) meaning: ReplyMeaning,
    /// Its fields, in order.
    pub(super) fields: Vec<FieldEntry>,
    /// It comes without the end mark of other packets; its fields must all be fixed.
    #[serde(default)]
    pub(super) bare: bool,
}
