//! Where the tool is, by kinematics alone.

use super::Robot;
use super::error::RobotError;
use super::hinges::FixedDirection;
use super::kinematics::{Item, Order, Placement};
use super::model::Pose;

/// Position and axes of the tool in a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPose {
    /// Tool centre, m.
    pub position_m: [f64; 3],
    /// Unit vectors of its x, y, z, global.
    pub axes: [[f64; 3]; 3],
}

impl Robot {
    /// Where the tool centre is in a pose, and how the tool is turned.
    ///
    /// # Errors
    /// [`RobotError::Unreachable`] if a loop does not close.
    pub fn tool_pose(&self, pose: &Pose) -> Result<ToolPose, RobotError> {
        let body = self.tool.body.map(Item::Body);
        let wanted = [Item::Node(self.end)].into_iter().chain(body);
        let order = Order::of(self, wanted).expect("a checked robot has no circular dependency");
        let mut placement = Placement::new(self, 0.0);
        order.place(self, pose, &mut placement)?;
        let world = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let axes = self.tool.axes.unwrap_or(world);
        Ok(ToolPose {
            position_m: placement.node_m(self.end),
            axes: axes.map(|local| {
                placement.direction(&FixedDirection {
                    body: self.tool.body,
                    local,
                })
            }),
        })
    }
}
