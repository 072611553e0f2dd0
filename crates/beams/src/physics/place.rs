//! Where a law acts.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

/// Kinds of places; each law has one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaceKind {
    /// A joint.
    Joint,
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
}

impl PlaceKind {
    /// What stands behind the `@` on the command line, as an example.
    #[must_use]
    pub fn example(self) -> &'static str {
        match self {
            Self::Joint => "@A3",
            Self::Axis => "@x",
            Self::Direction => "@y",
            Self::Toward => "@y>z",
            Self::Element => "@A3B1",
            Self::ForceGauge => "@force",
            Self::DisplacementGauge => "@displacement",
            Self::Structure => "@structure",
            Self::Clock => "@clock",
            Self::Run => "@P3.z.2.5",
        }
    }

    /// What a place of this kind is, in words.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Joint => "the name of a joint",
            Self::Axis => "an axis, x, y or z, through the first support",
            Self::Direction => "a direction, x, y or z",
            Self::Toward => "the direction of the load and, behind >, another axis",
            Self::Element => "the name of an element",
            Self::ForceGauge => "the force gauge",
            Self::DisplacementGauge => "the displacement gauge",
            Self::Structure => "the structure",
            Self::Clock => "the clock",
            Self::Run => "pose, direction, repeat and first step of a run, with points between",
        }
    }

    /// The place, where there is but one of this kind.
    #[must_use]
    pub fn only(self) -> Option<Place> {
        match self {
            Self::ForceGauge => Some(Place::ForceGauge),
            Self::DisplacementGauge => Some(Place::DisplacementGauge),
            Self::Structure => Some(Place::Structure),
            Self::Clock => Some(Place::Clock),
            _ => None,
        }
    }

    /// Reads what stands behind the `@` on the command line; `None` if it is no such place.
    #[must_use]
    pub fn read(self, text: &str) -> Option<Place> {
        let name = (!text.is_empty()).then(|| text.to_owned());
        match self {
            Self::Joint => name.map(Place::Joint),
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
                // Names of poses may have points in them: the last three parts are the others.
                let mut parts = text.rsplitn(4, '.');
                let step = parts.next()?.parse().ok()?;
                let repeat = parts.next()?.parse().ok()?;
                let direction = parts.next()?.parse().ok()?;
                let pose = PoseId::new(parts.next().filter(|pose| !pose.is_empty())?);
                Some(Place::Run {
                    pose,
                    direction,
                    repeat,
                    step,
                })
            }
            Self::ForceGauge | Self::DisplacementGauge | Self::Structure | Self::Clock => {
                let place = self.only()?;
                (place.compact() == text).then_some(place)
            }
        }
    }
}

/// The place of an effect, as it stands in files.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(into = "PlaceObject")]
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
    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> PlaceKind {
        match self {
            Self::Joint(_) => PlaceKind::Joint,
            Self::Axis(_) => PlaceKind::Axis,
            Self::Direction(_) => PlaceKind::Direction,
            Self::Toward { .. } => PlaceKind::Toward,
            Self::Element(_) => PlaceKind::Element,
            Self::ForceGauge => PlaceKind::ForceGauge,
            Self::DisplacementGauge => PlaceKind::DisplacementGauge,
            Self::Structure => PlaceKind::Structure,
            Self::Clock => PlaceKind::Clock,
            Self::Run { .. } => PlaceKind::Run,
        }
    }

    /// The form that stands behind the `@` on the command line; [`PlaceKind::read`] reads it.
    #[must_use]
    pub fn compact(&self) -> String {
        match self {
            Self::Joint(name) | Self::Element(name) => name.clone(),
            Self::Axis(axis) => axis.to_string(),
            Self::Direction(direction) => direction.to_string(),
            Self::Toward { direction, toward } => format!("{direction}>{toward}"),
            Self::ForceGauge => "force".to_owned(),
            Self::DisplacementGauge => "displacement".to_owned(),
            Self::Structure => "structure".to_owned(),
            Self::Clock => "clock".to_owned(),
            Self::Run {
                pose,
                direction,
                repeat,
                step,
            } => format!("{pose}.{direction}.{repeat}.{step}"),
        }
    }
}

/// A place as results and answers write it, for example `{"joint": "A3"}`.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
#[schemars(deny_unknown_fields)]
enum PlaceObject {
    /// A joint of the robot, by name.
    Joint { joint: String },
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
    },
    /// One run, from one step on.
    Run { run: RunObject, step: u32 },
}

/// A run as results write it.
#[derive(Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
struct RunObject {
    pose: PoseId,
    direction: Direction,
    repeat: u32,
}

impl From<Place> for PlaceObject {
    fn from(place: Place) -> Self {
        match place {
            Place::Joint(joint) => Self::Joint { joint },
            Place::Axis(axis) => Self::Axis { axis },
            Place::Direction(direction) => Self::Direction { direction },
            Place::Toward { direction, toward } => Self::Toward { direction, toward },
            Place::Element(element) => Self::Element { element },
            Place::ForceGauge => Self::Gauge { gauge: "force" },
            Place::DisplacementGauge => Self::Gauge {
                gauge: "displacement",
            },
            Place::Structure => Self::Structure { structure: true },
            Place::Clock => Self::Clock { clock: true },
            Place::Run {
                pose,
                direction,
                repeat,
                step,
            } => Self::Run {
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn json_and_command_line_name_the_same_places() {
        let y = Direction::Y;
        let run = Place::Run {
            pose: PoseId::new("P3.low"),
            direction: Direction::Z,
            repeat: 2,
            step: 5,
        };
        let toward = Direction::Z;
        let toward = Place::Toward {
            direction: y,
            toward,
        };
        for (place, compact, expected) in [
            (Place::Joint("A3".into()), "A3", json!({"joint": "A3"})),
            (Place::Axis(Direction::X), "x", json!({"axis": "x"})),
            (Place::Direction(y), "y", json!({"direction": "y"})),
            (toward, "y>z", json!({"direction": "y", "toward": "z"})),
            (
                Place::Element("B1B2".into()),
                "B1B2",
                json!({"element": "B1B2"}),
            ),
            (Place::ForceGauge, "force", json!({"gauge": "force"})),
            (
                Place::DisplacementGauge,
                "displacement",
                json!({"gauge": "displacement"}),
            ),
            (Place::Structure, "structure", json!({"structure": true})),
            (Place::Clock, "clock", json!({"clock": true})),
            (
                run,
                "P3.low.z.2.5",
                json!({"run": {"pose": "P3.low", "direction": "z", "repeat": 2}, "step": 5}),
            ),
        ] {
            assert_eq!(json!(place), expected);
            assert_eq!(place.compact(), compact);
            assert_eq!(place.kind().read(compact), Some(place));
        }
    }

    #[test]
    fn what_is_no_place_is_not_read_as_one() {
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
