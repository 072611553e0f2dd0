//! Faults as a file: what goes wrong when, on which gauge, for how long.

use serde::Deserialize;

use crate::instrument::Channel;
use crate::nearest::nearest;
use crate::source_text::SourceText;

use super::fault::{Fault, LineFault};
use super::gauge::Panel;

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
    pub lasts: Lasts,
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
pub enum Lasts {
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
        help("docs/fault-script.md lists what a fault script may say")
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
    fault: Vec<Entry>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    what: String,
    gauge: Option<GaugeWord>,
    at_s: Option<f64>,
    packet: Option<u64>,
    reading: Option<u64>,
    phase: Option<Box<str>>,
    nth: Option<u64>,
    for_s: Option<f64>,
    for_packets: Option<u64>,
    by_s: Option<f64>,
    packets: Option<usize>,
    bytes: Option<String>,
    unit: Option<Box<str>>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum GaugeWord {
    Force,
    Displacement,
    Both,
}

/// What a fault may be called.
const WORDS: [&str; 20] = [
    "partial-packet",
    "cut-packet",
    "merged-packets",
    "garbage",
    "nul",
    "echo",
    "late-reply",
    "silence",
    "unit",
    "sign-inverted",
    "peak-mode",
    "hold",
    "overload",
    "low-battery",
    "frozen",
    "tool-off",
    "data-key",
    "unplug",
    "swap",
    "suspend",
];

/// What goes wrong with an entry, and what to write instead.
type Problem = (String, String);

impl FaultScript {
    /// Reads a fault script.
    ///
    /// # Errors
    /// [`FaultScriptError`] for a text that is no fault script, or a fault that cannot be.
    pub fn parse(source: &SourceText) -> Result<Self, FaultScriptError> {
        let file: File = toml::from_str(&source.text).map_err(|error| {
            let offset = error.span().map_or(0, |span| span.start);
            FaultScriptError::File {
                file: source.name.clone(),
                line: source.line_and_column(offset).0,
                problem: error.message().to_owned(),
            }
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

    /// Reads one fault in one line, `GAUGE WHAT [KEY=VALUE ...]`, as it is typed at a running bench; it begins at once unless it says when.
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

impl Entry {
    fn read(&self) -> Result<ScriptedFault, Problem> {
        let fault = self.fault()?;
        self.check_numbers()?;
        self.check_parameters(&fault)?;
        Ok(ScriptedFault {
            when: self.when()?,
            gauge: match self.gauge {
                Some(GaugeWord::Force) => Some(Channel::Force),
                Some(GaugeWord::Displacement) => Some(Channel::Displacement),
                Some(GaugeWord::Both) | None => None,
            },
            lasts: self.lasts(&fault)?,
            fault,
        })
    }

    fn fault(&self) -> Result<Fault, Problem> {
        let fault = match self.what.as_str() {
            "partial-packet" => Fault::Line(LineFault::PartialPacket {
                pause_s: self.by_s.unwrap_or(0.2),
            }),
            "cut-packet" => Fault::Line(LineFault::CutPacket),
            "merged-packets" => Fault::Line(LineFault::MergedPackets {
                packets: self.packets.unwrap_or(2),
            }),
            "garbage" => Fault::Line(LineFault::Garbage(self.garbage()?)),
            "nul" => Fault::Line(LineFault::NulBefore),
            "echo" => Fault::Line(LineFault::Echo),
            "late-reply" => Fault::Line(LineFault::LateReply {
                by_s: self.by_s.unwrap_or(0.5),
            }),
            "silence" => Fault::Line(LineFault::Silence),
            "unit" => Fault::Gauge(Panel::Unit(self.unit.clone().ok_or_else(|| {
                let help = "unit = \"lbF\"".to_owned();
                (
                    "which unit is set at the panel is not said".to_owned(),
                    help,
                )
            })?)),
            "sign-inverted" => Fault::Gauge(Panel::InvertSign(true)),
            "peak-mode" => Fault::Gauge(Panel::PeakMode(true)),
            "hold" => Fault::Gauge(Panel::Hold(true)),
            "overload" => Fault::Gauge(Panel::Overload(true)),
            "low-battery" => Fault::Gauge(Panel::LowBattery(true)),
            "frozen" => Fault::Gauge(Panel::Freeze(true)),
            "tool-off" => Fault::Gauge(Panel::ToolOff(true)),
            "data-key" => Fault::Gauge(Panel::DataKey),
            "unplug" => Fault::Unplug,
            "swap" => Fault::Swap,
            "suspend" => Fault::Suspend,
            unknown => {
                let meant = nearest(unknown, WORDS)
                    .map_or_else(String::new, |near| format!("did you mean {near}? "));
                return Err((
                    format!("there is no fault {unknown}"),
                    format!("{meant}faults are {}", WORDS.join(", ")),
                ));
            }
        };
        Ok(fault)
    }

    fn garbage(&self) -> Result<Option<Vec<u8>>, Problem> {
        let Some(text) = &self.bytes else {
            return Ok(None);
        };
        let bytes = text
            .split_whitespace()
            .map(|byte| u8::from_str_radix(byte, 16));
        bytes.collect::<Result<_, _>>().map(Some).map_err(|_| {
            (
                format!("bytes {text} are not hexadecimal"),
                "two digits a byte, with blanks between them: bytes = \"ff 00 7e\"".to_owned(),
            )
        })
    }

    fn when(&self) -> Result<When, Problem> {
        let given = [
            self.at_s.map(When::Time),
            self.packet.map(When::Packet),
            self.reading.map(When::Reading),
            self.phase
                .as_ref()
                .map(|phase| When::Phase(phase.clone(), self.nth.unwrap_or(1))),
        ];
        let mut given = given.into_iter().flatten();
        let when = given.next().unwrap_or(When::Now);
        if given.next().is_some() {
            return Err((
                "it is to begin at more than one moment".to_owned(),
                "give one of at_s, packet, reading, phase; two faults can be two entries"
                    .to_owned(),
            ));
        }
        Ok(when)
    }

    /// A fault of a line hits one packet unless told otherwise, one that is a state of a gauge lasts, and a cable is out for two seconds.
    fn lasts(&self, fault: &Fault) -> Result<Lasts, Problem> {
        if self.for_s.is_some() && self.for_packets.is_some() {
            return Err((
                "it is to last for a time and for a number of packets".to_owned(),
                "give one of for_s, for_packets".to_owned(),
            ));
        }
        let given = self.for_s.map(Lasts::Seconds);
        let given = given.or(self.for_packets.map(Lasts::Packets));
        Ok(given.unwrap_or(match fault {
            Fault::Line(LineFault::Echo) | Fault::Gauge(_) => Lasts::Ever,
            Fault::Line(LineFault::MergedPackets { packets }) => Lasts::Packets(*packets as u64),
            Fault::Line(LineFault::Silence) | Fault::Unplug | Fault::Swap | Fault::Suspend => {
                Lasts::Seconds(2.0)
            }
            Fault::Line(_) => Lasts::Packets(1),
        }))
    }

    fn check_numbers(&self) -> Result<(), Problem> {
        for (key, value) in [
            ("at_s", self.at_s),
            ("for_s", self.for_s),
            ("by_s", self.by_s),
        ] {
            if value.is_some_and(|value| !(value.is_finite() && value >= 0.0)) {
                return Err((
                    format!("{key} is no time"),
                    format!("write {key} = 2.5, in seconds"),
                ));
            }
        }
        let counted = [self.packet, self.reading, self.nth, self.for_packets];
        if counted.contains(&Some(0)) || self.packets == Some(0) {
            return Err((
                "packets, readings and phases are counted from 1".to_owned(),
                "write 1 for the first".to_owned(),
            ));
        }
        Ok(())
    }

    /// A parameter of another fault is a mistake.
    fn check_parameters(&self, fault: &Fault) -> Result<(), Problem> {
        use LineFault::{Garbage, LateReply, MergedPackets, PartialPacket};
        let late = matches!(fault, Fault::Line(LateReply { .. } | PartialPacket { .. }));
        let merged = matches!(fault, Fault::Line(MergedPackets { .. }));
        let garbage = matches!(fault, Fault::Line(Garbage(_)));
        let unit = matches!(fault, Fault::Gauge(Panel::Unit(_)));
        let by_packets = matches!(fault, Fault::Line(_));
        for (key, given, fits) in [
            ("by_s", self.by_s.is_some(), late),
            ("packets", self.packets.is_some(), merged),
            ("bytes", self.bytes.is_some(), garbage),
            ("unit", self.unit.is_some(), unit),
            ("nth", self.nth.is_some(), self.phase.is_some()),
            ("for_packets", self.for_packets.is_some(), by_packets),
        ] {
            if given && !fits {
                return Err((
                    format!("{key} means nothing for {}", self.what),
                    format!("leave {key} out; docs/fault-script.md says where it belongs"),
                ));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
                lasts: Lasts::Packets(3),
            }
        );
        assert_eq!(faults[1].when, When::Phase("settle".into(), 2));
        assert_eq!(faults[1].lasts, Lasts::Seconds(3.0));
        let garbage = Fault::Line(LineFault::Garbage(Some(vec![0xff, 0x00])));
        assert_eq!((&faults[2].fault, faults[2].gauge), (&garbage, None));
        assert!(faults[2].concerns(Channel::Force) && !faults[0].concerns(Channel::Displacement));
    }

    #[test]
    fn what_cannot_be_is_refused_with_its_place() {
        for (entries, part) in [
            ("[[fault]]\nwhat = \"garbbage\"\n", "no fault garbbage"),
            ("[[fault]]\nwhat = \"unit\"\n", "which unit"),
            (
                "[[fault]]\nwhat = \"nul\"\npacket = 1\nreading = 1\n",
                "more than one moment",
            ),
            ("[[fault]]\nwhat = \"nul\"\npacket = 0\n", "from 1"),
            (
                "[[fault]]\nwhat = \"nul\"\nby_s = 1\n",
                "by_s means nothing",
            ),
            (
                "[[fault]]\nwhat = \"unplug\"\nfor_packets = 1\n",
                "for_packets means nothing",
            ),
            (
                "[[fault]]\nwhat = \"nul\"\nfor_s = -1\n",
                "for_s is no time",
            ),
            (
                "[[fault]]\nwhat = \"garbage\"\nbytes = \"xy\"\n",
                "not hexadecimal",
            ),
            ("[[fault]]\nwhat = \"nul\"\nwhen = 3\n", "line 4"),
            (
                "[[fault]]\nwhat = \"nul\"\nfor_s = 1\nfor_packets = 1\n",
                "a time and",
            ),
        ] {
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
        assert_eq!(fault.lasts, Lasts::Packets(2));
        let unit = FaultScript::parse_line("both unit unit=lbF").unwrap();
        assert_eq!(unit.fault, Fault::Gauge(Panel::Unit("lbF".into())));
        for line in ["", "force", "force nonsense", "spring nul", "force nul x"] {
            assert!(FaultScript::parse_line(line).is_err(), "{line}");
        }
    }
}
