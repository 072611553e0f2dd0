//! From a robot, a mechanism and a pose to the structure that carries the load.

use stiffbench_numeric::vector::{cross, subtract};
use stiffbench_units_and_text::test_point::Direction;

use crate::structure::{
    Attachment, Compliance6, Element, Hinge, Node, Reduction, SolutionPath, Structure, Support,
};

use super::Robot;
use super::error::RobotError;
use super::kinematics::{Item, Order, Placement};
use super::mechanism::Mechanism;
use super::model::{Member, Pose};
use super::model_parameter::FittingFactors;

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
    /// Stiffness of each hinge without the springs among the parameters, N·m/rad.
    hinges_nm_per_rad: Vec<f64>,
    /// Compliance of the base about x, y, z, rad/(N·m).
    base_rad_per_nm: [f64; 3],
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

        let hinges = hinged_joints(robot, mechanism, joints, factors);
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
            hinges_nm_per_rad: hinges.iter().map(|(_, stiffness)| *stiffness).collect(),
            base_rad_per_nm: [0.0; 3],
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

    /// Multiplies the nominal section constants by fitting factors (the paper's eq. (17)), and takes the springs of joints and base.
    ///
    /// A joint yields only if the model was made with a hinge or a spring in it.
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
                .scaled(factors.of_element(member.class, self.robot.section_name(member)));
        }
        let springs = self.hinge_joints.iter().zip(&self.hinges_nm_per_rad);
        for (hinge, (&joint, &own)) in self.structure.hinges.iter_mut().zip(springs) {
            hinge.stiffness_nm_per_rad = in_series(
                own,
                factors.joint_rad_per_nm(&self.robot.joints[joint].name),
            );
        }
        self.base_rad_per_nm = factors.base_rad_per_nm;
    }

    /// Displacement of the end per rocking of the base about x, y, z through the first support: axis × (end - support), m/rad.
    #[must_use]
    pub fn base_levers_m(&self) -> [[f64; 3]; 3] {
        let end = self.structure.nodes[self.structure.end.node].position_m;
        let first = self.structure.supports.first();
        let support = first.map_or([0.0; 3], |held| self.structure.nodes[held.node].position_m);
        base_levers_between(support, end)
    }

    /// Compliance of the end with that of the base under it.
    pub(super) fn with_base(&self, mut compliance: Compliance6) -> Compliance6 {
        if self.base_rad_per_nm != [0.0; 3] {
            compliance.add_rocking(self.base_rad_per_nm, &self.base_levers_m());
        }
        compliance
    }

    /// Robot joint of each hinge of the structure.
    pub(super) fn hinge_joints(&self) -> &[usize] {
        &self.hinge_joints
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

    /// Takes other values, and gives a reduction the constants that the structure then has; returns whether all can be used.
    pub(super) fn rate(&mut self, reduction: &mut Reduction, factors: &FittingFactors) -> bool {
        self.set_factors(factors);
        reduction.rate(&self.structure)
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

/// Stiffness that stands for a rigid joint, N·m/rad: far beyond any drive, so that a compliance of zero needs no other structure.
const RIGID_NM_PER_RAD: f64 = 1e30;

/// Stiffness of a joint with a spring in series with it, N·m/rad.
fn in_series(stiffness_nm_per_rad: f64, spring_rad_per_nm: f64) -> f64 {
    if spring_rad_per_nm == 0.0 {
        return stiffness_nm_per_rad.min(RIGID_NM_PER_RAD);
    }
    (1.0 / (1.0 / stiffness_nm_per_rad + spring_rad_per_nm)).min(RIGID_NM_PER_RAD)
}

/// Displacement of an end per rocking about each axis through a support, m/rad.
pub(crate) fn base_levers_between(support_m: [f64; 3], end_m: [f64; 3]) -> [[f64; 3]; 3] {
    Direction::ALL.map(|axis| cross(axis.unit_vector(), subtract(end_m, support_m)))
}

/// Joints that turn, with their stiffness; infinite where only a spring among the parameters lets them.
fn hinged_joints(
    robot: &Robot,
    mechanism: &Mechanism,
    joints: &JointModel,
    factors: &FittingFactors,
) -> Vec<(usize, f64)> {
    let existing = mechanism.joints(robot);
    let mut hinges = match joints {
        JointModel::Rigid => Vec::new(),
        JointModel::Pinned => existing
            .iter()
            .copied()
            .filter(|joint| !mechanism.locked.contains(joint))
            .map(|joint| (joint, 0.0))
            .collect(),
        JointModel::Hinged(list) => list
            .iter()
            .copied()
            .filter(|(joint, _)| existing.contains(joint))
            .collect(),
    };
    for joint in existing {
        let name = robot.joints[joint].name.as_str();
        let is_sprung = factors.joints_rad_per_nm.contains_key(name);
        if is_sprung && hinges.iter().all(|(known, _)| *known != joint) {
            hinges.push((joint, f64::INFINITY));
        }
    }
    hinges
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
