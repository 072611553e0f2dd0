//! A robot as it is drawn: nodes, members and joints in the frame of the world.

use super::range::finite_ends;
use super::robot_views::DrawnAxes;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotDrawing {
    /// For the title, for example `hp-robot, mechanism F, pose P1`.
    pub name: String,
    /// Nodes.
    pub nodes: Vec<DrawnNode>,
    /// Members between them.
    pub members: Vec<DrawnMember>,
    /// Held nodes, by index.
    pub supports: Vec<usize>,
    /// The end node, by index; it is named before all others.
    pub end: usize,
    /// Joints that are marked.
    pub joints: Vec<DrawnJoint>,
    /// The axes of the world.
    pub axes: DrawnAxes,
    /// Force at the end node, N; `None` draws the robot without a load and marks its end.
    pub force_n: Option<[f64; 3]>,
}

impl RobotDrawing {
    /// How far its nodes reach along an axis, m.
    #[must_use]
    pub fn extent_m(&self, axis: usize) -> f64 {
        let ends = finite_ends(self.nodes.iter().map(|node| node.position_m[axis]));
        ends.map_or(0.0, |[low, high]| high - low)
    }
}

/// A joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrawnJoint {
    /// The node it sits at, by index.
    pub node: usize,
    /// Whether it slides rather than turns.
    pub slides: bool,
}

/// A node with its displacement under the load.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnNode {
    /// Name.
    pub name: String,
    /// Position without load, m.
    pub position_m: [f64; 3],
    /// Displacement under the load, m.
    pub displacement_m: [f64; 3],
}

/// A member with the rotations of its ends under the load.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnMember {
    /// Its nodes, by index.
    pub nodes: [usize; 2],
    /// Rotation of its own two ends, twists of joints included, rad.
    pub rotations_rad: [[f64; 3]; 2],
    /// Chain, for the colour.
    pub chain: String,
    /// What it is.
    pub kind: DrawnKind,
}

/// What a member is, for its look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum DrawnKind {
    /// Neither bends nor stretches: drawn hollow.
    Rigid,
    /// The same where the robot file does not ask for it: drawn hollow and dashed.
    Added,
    /// Carries a drive: drawn thick.
    Beam,
    /// A link: drawn thin.
    Link,
}
