//! Where the joints, bodies and nodes of a robot are in a pose.

use stiffbench_units_and_text::test_point::Direction;

use super::Robot;
use super::error::RobotError;
use super::kinematics::{FixedDirection, Item, Order, Placement};
use super::model::{Mechanism, Pose};

/// The bodies, joints and nodes of a mechanism in a pose.
#[derive(Debug, Clone)]
pub struct PlacedRobot<'a> {
    robot: &'a Robot,
    joints: Vec<usize>,
    placement: Placement<f64>,
}

impl<'a> PlacedRobot<'a> {
    /// Places all that a mechanism has.
    ///
    /// # Errors
    /// [`RobotError::Unreachable`] if a loop does not close, [`RobotError::OutOfPlane`] or [`RobotError::NoDirection`] if two nodes do not
    /// lie as a plane or a body needs them.
    pub fn new(robot: &'a Robot, mechanism: &Mechanism, pose: &Pose) -> Result<Self, RobotError> {
        let joints = mechanism.joints(robot);
        let members = || {
            mechanism
                .members
                .iter()
                .map(|&member| &robot.members[member])
        };
        let of_joints = joints.iter().map(|&joint| &robot.joints[joint]);
        let of_joints = of_joints.flat_map(|joint| {
            let plane = robot.planes[joint.plane].body;
            let bodies = joint.bodies.into_iter().chain([plane]);
            bodies.map(Item::Body).chain([Item::Node(joint.node)])
        });
        let of_members = members().flat_map(|member| {
            let bodies = [member.body, robot.planes[member.plane].body].map(Item::Body);
            bodies.into_iter().chain(member.nodes.map(Item::Node))
        });
        let links = mechanism.rigid_links.iter();
        let links = links.map(|&link| Item::Body(robot.rigid_links[link].body));
        let end = links.chain([Item::Node(robot.end)]);
        let order = Order::of(robot, of_joints.chain(of_members).chain(end))
            .expect("a checked robot has no circular dependency");
        let mut placement = Placement::new(robot, 0.0);
        order.place(robot, pose, &mut placement)?;
        Ok(Self {
            robot,
            joints,
            placement,
        })
    }

    /// The joints that the mechanism has, by their place in the robot.
    #[must_use]
    pub fn joints(&self) -> &[usize] {
        &self.joints
    }

    /// Position of a node of the mechanism, m.
    #[must_use]
    pub fn node_m(&self, node: usize) -> [f64; 3] {
        self.placement.node_m(node)
    }

    /// Unit vector of the axis of a joint of the mechanism.
    #[must_use]
    pub fn axis(&self, joint: usize) -> [f64; 3] {
        self.placement
            .plane_normal(self.robot, self.robot.joints[joint].plane)
    }

    /// Origin of a body of the mechanism, m.
    #[must_use]
    pub fn body_origin_m(&self, body: usize) -> [f64; 3] {
        self.placement.point_m(body, &[0.0; 3])
    }

    /// Unit vectors x, y, z of a body of the mechanism.
    #[must_use]
    pub fn body_axes(&self, body: usize) -> [[f64; 3]; 3] {
        Direction::ALL.map(|axis| {
            self.placement.direction(&FixedDirection {
                body: Some(body),
                local: axis.unit_vector(),
            })
        })
    }
}
