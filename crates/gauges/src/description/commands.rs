//! What can be sent to a gauge.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a command is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CommandRole {
    /// One value, now.
    Read,
    /// Begin to send values unasked.
    StreamStart,
    /// Stop that.
    StreamStop,
    /// Zero here.
    Zero,
    /// Who are you.
    Identify,
    /// Which unit.
    QueryUnit,
    /// Newton or millimetre, please.
    SetUnit,
    /// Which mode.
    QueryMode,
    /// The mode of running values, please.
    SetMode,
    /// Do not switch off.
    KeepAwake,
    /// Forget what was half received.
    Resynchronise,
}

impl CommandRole {
    /// All, in the order of a file.
    pub const ALL: [Self; 11] = [
        Self::Read,
        Self::StreamStart,
        Self::StreamStop,
        Self::Zero,
        Self::Identify,
        Self::QueryUnit,
        Self::SetUnit,
        Self::QueryMode,
        Self::SetMode,
        Self::KeepAwake,
        Self::Resynchronise,
    ];

    /// Its key in a description.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::StreamStart => "stream_start",
            Self::StreamStop => "stream_stop",
            Self::Zero => "zero",
            Self::Identify => "identify",
            Self::QueryUnit => "query_unit",
            Self::SetUnit => "set_unit",
            Self::QueryMode => "query_mode",
            Self::SetMode => "set_mode",
            Self::KeepAwake => "keep_awake",
            Self::Resynchronise => "resynchronise",
        }
    }
}

impl fmt::Display for CommandRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.key())
    }
}

/// What a gauge answers to a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Expect {
    /// Nothing.
    Nothing,
    /// A value.
    Value,
    /// Text: identity, unit or mode.
    Text,
    /// That it was done, or refused.
    Acknowledgement,
    /// The command itself.
    Echo,
}

/// What a command does to a gauge.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "Effect")]
pub enum CommandEffect {
    /// Nothing.
    #[default]
    Reads,
    /// Sets what it names: sent twice it does no harm.
    Sets,
    /// Goes to the next of a list: to be read back after each.
    Steps,
    /// Turns something on or off: never to be sent blindly.
    Toggles,
}

/// One command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GaugeCommand {
    /// What is sent, terminator included; in one write.
    pub bytes: Vec<u8>,
    /// What the gauge answers.
    pub expects: Expect,
    /// What it does to the gauge.
    pub effect: CommandEffect,
    /// The value is the running one, whatever the display holds or peak it shows.
    pub running: bool,
    pub(crate) separator: Option<String>,
    pub(crate) refuse: Vec<(String, String)>,
}

impl GaugeCommand {
    /// Why values must not be used after this answer (peak mode, hold), if so.
    #[must_use]
    pub fn objection(&self, answer: &str) -> Option<&str> {
        let words: Vec<&str> = match &self.separator {
            Some(separator) => answer.split(separator.as_str()).map(str::trim).collect(),
            None => vec![answer.trim()],
        };
        let mut refused = self.refuse.iter();
        refused
            .find(|(word, _)| words.contains(&word.as_str()))
            .map(|(_, reason)| reason.as_str())
    }
}

/// The commands of a gauge by role.
#[derive(Debug, Clone, Default)]
pub struct Commands([Option<GaugeCommand>; CommandRole::ALL.len()]);

impl Commands {
    /// The command of a role.
    #[must_use]
    pub fn of(&self, role: CommandRole) -> Option<&GaugeCommand> {
        self.0[role as usize].as_ref()
    }

    pub(super) fn set(&mut self, role: CommandRole, command: GaugeCommand) {
        self.0[role as usize] = Some(command);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_role_has_its_place_and_key() {
        for (place, role) in CommandRole::ALL.into_iter().enumerate() {
            assert_eq!(role as usize, place);
            assert!(!role.key().is_empty());
        }
    }

    #[test]
    fn an_answer_is_refused_by_whole_words_only() {
        let mut command = GaugeCommand {
            bytes: Vec::new(),
            expects: Expect::Text,
            effect: CommandEffect::Reads,
            running: false,
            separator: Some(";".to_owned()),
            refuse: vec![("PT".to_owned(), "peak".to_owned())],
        };
        assert_eq!(command.objection("V1.00;LBF;PT;FLTC8"), Some("peak"));
        assert_eq!(command.objection("V1.00;LBF;CUR;OPT"), None);
        command.separator = None;
        assert_eq!(command.objection("V1.00;PT"), None);
        assert_eq!(command.objection("PT "), Some("peak"));
    }
}
