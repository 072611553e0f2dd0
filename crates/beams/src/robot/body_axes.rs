//! Where the axes of a body point in a pose.

use super::Robot;
use super::error::RobotError;
use super::kinematics::{Item, Order, Placement};
use super::model::{Mechanism, Pose};

impl Robot {
    /// Unit vectors of the x, y and z of a body in a pose, in the axes of the base.
    ///
    /// # Errors
    /// [`RobotError::Unreachable`] if a loop that the body hangs on does not close.
    ///
    /// # Panics
    /// If `body` is out of range.
    pub fn body_axes(&self, body: usize, pose: &Pose) -> Result<[[f64; 3]; 3], RobotError> {
        let order = Order::of(self, [Item::Body(body)].into_iter())
            .expect("a checked robot has no circular dependency");
        let mut placement = Placement::new(self, 0.0);
        order.place(self, pose, &mut placement)?;
        Ok(placement.axes(body))
    }

    /// The body that carries the end: that of the last member or rigid link of a mechanism at the end node.
    #[must_use]
    pub fn end_body(&self, mechanism: &Mechanism) -> Option<usize> {
        let links = mechanism.rigid_links.iter().map(|&link| {
            let link = &self.rigid_links[link];
            (link.nodes, link.body)
        });
        let members = mechanism.members.iter().map(|&member| {
            let member = &self.members[member];
            (member.nodes, member.body)
        });
        let at_end = |(nodes, _): &([usize; 2], usize)| nodes.contains(&self.end);
        let last = members.chain(links).rfind(at_end);
        last.map(|(_, body)| body)
    }
}
