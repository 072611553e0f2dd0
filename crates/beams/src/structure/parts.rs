//! What a structure is made of, and what can be wrong with it.

use std::fmt;
use std::sync::Arc;

use stiffbench_numeric::vector::norm;

use super::element::{Attachment, Element};

/// A point of the structure with six freedoms.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Name for messages and tables.
    pub name: Arc<str>,
    /// Global position, m.
    pub position_m: [f64; 3],
}

/// A motion between what hangs on it and its node: about one axis through the node, or along it.
///
/// Stiffness zero is a pin; 1/c is a compliant joint with compliance c.
#[derive(Debug, Clone, PartialEq)]
pub struct Hinge {
    /// Name for messages: the joint that is released.
    pub name: Arc<str>,
    /// Unit vector of the axis, global.
    pub axis: [f64; 3],
    /// Whether it slides along the axis instead of turning about it.
    pub slides: bool,
    /// Stiffness about the axis, N·m/rad, or along it, N/m.
    pub stiffness_nm_per_rad: f64,
}

impl Hinge {
    /// Refuses an axis that is no unit vector: a twist about a longer one would count for more than it is.
    pub(super) fn check_axis(&self) -> Result<(), StructureError> {
        let length = norm(self.axis);
        // 1e-9 is far above the rounding of an axis that was rotated, far below any effect on a result.
        if length.is_nan() || (length - 1.0).abs() > 1e-9 {
            let hinge = self.name.clone();
            return Err(StructureError::ImpossibleAxis { hinge, length });
        }
        Ok(())
    }
}

/// A member that neither bends nor stretches: its two ends move as one body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RigidMember {
    /// Name for messages.
    pub name: Arc<str>,
    /// Where its ends hang.
    pub ends: [Attachment; 2],
}

/// A node whose freedoms are held.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Support {
    /// Index of the node.
    pub node: usize,
    /// Held freedoms in the order ux, uy, uz, rx, ry, rz.
    pub held: [bool; 6],
}

impl Support {
    /// All six freedoms held.
    #[must_use]
    pub fn clamped(node: usize) -> Self {
        Self {
            node,
            held: [true; 6],
        }
    }
}

/// A spring between two points, as it is in the pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Strut {
    /// What its two points move with; `None` is the ground.
    pub ends: [Option<Attachment>; 2],
    /// Its two points, m.
    pub points_m: [[f64; 3]; 2],
    /// Its force, N; above zero it pulls its points together.
    pub force_n: f64,
    /// Derivative of the force to the distance of the points, N/m.
    pub stiffness_n_per_m: f64,
}

/// A structure of beams: rigid joints unless a hinge stands between an element end and its node.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Structure {
    /// Points.
    pub nodes: Vec<Node>,
    /// Two-node beams.
    pub elements: Vec<Element>,
    /// Members that do not yield.
    pub rigid_members: Vec<RigidMember>,
    /// Released or compliant motions.
    pub hinges: Vec<Hinge>,
    /// Held nodes.
    pub supports: Vec<Support>,
    /// Springs between two points that already pull or push.
    pub struts: Vec<Strut>,
    /// Where the end of the structure is: loads of a compliance act and displacements are read here.
    pub end: Attachment,
}

impl Structure {
    /// The node that a hinge sits at; `None` if nothing lies behind it.
    pub(super) fn node_of_hinge(&self, hinge: usize) -> Option<usize> {
        let rigid = self.rigid_members.iter().flat_map(|member| &member.ends);
        let ends = self.elements.iter().flat_map(|element| &element.ends);
        let ends = ends.chain(rigid);
        let mut all = ends.chain([&self.end]);
        Some(all.find(|at| at.hinges.contains(&hinge))?.node)
    }
}

/// One freedom of a structure, by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Freedom {
    /// A displacement or rotation of a node.
    OfNode {
        /// Name of the node.
        node: Arc<str>,
        /// 0 to 5: ux, uy, uz, rx, ry, rz.
        component: usize,
    },
    /// The twist of a hinge.
    OfHinge {
        /// Name of the hinge.
        hinge: Arc<str>,
    },
}

impl fmt::Display for Freedom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OfNode { node, component } => {
                let kind = if *component < 3 {
                    "displacement along"
                } else {
                    "rotation about"
                };
                write!(
                    f,
                    "{kind} {} of node {node}",
                    ["x", "y", "z"][component % 3]
                )
            }
            Self::OfHinge { hinge } => write!(f, "twist of joint {hinge}"),
        }
    }
}

/// What makes a structure impossible to solve.
#[derive(Debug, Clone, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum StructureError {
    /// Something moves without resistance.
    #[error("the structure is a mechanism: nothing resists the {freedom}")]
    #[diagnostic(
        code(stiffbench::structure::mechanism),
        help(
            "add the member, support or joint stiffness that should hold it, or give its section a stiffness above zero"
        )
    )]
    Mechanism {
        /// The freedom that moves most in the motion without resistance.
        freedom: Freedom,
    },
    /// An element so stiff that the digits of its neighbours are lost.
    #[error(
        "the element between nodes {first} and {second} is too stiff beside its neighbours: {ratio:.0e} times the middle one, and displacements would keep fewer than six digits"
    )]
    #[diagnostic(
        code(stiffbench::structure::too_stiff),
        help(
            "a section 1000 times stiffer than its neighbours is as good as rigid; check the unit of A, Iy, Iz and J (m2, m4)"
        )
    )]
    TooStiff {
        /// Name of its first node.
        first: Arc<str>,
        /// Name of its second node.
        second: Arc<str>,
        /// Its stiffness over that of the middle element, in the strain where it is largest.
        ratio: f64,
    },
    /// A law in the joints of a structure with loops of rigid members.
    #[error("rigid links close a loop at joint {}: laws in joints are not available there", joints.join(", "))]
    #[diagnostic(
        code(stiffbench::structure::rigid_loop),
        help(
            "leave the effect in the joint out and give the joint a spring, or give one link of the loop a section, so that it yields"
        )
    )]
    RigidLoop {
        /// Names of the joints that close loops.
        joints: Vec<Arc<str>>,
    },
    /// A loop of rigid members that stands where its joints move it in more ways than elsewhere.
    #[error("the loop of rigid links through joints {} is singular in this pose, and its stiffness is not determined", joints.join(", "))]
    #[diagnostic(
        code(stiffbench::structure::singular_loop),
        help(
            "choose a pose in which the joints of the loop do not lie in one line, or give a link of the loop a section"
        )
    )]
    SingularLoop {
        /// Names of the joints of the loop.
        joints: Vec<Arc<str>>,
    },
    /// A rigid body held in part at two nodes.
    #[error("the rigid body at node {node} is held in part at several nodes")]
    #[diagnostic(
        code(stiffbench::structure::held_rigid_body),
        help("hold it at one node only, or in all six freedoms")
    )]
    HeldRigidBody {
        /// Name of the second of the nodes.
        node: Arc<str>,
    },
    /// An element whose nodes coincide, or whose local axes cannot be determined.
    #[error("element {element} between nodes {first} and {second} has no length or no plane")]
    #[diagnostic(
        code(stiffbench::structure::element),
        help("its nodes must lie apart, and its local y must not be parallel to it")
    )]
    DegenerateElement {
        /// Index of the element.
        element: usize,
        /// Name of its first node.
        first: Arc<str>,
        /// Name of its second node.
        second: Arc<str>,
    },
    /// An index that points nowhere.
    #[error("{what} refers to {kind} {index}, but there are only {count}")]
    #[diagnostic(code(stiffbench::structure::index))]
    UnknownIndex {
        /// What refers.
        what: &'static str,
        /// Kind of thing referred to.
        kind: &'static str,
        /// The index.
        index: usize,
        /// How many exist.
        count: usize,
    },
    /// A section, material, hinge or shear constant that is negative or not finite.
    #[error("{what} of {of} is {value}: it must be finite and not negative")]
    #[diagnostic(code(stiffbench::structure::constant))]
    ImpossibleConstant {
        /// Which constant.
        what: &'static str,
        /// Which element or hinge.
        of: String,
        /// Its value in SI.
        value: f64,
    },
    /// A hinge axis that is no unit vector.
    #[error("the axis of joint {hinge} has the length {length}: it must be a unit vector")]
    #[diagnostic(code(stiffbench::structure::axis))]
    ImpossibleAxis {
        /// Name of the hinge.
        hinge: Arc<str>,
        /// Length of its axis.
        length: f64,
    },
}
