//! Where a law acts.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_units_and_text::test_point::{Direction, DirectionName, PoseId};

use crate::robot::{JointMotion, ModelParameter, SpringAxis};
use crate::structure::Property;

use super::place_object::PlaceObject;

/// Kinds of places; each law has one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaceKind {
    /// A joint.
    Joint,
    /// An axis of a joint's frame across the joint's own.
    AcrossJoint,
    /// An axis of the tool that it turns about.
    ToolAbout,
    /// An axis of the tool that it moves along.
    ToolAlong,
    /// An axis through the first support.
    Axis,
    /// A direction of measurement.
    Direction,
    /// A direction of loading and the axis toward which the force turns.
    Toward,
    /// An element.
    Element,
    /// The force gauge.
    ForceGauge,
    /// The displacement gauge.
    DisplacementGauge,
    /// The whole structure.
    Structure,
    /// The clock.
    Clock,
    /// One run, from one step on.
    Run,
    /// A length in the robot file.
    Length,
    /// The angle of a joint, in all poses or in one.
    JointAngle,
    /// A group of elements with common factors.
    Group,
    /// A mechanism of the robot file.
    Mechanism,
}

impl PlaceKind {
    /// Whether an effect there is one of the robot, not of the bench: of gauges, their stand, the load's direction, time and repeats.
    #[must_use]
    pub fn is_of_robot(self) -> bool {
        matches!(
            self,
            Self::Joint
                | Self::AcrossJoint
                | Self::ToolAbout
                | Self::ToolAlong
                | Self::Axis
                | Self::Element
        )
    }

    /// What stands behind the `@` on the command line, as an example.
    #[must_use]
    pub fn example(self) -> &'static str {
        match self {
            Self::Joint => "@A3",
            Self::AcrossJoint => "@A3.y",
            Self::ToolAbout => "@rx",
            Self::ToolAlong => "@x",
            Self::Axis => "@x",
            Self::Direction => "@y",
            Self::Toward => "@y>z",
            Self::Element => "@A3B1",
            Self::ForceGauge => "@force",
            Self::DisplacementGauge => "@displacement",
            Self::Structure => "@structure",
            Self::Clock => "@clock",
            Self::Run => "@P3.z.2.5",
            Self::Length => "@upper_arm.l_A3A4",
            Self::JointAngle => "@A3",
            Self::Group => "@link.Iy",
            Self::Mechanism => "@B",
        }
    }

    /// What a place of this kind is, in words.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Joint => "the name of a joint",
            Self::AcrossJoint => {
                "the name of a joint, a point, and an axis of its frame perpendicular to the joint axis"
            }
            Self::ToolAbout => "rx, ry or rz, about that axis of the tool",
            Self::ToolAlong => "x, y or z, along that axis of the tool",
            Self::Axis => "an axis, x, y or z, through the first support",
            Self::Direction => "a direction, x, y or z",
            Self::Toward => "the direction of the load, >, and another axis",
            Self::Element => "the name of an element",
            Self::ForceGauge => "the force gauge",
            Self::DisplacementGauge => "the displacement gauge",
            Self::Structure => "the structure",
            Self::Clock => "the clock",
            Self::Run => "pose, direction, repeat and first step of a run, separated by points",
            Self::Length => {
                "a body, a point, and the entry of the robot file that states its length"
            }
            Self::JointAngle => {
                "the name of a joint; then / and a pose, if only that pose is wrong"
            }
            Self::Group => {
                "link, beam or a group of elements; then a point and a section constant, if only that one is wrong"
            }
            Self::Mechanism => "a mechanism of the robot file",
        }
    }

    /// The place, where there is but one of this kind; of displacement gauges and what a clock moves in them, where there is one gauge.
    #[must_use]
    pub fn only(self) -> Option<Place> {
        match self {
            Self::ForceGauge => Some(Place::ForceGauge),
            Self::DisplacementGauge => Some(Place::DisplacementGauge(None)),
            Self::Structure => Some(Place::Structure),
            Self::Clock => Some(Place::Clock(None)),
            _ => None,
        }
    }

    /// Reads what stands behind the `@` on the command line; `None` if it is no such place.
    #[must_use]
    pub fn read(self, text: &str) -> Option<Place> {
        let name = (!text.is_empty()).then(|| text.to_owned());
        match self {
            Self::Joint => name.map(Place::Joint),
            Self::AcrossJoint => {
                let (joint, axis) = text.rsplit_once('.')?;
                let axis = axis.parse().ok()?;
                let joint = joint.to_owned();
                (!joint.is_empty()).then_some(Place::AcrossJoint { joint, axis })
            }
            Self::ToolAbout | Self::ToolAlong => {
                let place = Place::Tool(text.parse().ok()?);
                (place.kind() == self).then_some(place)
            }
            Self::Element => name.map(Place::Element),
            Self::Axis => text.parse().ok().map(Place::Axis),
            Self::Direction => text.parse().ok().map(Place::Direction),
            Self::Toward => {
                let (direction, toward) = text.split_once('>')?;
                let direction = direction.trim().parse().ok()?;
                let toward = toward.trim().parse().ok()?;
                (direction != toward).then_some(Place::Toward { direction, toward })
            }
            Self::Run => {
                let (text, gauge) = gauge_behind(text, '/');
                // Names of poses may have points in them: the last three parts are the others.
                let mut parts = text.rsplitn(3, '.');
                let step = parts.next()?.parse().ok()?;
                let repeat = parts.next()?.parse().ok()?;
                let cell = parts.next()?;
                // So have the components of a direction in brackets.
                let (pose, direction) = if cell.ends_with(')') {
                    let (pose, rest) = cell.rsplit_once(".(")?;
                    (pose, &cell[cell.len() - rest.len() - 1..])
                } else {
                    cell.rsplit_once('.')?
                };
                let is_named = !(pose.is_empty() || direction.is_empty());
                is_named.then(|| Place::Run {
                    pose: PoseId::new(pose),
                    direction: DirectionName::new(direction),
                    repeat,
                    step,
                    gauge,
                })
            }
            Self::Length => {
                let (body, entry) = text.split_once('.')?;
                let is_full = !(body.is_empty() || entry.is_empty());
                is_full.then(|| Place::Length {
                    body: body.to_owned(),
                    entry: entry.to_owned(),
                })
            }
            Self::JointAngle => {
                let (joint, pose) = match text.rsplit_once('/') {
                    Some((joint, pose)) => (
                        joint,
                        Some(PoseId::new(Some(pose).filter(|pose| !pose.is_empty())?)),
                    ),
                    None => (text, None),
                };
                let joint = joint.to_owned();
                (!joint.is_empty()).then_some(Place::JointAngle { joint, pose })
            }
            Self::Group => {
                let (group, property) = match text.rsplit_once('.') {
                    Some((group, last)) if property(last).is_some() => (group, property(last)),
                    _ => (text, None),
                };
                let group = group.to_owned();
                (!group.is_empty()).then_some(Place::Group { group, property })
            }
            Self::Mechanism => name.map(Place::Mechanism),
            Self::DisplacementGauge => match gauge_behind(text, '.') {
                ("displacement", axis) => Some(Place::DisplacementGauge(axis)),
                _ => None,
            },
            Self::Clock => match gauge_behind(text, '.') {
                ("clock", axis) => Some(Place::Clock(axis)),
                _ => None,
            },
            Self::ForceGauge | Self::Structure => {
                let place = self.only()?;
                (place.compact() == text).then_some(place)
            }
        }
    }
}

/// A text without the axis of one of several gauges behind it, and the axis.
fn gauge_behind(text: &str, mark: char) -> (&str, Option<Direction>) {
    let behind = text.rsplit_once(mark);
    let with_axis = behind.and_then(|(text, axis)| Some((text, axis.parse().ok()?)));
    with_axis.map_or((text, None), |(text, axis)| (text, Some(axis)))
}

/// The place of an effect, as it stands in files.
#[derive(
    Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(into = "PlaceObject", try_from = "PlaceObject")]
pub enum Place {
    /// A joint of the robot that turns, by name.
    Joint(String),
    /// A joint of the robot that slides, by name: laws of joints act along it, in units of translation.
    Slide(String),
    /// An axis of a joint's frame across the joint's own.
    AcrossJoint {
        /// The joint.
        joint: String,
        /// The axis of its frame; x is the joint's own.
        axis: Direction,
    },
    /// The tool, along or about an axis of its frame.
    Tool(SpringAxis),
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
    /// The displacement gauge; of several the one along an axis.
    DisplacementGauge(Option<Direction>),
    /// The whole structure.
    Structure,
    /// The clock; of what it moves in several gauges that of the one along an axis.
    Clock(Option<Direction>),
    /// One run, from one step on.
    Run {
        /// The pose held.
        pose: PoseId,
        /// The direction loaded.
        direction: DirectionName,
        /// The repeat.
        repeat: u32,
        /// The step from which on it acts.
        step: u32,
        /// Of several gauges the axis of the one whose readings it moves.
        gauge: Option<Direction>,
    },
    /// A length in the robot file.
    Length {
        /// The body whose length it is.
        body: String,
        /// The entry that states it.
        entry: String,
    },
    /// The angle of a joint.
    JointAngle {
        /// The joint.
        joint: String,
        /// The pose in which it is wrong; all if `None`.
        pose: Option<PoseId>,
    },
    /// A group of elements with common factors.
    Group {
        /// `beam`, `link` or a group of the robot file.
        group: String,
        /// The section constant; all if `None`.
        property: Option<Property>,
    },
    /// A mechanism of the robot file.
    Mechanism(String),
}

/// The section constant of a name.
fn property(name: &str) -> Option<Property> {
    Property::ALL
        .into_iter()
        .find(|property| property.name() == name)
}

impl Place {
    /// A joint as it moves.
    #[must_use]
    pub fn of_joint(name: &str, motion: JointMotion) -> Self {
        match motion {
            JointMotion::Turns => Self::Joint(name.to_owned()),
            JointMotion::Slides => Self::Slide(name.to_owned()),
        }
    }

    /// The joint in which a law sits there; `None` of places that are no joint's own motion.
    #[must_use]
    pub fn joint(&self) -> Option<&str> {
        match self {
            Self::Joint(name) | Self::Slide(name) => Some(name),
            _ => None,
        }
    }

    /// The places that the writing of one may mean: a joint turns or slides, which the units of the parameters beside it decide.
    pub(super) fn meant(self) -> impl Iterator<Item = Self> {
        let slide = match &self {
            Self::Joint(name) => Some(Self::Slide(name.clone())),
            _ => None,
        };
        std::iter::once(self).chain(slide)
    }

    /// Name of the joint that stands for a part without a robot file.
    pub const PART: &str = "specimen";

    /// The place as one of a kind: a joint as its angle where the kind is that.
    #[must_use]
    pub fn of(self, kind: PlaceKind) -> Self {
        match self {
            Self::Joint(joint) if kind == PlaceKind::JointAngle => {
                Self::JointAngle { joint, pose: None }
            }
            other => other,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Joint(joint) if joint == Self::PART => f.write_str("the part"),
            Self::Joint(joint) | Self::Slide(joint) => write!(f, "joint {joint}"),
            Self::AcrossJoint { joint, axis } => {
                write!(f, "joint {joint}, about {axis} of its frame")
            }
            Self::Tool(axis) => {
                let how = if axis.turns() { "about" } else { "along" };
                let axis = Direction::ALL[axis.index() % 3];
                write!(f, "the tool, {how} its {axis}")
            }
            Self::Axis(axis) => write!(f, "the base, about {axis}"),
            Self::Direction(direction) => write!(f, "direction {direction}"),
            Self::Toward { direction, toward } => write!(f, "{direction} toward {toward}"),
            Self::Element(element) => write!(f, "element {element}"),
            Self::ForceGauge => f.write_str("the force gauge"),
            Self::DisplacementGauge(None) => f.write_str("the displacement gauge"),
            Self::DisplacementGauge(Some(axis)) => {
                write!(f, "the displacement gauge along {axis}")
            }
            Self::Structure => f.write_str("the structure"),
            Self::Clock(None) => f.write_str("the clock"),
            Self::Clock(Some(axis)) => write!(f, "the clock, in the gauge along {axis}"),
            Self::Run {
                pose,
                direction,
                repeat,
                step,
                gauge,
            } => {
                write!(f, "{pose} {direction}, repeat {repeat}, from step {step}")?;
                match gauge {
                    Some(axis) => write!(f, ", gauge along {axis}"),
                    None => Ok(()),
                }
            }
            Self::Length { body, entry } => write!(f, "length {entry} of {body}"),
            Self::JointAngle { joint, pose: None } => write!(f, "angle of joint {joint}"),
            Self::JointAngle {
                joint,
                pose: Some(pose),
            } => {
                write!(f, "angle of joint {joint} in pose {pose}")
            }
            Self::Group {
                group,
                property: None,
            } => write!(f, "factors of {group}"),
            Self::Group {
                group,
                property: Some(property),
            } => {
                write!(f, "factor {group}.{}", property.name())
            }
            Self::Mechanism(mechanism) => write!(f, "mechanism {mechanism}"),
        }
    }
}

impl Place {
    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> PlaceKind {
        match self {
            Self::Joint(_) | Self::Slide(_) => PlaceKind::Joint,
            Self::AcrossJoint { .. } => PlaceKind::AcrossJoint,
            Self::Tool(axis) if axis.turns() => PlaceKind::ToolAbout,
            Self::Tool(_) => PlaceKind::ToolAlong,
            Self::Axis(_) => PlaceKind::Axis,
            Self::Direction(_) => PlaceKind::Direction,
            Self::Toward { .. } => PlaceKind::Toward,
            Self::Element(_) => PlaceKind::Element,
            Self::ForceGauge => PlaceKind::ForceGauge,
            Self::DisplacementGauge(_) => PlaceKind::DisplacementGauge,
            Self::Structure => PlaceKind::Structure,
            Self::Clock(_) => PlaceKind::Clock,
            Self::Run { .. } => PlaceKind::Run,
            Self::Length { .. } => PlaceKind::Length,
            Self::JointAngle { .. } => PlaceKind::JointAngle,
            Self::Group { .. } => PlaceKind::Group,
            Self::Mechanism(_) => PlaceKind::Mechanism,
        }
    }

    /// The spring of the structure there, if there is one.
    #[must_use]
    pub fn spring(&self) -> Option<ModelParameter> {
        match self {
            Self::AcrossJoint { joint, axis } => {
                Some(ModelParameter::JointAbout(joint.as_str().into(), *axis))
            }
            Self::Tool(axis) => Some(ModelParameter::Tool(*axis)),
            _ => None,
        }
    }

    /// The form that stands behind the `@` on the command line; [`PlaceKind::read`] reads it.
    #[must_use]
    pub fn compact(&self) -> String {
        match self {
            Self::Joint(name) | Self::Slide(name) | Self::Element(name) | Self::Mechanism(name) => {
                name.clone()
            }
            Self::Length { body, entry } => format!("{body}.{entry}"),
            Self::JointAngle { joint, pose: None } => joint.clone(),
            Self::JointAngle {
                joint,
                pose: Some(pose),
            } => format!("{joint}/{pose}"),
            Self::Group {
                group,
                property: None,
            } => group.clone(),
            Self::Group {
                group,
                property: Some(property),
            } => format!("{group}.{}", property.name()),
            Self::AcrossJoint { joint, axis } => format!("{joint}.{axis}"),
            Self::Tool(axis) => axis.to_string(),
            Self::Axis(axis) => axis.to_string(),
            Self::Direction(direction) => direction.to_string(),
            Self::Toward { direction, toward } => format!("{direction}>{toward}"),
            Self::ForceGauge => "force".to_owned(),
            Self::DisplacementGauge(None) => "displacement".to_owned(),
            Self::DisplacementGauge(Some(axis)) => format!("displacement.{axis}"),
            Self::Structure => "structure".to_owned(),
            Self::Clock(None) => "clock".to_owned(),
            Self::Clock(Some(axis)) => format!("clock.{axis}"),
            Self::Run {
                pose,
                direction,
                repeat,
                step,
                gauge,
            } => {
                let run = format!("{pose}.{direction}.{repeat}.{step}");
                gauge.map_or(run.clone(), |axis| format!("{run}/{axis}"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn json_and_command_line_name_the_same_places() {
        let y = Direction::Y;
        let run = Place::Run {
            pose: PoseId::new("P3.low"),
            direction: Direction::Z.into(),
            repeat: 2,
            step: 5,
            gauge: None,
        };
        let oblique = Place::Run {
            pose: PoseId::new("P3.low"),
            direction: DirectionName::new("(0,0.7071,0.7071)"),
            repeat: 2,
            step: 5,
            gauge: Some(Direction::X),
        };
        let toward = Direction::Z;
        let toward = Place::Toward {
            direction: y,
            toward,
        };
        #[rustfmt::skip]
        let cases = [
            (Place::Joint("A3".into()), "A3", json!({"joint": "A3"})),
            (Place::Axis(Direction::X), "x", json!({"axis": "x"})),
            (Place::Direction(y), "y", json!({"direction": "y"})),
            (toward, "y>z", json!({"direction": "y", "toward": "z"})),
            (Place::Element("B1B2".into()), "B1B2", json!({"element": "B1B2"})),
            (Place::ForceGauge, "force", json!({"gauge": "force"})),
            (Place::DisplacementGauge(None), "displacement", json!({"gauge": "displacement"})),
            (Place::DisplacementGauge(Some(y)), "displacement.y", json!({"gauge": "displacement", "direction": "y"})),
            (Place::Structure, "structure", json!({"structure": true})),
            (Place::Clock(None), "clock", json!({"clock": true})),
            (Place::Clock(Some(y)), "clock.y", json!({"clock": true, "direction": "y"})),
            (oblique, "P3.low.(0,0.7071,0.7071).2.5/x", json!({"run": {"pose": "P3.low", "direction": "(0,0.7071,0.7071)", "repeat": 2}, "step": 5, "direction": "x"})),
            (run, "P3.low.z.2.5", json!({"run": {"pose": "P3.low", "direction": "z", "repeat": 2}, "step": 5})),
            (Place::Length { body: "arm1".into(), entry: "nodes.N4.at.2".into() }, "arm1.nodes.N4.at.2", json!({"body": "arm1", "entry": "nodes.N4.at.2"})),
            (Place::JointAngle { joint: "A3".into(), pose: Some(PoseId::new("P2")) }, "A3/P2", json!({"joint": "A3", "pose": "P2"})),
            (Place::Group { group: "link".into(), property: Some(Property::Iy) }, "link.Iy", json!({"group": "link", "property": "Iy"})),
            (Place::Mechanism("B".into()), "B", json!({"mechanism": "B"})),
        ];
        for (place, compact, expected) in cases {
            assert_eq!(json!(place), expected);
            assert_eq!(Place::deserialize(&expected).unwrap(), place);
            assert_eq!(place.compact(), compact);
            assert_eq!(place.kind().read(compact), Some(place));
        }
    }

    #[test]
    fn what_is_no_place_is_not_read_as_one() {
        for object in [
            json!({"joints": "A3"}),
            json!({"joint": "A3", "element": "A3B1"}),
            json!({"tool": "w"}),
            json!({"gauge": "force", "direction": "x"}),
            json!({"clock": false}),
        ] {
            assert!(Place::deserialize(&object).is_err(), "{object}");
        }
        for (kind, text) in [
            (PlaceKind::Joint, ""),
            (PlaceKind::Axis, "w"),
            (PlaceKind::Toward, "y"),
            (PlaceKind::Toward, "y>y"),
            (PlaceKind::Run, "P3.z.2"),
            (PlaceKind::Run, ".z.2.5"),
            (PlaceKind::Run, "P3.z.-2.5"),
            (PlaceKind::Clock, "watch"),
        ] {
            assert_eq!(kind.read(text), None, "{kind:?} {text}");
        }
    }
}
