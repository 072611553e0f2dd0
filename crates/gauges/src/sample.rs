//! One value of a gauge, with everything that came with it.

use std::fmt;

use serde::Serialize;

use stiffbench_units_and_text::quantity::Kind;

/// Which of the two gauges of a bench.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    serde::Deserialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Channel {
    /// The force gauge (tension-compression dynamometer).
    Force,
    /// The dial or length gauge.
    Displacement,
}

impl Channel {
    /// Both, force first.
    pub const ALL: [Self; 2] = [Self::Force, Self::Displacement];

    /// What this gauge measures.
    #[must_use]
    pub fn kind(self) -> Kind {
        match self {
            Self::Force => Kind::Force,
            Self::Displacement => Kind::Displacement,
        }
    }

    /// 0 for force, 1 for displacement.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// Something that a gauge reports about a value besides the value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mark {
    /// The gauge was not asked: a foot switch, a DATA key, or a stream that was left on.
    Unrequested,
    /// The battery is low.
    LowBattery,
    /// The gauge reports that the value still moves.
    Unstable,
    /// Below the lower limit set at the gauge.
    BelowLimit,
    /// Between the limits set at the gauge.
    WithinLimits,
    /// Above the upper limit set at the gauge.
    AboveLimit,
}

/// One value of a gauge. Values that must not be used (overload, peak mode, hold, a wrong unit) are never samples but [`Rejected`].
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Force or displacement.
    pub kind: Kind,
    /// The value in the sign as sent, N or m.
    pub value_si: f64,
    /// Step of the last digit sent, N or m.
    pub resolution_si: f64,
    /// The value as a number in `unit`, in the sign as sent.
    pub value: f64,
    /// The unit of the packet, or the configured one where packets carry none; spelling of [`Kind::si_factor`].
    pub unit: Box<str>,
    /// The packet as it came, without its end mark; bytes that are not printable ASCII as `\xNN`.
    pub raw: Box<str>,
    /// When its last byte arrived, s of the clock that the decoder was given.
    pub at_s: f64,
    /// What came with the value.
    pub marks: Vec<Mark>,
}

/// Bytes that are no sample, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rejected {
    /// The bytes as they came; those that are not printable ASCII as `\xNN`.
    pub raw: Box<str>,
    /// Why, and what to do about it where the operator can.
    pub reason: Box<str>,
    /// When the last of them arrived, s.
    #[serde(skip)]
    pub at_s: f64,
}
