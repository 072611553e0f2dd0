//! From a robot, a mechanism and a pose to the structure that carries the load.

use crate::structure::{
    Attachment, Element, Hinge, Node, Reduction, SolutionPath, Structure, Support,
};

use super::Robot;
use super::error::RobotError;
use super::kinematics::{Item, Order, Placement};
use super::mechanism::Mechanism;
use super::model::{FittingFactors, Member, Pose};

/// How joints pass on moments.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum JointModel {
    /// Every joint passes on everything (the paper).
    #[default]
    Rigid,
    /// Every joint turns freely unless a drive or a brake locks it.
    Pinned,
    /// The named joints, by index, turn against a stiffness in N·m/rad (zero is a pin); all others are rigid.
    Hinged(Vec<(usize, f64)>),
}

/// Beam theory of the elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Theory {
    /// Plane sections stay normal to the axis (the paper).
    #[default]
    EulerBernoulli,
    /// Shear deformation with the coefficients of the sections.
    Timoshenko,
}

/// The structure of one mechanism, which moves from pose to pose and takes any factors.
#[derive(Debug, Clone)]
pub struct MechanismModel<'a> {
    robot: &'a Robot,
    mechanism: &'a Mechanism,
    order: Order,
    placement: Placement<f64>,
    /// Robot node of each structure node.
    nodes: Vec<usize>,
    /// Robot joint of each structure hinge.
    hinge_joints: Vec<usize>,
    structure: Structure,
}

impl<'a> MechanismModel<'a> {
    /// The structure of a mechanism, not yet placed: call [`MechanismModel::place`] next.
    ///
    /// # Errors
    /// [`RobotError::IncompleteMechanism`] if no element reaches the end node or a support.
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        joints: &JointModel,
        theory: Theory,
        factors: &FittingFactors,
    ) -> Result<Self, RobotError> {
        let members: Vec<&Member> = mechanism
            .members
            .iter()
            .map(|&member| &robot.members[member])
            .collect();
        let mut nodes: Vec<usize> = Vec::new();
        for node in members.iter().flat_map(|member| member.nodes) {
            if !nodes.contains(&node) {
                nodes.push(node);
            }
        }
        let place_of = |node: usize| nodes.iter().position(|n| *n == node);
        let incomplete = |what: &str| RobotError::IncompleteMechanism {
            mechanism: mechanism.name.clone(),
            what: what.to_owned(),
        };
        let end = place_of(robot.end)
            .ok_or_else(|| incomplete(&format!("its end node {}", robot.nodes[robot.end].name)))?;
        let supports: Vec<Support> = robot
            .supports
            .iter()
            .filter_map(|&node| place_of(node))
            .map(Support::clamped)
            .collect();
        if supports.is_empty() {
            return Err(incomplete("any support"));
        }

        let hinges = hinged_joints(robot, mechanism, joints);
        let hinge_joints: Vec<usize> = hinges.iter().map(|(joint, _)| *joint).collect();
        let attach = |node: usize, body: Option<usize>| Attachment {
            node: place_of(node).expect("every node of a member was collected"),
            hinges: body.map_or_else(Vec::new, |body| {
                hinges_behind(robot, &hinge_joints, node, body)
            }),
        };
        let elements = members
            .iter()
            .map(|member| Element {
                ends: member.nodes.map(|node| attach(node, Some(member.body))),
                toward_y: [1.0, 0.0, 0.0],
                section: robot.sections[member.section].section,
                material: robot.sections[member.section].material,
                shear: (theory == Theory::Timoshenko)
                    .then_some(robot.sections[member.section].shear),
            })
            .collect();
        let structure = Structure {
            nodes: nodes
                .iter()
                .map(|&node| Node {
                    name: robot.nodes[node].name.clone(),
                    position_m: [0.0; 3],
                })
                .collect(),
            elements,
            hinges: hinges
                .iter()
                .map(|&(joint, stiffness_nm_per_rad)| Hinge {
                    name: robot.joints[joint].name.as_str().into(),
                    axis: [1.0, 0.0, 0.0],
                    stiffness_nm_per_rad,
                })
                .collect(),
            supports,
            end: Attachment {
                node: end,
                ..attach(robot.end, last_body(robot, &hinge_joints))
            },
        };
        let wanted_bodies = members
            .iter()
            .map(|member| member.plane)
            .chain(hinge_joints.iter().map(|&joint| robot.joints[joint].plane))
            .map(|plane| Item::Body(robot.planes[plane].body));
        let order = Order::of(
            robot,
            nodes
                .iter()
                .map(|&node| Item::Node(node))
                .chain(wanted_bodies),
        )
        .expect("a checked robot has no circular dependency");
        let mut model = Self {
            robot,
            mechanism,
            order,
            placement: Placement::new(robot, 0.0),
            nodes,
            hinge_joints,
            structure,
        };
        model.set_factors(factors);
        Ok(model)
    }

    /// Moves the structure to a pose; allocates nothing.
    ///
    /// # Errors
    /// [`RobotError::Unreachable`] if a loop of this mechanism does not close.
    pub fn place(&mut self, pose: &Pose) -> Result<(), RobotError> {
        self.order.place(self.robot, pose, &mut self.placement)?;
        for (node, &index) in self.structure.nodes.iter_mut().zip(&self.nodes) {
            node.position_m = self.placement.node_m(index);
        }
        for (element, &member) in self
            .structure
            .elements
            .iter_mut()
            .zip(&self.mechanism.members)
        {
            element.toward_y = self
                .placement
                .plane_normal(self.robot, self.robot.members[member].plane);
        }
        for (hinge, &joint) in self.structure.hinges.iter_mut().zip(&self.hinge_joints) {
            hinge.axis = self
                .placement
                .plane_normal(self.robot, self.robot.joints[joint].plane);
        }
        Ok(())
    }

    /// Multiplies the nominal section constants by fitting factors (the paper's eq. (17)).
    pub fn set_factors(&mut self, factors: &FittingFactors) {
        for (element, &member) in self
            .structure
            .elements
            .iter_mut()
            .zip(&self.mechanism.members)
        {
            let member = &self.robot.members[member];
            element.section = self.robot.sections[member.section]
                .section
                .scaled(factors.of(member.class));
        }
    }

    /// Robot node of each node of the structure.
    pub(super) fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// The order in which its bodies and nodes follow from one another.
    pub(super) fn order(&self) -> &Order {
        &self.order
    }

    /// The structure as it stands.
    #[must_use]
    pub fn structure(&self) -> &Structure {
        &self.structure
    }

    /// The robot's members, one an element of the structure.
    pub fn members(&self) -> impl Iterator<Item = &'a Member> {
        self.mechanism
            .members
            .iter()
            .map(|&member| &self.robot.members[member])
    }

    /// For each hinge of the structure the plane whose normal is its axis.
    fn hinge_planes(&self) -> impl Iterator<Item = usize> {
        let joints = self.hinge_joints.iter();
        joints.map(|&joint| self.robot.joints[joint].plane)
    }

    /// Planes whose normals elements and hinges need, ascending.
    pub(super) fn planes(&self) -> Vec<usize> {
        let of_members = self.members().map(|member| member.plane);
        let mut planes: Vec<usize> = of_members.chain(self.hinge_planes()).collect();
        planes.sort_unstable();
        planes.dedup();
        planes
    }

    /// Normal of a plane of the robot where the structure stands.
    pub(super) fn plane_normal(&self, plane: usize) -> [f64; 3] {
        self.placement.plane_normal(self.robot, plane)
    }

    /// The series-parallel reduction of the structure, not yet rated; `None` if only the general solver serves it.
    pub(super) fn reduction(&self, path: SolutionPath) -> Option<Reduction> {
        let planes: Vec<usize> = self.members().map(|member| member.plane).collect();
        let hinge_planes: Vec<usize> = self.hinge_planes().collect();
        Reduction::of(&self.structure, &planes, &hinge_planes, path)
    }

    /// Gives a reduction the structure's sections, multiplied by factors; tells whether all can be used.
    pub(super) fn rate(&self, reduction: &mut Reduction, factors: &FittingFactors) -> bool {
        let members = &self.mechanism.members;
        reduction.rate(&self.structure, |element| {
            factors.of(self.robot.members[members[element]].class)
        })
    }

    /// The mechanism this is the structure of.
    #[must_use]
    pub fn mechanism(&self) -> &'a Mechanism {
        self.mechanism
    }

    /// The robot this is the structure of.
    #[must_use]
    pub fn robot(&self) -> &'a Robot {
        self.robot
    }
}

/// Joints that turn, with their stiffness.
fn hinged_joints(robot: &Robot, mechanism: &Mechanism, joints: &JointModel) -> Vec<(usize, f64)> {
    let existing = mechanism.joints(robot);
    match joints {
        JointModel::Rigid => Vec::new(),
        JointModel::Pinned => existing
            .into_iter()
            .filter(|joint| !mechanism.locked.contains(joint))
            .map(|joint| (joint, 0.0))
            .collect(),
        JointModel::Hinged(list) => list
            .iter()
            .copied()
            .filter(|(joint, _)| existing.contains(joint))
            .collect(),
    }
}

/// Places, among the hinged joints, of those that stand between a body and the rest of a node.
///
/// A compliant joint splits its node: the element ends of its second body go to the new node, all others stay. Where several joints
/// share a node, each second body turns against the node itself, not against the body before it.
fn hinges_behind(robot: &Robot, hinge_joints: &[usize], node: usize, body: usize) -> Vec<usize> {
    hinge_joints
        .iter()
        .enumerate()
        .filter(|(_, joint)| {
            let joint = &robot.joints[**joint];
            joint.node == node && joint.bodies[1] == body
        })
        .map(|(hinge, _)| hinge)
        .collect()
}

/// The body on which the load acts: the one behind the most hinges at the end node.
fn last_body(robot: &Robot, hinge_joints: &[usize]) -> Option<usize> {
    robot
        .joints
        .iter()
        .filter(|joint| joint.node == robot.end)
        .map(|joint| joint.bodies[1])
        .max_by_key(|&body| hinges_behind(robot, hinge_joints, robot.end, body).len())
}
