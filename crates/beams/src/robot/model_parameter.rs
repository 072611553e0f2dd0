//! What a fit can change in a robot: the list of model parameters.
//!
//! Two kinds. A factor multiplies a nominal section constant, of a class of elements (the paper's eq. (16)), of one section or of a group
//! of members. A spring is a compliance where the model is otherwise rigid: in a joint, under the base or at the tool (the virtual joint
//! method).

use std::fmt;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_units_and_text::test_point::Direction;

use super::spring_axis::{JointMotion, SpringAxis};
use crate::structure::Property;

/// Role of an element in the fit.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, Serialize, JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum ElementClass {
    /// Drive-carrying: host links, cranks, plates.
    Beam,
    /// Coupler rods.
    Link,
}

/// One parameter of the model of a robot.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum ModelParameter {
    /// Multiplier of a section constant in all elements of a class.
    Class(ElementClass, Property),
    /// Multiplier of a constant of one section, by name, beside that of the class.
    Section(Arc<str>, Property),
    /// Multiplier of a section constant in the members of a group, by name, beside those of class and section.
    Group(Arc<str>, Property),
    /// Compliance of a joint that turns, by name, about its axis, rad/(N·m).
    Joint(Arc<str>),
    /// Compliance of a joint that slides, by name, along its axis, m/N.
    JointAlong(Arc<str>),
    /// Compliance of a joint, by name, about an axis of its frame (x is its own), rad/(N·m).
    JointAbout(Arc<str>, Direction),
    /// Compliance of the base along (m/N) or about (rad/(N·m)) an axis of the world through the first support.
    Base(SpringAxis),
    /// Compliance of the tool along (m/N) or about (rad/(N·m)) an axis of its frame through its mount.
    Tool(SpringAxis),
}

impl ModelParameter {
    /// What is said of springs that the robot file makes rigid.
    pub const RIGID: &str = "rigid by the file";
    /// What is said of springs that it leaves to a fit, of which nothing is known yet.
    pub const UNKNOWN: &str = "no stiffness yet (unknown)";

    /// The paper's eight factors: beams A, Iy, Iz, J, then links.
    pub const CLASSES: [Self; 8] = {
        use ElementClass::{Beam, Link};
        use Property::{A, Iy, Iz, J};
        [
            Self::Class(Beam, A),
            Self::Class(Beam, Iy),
            Self::Class(Beam, Iz),
            Self::Class(Beam, J),
            Self::Class(Link, A),
            Self::Class(Link, Iy),
            Self::Class(Link, Iz),
            Self::Class(Link, J),
        ]
    };

    /// The paper's four factors of beams: A, Iy, Iz, J.
    pub const BEAMS: [Self; 4] = {
        use Property::{A, Iy, Iz, J};
        const BEAM: ElementClass = ElementClass::Beam;
        [
            Self::Class(BEAM, A),
            Self::Class(BEAM, Iy),
            Self::Class(BEAM, Iz),
            Self::Class(BEAM, J),
        ]
    };

    /// The spring of a joint's own motion.
    #[must_use]
    pub fn of_joint(name: &str, motion: JointMotion) -> Self {
        match motion {
            JointMotion::Turns => Self::Joint(name.into()),
            JointMotion::Slides => Self::JointAlong(name.into()),
        }
    }

    /// Its unit, `1` for a factor.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Class(..) | Self::Section(..) | Self::Group(..) => "1",
            Self::Joint(_) | Self::JointAbout(..) => "rad/(N*m)",
            Self::JointAlong(_) => "m/N",
            Self::Base(axis) | Self::Tool(axis) if axis.turns() => "rad/(N*m)",
            Self::Base(_) | Self::Tool(_) => "m/N",
        }
    }

    /// Why readings say nothing of it, if no load acts on it.
    #[must_use]
    pub fn unloaded_words(&self) -> &'static str {
        match self.unit() {
            "1" => "no reading depends on it, so it keeps its start",
            "m/N" => "nothing moves it (no load of these data reaches it)",
            _ => "nothing turns it (no load of these data reaches it)",
        }
    }

    /// The joint whose spring it is.
    #[must_use]
    pub fn joint(&self) -> Option<&str> {
        match self {
            Self::Joint(joint) | Self::JointAlong(joint) | Self::JointAbout(joint, _) => {
                Some(joint)
            }
            _ => None,
        }
    }

    /// Whether laws act on it beside the structure: of a joint about its axis, or of the base about an axis. Other springs are hinges of the
    /// structure.
    #[must_use]
    pub fn is_beside_structure(&self) -> bool {
        match self {
            Self::Joint(_) => true,
            Self::Base(axis) => axis.turns(),
            _ => false,
        }
    }

    /// Whether it multiplies a section constant; else it is the compliance of a spring.
    #[must_use]
    pub fn is_factor(&self) -> bool {
        matches!(self, Self::Class(..) | Self::Section(..) | Self::Group(..))
    }
}

/// Its name in files, options and tables.
impl fmt::Display for ModelParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Class(ElementClass::Beam, property) => write!(f, "beam.{}", property.name()),
            Self::Class(ElementClass::Link, property) => write!(f, "link.{}", property.name()),
            Self::Section(section, property) => write!(f, "section.{section}.{}", property.name()),
            Self::Group(group, property) => write!(f, "group.{group}.{}", property.name()),
            Self::Joint(joint) => write!(f, "joint.{joint}"),
            Self::JointAlong(joint) => write!(f, "joint.{joint}.along"),
            Self::JointAbout(joint, axis) => write!(f, "joint.{joint}.{axis}"),
            Self::Base(axis) => write!(f, "base.{axis}"),
            Self::Tool(axis) => write!(f, "tool.{axis}"),
        }
    }
}

impl From<ModelParameter> for String {
    fn from(parameter: ModelParameter) -> Self {
        parameter.to_string()
    }
}

/// A text that names no parameter.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{text}` is not a model parameter")]
#[diagnostic(
    code(stiffbench::robot::model_parameter),
    help(
        "write for example beam.Iy, link.A, section.NAME.Iz, group.NAME.J, joint.NAME, joint.NAME.y, base.rx (about x), base.x (along x) or tool.z"
    )
)]
pub struct NotAParameter {
    /// The text.
    pub text: String,
}

impl ModelParameter {
    /// The spring of a name, such as `joint.J2.y`.
    ///
    /// # Errors
    /// [`NotAParameter`] for a name that is none, and for that of a factor.
    pub fn spring_named(name: &str) -> Result<Self, NotAParameter> {
        let text = name.to_owned();
        let parameter = Self::try_from(text.clone())?;
        if parameter.is_factor() {
            return Err(NotAParameter { text });
        }
        Ok(parameter)
    }
}

impl TryFrom<String> for ModelParameter {
    type Error = NotAParameter;

    fn try_from(text: String) -> Result<Self, NotAParameter> {
        let property = |name: &str| Property::ALL.into_iter().find(|p| p.name() == name);
        let named = |rest: &str, of: fn(Arc<str>, Property) -> Self| {
            let (name, constant) = rest.rsplit_once('.')?;
            Some(of(name.into(), property(constant)?))
        };
        let joint = |name: &str| match name.rsplit_once('.') {
            Some((joint, "along")) => Self::JointAlong(joint.into()),
            Some((joint, "x")) => Self::JointAbout(joint.into(), Direction::X),
            Some((joint, "y")) => Self::JointAbout(joint.into(), Direction::Y),
            Some((joint, "z")) => Self::JointAbout(joint.into(), Direction::Z),
            _ => Self::Joint(name.into()),
        };
        let parsed = match text.split_once('.') {
            Some(("beam", name)) => property(name).map(|p| Self::Class(ElementClass::Beam, p)),
            Some(("link", name)) => property(name).map(|p| Self::Class(ElementClass::Link, p)),
            Some(("section", rest)) => named(rest, Self::Section),
            Some(("group", rest)) => named(rest, Self::Group),
            Some(("joint", name)) => Some(joint(name)),
            Some(("base", axis)) => axis.parse().ok().map(Self::Base),
            Some(("tool", axis)) => axis.parse().ok().map(Self::Tool),
            _ => None,
        };
        parsed.ok_or(NotAParameter { text })
    }
}
