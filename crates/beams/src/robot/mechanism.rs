//! Which parts of a robot are there.

use super::{Joint, Robot};

/// One choice of chains and single elements.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mechanism {
    /// Name.
    pub name: String,
    /// Chains that are there.
    pub chains: Vec<String>,
    /// Indices of the robot's members that are there.
    pub members: Vec<usize>,
    /// Indices of joints that a drive or a brake holds when a pose is held.
    pub locked: Vec<usize>,
}

impl Mechanism {
    /// Whether a joint exists here: both of its bodies have an element end at its node, or the node is held and one of them has.
    #[must_use]
    pub fn has_joint(&self, robot: &Robot, joint: &Joint) -> bool {
        let ends_there = |body: usize| {
            self.members
                .iter()
                .map(|&member| &robot.members[member])
                .any(|m| m.body == body && m.nodes.contains(&joint.node))
        };
        let [first, second] = joint.bodies.map(ends_there);
        (first && second) || (robot.supports.contains(&joint.node) && (first || second))
    }

    /// Indices of the joints that exist here.
    #[must_use]
    pub fn joints(&self, robot: &Robot) -> Vec<usize> {
        (0..robot.joints.len())
            .filter(|&joint| self.has_joint(robot, &robot.joints[joint]))
            .collect()
    }
}
