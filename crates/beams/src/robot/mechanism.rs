//! Which parts of a robot are there.

use super::model::{Joint, Mechanism, Robot};

impl Mechanism {
    /// Body and nodes of each member, beams first.
    pub(super) fn bodies_and_nodes<'a>(
        &'a self,
        robot: &'a Robot,
    ) -> impl Iterator<Item = (usize, [usize; 2])> + Clone + 'a {
        let beams = self.members.iter().map(|&member| &robot.members[member]);
        let rigid = self
            .rigid_links
            .iter()
            .map(|&link| &robot.rigid_links[link]);
        let beams = beams.map(|member| (member.body, member.nodes));
        beams.chain(rigid.map(|link| (link.body, link.nodes)))
    }

    /// Whether a joint exists here: both of its bodies have the end of a member at its node, or the node is held and one of them has.
    #[must_use]
    pub fn has_joint(&self, robot: &Robot, joint: &Joint) -> bool {
        let ends_there = |body: usize| {
            let mut members = self.bodies_and_nodes(robot);
            members.any(|(own, nodes)| own == body && nodes.contains(&joint.node))
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
