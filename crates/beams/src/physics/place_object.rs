//! Places as results and answers write them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_units_and_text::test_point::{Direction, DirectionName, PoseId};

use crate::robot::SpringAxis;
use crate::structure::Property;

use super::place::Place;

/// A place as results and answers write it, for example `{"joint": "A3"}`.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "a place is an object such as {\"joint\": \"A3\"} or {\"gauge\": \"force\"}; the schema lists all of them"
)]
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
    Tool { tool: SpringAxis },
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
        gauge: GaugePlace,
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
        property: Option<Property>,
    },
    /// A mechanism of the robot file.
    Mechanism { mechanism: String },
}

/// The gauges by name.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(inline)]
pub(super) enum GaugePlace {
    Force,
    Displacement,
}

/// A run as results write it.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RunObject {
    pose: PoseId,
    direction: DirectionName,
    repeat: u32,
}

impl From<Place> for PlaceObject {
    fn from(place: Place) -> Self {
        match place {
            Place::Joint(joint) | Place::Slide(joint) => Self::Joint { joint, pose: None },
            Place::JointAngle { joint, pose } => Self::Joint { joint, pose },
            Place::AcrossJoint { joint, axis } => Self::AcrossJoint { joint, axis },
            Place::Tool(axis) => Self::Tool { tool: axis },
            Place::Length { body, entry } => Self::Length { body, entry },
            Place::Group { group, property } => Self::Group { group, property },
            Place::Mechanism(mechanism) => Self::Mechanism { mechanism },
            Place::Axis(axis) => Self::Axis { axis },
            Place::Direction(direction) => Self::Direction { direction },
            Place::Toward { direction, toward } => Self::Toward { direction, toward },
            Place::Element(element) => Self::Element { element },
            Place::ForceGauge => Self::Gauge {
                gauge: GaugePlace::Force,
                direction: None,
            },
            Place::DisplacementGauge(direction) => Self::Gauge {
                gauge: GaugePlace::Displacement,
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

/// Of a joint's angle in all poses the joint alone: which of the two is meant, only the law beside it decides.
impl TryFrom<PlaceObject> for Place {
    type Error = &'static str;

    fn try_from(object: PlaceObject) -> Result<Self, &'static str> {
        Ok(match object {
            PlaceObject::Joint { joint, pose: None } => Self::Joint(joint),
            PlaceObject::Joint { joint, pose } => Self::JointAngle { joint, pose },
            PlaceObject::AcrossJoint { joint, axis } => Self::AcrossJoint { joint, axis },
            PlaceObject::Tool { tool } => Self::Tool(tool),
            PlaceObject::Length { body, entry } => Self::Length { body, entry },
            PlaceObject::Group { group, property } => Self::Group { group, property },
            PlaceObject::Mechanism { mechanism } => Self::Mechanism(mechanism),
            PlaceObject::Axis { axis } => Self::Axis(axis),
            PlaceObject::Direction { direction } => Self::Direction(direction),
            PlaceObject::Toward { direction, toward } => Self::Toward { direction, toward },
            PlaceObject::Element { element } => Self::Element(element),
            PlaceObject::Gauge {
                gauge: GaugePlace::Force,
                direction: None,
            } => Self::ForceGauge,
            PlaceObject::Gauge {
                gauge: GaugePlace::Force,
                ..
            } => return Err("there is one force gauge: its place has no direction"),
            PlaceObject::Gauge { direction, .. } => Self::DisplacementGauge(direction),
            PlaceObject::Structure { structure: true } => Self::Structure,
            PlaceObject::Clock {
                clock: true,
                direction,
            } => Self::Clock(direction),
            PlaceObject::Structure { .. } | PlaceObject::Clock { .. } => {
                return Err("structure and clock are true where they are the place");
            }
            PlaceObject::Run {
                run,
                step,
                direction: gauge,
            } => Self::Run {
                pose: run.pose,
                direction: run.direction,
                repeat: run.repeat,
                step,
                gauge,
            },
        })
    }
}
