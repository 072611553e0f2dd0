//! Where in the experiment a number belongs: pose, direction, load step, repeat, branch.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// Name of a pose, as in the robot or procedure file.
///
/// Cloning is cheap: a table of a million readings holds each name once.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, schemars::JsonSchema)]
pub struct PoseId(Arc<str>);

impl PoseId {
    /// A pose by its name.
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self(Arc::from(name))
    }

    /// The name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for PoseId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0)
    }
}

impl From<&str> for PoseId {
    fn from(name: &str) -> Self {
        Self::new(name)
    }
}

impl<'de> Deserialize<'de> for PoseId {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(|name| Self::new(&name))
    }
}

impl Serialize for PoseId {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0)
    }
}

/// Name of the direction of a load, as the procedure has it: an axis, or a name of its own.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, schemars::JsonSchema)]
pub struct DirectionName(Arc<str>);

impl DirectionName {
    /// A direction by its name.
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self(Arc::from(name))
    }

    /// The name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for DirectionName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0)
    }
}

impl From<Direction> for DirectionName {
    fn from(axis: Direction) -> Self {
        Self::new(["x", "y", "z"][axis.index()])
    }
}

impl<'de> Deserialize<'de> for DirectionName {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(|name| Self::new(&name))
    }
}

impl Serialize for DirectionName {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0)
    }
}

/// Axis of load and displacement, of the robot's base.
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
    Deserialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// x of the robot's base; in the paper lateral, out of the arm plane.
    X,
    /// y of the robot's base; in the paper vertical, up.
    Y,
    /// z of the robot's base; in the paper radial, the reach of the arm.
    Z,
}

impl Direction {
    /// All three, in order.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// 0, 1 or 2: the place of this axis in a vector.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }

    /// Unit vector along this axis.
    #[must_use]
    pub fn unit_vector(self) -> [f64; 3] {
        let mut vector = [0.0; 3];
        vector[self.index()] = 1.0;
        vector
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// The text is not a direction.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a direction: x, y or z")]
pub struct NotADirection(pub String);

impl FromStr for Direction {
    type Err = NotADirection;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "x" | "X" => Ok(Self::X),
            "y" | "Y" => Ok(Self::Y),
            "z" | "Z" => Ok(Self::Z),
            other => Err(NotADirection(other.to_owned())),
        }
    }
}

/// Whether the load was growing or being taken off when the reading was made.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Default,
    Serialize,
    Deserialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Branch {
    /// The load grows in size.
    #[default]
    Loading,
    /// The load is taken off.
    Unloading,
}

impl fmt::Display for Branch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// One cell of the experiment: all readings of one pose along one direction, under loads along one.
#[derive(
    Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, schemars::JsonSchema,
)]
pub struct Cell {
    /// The pose held.
    pub pose: PoseId,
    /// The direction of the displacement, and of the load where it has no other.
    pub direction: Direction,
    /// The direction of the load, where the displacement was read along another axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load: Option<DirectionName>,
}

impl Cell {
    /// A pose and direction of load and displacement.
    #[must_use]
    pub fn new(pose: PoseId, direction: Direction) -> Self {
        Self {
            pose,
            direction,
            load: None,
        }
    }

    /// Whether its loads have a direction of this name.
    #[must_use]
    pub fn is_loaded_along(&self, name: &DirectionName) -> bool {
        match &self.load {
            Some(load) => load == name,
            None => *name == DirectionName::from(self.direction),
        }
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.pose, self.direction)?;
        match &self.load {
            Some(load) => write!(f, " under {load}"),
            None => Ok(()),
        }
    }
}
