//! A checked robot and its parts; references are indices.

use std::sync::Arc;

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::test_point::PoseId;

use super::fitting_factors::FittingFactors;
use super::loads::{Balancer, PointMass};
use super::model_parameter::ElementClass;
use super::spring_axis::JointMotion;
use super::springs::{JointSprings, SpringDefault, Tool};
use crate::structure::{Material, Section, ShearCoefficients};

/// A limit is broken when a pose lies beyond it by more than this, degrees: files state angles to a thousandth, sums of them
/// round at 1e-13.
const LIMIT_TOLERANCE_DEG: f64 = 1e-9;

/// A coordinate of the pose: an angle, degrees, or of a joint that slides a distance, m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "VariableReport")]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Whether it is an angle or a distance.
    #[serde(skip)]
    pub motion: JointMotion,
    /// Smallest value, degrees or m.
    pub min_deg: f64,
    /// Largest value, degrees or m.
    pub max_deg: f64,
    /// Value in poses that do not name it, degrees or m.
    pub nominal_deg: f64,
}

/// A coupled limit: Σ coefficient × variable ≥ `at_least_deg`.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// Variable and coefficient.
    pub terms: Vec<(usize, f64)>,
    /// Smallest value of the sum, degrees.
    pub at_least_deg: f64,
}

impl Limit {
    /// What the limit bounds from below, in a pose, degrees.
    fn sum_deg(&self, pose: &Pose) -> f64 {
        let terms = self.terms.iter();
        terms
            .map(|(variable, c)| c * pose.angles_deg[*variable])
            .sum()
    }

    /// The limit in words, for example `theta2 - theta3 >= 52.17`.
    #[must_use]
    pub fn in_words(&self, robot: &Robot) -> String {
        let mut text = String::new();
        for (place, (variable, coefficient)) in self.terms.iter().enumerate() {
            let sign = match (place, *coefficient < 0.0) {
                (0, false) => "",
                (0, true) => "-",
                (_, false) => " + ",
                (_, true) => " - ",
            };
            text.push_str(sign);
            if coefficient.abs() != 1.0 {
                text.push_str(&coefficient.abs().to_string());
                text.push(' ');
            }
            text.push_str(&robot.variables[*variable].name);
        }
        format!("{text} >= {}", self.at_least_deg)
    }
}

/// A limit that a pose breaks.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitViolation {
    /// The limit in words, for example `theta2 - theta3 >= 52.17`.
    pub limit: String,
    /// How far beyond it the pose lies, degrees.
    pub excess_deg: f64,
}

/// A plane fixed to a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Name.
    pub name: String,
    /// Body it is fixed to.
    pub body: usize,
    /// Unit normal in the body's axes.
    pub normal: [f64; 3],
}

/// A rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Name.
    pub name: String,
    /// Chain it is counted in; `None` for a helper.
    pub chain: Option<String>,
    /// How its axes follow from the pose.
    pub place: BodyPlace,
}

/// How a body's axes follow from the pose.
#[derive(Debug, Clone, PartialEq)]
pub enum BodyPlace {
    /// The reference: origin at zero, axes those of the world.
    Ground,
    /// Turned on a parent about an axis through a node.
    Turned {
        /// The parent body.
        parent: usize,
        /// Node at the origin.
        origin: usize,
        /// Unit axis in the parent's axes.
        axis: [f64; 3],
        /// The angle.
        angle: Angle,
    },
    /// Moved on a parent along an axis from a node; its axes are those of the parent.
    Slid {
        /// The parent body.
        parent: usize,
        /// Node from which the distance counts; on the parent.
        origin: usize,
        /// Unit axis in the parent's axes.
        axis: [f64; 3],
        /// The distance: offset and value in m, coefficients of distances 1 and of angles m per degree.
        distance: Angle,
    },
    /// Local z from one node to another, local x along a plane's normal.
    Along {
        /// The two nodes.
        nodes: [usize; 2],
        /// The plane.
        plane: usize,
        /// Turn from z towards y, degrees.
        turn_deg: f64,
    },
}

/// offset + Σ coefficient × variable, degrees.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Angle {
    /// Constant part, degrees.
    pub offset_deg: f64,
    /// Variable and coefficient.
    pub terms: Vec<(usize, f64)>,
}

/// A joint between two bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name.
    pub name: String,
    /// Node it sits at.
    pub node: usize,
    /// First and second body; the second moves on the first.
    pub bodies: [usize; 2],
    /// Chain it is counted in.
    pub chain: Option<String>,
    /// Plane about whose normal it turns, or along whose normal it slides.
    pub plane: usize,
    /// Whether it turns or slides.
    pub motion: JointMotion,
    /// Where it yields.
    pub springs: JointSprings,
}

/// A point.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotNode {
    /// Name.
    pub name: Arc<str>,
    /// How its position follows from the pose.
    pub place: NodePlace,
}

/// How a node's position follows from the pose.
#[derive(Debug, Clone, PartialEq)]
pub enum NodePlace {
    /// Fixed on a body.
    Fixed {
        /// The body.
        body: usize,
        /// Local coordinates, m.
        at_m: [f64; 3],
    },
    /// Intersection of two circles in a plane.
    Loop {
        /// Centres.
        centres: [usize; 2],
        /// Radii.
        radii: [RadiusOf; 2],
        /// The plane.
        plane: usize,
        /// +1 or -1: the side of n × u on which the node lies.
        branch: f64,
    },
}

/// Radius of a loop's circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RadiusOf {
    /// A length, m.
    Length(f64),
    /// Distance between two nodes.
    Distance([usize; 2]),
}

/// A two-node beam of the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Member {
    /// Name.
    pub name: String,
    /// Its nodes.
    pub nodes: [usize; 2],
    /// Chain it belongs to.
    pub chain: String,
    /// Which factors it takes.
    pub class: ElementClass,
    /// Index of its section.
    pub section: usize,
    /// Body it is part of.
    pub body: usize,
    /// Plane whose normal is local y.
    pub plane: usize,
    /// Groups of parameters that it takes part in, by name.
    pub groups: Vec<Arc<str>>,
}

/// Two nodes that a body holds at their distance: a member that neither bends nor stretches.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidLink {
    /// Name.
    pub name: String,
    /// Its nodes; they may coincide.
    pub nodes: [usize; 2],
    /// Chain it belongs to.
    pub chain: String,
    /// Body it is part of.
    pub body: usize,
    /// Whether the robot file does not ask for it: its nodes lie apart, and no beam leads from one to the other.
    pub is_added: bool,
}

/// Values of the variables, degrees or, of those that slide, m, in the order of the robot.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Pose {
    /// Values of the variables in their order, degrees or, of those that slide, m.
    pub angles_deg: Vec<f64>,
}

/// A pose with its name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "PoseReport")]
pub struct NamedPose {
    /// Its name.
    #[serde(rename = "name")]
    pub id: PoseId,
    /// The angles.
    #[serde(flatten)]
    pub pose: Pose,
    /// The point (z, y) that a publication states for it, m.
    #[serde(skip)]
    pub stated_zy_m: Option<[f64; 2]>,
}

/// Whether a pose breaks no limit.
pub(super) fn is_within_limits(robot: &Robot, pose: &Pose) -> bool {
    let keeps = |(variable, &angle): (&Variable, &f64)| {
        variable.min_deg - angle <= LIMIT_TOLERANCE_DEG
            && angle - variable.max_deg <= LIMIT_TOLERANCE_DEG
    };
    let own = robot.variables.iter().zip(&pose.angles_deg).all(keeps);
    own && robot
        .limits
        .iter()
        .all(|limit| limit.at_least_deg - limit.sum_deg(pose) <= LIMIT_TOLERANCE_DEG)
}

/// Limits that a pose breaks.
pub(super) fn violated_limits(robot: &Robot, pose: &Pose) -> Vec<LimitViolation> {
    let mut violations = Vec::new();
    let mut check = |excess_deg: f64, limit: &dyn Fn() -> String| {
        if excess_deg > LIMIT_TOLERANCE_DEG {
            violations.push(LimitViolation {
                limit: limit(),
                excess_deg,
            });
        }
    };
    for (variable, &angle) in robot.variables.iter().zip(&pose.angles_deg) {
        let Variable {
            name,
            min_deg,
            max_deg,
            ..
        } = variable;
        check(min_deg - angle, &|| format!("{name} >= {min_deg}"));
        check(angle - max_deg, &|| format!("{name} <= {max_deg}"));
    }
    for limit in &robot.limits {
        check(limit.at_least_deg - limit.sum_deg(pose), &|| {
            limit.in_words(robot)
        });
    }
    violations
}

/// A robot, checked and ready to be posed.
#[derive(Debug, Clone)]
pub struct Robot {
    /// The text that it was read from.
    pub source: Arc<SourceText>,
    /// What it is called.
    pub name: String,
    /// Angles and distances that make a pose.
    pub variables: Vec<Variable>,
    /// Coupled limits.
    pub limits: Vec<Limit>,
    /// Planes in which linkages move.
    pub planes: Vec<Plane>,
    /// Rigid bodies.
    pub bodies: Vec<Body>,
    /// Joints between bodies.
    pub joints: Vec<Joint>,
    /// Points.
    pub nodes: Vec<RobotNode>,
    /// Beams between nodes.
    pub members: Vec<Member>,
    /// Rigid members between nodes.
    pub rigid_links: Vec<RigidLink>,
    /// Held nodes.
    pub supports: Vec<usize>,
    /// The node at the end: the tool centre, where loads act and displacements are read.
    pub end: usize,
    /// What is mounted at the end.
    pub tool: Tool,
    /// Springs of the base along and about the axes of the world, through the first support: x, y, z (m/N), rx, ry, rz (rad/(N·m)).
    pub base: [SpringDefault; 6],
    /// Sections with their material, by name.
    pub sections: IndexMap<String, RatedSection>,
    /// Unit vector of the vertical, upward; weight acts against it.
    pub vertical: [f64; 3],
    /// Words for x, y, z, for labels.
    pub axis_words: [Option<String>; 3],
    /// Masses that no section has.
    pub masses: Vec<PointMass>,
    /// Springs and cylinders that carry part of the weight.
    pub balancers: Vec<Balancer>,
    /// Mechanisms by name, in the order of the file.
    pub mechanisms: IndexMap<String, Mechanism>,
    /// Factor sets by name.
    pub factors: IndexMap<String, FittingFactors>,
    /// Named poses, in the order of the file.
    pub poses: Vec<NamedPose>,
    /// Height below which no joint and no tool may be in a proposed pose, m; `None` if the file states none.
    pub floor_m: Option<f64>,
    /// Least distance of the tool from the vertical through the base in a proposed pose, m; `None` if the file states none.
    pub base_radius_m: Option<f64>,
    /// Keys of the file that this version does not know, and other things that are odd but not wrong.
    pub warnings: Vec<String>,
}

/// A nominal section with the material it is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RatedSection {
    /// Nominal constants, before any factor.
    pub section: Section,
    /// Elastic constants.
    pub material: Material,
    /// Shear coefficients for Timoshenko beams.
    pub shear: ShearCoefficients,
    /// Mass of a member per length, kg/m; `None` where the file gives neither it nor a density.
    pub mass_kg_per_m: Option<f64>,
}

/// One choice of chains and single elements.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mechanism {
    /// Name.
    pub name: String,
    /// Chains that are there.
    pub chains: Vec<String>,
    /// Indices of the robot's members that are there.
    pub members: Vec<usize>,
    /// Indices of the robot's rigid links that are there.
    pub rigid_links: Vec<usize>,
    /// Indices of joints that a drive or a brake holds when a pose is held.
    pub locked: Vec<usize>,
}

impl FittingFactors {
    /// Multipliers of the constants of a member: those of its class times those of its section, by name, and of its groups.
    #[must_use]
    pub fn of_member(&self, member: &Member, section: &str) -> [f64; 4] {
        let mut multipliers = self.of(member.class);
        let groups = member.groups.iter();
        let of_groups = groups.filter_map(|group| self.groups.get(&**group));
        for factors in self.sections.get(section).into_iter().chain(of_groups) {
            for (multiplier, factor) in multipliers.iter_mut().zip(factors) {
                *multiplier *= factor;
            }
        }
        multipliers
    }
}
