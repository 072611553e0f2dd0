//! From a robot, a mechanism and a pose to the structure that carries the load.

use stiffbench_numeric::vector::{cross, norm, subtract};
use stiffbench_units_and_text::test_point::Direction;

use super::carried_masses::{CarriedMass, bodies_of_loads, carried_masses};
use crate::structure::{Element, Reduction, SolutionPath, Structure, Strut};

use super::Robot;
use super::error::RobotError;
use super::fitting_factors::FittingFactors;
use super::hinges::{JointModel, ModelHinge, hinges};
use super::kinematics::{FixedDirection, Item, Order, Placement};
use super::loads::BodyPoint;
use super::model::{Mechanism, Member, Pose};
use super::model_parameter::ModelParameter;
use super::structure_parts::StructureParts;

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
    /// The same with what only masses and balancers need; nothing if there are none.
    order_of_loads: Order,
    placement: Placement<f64>,
    /// Robot node of each structure node.
    nodes: Vec<usize>,
    hinges: Vec<ModelHinge>,
    masses: Vec<CarriedMass>,
    structure: Structure,
}

impl<'a> MechanismModel<'a> {
    /// The structure of a mechanism, not yet placed: call [`MechanismModel::place`] next.
    ///
    /// Joints, base and tool yield by the springs of `factors` and, where those do not name them, of the robot file.
    ///
    /// # Errors
    /// [`RobotError::IncompleteMechanism`] if no member reaches the end node or a support.
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        joints: &JointModel,
        theory: Theory,
        factors: &FittingFactors,
    ) -> Result<Self, RobotError> {
        Self::with_parameters(robot, mechanism, joints, theory, factors, &[])
    }

    /// The same with room for springs among `parameters`, whatever their value now.
    ///
    /// # Errors
    /// [`RobotError::IncompleteMechanism`].
    pub fn with_parameters(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        joints: &JointModel,
        theory: Theory,
        factors: &FittingFactors,
        parameters: &[ModelParameter],
    ) -> Result<Self, RobotError> {
        let hinges = hinges(robot, mechanism, joints, factors, parameters);
        let parts = StructureParts::new(robot, mechanism, &hinges)?;
        let members = mechanism
            .members
            .iter()
            .map(|&member| &robot.members[member]);
        let elements = members.map(|member| Element {
            ends: member
                .nodes
                .map(|node| parts.attachment(node, Some(member.body))),
            toward_y: [1.0, 0.0, 0.0],
            section: robot.sections[member.section].section,
            material: robot.sections[member.section].material,
            shear: (theory == Theory::Timoshenko).then_some(robot.sections[member.section].shear),
        });
        let structure = Structure {
            elements: elements.collect(),
            ..parts.structure(factors)
        };
        let hangs = |point: &BodyPoint| parts.hangs(point);
        let place_of = |node: usize| parts.nodes.iter().position(|known| *known == node);
        let masses = carried_masses(robot, mechanism, hangs, place_of, &structure.end);
        let struts = robot.balancers.iter().map(|balancer| Strut {
            ends: [0, 1].map(|end: usize| hangs(&balancer.pivots[end])),
            ..Strut::default()
        });
        let structure = Structure {
            struts: struts.collect(),
            ..structure
        };
        let nodes = parts.nodes;
        let wanted = wanted_items(robot, mechanism, &hinges, &nodes);
        let order = Order::of(robot, wanted.iter().copied()).expect(NO_CIRCLE);
        let bodies = bodies_of_loads(robot);
        let order_of_loads = if bodies.is_empty() {
            Order::default()
        } else {
            let all = wanted.into_iter().chain(bodies.into_iter().map(Item::Body));
            Order::of(robot, all).expect(NO_CIRCLE)
        };
        let mut model = Self {
            robot,
            mechanism,
            order,
            order_of_loads,
            placement: Placement::new(robot, 0.0),
            nodes,
            hinges,
            masses,
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
        self.order_of_loads
            .place(self.robot, pose, &mut self.placement)?;
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
        for (hinge, own) in self.structure.hinges.iter_mut().zip(&self.hinges) {
            hinge.axis = self.placement.direction(&own.direction);
        }
        let balancers = &self.robot.balancers;
        for (strut, balancer) in self.structure.struts.iter_mut().zip(balancers) {
            let pivot_m = |pivot: &BodyPoint| self.placement.point_m(pivot.body, &pivot.at_m);
            strut.points_m = [0, 1].map(|end: usize| pivot_m(&balancer.pivots[end]));
            let [first, second] = strut.points_m;
            (strut.force_n, strut.stiffness_n_per_m) =
                balancer.force.at(norm(subtract(second, first)));
        }
        Ok(())
    }

    /// Multiplies the nominal section constants by fitting factors (the paper's eq. (17)), and takes the springs of joints, base and tool.
    ///
    /// A spring yields only if the model was made with it.
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
                .scaled(factors.of_member(member, self.robot.section_name(member)));
        }
        for (hinge, own) in self.structure.hinges.iter_mut().zip(&self.hinges) {
            hinge.stiffness_nm_per_rad = own.stiffness(factors);
        }
    }

    /// Motion of the end per rocking of the base about x, y, z through the first support: axis × (end - support), m/rad, and the axis.
    #[must_use]
    pub fn base_levers(&self) -> [[f64; 6]; 3] {
        let end = self.structure.nodes[self.structure.end.node].position_m;
        let first = self.structure.supports.first();
        let support = first.map_or([0.0; 3], |held| self.structure.nodes[held.node].position_m);
        base_levers_between(support, end)
    }

    /// What each hinge of the structure stands for.
    pub(super) fn hinges(&self) -> &[ModelHinge] {
        &self.hinges
    }

    /// The parameter that is the compliance of each hinge of the structure.
    pub fn hinge_parameters(&self) -> impl Iterator<Item = &ModelParameter> {
        self.hinges.iter().map(|hinge| &hinge.spring)
    }

    pub(super) fn carried_masses(&self) -> &[CarriedMass] {
        &self.masses
    }

    /// Where the bodies and nodes of the robot are.
    pub(super) fn placement(&self) -> &Placement<f64> {
        &self.placement
    }

    /// Robot node of each node of the structure.
    pub(super) fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// The order in which its bodies and nodes follow from one another, those of balancers included.
    pub(super) fn order(&self) -> &Order {
        if self.structure.struts.is_empty() {
            &self.order
        } else {
            &self.order_of_loads
        }
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

    /// For each hinge of the structure the number of its axis among the planes of the robot and [`MechanismModel::directions`].
    fn hinge_planes(&self) -> Vec<usize> {
        let mut next = self.robot.planes.len();
        let mut number = |hinge: &ModelHinge| {
            hinge.plane.unwrap_or_else(|| {
                next += 1;
                next - 1
            })
        };
        self.hinges.iter().map(&mut number).collect()
    }

    /// Axes of hinges that are no normals of planes on which elements may lie; numbered after the planes.
    pub(super) fn directions(&self) -> impl Iterator<Item = &FixedDirection> {
        let others = self.hinges.iter().filter(|hinge| hinge.plane.is_none());
        others.map(|hinge| &hinge.direction)
    }

    /// Planes whose normals elements and hinges need, ascending.
    pub(super) fn planes(&self) -> Vec<usize> {
        let of_members = self.members().map(|member| member.plane);
        let of_hinges = self.hinges.iter().filter_map(|hinge| hinge.plane);
        let mut planes: Vec<usize> = of_members.chain(of_hinges).collect();
        planes.sort_unstable();
        planes.dedup();
        planes
    }

    /// Unit vectors x, y, z of the tool where the model stands, in the axes of the world.
    #[must_use]
    pub fn tool_axes(&self) -> [[f64; 3]; 3] {
        let tool = &self.robot.tool;
        let own = tool
            .axes
            .unwrap_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        own.map(|local| {
            self.placement.direction(&FixedDirection {
                body: tool.body,
                local,
            })
        })
    }

    /// Normal of a plane of the robot where the structure stands.
    pub(super) fn plane_normal(&self, plane: usize) -> [f64; 3] {
        self.placement.plane_normal(self.robot, plane)
    }

    /// The series-parallel reduction of the structure, not yet rated; `None` if only the general solver serves it.
    pub(super) fn reduction(&self, path: SolutionPath) -> Option<Reduction> {
        let planes: Vec<usize> = self.members().map(|member| member.plane).collect();
        Reduction::of(&self.structure, &planes, &self.hinge_planes(), path)
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

/// Motion of an end per rocking about each axis through a support: displacement, m/rad, and rotation.
pub(crate) fn base_levers_between(support_m: [f64; 3], end_m: [f64; 3]) -> [[f64; 6]; 3] {
    Direction::ALL.map(|axis| {
        let [x, y, z] = cross(axis.unit_vector(), subtract(end_m, support_m));
        let [rx, ry, rz] = axis.unit_vector();
        [x, y, z, rx, ry, rz]
    })
}

/// What has to be placed for a structure.
fn wanted_items(
    robot: &Robot,
    mechanism: &Mechanism,
    hinges: &[ModelHinge],
    nodes: &[usize],
) -> Vec<Item> {
    let members = mechanism
        .members
        .iter()
        .map(|&member| robot.members[member].plane);
    let planes = members.chain(hinges.iter().filter_map(|hinge| hinge.plane));
    let bodies = planes.map(|plane| robot.planes[plane].body);
    let others = hinges.iter().filter(|hinge| hinge.plane.is_none());
    let bodies = bodies.chain(others.filter_map(|hinge| hinge.direction.body));
    let bodies = bodies.chain(robot.tool.body);
    let nodes = nodes.iter().map(|&node| Item::Node(node));
    nodes.chain(bodies.map(Item::Body)).collect()
}

/// Why an order is found.
const NO_CIRCLE: &str = "a checked robot has no circular dependency";
