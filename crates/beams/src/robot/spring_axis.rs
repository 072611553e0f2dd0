//! How joints move, and the axes along and about which springs yield.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_units_and_text::test_point::Direction;

/// How the second body of a joint moves on the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum JointMotion {
    /// About the axis; a revolute joint.
    #[default]
    Turns,
    /// Along the axis; a sliding (prismatic) joint.
    Slides,
}

impl JointMotion {
    /// The unit in which tables state its variable.
    #[must_use]
    pub fn usual_unit(self) -> &'static str {
        match self {
            Self::Turns => "deg",
            Self::Slides => "mm",
        }
    }
}

impl fmt::Display for JointMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Turns => "turns",
            Self::Slides => "slides",
        })
    }
}

/// One of six springs in series: along an axis, m/N, or about it, rad/(N·m).
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "lowercase")]
#[schemars(inline)]
pub enum SpringAxis {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
    /// About x.
    Rx,
    /// About y.
    Ry,
    /// About z.
    Rz,
}

impl SpringAxis {
    /// All six, in the order of displacements and rotations.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::Rx, Self::Ry, Self::Rz];

    /// Place in the order ux, uy, uz, rx, ry, rz.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Whether it turns.
    #[must_use]
    pub const fn turns(self) -> bool {
        self.index() >= 3
    }

    /// The axis it turns about.
    #[must_use]
    pub fn turn(self) -> Option<Direction> {
        self.turns().then(|| Direction::ALL[self.index() - 3])
    }

    /// The spring about an axis.
    #[must_use]
    pub const fn about(axis: Direction) -> Self {
        match axis {
            Direction::X => Self::Rx,
            Direction::Y => Self::Ry,
            Direction::Z => Self::Rz,
        }
    }

    /// `x`, `y`, `z`, `rx`, `ry`, `rz`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        ["x", "y", "z", "rx", "ry", "rz"][self.index()]
    }
}

impl fmt::Display for SpringAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A text that is none of `x`, `y`, `z`, `rx`, `ry`, `rz`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("an axis of a spring is x, y, z, rx, ry or rz")]
pub struct NotASpringAxis;

impl FromStr for SpringAxis {
    type Err = NotASpringAxis;

    fn from_str(text: &str) -> Result<Self, NotASpringAxis> {
        let mut all = Self::ALL.into_iter();
        all.find(|axis| axis.name() == text).ok_or(NotASpringAxis)
    }
}
