//! Instrument descriptions: one file for each model of gauge, schema `stiffbench/instrument/1`.
//!
//! A description states the commands of the gauge, how its packets are distinguished and what their fields mean. It holds what makers and
//! public programs state about the gauge, quirks included; unstated values are not filled in.

mod commands;
mod compile;
mod entries;
mod fields;
pub(super) mod file;
mod keywords;
mod packets;
mod parse;
mod problem;
mod warnings;

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::framing::Framing;
use super::grammar::Grammar;
use super::sample::Channel;
use super::units::Units;

pub use commands::{CommandEffect, CommandRole, Commands, Expect, GaugeCommand};
pub use file::{SCHEMA, json_schema};
pub use keywords::{
    CheckSumKind, DescriptionStatus, RegisterFormat, ReplyMeaning, SignMeaning, Trouble, UnitSource,
};
pub use problem::{DescriptionError, DescriptionProblem};

/// One model of gauge, checked and ready to decode.
#[derive(Debug, Clone)]
pub struct InstrumentDescription {
    /// Name by which it is chosen.
    pub name: String,
    /// What it is, in one line.
    pub text: String,
    /// What it measures.
    pub channel: Channel,
    /// How far the description can be trusted.
    pub status: DescriptionStatus,
    /// Known in part only.
    pub experimental: bool,
    /// Where the facts were read.
    pub sources: Vec<String>,
    /// What the operator should know.
    pub notes: Vec<String>,
    /// What its packets with a value are, in words.
    pub packets: Vec<String>,
    /// Settings of the serial line.
    pub line: LineSettings,
    /// Levels of the modem lines.
    pub modem: ModemLines,
    /// What the sign means.
    pub sign: SignConvention,
    /// What it can measure.
    pub physical: Physical,
    pub(super) no_tty: Vec<(String, String)>,
    pub(super) timing: Timing,
    pub(super) commands: Commands,
    pub(super) framing: Framing,
    pub(super) units: Units,
    pub(super) grammar: Grammar,
}

impl InstrumentDescription {
    /// The command of a role, if the gauge has one.
    #[must_use]
    pub fn command(&self, role: CommandRole) -> Option<&GaugeCommand> {
        self.commands.of(role)
    }

    /// Times and counts.
    #[must_use]
    pub fn timing(&self) -> &Timing {
        &self.timing
    }

    /// The same gauge where everything but the line runs `times` as fast, as an emulated one in fast-forward does: it may be asked as much more
    /// often. Deadlines of the line stay.
    #[must_use]
    pub fn sped_up(mut self, times: f64) -> Self {
        self.timing.most_per_s *= times;
        self.timing.gap_s /= times;
        self
    }

    /// The same gauge set to another speed, bit/s.
    #[must_use]
    pub fn with_baud(mut self, baud: u32) -> Self {
        self.line.baud = baud;
        self
    }

    /// Silence after which [`super::Decoder::idle`] is to be called, s.
    #[must_use]
    pub fn idle_gap_s(&self) -> f64 {
        self.framing.idle_s
    }

    /// Whether the gauge sends values unasked: by itself, or after a command.
    #[must_use]
    pub fn streams(&self) -> bool {
        self.command(CommandRole::StreamStart).is_some()
            || self.command(CommandRole::Read).is_none()
    }

    /// Whether using it needs the operator's word (`--allow-unverified`).
    #[must_use]
    pub fn is_unverified(&self) -> bool {
        self.status == DescriptionStatus::Recalled
    }

    /// Why there is no serial port on a system (`linux`, `macos`, `windows`), and what to do.
    #[must_use]
    pub fn no_tty(&self, system: &str) -> Option<&str> {
        let mut notes = self.no_tty.iter();
        notes
            .find(|(name, _)| name == system)
            .map(|(_, note)| note.as_str())
    }

    /// Systems on which the gauge makes no serial port, each with what to do.
    pub fn no_tty_notes(&self) -> impl Iterator<Item = (&str, &str)> {
        self.no_tty
            .iter()
            .map(|(system, note)| (system.as_str(), note.as_str()))
    }

    /// Units that may be configured; none where packets carry theirs, or the unit is fixed.
    #[must_use]
    pub fn unit_choices(&self) -> Vec<&str> {
        self.units.choices.iter().map(String::as_str).collect()
    }

    /// Where the unit of a value comes from.
    #[must_use]
    pub fn unit_source(&self) -> UnitSource {
        self.units.source
    }

    /// How packets are distinguished, in words.
    #[must_use]
    pub fn framing_text(&self) -> String {
        self.framing.to_string()
    }
}

/// Settings of a serial line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct LineSettings {
    /// Bits per second.
    pub baud: u32,
    /// Other speeds to try.
    pub alternatives: Vec<u32>,
    /// 7 or 8.
    pub data_bits: u8,
    /// Parity bit.
    pub parity: Parity,
    /// 1 or 2.
    pub stop_bits: u8,
    /// Flow control.
    pub flow: Flow,
}

impl fmt::Display for LineSettings {
    /// For example `9600 8N1`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parity = match self.parity {
            Parity::None => 'N',
            Parity::Even => 'E',
            Parity::Odd => 'O',
        };
        write!(
            f,
            "{} {}{parity}{}",
            self.baud, self.data_bits, self.stop_bits
        )
    }
}

/// Parity bit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Parity {
    /// No parity bit.
    #[default]
    None,
    /// Even.
    Even,
    /// Odd.
    Odd,
}

/// Flow control.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Flow {
    /// None.
    #[default]
    None,
    /// XON and XOFF bytes.
    XonXoff,
    /// RTS and CTS lines.
    RtsCts,
}

/// Levels of the modem lines while the port is open, and the wait after opening.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ModemLines {
    /// DTR; left to the system if `None`.
    pub dtr: Option<bool>,
    /// RTS; left to the system if `None`.
    pub rts: Option<bool>,
    /// Wait after opening, s.
    pub settle_s: f64,
}

/// Times and counts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Timing {
    /// A reply that takes longer does not come, s.
    pub reply_deadline_s: f64,
    /// Silence after which the line counts as drained after an error, s.
    pub drain_s: f64,
    /// Tries beyond the first.
    pub retries: u32,
    /// Least time between two commands, s.
    pub gap_s: f64,
    /// Most values a second.
    pub most_per_s: f64,
    /// Values to leave out after the port was opened, a wake or a change of unit.
    pub discard_after_open: u32,
    /// Silence that is reported to the operator, s.
    pub silent_after_s: f64,
}

/// What the sign of a value means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct SignConvention {
    /// How a push arrives.
    pub compression: SignMeaning,
    /// The sign can be taken away or turned at the panel.
    pub removable: bool,
}

/// What a gauge can measure.
#[derive(Debug, Clone, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Physical {
    /// Largest value for which it is built, N or m.
    pub capacity_si: Option<f64>,
    /// A value beyond this in size is no value, N or m.
    pub plausible_si: Option<f64>,
    /// Step of the last digit by unit, in that unit.
    pub resolution: Vec<(String, f64)>,
    /// Digits behind the point that may be sent, by unit.
    pub decimals: Vec<(String, Vec<u8>)>,
}
