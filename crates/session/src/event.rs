//! What a journal keeps: one event a line.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_gauges::Channel;
use stiffbench_measurement::procedure::LimitVerdict;
use stiffbench_measurement::readings::{JointColumn, JointUnit};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Branch, Direction};

use super::decision::{Flagged, Skipped, Superseded, Undone};
use super::raw_bytes::RawBytes;
use super::surroundings::Surroundings;

/// Something that happened in a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", content = "data", rename_all = "kebab-case")]
pub enum Event {
    /// The session began.
    Started(Started),
    /// The session was taken up again by another process.
    Resumed(Resumed),
    /// A gauge reported its identity.
    Instrument(InstrumentSeen),
    /// Which way a gauge counts.
    SignCheck(SignChecked),
    /// The operator confirmed a pose and direction.
    PoseSet(PoseSet),
    /// The gauges were zeroed, or the zero was checked.
    Zero(Zeroed),
    /// A reading was taken.
    Reading(Box<TakenReading>),
    /// A reading no longer counts; it stays.
    Superseded(Superseded),
    /// Readings turned out to be doubtful after they were taken.
    Flagged(Flagged),
    /// A planned reading is left out.
    Skipped(Skipped),
    /// A reading, a skip or a flag was taken back after the session had stopped.
    Undone(Undone),
    /// The operator's words.
    Note(Noted),
    /// The surroundings.
    Environment(Surroundings),
    /// A line went down or came back, or a gauge sent what must not be used.
    Link(LinkChange),
    /// Nothing ran for a while: the machine was suspended, or the program was stopped.
    Gap(Gap),
    /// UTC and session time no longer go together.
    ClockJump(ClockJump),
    /// The session was paused.
    Paused(Paused),
    /// A calibration had run out.
    CalibrationWarning(Warning),
    /// The session is over.
    Ended(Ended),
}

impl Event {
    /// Whether a session that records it has decided what becomes of the readings on a zero that moved.
    pub(crate) fn decides_on_zero(&self) -> bool {
        match self {
            Self::Reading(_) | Self::Superseded(_) => true,
            Self::Ended(ended) => ended.outcome == SessionEnd::Complete,
            _ => false,
        }
    }
}

/// The form of a journal.
pub const JOURNAL_SCHEMA: &str = "stiffbench/journal/1";

/// How a session began.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Started {
    /// The form of the journal, [`JOURNAL_SCHEMA`]; absent in journals of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// Session id.
    pub session: String,
    /// Name of the procedure.
    pub procedure: String,
    /// SHA-256 of the procedure as written out, in hexadecimal.
    pub procedure_sha256: String,
    /// Program and version.
    pub software: String,
    /// Process number.
    pub pid: u32,
    /// Name of the machine.
    pub host: String,
    /// SHA-256 of the robot file, in hexadecimal; absent in journals of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot_sha256: Option<String>,
    /// SHA-256 of `session.toml` without the records of the instruments, in hexadecimal; absent in journals of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub header_sha256: Option<String>,
    /// SHA-256 of the records of the instruments in `session.toml`, in hexadecimal; absent in journals of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instruments_sha256: Option<String>,
    /// Mechanism of the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mechanism: Option<String>,
    /// The origin of readings that are not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<String>,
    /// Base axes along which displacement gauges stand; none for one gauge along the load.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub displacement_axes: Vec<Direction>,
}

/// How a session was taken up again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Resumed {
    /// Program and version.
    pub software: String,
    /// Process number.
    pub pid: u32,
    /// Name of the machine.
    pub host: String,
    /// Bytes of a record that was being written when the session stopped; they were taken off.
    pub cut_bytes: u64,
}

/// A gauge as it was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct InstrumentSeen {
    /// Which gauge.
    pub channel: Channel,
    /// The identity that it reported; empty if none.
    pub identity: String,
    /// The port it was found on; empty where that is not known.
    pub port: String,
    /// The unit it sends.
    pub unit: String,
    /// Step of its last digit, N or m.
    pub resolution_si: f64,
    /// The coarser step that it counts in, as the operator confirmed, N or m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_si: Option<f64>,
}

/// Which way a gauge counts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SignChecked {
    /// Which gauge.
    pub channel: Channel,
    /// 1 if it counts along the positive axis, -1 if against it.
    pub sign: f64,
    /// What that rests on.
    pub basis: String,
}

/// A pose and direction that stand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PoseSet {
    /// Place of the cell in the plan, from 0.
    pub cell: usize,
    /// The pose.
    pub pose: String,
    /// The direction of the load.
    pub direction: LoadDirection,
    /// The joints of the robot in this pose, where the procedure states them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<JointSet>,
}

/// The value of a variable of the robot: an angle or, of a sliding joint, a length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct JointSet {
    /// Name of the variable.
    pub variable: String,
    /// The angle, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deg: Option<f64>,
    /// The length, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mm: Option<f64>,
}

/// A gauge zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Zeroed {
    /// Place of the cell in the plan, from 0.
    pub cell: usize,
    /// What of the plan it is for: `cell`, or the repeat.
    pub scope: String,
    /// Its name in the column `zero_id`.
    pub label: String,
    /// When.
    pub moment: ZeroOccasion,
    /// What the force gauge shows unloaded, N in the sign as sent; it is taken off.
    pub force_offset_n: f64,
    /// What the displacement gauge shows under the preload, m in the sign as sent; it is taken off. Of gauges along the base axes, the
    /// first in `gauges`.
    pub displacement_offset_m: f64,
    /// Whether the gauges set their own zero; else the offsets do all of it.
    pub by_gauge: [bool; 2],
    /// Force under which the displacement zero was set, N along the axis; absent in journals of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preload_n: Option<f64>,
    /// Displacement from the zero at a check, less what the force then yields more than at the zero, m along the axis.
    pub drift_m: Option<f64>,
    /// Force of the unloaded gauge at a check, N along the axis; absent in journals of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_drift_n: Option<f64>,
    /// What is wrong with the readings since the zero was last certain; empty if nothing is.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub flag: String,
    /// The zeros of displacement gauges along the base axes; none for one gauge along the load.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gauges: Vec<AxisZero>,
}

/// The zero of a displacement gauge along a base axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AxisZero {
    /// Which gauge.
    pub channel: Channel,
    /// What it shows under the preload, m in the sign as sent; it is taken off.
    pub offset_m: f64,
    /// Whether it set its own zero; else the offset does all of it.
    pub by_gauge: bool,
    /// Displacement from the zero at a check, m along the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift_m: Option<f64>,
}

/// When a zero was set or checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ZeroOccasion {
    /// Set, before the readings on it.
    Before,
    /// Checked, after the readings on it.
    After,
    /// Checked after an interruption, and kept.
    Kept,
}

/// A reading as taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TakenReading {
    /// Number of the reading in the session, from 1.
    pub number: u32,
    /// Place of the cell in the plan, from 0.
    pub cell: usize,
    /// Place in the readings planned for that cell, from 0.
    pub index: usize,
    /// The pose held.
    pub pose: String,
    /// The direction of the load.
    pub direction: LoadDirection,
    /// Loading or unloading.
    pub branch: Branch,
    /// Place in the load sequence.
    pub step: u32,
    /// n-th application.
    pub repeat: u32,
    /// n-th try.
    pub attempt: u32,
    /// Name of the gauge zero.
    pub zero: String,
    /// Target, N.
    pub target_n: f64,
    /// Force along the axis, N: what the gauge showed less what it showed unloaded.
    pub force_n: f64,
    /// The force gauge's own text.
    pub force_raw: String,
    /// Displacement from the zero along the axis, m. Of gauges along the base axes, that of the axis nearest to the load.
    pub displacement_m: f64,
    /// The displacement gauge's own text.
    pub displacement_raw: String,
    /// What the gauges showed at their zero, N and m in the sign as sent: it is taken off. Absent in journals of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zero_si: Option<[f64; 2]>,
    /// When the two samples arrived, s.
    pub samples_at_s: [f64; 2],
    /// Time under this load, s.
    pub hold_s: f64,
    /// Force when this load was begun, N: the direction of approach.
    pub approached_from_n: f64,
    /// By how much the force went past the target on the way, N.
    pub overshoot_n: f64,
    /// Last temperature entered, °C.
    pub temperature_deg_c: Option<f64>,
    /// Rule that flagged it and what the operator decided; empty for most.
    pub flag: String,
    /// What each displacement gauge along a base axis showed; none for one gauge along the load.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gauges: Vec<AxisReading>,
    /// Where the packets of the values lie in the traces, a gauge each, force first; none where no trace is kept.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub raw_bytes: Vec<RawBytes>,
    /// How the value stands to the limits of the procedure; none where it has no limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<LimitCheck>,
}

/// How a value stands to the limits of the procedure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct LimitCheck {
    /// In a word.
    pub verdict: LimitVerdict,
    /// The limit that is exceeded; empty if none is.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub exceeded: String,
}

/// What a displacement gauge along a base axis showed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AxisReading {
    /// Which gauge.
    pub channel: Channel,
    /// Displacement from the zero along the axis, m.
    pub displacement_m: f64,
    /// The gauge's own text.
    pub raw: String,
    /// What it showed at its zero, m in the sign as sent: it is taken off.
    pub zero_m: f64,
    /// When the sample arrived, s.
    pub at_s: f64,
}

impl JointSet {
    /// The value of a variable, rad or m, as it is kept.
    #[must_use]
    pub fn new(joint: &JointColumn, value_si: f64) -> Self {
        // The digits that tables have, so that journal and table agree.
        let written = joint.unit.written(value_si).parse().ok();
        let (deg, mm) = match joint.unit {
            JointUnit::Angle => (written, None),
            JointUnit::Length => (None, written),
        };
        Self {
            variable: joint.variable.clone(),
            deg,
            mm,
        }
    }

    /// The column of the variable, and its value, rad or m; `None` for a record without a value.
    #[must_use]
    pub fn column(&self) -> Option<(JointColumn, f64)> {
        let column = |unit| JointColumn {
            variable: self.variable.clone(),
            unit,
        };
        let angle = self
            .deg
            .map(|deg| (column(JointUnit::Angle), deg.to_radians()));
        angle.or_else(|| self.mm.map(|mm| (column(JointUnit::Length), mm / 1e3)))
    }
}

impl TakenReading {
    /// Displacement from the zero that a displacement gauge showed, m; `None` if it was not there.
    #[must_use]
    pub fn displacement_of(&self, channel: Channel) -> Option<f64> {
        match channel {
            Channel::Force => None,
            Channel::Displacement => self.gauges.is_empty().then_some(self.displacement_m),
            axis => Some(self.axis_reading(axis)?.displacement_m),
        }
    }

    /// The text of a gauge; empty if it was not there.
    #[must_use]
    pub fn raw_of(&self, channel: Channel) -> &str {
        match channel {
            Channel::Force => &self.force_raw,
            Channel::Displacement => &self.displacement_raw,
            axis => self.axis_reading(axis).map_or("", |of| &of.raw),
        }
    }

    /// When the sample of a gauge arrived, s; `None` if it was not there.
    #[must_use]
    pub fn sampled_at_s(&self, channel: Channel) -> Option<f64> {
        match channel {
            Channel::Force => Some(self.samples_at_s[0]),
            Channel::Displacement => self.gauges.is_empty().then_some(self.samples_at_s[1]),
            axis => Some(self.axis_reading(axis)?.at_s),
        }
    }

    /// The displacement along the load, m; `None` where the load has a component along an axis that no gauge reads.
    #[must_use]
    pub fn along_load_m(&self) -> Option<f64> {
        if self.gauges.is_empty() {
            return Some(self.displacement_m);
        }
        let components = Direction::ALL.into_iter().map(|axis| {
            let share = self.direction.along(axis);
            let read_m = self.displacement_of(Channel::along(axis));
            if share.abs() < NO_COMPONENT {
                Some(0.0)
            } else {
                read_m.map(|read_m| share * read_m)
            }
        });
        components.sum()
    }

    /// What the displacement gauges showed, in words.
    #[must_use]
    pub fn displacement_text(&self) -> String {
        if self.gauges.is_empty() {
            return format!("{:.1} um", self.displacement_m * 1e6);
        }
        let gauges = self.gauges.iter().map(|of| {
            let axis = of
                .channel
                .axis()
                .map_or_else(String::new, |axis| format!("{axis} "));
            format!("{axis}{:.1} um", of.displacement_m * 1e6)
        });
        gauges.collect::<Vec<_>>().join(", ")
    }

    fn axis_reading(&self, channel: Channel) -> Option<&AxisReading> {
        self.gauges.iter().find(|of| of.channel == channel)
    }
}

/// Components of a unit vector below this are none.
const NO_COMPONENT: f64 = 1e-9;

/// The operator's words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Noted {
    /// Place of the cell in the plan, from 0.
    pub cell: Option<usize>,
    /// The words.
    pub text: String,
}

/// How the line to a gauge stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct LinkChange {
    /// Which gauge.
    pub channel: Channel,
    /// What happened.
    pub text: String,
    /// Whether the gauge was away, and may have forgotten zero, unit or mode.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub lost: bool,
}

/// A time in which nothing ran.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Gap {
    /// How long, s.
    pub seconds: f64,
}

/// A clock that was set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClockJump {
    /// By how much UTC went ahead of session time, s.
    pub seconds: f64,
}

/// A pause.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Paused {
    /// Why.
    pub reason: String,
}

/// Something to know before the numbers are used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Warning {
    /// What.
    pub text: String,
}

/// How a session ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Ended {
    /// How.
    pub outcome: SessionEnd,
    /// Why.
    pub reason: String,
    /// By whom: the operator, by name where it is known, or `program`; absent in journals of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// Readings that count.
    pub accepted: u32,
    /// Readings that were planned.
    pub planned: u32,
}

/// How a session ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SessionEnd {
    /// Every planned reading was taken or skipped.
    Complete,
    /// Stopped at a safe point; it can be resumed.
    Partial,
    /// Stopped at once; it can be resumed.
    Aborted,
}
