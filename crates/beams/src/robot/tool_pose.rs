//! Where the tool is, by kinematics alone.

use stiffbench_numeric::vector::cross;

use super::Robot;
use super::error::RobotError;
use super::kinematics::{FixedDirection, Item, Order, Placement};
use super::model::{Mechanism, Pose};

/// Position and axes of the tool in a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPose {
    /// Tool centre, m.
    pub position_m: [f64; 3],
    /// Unit vectors of its x, y, z, global.
    pub axes: [[f64; 3]; 3],
}

impl ToolPose {
    /// Where it is after a small motion: displacement, m, and rotation, rad, in the axes of the base.
    #[must_use]
    pub fn moved(&self, [x, y, z, rx, ry, rz]: [f64; 6]) -> Self {
        let sum = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] + b[i]);
        Self {
            position_m: sum(self.position_m, [x, y, z]),
            axes: self.axes.map(|axis| sum(axis, cross([rx, ry, rz], axis))),
        }
    }

    /// By how much it has moved from another place: displacement, m, and small rotation, rad, in the axes of the base.
    #[must_use]
    pub fn moved_from(&self, other: &Self) -> [f64; 6] {
        // Of a small turn θ each axis e moves by θ × e, and Σ e × (θ × e) = 2 θ over three orthogonal axes.
        let turned = self.axes.iter().zip(&other.axes);
        let turned = turned.map(|(now, before)| cross(*before, *now));
        let turned = turned.fold([0.0; 3], |sum, one| {
            [0, 1, 2].map(|i| sum[i] + 0.5 * one[i])
        });
        std::array::from_fn(|i| match i {
            0..3 => self.position_m[i] - other.position_m[i],
            _ => turned[i - 3],
        })
    }
}

/// By how much a variable is moved to see whether the tool does, degrees or m.
const STEP: f64 = 0.01;

impl Robot {
    /// Whether a variable moves the tool from the nominal pose; so it counts too where that pose, or one next to it, cannot be reached.
    #[must_use]
    pub fn moves_tool(&self, variable: usize) -> bool {
        let nominal = self.nominal_pose();
        let mut moved = nominal.clone();
        moved.angles_deg[variable] += STEP;
        match (self.tool_pose(&nominal), self.tool_pose(&moved)) {
            (Ok(before), Ok(after)) => before != after,
            _ => true,
        }
    }

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

    /// The same; of a robot file without a tool, where the end of a mechanism is, with the axes of the body that carries it.
    ///
    /// # Errors
    /// As [`Robot::tool_pose`].
    pub fn end_pose(&self, mechanism: &Mechanism, pose: &Pose) -> Result<ToolPose, RobotError> {
        let tool = self.tool_pose(pose)?;
        Ok(match (self.tool.body, self.end_body(mechanism)) {
            (None, Some(body)) => ToolPose {
                axes: self.body_axes(body, pose)?,
                ..tool
            },
            _ => tool,
        })
    }
}
