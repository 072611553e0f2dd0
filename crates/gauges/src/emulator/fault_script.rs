//! Faults as a file: what goes wrong when, on which gauge, for how long.

use serde::Deserialize;

use crate::Channel;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::{TomlError, read_types};

use super::fault::Fault;
use super::fault_entry::FaultEntry;

/// The schema that a fault script names.
pub const FAULT_SCHEMA: &str = "stiffbench/faults/1";

/// A list of faults.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FaultScript {
    /// The faults, in the order of the file.
    pub faults: Vec<ScriptedFault>,
}

/// A fault with its moment and its place.
#[derive(Debug, Clone, PartialEq)]
pub struct ScriptedFault {
    /// When it begins.
    pub when: When,
    /// The gauge that has it; `None` for both.
    pub gauge: Option<Channel>,
    /// What goes wrong.
    pub fault: Fault,
    /// How long.
    pub lasts: FaultDuration,
}

/// When a fault begins.
#[derive(Debug, Clone, PartialEq)]
pub enum When {
    /// At once.
    Now,
    /// At a session time, s.
    Time(f64),
    /// With the n-th packet that the gauge sends, from 1.
    Packet(u64),
    /// With the n-th load that is set, from 1.
    Reading(u64),
    /// When a phase of the session begins for the n-th time, from 1.
    Phase(Box<str>, u64),
}

/// How long a fault lasts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FaultDuration {
    /// So many packets.
    Packets(u64),
    /// So many seconds of the line.
    Seconds(f64),
    /// To the end.
    Ever,
}

impl ScriptedFault {
    /// Whether a gauge has this fault.
    #[must_use]
    pub fn concerns(&self, channel: Channel) -> bool {
        self.gauge.is_none_or(|gauge| gauge == channel)
    }
}

/// A fault script that cannot be followed.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum FaultScriptError {
    /// Not TOML, or a key or value that means nothing.
    #[error("{file}, line {line}: {problem}")]
    #[diagnostic(
        code(stiffbench::input::fault_script),
        help("crates/gauges/fault-script.md lists the keys of a fault script")
    )]
    File {
        /// The file.
        file: String,
        /// The line, from 1.
        line: usize,
        /// What is wrong there.
        problem: String,
    },
    /// Another schema.
    #[error("{file} has schema {found}, and a fault script has {FAULT_SCHEMA}")]
    #[diagnostic(
        code(stiffbench::input::fault_script),
        help("write schema = \"{FAULT_SCHEMA}\" in the first line")
    )]
    Schema {
        /// The file.
        file: String,
        /// What it names.
        found: String,
    },
    /// A fault that cannot be.
    #[error("{file}: fault {number}: {problem}")]
    #[diagnostic(code(stiffbench::input::fault_script))]
    Fault {
        /// The file.
        file: String,
        /// Which fault, from 1.
        number: usize,
        /// What is wrong with it.
        problem: String,
        /// What to write.
        #[help]
        help: String,
    },
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    schema: String,
    #[serde(default)]
    fault: Vec<FaultEntry>,
}

impl FaultScript {
    /// Reads a fault script.
    ///
    /// # Errors
    /// [`FaultScriptError`] for a text that is no fault script, or a fault that cannot be.
    pub fn parse(source: &SourceText) -> Result<Self, FaultScriptError> {
        let file: File = read_types(source).map_err(|TomlError(error)| FaultScriptError::File {
            file: error.file,
            line: error.line,
            problem: error.problem.to_string(),
        })?;
        if file.schema != FAULT_SCHEMA {
            return Err(FaultScriptError::Schema {
                file: source.name.clone(),
                found: file.schema,
            });
        }
        let faults = (1..).zip(&file.fault).map(|(number, entry)| {
            entry
                .read()
                .map_err(|(problem, help)| FaultScriptError::Fault {
                    file: source.name.clone(),
                    number,
                    problem,
                    help,
                })
        });
        Ok(Self {
            faults: faults.collect::<Result<_, _>>()?,
        })
    }

    /// Reads one fault in one line, `GAUGE WHAT [KEY=VALUE ...]`, as it is typed at a running bench; it begins at once unless it has a start time.
    ///
    /// # Errors
    /// As [`FaultScript::parse`].
    pub fn parse_line(line: &str) -> Result<ScriptedFault, FaultScriptError> {
        use std::fmt::Write;
        let mut words = line.split_whitespace();
        let (gauge, what) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
        let mut text =
            format!("schema = {FAULT_SCHEMA:?}\n[[fault]]\ngauge = {gauge:?}\nwhat = {what:?}\n");
        for word in words {
            let (key, value) = word.split_once('=').unwrap_or((word, ""));
            let _ = match value.parse::<f64>() {
                Ok(_) => writeln!(text, "{key} = {value}"),
                Err(_) => writeln!(text, "{key} = {value:?}"),
            };
        }
        let script = Self::parse(&SourceText::new(format!("`{line}`"), text))?;
        Ok(script.faults.into_iter().next().expect("one was written"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::fault::LineFault;
    use crate::emulator::fault_entry::WORDS;
    use crate::emulator::gauge::PanelAction;

    fn parse(entries: &str) -> Result<FaultScript, FaultScriptError> {
        let text = format!("schema = \"{FAULT_SCHEMA}\"\n{entries}");
        FaultScript::parse(&SourceText::new("faults.toml", text))
    }

    #[test]
    fn every_word_is_a_fault() {
        for word in WORDS {
            let parameter = if word == "unit" { "unit = \"LB\"" } else { "" };
            let script = parse(&format!("[[fault]]\nwhat = \"{word}\"\n{parameter}\n"));
            assert_eq!(script.unwrap().faults.len(), 1, "{word}");
        }
    }

    #[test]
    fn moments_places_and_parameters_are_read() {
        let script = parse(
            "[[fault]]\nwhat = \"late-reply\"\ngauge = \"force\"\npacket = 7\nby_s = 0.4\nfor_packets = 3\n\
             [[fault]]\nwhat = \"unplug\"\ngauge = \"displacement\"\nphase = \"settle\"\nnth = 2\nfor_s = 3\n\
             [[fault]]\nwhat = \"garbage\"\nat_s = 12.5\nbytes = \"ff 00\"\n",
        );
        let faults = script.unwrap().faults;
        assert_eq!(
            faults[0],
            ScriptedFault {
                when: When::Packet(7),
                gauge: Some(Channel::Force),
                fault: Fault::Line(LineFault::LateReply { by_s: 0.4 }),
                lasts: FaultDuration::Packets(3),
            }
        );
        assert_eq!(faults[1].when, When::Phase("settle".into(), 2));
        assert_eq!(faults[1].lasts, FaultDuration::Seconds(3.0));
        let garbage = Fault::Line(LineFault::Garbage(Some(vec![0xff, 0x00])));
        assert_eq!((&faults[2].fault, faults[2].gauge), (&garbage, None));
        assert!(faults[2].concerns(Channel::Force) && !faults[0].concerns(Channel::Displacement));
    }

    #[test]
    fn impossible_entries_are_refused_with_their_place() {
        #[rustfmt::skip]
        let cases = [
            ("[[fault]]\nwhat = \"garbbage\"\n", "no fault garbbage"),
            ("[[fault]]\nwhat = \"unit\"\n", "the unit"),
            ("[[fault]]\nwhat = \"nul\"\npacket = 1\nreading = 1\n", "more than one start time"),
            ("[[fault]]\nwhat = \"nul\"\npacket = 0\n", "from 1"),
            ("[[fault]]\nwhat = \"nul\"\nby_s = 1\n", "by_s means nothing"),
            ("[[fault]]\nwhat = \"unplug\"\nfor_packets = 1\n", "for_packets means nothing"),
            ("[[fault]]\nwhat = \"nul\"\nfor_s = -1\n", "for_s is not a time"),
            ("[[fault]]\nwhat = \"garbage\"\nbytes = \"xy\"\n", "not hexadecimal"),
            ("[[fault]]\nwhat = \"nul\"\nwhen = 3\n", "line 4"),
            ("[[fault]]\nwhat = \"nul\"\nfor_s = 1\nfor_packets = 1\n", "a time and"),
        ];
        for (entries, part) in cases {
            let error = parse(entries).unwrap_err().to_string();
            assert!(error.contains(part), "{entries}: {error}");
        }
        let other = FaultScript::parse(&SourceText::new("f", "schema = \"stiffbench/faults/2\"\n"));
        assert!(matches!(other, Err(FaultScriptError::Schema { .. })));
    }

    #[test]
    fn a_fault_can_be_typed_in_a_line() {
        let fault = FaultScript::parse_line("force late-reply by_s=0.5 for_packets=2").unwrap();
        assert_eq!(fault.when, When::Now);
        assert_eq!(fault.lasts, FaultDuration::Packets(2));
        let unit = FaultScript::parse_line("both unit unit=lbF").unwrap();
        assert_eq!(unit.fault, Fault::Gauge(PanelAction::Unit("lbF".into())));
        for line in ["", "force", "force nonsense", "spring nul", "force nul x"] {
            assert!(FaultScript::parse_line(line).is_err(), "{line}");
        }
    }
}
