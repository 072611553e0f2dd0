//! Where a law acts.

use std::fmt;

use crate::test_point::{Direction, PoseId};

/// The place of an effect, as it stands in files.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Place {
    /// A joint of the robot, by name.
    Joint(String),
    /// An axis through the first support.
    Axis(Direction),
    /// A direction of measurement.
    Direction(Direction),
    /// A direction of loading, turned toward another axis.
    Toward {
        /// Direction of loading.
        direction: Direction,
        /// Axis toward which the force turns.
        toward: Direction,
    },
    /// An element of the robot, by name.
    Element(String),
    /// The force gauge.
    ForceGauge,
    /// The displacement gauge.
    DisplacementGauge,
    /// The whole structure.
    Structure,
    /// The clock.
    Clock,
    /// One run, from one step on.
    Run {
        /// The pose held.
        pose: PoseId,
        /// The direction loaded.
        direction: Direction,
        /// The repeat.
        repeat: u32,
        /// The step from which on it acts.
        step: u32,
    },
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Joint(joint) => write!(f, "joint {joint}"),
            Self::Axis(axis) => write!(f, "the base, about {axis}"),
            Self::Direction(direction) => write!(f, "direction {direction}"),
            Self::Toward { direction, toward } => write!(f, "{direction} toward {toward}"),
            Self::Element(element) => write!(f, "element {element}"),
            Self::ForceGauge => f.write_str("the force gauge"),
            Self::DisplacementGauge => f.write_str("the displacement gauge"),
            Self::Structure => f.write_str("the structure"),
            Self::Clock => f.write_str("the clock"),
            Self::Run {
                pose,
                direction,
                repeat,
                step,
            } => write!(f, "{pose} {direction}, repeat {repeat}, from step {step}"),
        }
    }
}

impl Place {
    /// The JSON form, for example `{"joint": "A3"}`.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        use serde_json::json;
        match self {
            Self::Joint(joint) => json!({ "joint": joint }),
            Self::Axis(axis) => json!({ "axis": axis.word() }),
            Self::Direction(direction) => json!({ "direction": direction.word() }),
            Self::Toward { direction, toward } => {
                json!({ "direction": direction.word(), "toward": toward.word() })
            }
            Self::Element(element) => json!({ "element": element }),
            Self::ForceGauge => json!({ "gauge": "force" }),
            Self::DisplacementGauge => json!({ "gauge": "displacement" }),
            Self::Structure => json!({ "structure": true }),
            Self::Clock => json!({ "clock": true }),
            Self::Run {
                pose,
                direction,
                repeat,
                step,
            } => json!({
                "run": { "pose": pose.as_str(), "direction": direction.word(), "repeat": repeat },
                "step": step
            }),
        }
    }
}
