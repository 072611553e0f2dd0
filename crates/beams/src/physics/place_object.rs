//! Places as results and answers write them.

use schemars::JsonSchema;
use serde::Serialize;
use stiffbench_units_and_text::test_point::{Direction, DirectionName, PoseId};

use crate::structure::Property;

use super::place::Place;

/// A place as results and answers write it, for example `{"joint": "A3"}`.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
#[schemars(deny_unknown_fields)]
pub(super) enum PlaceObject {
    /// A joint of the robot, by name; of its angle the pose, if it is wrong in one only.
    Joint {
        joint: String,
        #[serde(skip_serializing_if = "Option::is_none")]
        pose: Option<PoseId>,
    },
    /// An axis of a joint's frame across the joint's own.
    AcrossJoint { joint: String, axis: Direction },
    /// The tool, along x, y, z or about rx, ry, rz of its frame.
    Tool {
        #[schemars(extend("enum" = ["x", "y", "z", "rx", "ry", "rz"]))]
        tool: &'static str,
    },
    /// An axis through the first support.
    Axis { axis: Direction },
    /// A direction of measurement.
    Direction { direction: Direction },
    /// A direction of loading, and the axis toward which the force turns.
    Toward {
        direction: Direction,
        toward: Direction,
    },
    /// An element of the robot, by name.
    Element { element: String },
    /// A gauge.
    Gauge {
        #[schemars(extend("enum" = ["force", "displacement"]))]
        gauge: &'static str,
        /// Of several displacement gauges the axis of this one.
        #[serde(skip_serializing_if = "Option::is_none")]
        direction: Option<Direction>,
    },
    /// The whole structure.
    Structure {
        #[schemars(extend("const" = true))]
        structure: bool,
    },
    /// The clock.
    Clock {
        #[schemars(extend("const" = true))]
        clock: bool,
        /// Of several displacement gauges the axis of the one that it moves.
        #[serde(skip_serializing_if = "Option::is_none")]
        direction: Option<Direction>,
    },
    /// One run, from one step on.
    Run {
        run: RunObject,
        step: u32,
        /// Of several displacement gauges the axis of the one that it moves.
        #[serde(skip_serializing_if = "Option::is_none")]
        direction: Option<Direction>,
    },
    /// A length in the robot file.
    Length { body: String, entry: String },
    /// A group of elements; of one section constant, if not of all.
    Group {
        group: String,
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schemars(extend("enum" = ["A", "Iy", "Iz", "J"]))]
        property: Option<&'static str>,
    },
    /// A mechanism of the robot file.
    Mechanism { mechanism: String },
}

/// A run as results write it.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RunObject {
    pose: PoseId,
    direction: DirectionName,
    repeat: u32,
}

impl From<Place> for PlaceObject {
    fn from(place: Place) -> Self {
        match place {
            Place::Joint(joint) => Self::Joint { joint, pose: None },
            Place::JointAngle { joint, pose } => Self::Joint { joint, pose },
            Place::AcrossJoint { joint, axis } => Self::AcrossJoint { joint, axis },
            Place::Tool(axis) => Self::Tool { tool: axis.name() },
            Place::Length { body, entry } => Self::Length { body, entry },
            Place::Group { group, property } => Self::Group {
                group,
                property: property.map(Property::name),
            },
            Place::Mechanism(mechanism) => Self::Mechanism { mechanism },
            Place::Axis(axis) => Self::Axis { axis },
            Place::Direction(direction) => Self::Direction { direction },
            Place::Toward { direction, toward } => Self::Toward { direction, toward },
            Place::Element(element) => Self::Element { element },
            Place::ForceGauge => Self::Gauge {
                gauge: "force",
                direction: None,
            },
            Place::DisplacementGauge(direction) => Self::Gauge {
                gauge: "displacement",
                direction,
            },
            Place::Structure => Self::Structure { structure: true },
            Place::Clock(direction) => Self::Clock {
                clock: true,
                direction,
            },
            Place::Run {
                pose,
                direction,
                repeat,
                step,
                gauge,
            } => Self::Run {
                direction: gauge,
                run: RunObject {
                    pose,
                    direction,
                    repeat,
                },
                step,
            },
        }
    }
}
