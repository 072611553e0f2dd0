//! One fault of a script, from its keys.

use serde::Deserialize;

use crate::Channel;
use stiffbench_units_and_text::nearest::nearest;

use super::fault::{Fault, LineFault};
use super::fault_script::{FaultDuration, ScriptedFault, When};
use super::gauge::PanelAction;

/// A fault as it is written.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FaultEntry {
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
#[serde(rename_all = "kebab-case")]
enum GaugeWord {
    Force,
    Displacement,
    DisplacementX,
    DisplacementY,
    DisplacementZ,
    Both,
}

/// What a fault may be called.
pub(super) const WORDS: [&str; 20] = [
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
pub(super) type EntryProblem = (String, String);

impl FaultEntry {
    /// The fault that is meant.
    pub(super) fn read(&self) -> Result<ScriptedFault, EntryProblem> {
        let fault = self.fault()?;
        self.check_numbers()?;
        self.check_parameters(&fault)?;
        Ok(ScriptedFault {
            when: self.when()?,
            gauge: match self.gauge {
                Some(GaugeWord::Force) => Some(Channel::Force),
                Some(GaugeWord::Displacement) => Some(Channel::Displacement),
                Some(GaugeWord::DisplacementX) => Some(Channel::DisplacementX),
                Some(GaugeWord::DisplacementY) => Some(Channel::DisplacementY),
                Some(GaugeWord::DisplacementZ) => Some(Channel::DisplacementZ),
                Some(GaugeWord::Both) | None => None,
            },
            lasts: self.lasts(&fault)?,
            fault,
        })
    }

    fn fault(&self) -> Result<Fault, EntryProblem> {
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
            "unit" => Fault::Gauge(PanelAction::Unit(self.unit.clone().ok_or_else(|| {
                let help = "unit = \"lbF\"".to_owned();
                (
                    "the unit that is set at the panel is missing".to_owned(),
                    help,
                )
            })?)),
            "sign-inverted" => Fault::Gauge(PanelAction::InvertSign(true)),
            "peak-mode" => Fault::Gauge(PanelAction::PeakMode(true)),
            "hold" => Fault::Gauge(PanelAction::Hold(true)),
            "overload" => Fault::Gauge(PanelAction::Overload(true)),
            "low-battery" => Fault::Gauge(PanelAction::LowBattery(true)),
            "frozen" => Fault::Gauge(PanelAction::Freeze(true)),
            "tool-off" => Fault::Gauge(PanelAction::ToolOff(true)),
            "data-key" => Fault::Gauge(PanelAction::DataKey),
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

    fn garbage(&self) -> Result<Option<Vec<u8>>, EntryProblem> {
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

    fn when(&self) -> Result<When, EntryProblem> {
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
                "it has more than one start time".to_owned(),
                "give one of at_s, packet, reading, phase; two faults can be two entries"
                    .to_owned(),
            ));
        }
        Ok(when)
    }

    /// A fault of a line hits one packet unless stated otherwise, one that is a state of a gauge lasts, and a cable is out for two seconds.
    fn lasts(&self, fault: &Fault) -> Result<FaultDuration, EntryProblem> {
        if self.for_s.is_some() && self.for_packets.is_some() {
            return Err((
                "it is to last for a time and for a number of packets".to_owned(),
                "give one of for_s, for_packets".to_owned(),
            ));
        }
        let given = self.for_s.map(FaultDuration::Seconds);
        let given = given.or(self.for_packets.map(FaultDuration::Packets));
        Ok(given.unwrap_or(match fault {
            Fault::Line(LineFault::Echo) | Fault::Gauge(_) => FaultDuration::Ever,
            Fault::Line(LineFault::MergedPackets { packets }) => {
                FaultDuration::Packets(*packets as u64)
            }
            Fault::Line(LineFault::Silence) | Fault::Unplug | Fault::Swap | Fault::Suspend => {
                FaultDuration::Seconds(2.0)
            }
            Fault::Line(_) => FaultDuration::Packets(1),
        }))
    }

    fn check_numbers(&self) -> Result<(), EntryProblem> {
        for (key, value) in [
            ("at_s", self.at_s),
            ("for_s", self.for_s),
            ("by_s", self.by_s),
        ] {
            if value.is_some_and(|value| !(value.is_finite() && value >= 0.0)) {
                return Err((
                    format!("{key} is not a time"),
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
    fn check_parameters(&self, fault: &Fault) -> Result<(), EntryProblem> {
        use LineFault::{Garbage, LateReply, MergedPackets, PartialPacket};
        let late = matches!(fault, Fault::Line(LateReply { .. } | PartialPacket { .. }));
        let merged = matches!(fault, Fault::Line(MergedPackets { .. }));
        let garbage = matches!(fault, Fault::Line(Garbage(_)));
        let unit = matches!(fault, Fault::Gauge(PanelAction::Unit(_)));
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
                    format!("leave {key} out; crates/gauges/fault-script.md lists its use"),
                ));
            }
        }
        Ok(())
    }
}
