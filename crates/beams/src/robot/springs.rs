//! Springs that a robot has by its file: where joints, base and tool yield, and what a fit does with each.

use super::model_parameter::ModelParameter;

/// How far something gives way where the model is otherwise rigid.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Yielding {
    /// Not at all; compliance 0.
    #[default]
    Rigid,
    /// Freely: it passes on no moment, or no force along a sliding axis.
    Pinned,
    /// In proportion to its load: rad/(N·m), along an axis m/N; finite and not negative.
    Compliance(f64),
}

impl Yielding {
    /// Compliance, rad/(N·m) or m/N; infinite for a pin.
    #[must_use]
    pub fn compliance(self) -> f64 {
        match self {
            Self::Rigid => 0.0,
            Self::Pinned => f64::INFINITY,
            Self::Compliance(c) => c,
        }
    }
}

/// What a fit does with a parameter if its user does not say.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum RoleInFit {
    /// Keeps its value.
    #[default]
    Fixed,
    /// Determines it.
    Free,
    /// Gives it the value of another parameter.
    Tied(ModelParameter),
}

/// A spring of the robot file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SpringDefault {
    /// Its value.
    pub yielding: Yielding,
    /// What a fit does with it.
    pub in_fit: RoleInFit,
}

impl SpringDefault {
    /// Whether the file leaves its value to a fit and states none to begin at. It is then neither rigid nor a spring of a known stiffness.
    #[must_use]
    pub fn is_unknown(&self) -> bool {
        self.in_fit != RoleInFit::Fixed && self.yielding.compliance() == 0.0
    }
}

/// The springs of a joint.
///
/// The joint's frame: x is its own axis, the normal n of its plane. With the axes of the plane's body taken in the order x, y, z, x, y is
/// the one after that in which n is largest, made perpendicular to n; z is x × y. So n = z has y along the body's x and z along its y.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointSprings {
    /// Of its own motion: about its axis, rad/(N·m), of a joint that slides along it, m/N. Parameter `joint.NAME`.
    pub own: SpringDefault,
    /// About x, y, z of its frame, rad/(N·m). Parameters `joint.NAME.x|y|z`; x of a joint that turns is `own`, and rigid here.
    pub about: [SpringDefault; 3],
}

/// What is mounted at the end: its frame, its springs, its payload.
///
/// Loads act at the end node of the robot, the tool centre, and displacements are those of that point. The springs sit at the node where
/// the tool is mounted, in series with everything.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tool {
    /// Node at which it is mounted; `None` is the end node itself.
    pub mount: Option<usize>,
    /// Body whose axes its own are given in; `None` is the ground, so that they are those of the world.
    pub body: Option<usize>,
    /// Unit vectors of its x, y, z in the axes of the body; `None` are the axes of the body.
    pub axes: Option<[[f64; 3]; 3]>,
    /// Along and about its axes, through the mount: x, y, z (m/N), rx, ry, rz (rad/(N·m)). Parameters `tool.x` and so on.
    pub springs: [SpringDefault; 6],
    /// What it carries.
    pub payload: Option<Payload>,
}

/// A load of known mass on the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Payload {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass from the tool centre, in the axes of the tool, m.
    pub at_m: [f64; 3],
}
