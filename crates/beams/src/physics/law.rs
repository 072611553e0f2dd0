//! The laws, by name: what each says, which parameters it has, and how large they may plausibly be.

use std::fmt;

use serde::Serialize;

use super::place::PlaceKind;

/// A physics that a beam model leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Law {
    /// A joint turns in proportion to its moment.
    JointCompliance,
    /// A joint turns freely through its play once its seat is overcome.
    JointBacklash,
    /// A joint sticks until its friction moment, then turns as a spring, and sticks again on reversal.
    JointFriction,
    /// A joint turns by a linear and a quadratic term of its moment.
    JointNonlinearity,
    /// All supports rock as one body.
    BaseCompliance,
    /// The stand of the dial gauge gives way in one direction.
    GaugeStandCompliance,
    /// The force acts turned toward another axis.
    LoadMisalignment,
    /// An element carries nothing.
    LooseMember,
    /// The force gauge is not linear.
    ForceGaugeNonlinearity,
    /// Displacement grows with the logarithm of the time under load.
    Creep,
    /// The reading drifts with the clock.
    DriftPerSecond,
    /// The reading drifts with the temperature.
    DriftPerKelvin,
    /// The first repeats give more than the later ones.
    SettingIn,
    /// Something slipped, once.
    Slip,
    /// The dial gauge has a periodic error.
    GaugePeriodic,
}

/// Which values a parameter can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Sign {
    /// Physics allows positive values only.
    Positive,
    /// Both signs are possible.
    Either,
}

/// One parameter of a law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterSpec {
    /// Name in files.
    pub name: &'static str,
    /// Unit in files, which is SI.
    pub unit: &'static str,
    /// Sign that physics allows.
    pub sign: Sign,
    /// Whether zero is impossible, because the law divides by it.
    pub divides: bool,
}

impl ParameterSpec {
    /// Which values it can have, in words.
    #[must_use]
    pub fn allowed(&self) -> &'static str {
        match (self.sign, self.divides) {
            (Sign::Positive, true) => "above zero",
            (Sign::Positive, false) => "not below zero",
            (Sign::Either, _) => "of either sign",
        }
    }

    /// Whether physics allows a value.
    #[must_use]
    pub fn allows(&self, value: f64) -> bool {
        let sign = match (self.sign, self.divides) {
            (Sign::Positive, true) => value > 0.0,
            (Sign::Positive, false) => value >= 0.0,
            (Sign::Either, _) => true,
        };
        value.is_finite() && sign
    }
}

const fn positive(name: &'static str, unit: &'static str) -> ParameterSpec {
    ParameterSpec {
        name,
        unit,
        sign: Sign::Positive,
        divides: false,
    }
}

const fn divisor(name: &'static str, unit: &'static str) -> ParameterSpec {
    ParameterSpec {
        name,
        unit,
        sign: Sign::Positive,
        divides: true,
    }
}

const fn signed(name: &'static str, unit: &'static str) -> ParameterSpec {
    ParameterSpec {
        name,
        unit,
        sign: Sign::Either,
        divides: false,
    }
}

/// Unit of a joint's compliance.
const RAD_PER_NM: &str = "rad/(N*m)";

impl Law {
    /// Every law, in the order of the library.
    pub const ALL: [Self; 15] = [
        Self::JointCompliance,
        Self::JointBacklash,
        Self::JointFriction,
        Self::JointNonlinearity,
        Self::BaseCompliance,
        Self::GaugeStandCompliance,
        Self::LoadMisalignment,
        Self::LooseMember,
        Self::ForceGaugeNonlinearity,
        Self::Creep,
        Self::DriftPerSecond,
        Self::DriftPerKelvin,
        Self::SettingIn,
        Self::Slip,
        Self::GaugePeriodic,
    ];

    /// Name in files; the unit of `rate` tells the two drifts apart.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::JointCompliance => "joint-compliance",
            Self::JointBacklash => "joint-backlash",
            Self::JointFriction => "joint-friction",
            Self::JointNonlinearity => "joint-nonlinearity",
            Self::BaseCompliance => "base-compliance",
            Self::GaugeStandCompliance => "gauge-stand-compliance",
            Self::LoadMisalignment => "load-misalignment",
            Self::LooseMember => "loose-member",
            Self::ForceGaugeNonlinearity => "force-gauge-nonlinearity",
            Self::Creep => "creep",
            Self::DriftPerSecond | Self::DriftPerKelvin => "thermal-drift",
            Self::SettingIn => "setting-in",
            Self::Slip => "slip",
            Self::GaugePeriodic => "gauge-periodic",
        }
    }

    /// The laws of a name: one, or the two drifts.
    pub fn named(name: &str) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |law| law.name() == name)
    }

    /// The equation, in ASCII.
    #[must_use]
    pub fn equation(self) -> &'static str {
        match self {
            Self::JointCompliance => "twist = c tau",
            Self::JointBacklash => {
                "twist = 0 for |tau| < seat_moment, then taken up at |tau| = seat_moment until |twist| = play"
            }
            Self::JointFriction => {
                "stuck for |tau| <= friction_moment, then twist = c (tau -/+ friction_moment); stuck again on reversal"
            }
            Self::JointNonlinearity => "twist = c tau + q tau |tau|",
            Self::BaseCompliance => {
                "all supports rock about the axis through the first one by c times the moment"
            }
            Self::GaugeStandCompliance => "displacement += c F",
            Self::LoadMisalignment => {
                "the force acts turned by angle; displacement is read along the direction"
            }
            Self::LooseMember => "the element carries nothing",
            Self::ForceGaugeNonlinearity => "true force = F (1 + q |F|)",
            Self::Creep => "displacement * (1 + k log10(1 + hold/t0))",
            Self::DriftPerSecond => "displacement += rate (t - t at the zero)",
            Self::DriftPerKelvin => "displacement += rate (T - T at the zero)",
            Self::SettingIn => "displacement * (1 + k exp(-(repeat - 1)/decay))",
            Self::Slip => "displacement += jump from that step of that run on",
            Self::GaugePeriodic => {
                "displacement += amplitude sin(2 pi displacement/period + phase)"
            }
        }
    }

    /// Its parameters; the first is its size, the others its shape.
    #[must_use]
    pub fn parameters(self) -> &'static [ParameterSpec] {
        const COMPLIANCE: &[ParameterSpec] = &[positive("c", RAD_PER_NM)];
        const BACKLASH: &[ParameterSpec] =
            &[positive("play", "rad"), positive("seat_moment", "N*m")];
        const FRICTION: &[ParameterSpec] = &[
            positive("c", RAD_PER_NM),
            positive("friction_moment", "N*m"),
        ];
        const NONLINEARITY: &[ParameterSpec] =
            &[positive("c", RAD_PER_NM), signed("q", "rad/(N*m)^2")];
        const STAND: &[ParameterSpec] = &[positive("c", "m/N")];
        const ANGLE: &[ParameterSpec] = &[signed("angle", "rad")];
        const FORCE: &[ParameterSpec] = &[signed("q", "1/N")];
        const CREEP: &[ParameterSpec] = &[positive("k", "1/decade"), divisor("t0", "s")];
        const PER_SECOND: &[ParameterSpec] = &[signed("rate", "m/s")];
        const PER_KELVIN: &[ParameterSpec] = &[signed("rate", "m/K")];
        const SETTING: &[ParameterSpec] = &[signed("k", "1"), divisor("decay", "repeats")];
        const SLIP: &[ParameterSpec] = &[signed("jump", "m")];
        const PERIODIC: &[ParameterSpec] = &[
            positive("amplitude", "m"),
            divisor("period", "m"),
            signed("phase", "rad"),
        ];
        match self {
            Self::JointCompliance | Self::BaseCompliance => COMPLIANCE,
            Self::JointBacklash => BACKLASH,
            Self::JointFriction => FRICTION,
            Self::JointNonlinearity => NONLINEARITY,
            Self::GaugeStandCompliance => STAND,
            Self::LoadMisalignment => ANGLE,
            Self::LooseMember => &[],
            Self::ForceGaugeNonlinearity => FORCE,
            Self::Creep => CREEP,
            Self::DriftPerSecond => PER_SECOND,
            Self::DriftPerKelvin => PER_KELVIN,
            Self::SettingIn => SETTING,
            Self::Slip => SLIP,
            Self::GaugePeriodic => PERIODIC,
        }
    }

    /// The kind of place where the law acts.
    #[must_use]
    pub fn place_kind(self) -> PlaceKind {
        match self {
            Self::JointCompliance
            | Self::JointBacklash
            | Self::JointFriction
            | Self::JointNonlinearity => PlaceKind::Joint,
            Self::BaseCompliance => PlaceKind::Axis,
            Self::GaugeStandCompliance => PlaceKind::Direction,
            Self::LoadMisalignment => PlaceKind::Toward,
            Self::LooseMember => PlaceKind::Element,
            Self::ForceGaugeNonlinearity => PlaceKind::ForceGauge,
            Self::Creep | Self::SettingIn => PlaceKind::Structure,
            Self::DriftPerSecond | Self::DriftPerKelvin => PlaceKind::Clock,
            Self::Slip => PlaceKind::Run,
            Self::GaugePeriodic => PlaceKind::DisplacementGauge,
        }
    }

    /// Whether the law sits in one joint.
    #[must_use]
    pub fn is_of_a_joint(self) -> bool {
        self.place_kind() == PlaceKind::Joint
    }

    /// Whether this law contains `simpler` at the same place, as friction and nonlinearity contain compliance.
    #[must_use]
    pub fn contains(self, simpler: Self) -> bool {
        simpler == Self::JointCompliance
            && matches!(self, Self::JointFriction | Self::JointNonlinearity)
    }
}

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
