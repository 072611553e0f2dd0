//! One value of a gauge, with everything that came with it.

use std::fmt;

use serde::Serialize;

use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::test_point::Direction;

/// Which gauge of a bench: force, and one displacement along the load or up to three along the base axes.
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
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// The force gauge (tension-compression dynamometer).
    Force,
    /// The dial or length gauge, mounted along the load.
    Displacement,
    /// The displacement gauge along the base axis x.
    DisplacementX,
    /// The displacement gauge along the base axis y.
    DisplacementY,
    /// The displacement gauge along the base axis z.
    DisplacementZ,
}

impl Channel {
    /// The two of a bench with one displacement gauge, force first. Each stands for what it measures.
    pub const ALL: [Self; 2] = [Self::Force, Self::Displacement];

    /// How many channels there are: the length of a list by [`Channel::index`].
    pub const COUNT: usize = 5;

    /// Every channel, in the order of [`Channel::index`].
    pub const EVERY: [Self; Self::COUNT] = [
        Self::Force,
        Self::Displacement,
        Self::DisplacementX,
        Self::DisplacementY,
        Self::DisplacementZ,
    ];

    /// The displacement gauge along a base axis.
    #[must_use]
    pub fn along(axis: Direction) -> Self {
        match axis {
            Direction::X => Self::DisplacementX,
            Direction::Y => Self::DisplacementY,
            Direction::Z => Self::DisplacementZ,
        }
    }

    /// The base axis along which a displacement gauge stands; `None` for the others.
    #[must_use]
    pub fn axis(self) -> Option<Direction> {
        match self {
            Self::Force | Self::Displacement => None,
            Self::DisplacementX => Some(Direction::X),
            Self::DisplacementY => Some(Direction::Y),
            Self::DisplacementZ => Some(Direction::Z),
        }
    }

    /// Whether it is a displacement gauge.
    #[must_use]
    pub fn is_displacement(self) -> bool {
        self != Self::Force
    }

    /// Its key in files: `force`, `displacement`, `displacement_x`, ….
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Force => "force",
            Self::Displacement => "displacement",
            Self::DisplacementX => "displacement_x",
            Self::DisplacementY => "displacement_y",
            Self::DisplacementZ => "displacement_z",
        }
    }

    /// What this gauge measures.
    #[must_use]
    pub fn kind(self) -> Kind {
        match self {
            Self::Force => Kind::Force,
            _ => Kind::Displacement,
        }
    }

    /// 0 for force, 1 for displacement, 2 to 4 for displacement along x, y, z.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Force => "force",
            Self::Displacement => "displacement",
            Self::DisplacementX => "displacement-x",
            Self::DisplacementY => "displacement-y",
            Self::DisplacementZ => "displacement-z",
        })
    }
}

/// Something that a gauge reports about a value besides the value.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Mark {
    /// The gauge was not asked: a foot switch, a DATA key, or a stream that was left on.
    // No text of a packet states it.
    #[serde(skip_deserializing)]
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

/// One value of a gauge. Values that must not be used (overload, peak mode, hold, a wrong unit) are never samples but rejected.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
#[schemars(rename = "DecodedValue")]
pub struct Sample {
    /// Force or displacement.
    #[serde(skip)]
    pub kind: Kind,
    /// The value in the sign as sent, N or m.
    #[serde(skip)]
    pub value_si: f64,
    /// Step of the last digit sent, N or m.
    #[serde(skip)]
    pub resolution_si: f64,
    /// The value as a number in `unit`, in the sign as sent.
    pub value: f64,
    // Spelling of [`Kind::si_factor`].
    /// The unit of the packet, or the configured one where packets carry none.
    pub unit: Box<str>,
    /// The packet as it came, without its end mark; bytes that are not printable ASCII as `\xNN`.
    pub raw: Box<str>,
    /// When its last byte arrived, s of the clock that the decoder was given.
    #[serde(skip)]
    pub at_s: f64,
    /// Where its packet lies among all bytes that the gauge sent: the first of them, from 0, and the one behind the last.
    #[serde(skip)]
    pub bytes: [u64; 2],
    /// What came with the value.
    pub marks: Vec<Mark>,
}

/// Bytes that are no sample, and why.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
#[schemars(rename = "RejectedPacket")]
pub struct Rejected {
    /// The bytes as they came; those that are not printable ASCII as `\xNN`.
    pub raw: Box<str>,
    /// Why, and what to do about it where the operator can.
    pub reason: Box<str>,
    /// When the last of them arrived, s.
    #[serde(skip)]
    pub at_s: f64,
}
