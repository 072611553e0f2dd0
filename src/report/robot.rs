//! A robot, its mobility and its compliance, for people and for programs.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_document::{Document, Table};

use crate::analysis::{RobotCheck, stiffness_words};
use crate::physics::{ActingPhysics, Effect};
use crate::robot::{
    ChainMobility, FittingFactors, MechanismModel, Mobility, ModelParameter, NamedPose, Robot,
    RoleInFit, Variable, Yielding,
};
use crate::structure::Compliance6;

use super::text::{or_dash, significant};

/// What a robot file says, counted.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RobotReport {
    /// Name of the robot.
    pub name: String,
    /// Number of bodies.
    pub bodies: usize,
    /// Number of joints.
    pub joints: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of elements.
    pub elements: usize,
    /// Number of rigid links.
    pub rigid_links: usize,
    /// Springs of joints, base and tool, by the names that a fit has for them.
    pub springs: Vec<String>,
    /// The end node.
    pub end: String,
    /// The supported nodes.
    pub supports: Vec<String>,
    /// The mechanisms.
    pub mechanisms: Vec<MechanismReport>,
    /// The joint variables.
    pub variables: Vec<Variable>,
    /// The named poses.
    pub poses: Vec<NamedPose>,
    /// The factor sets by name.
    pub factors: IndexMap<String, FittingFactors>,
    #[serde(skip)]
    sections: usize,
}

/// A mechanism of a robot.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct MechanismReport {
    /// Its name.
    pub name: String,
    /// Its chains.
    pub chains: Vec<String>,
    /// Names of its elements.
    pub elements: Vec<String>,
    /// Names of its rigid links.
    pub rigid_links: Vec<String>,
    /// Names of its joints.
    pub joints: Vec<String>,
}

impl RobotReport {
    /// Counts what is in a robot.
    #[must_use]
    pub fn new(robot: &Robot) -> Self {
        let mechanisms = robot.mechanisms.values().map(|mechanism| MechanismReport {
            name: mechanism.name.clone(),
            chains: mechanism.chains.clone(),
            elements: mechanism
                .members
                .iter()
                .map(|&member| robot.members[member].name.clone())
                .collect(),
            rigid_links: mechanism
                .rigid_links
                .iter()
                .map(|&link| robot.rigid_links[link].name.clone())
                .collect(),
            joints: mechanism
                .joints(robot)
                .iter()
                .map(|&joint| robot.joints[joint].name.clone())
                .collect(),
        });
        let node = |&node: &usize| robot.nodes[node].name.to_string();
        Self {
            name: robot.name.clone(),
            bodies: robot.bodies.len(),
            joints: robot.joints.len(),
            nodes: robot.nodes.len(),
            elements: robot.members.len(),
            rigid_links: robot.rigid_links.len(),
            springs: robot
                .own_springs()
                .filter(|(_, spring)| {
                    matches!(spring.yielding, Yielding::Compliance(_))
                        || spring.in_fit != RoleInFit::Fixed
                })
                .map(|(name, _)| name.to_string())
                .collect(),
            end: node(&robot.end),
            supports: robot.supports.iter().map(node).collect(),
            mechanisms: mechanisms.collect(),
            variables: robot.variables.clone(),
            poses: robot.poses.clone(),
            factors: robot.factors.clone(),
            sections: robot.sections.len(),
        }
    }

    /// The same for people.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut document = Document::of(format!(
            "{} bodies, {} joints, {} nodes, {} elements, {} rigid links, {} springs, {} sections, end node {}, supports {}.",
            self.bodies,
            self.joints,
            self.nodes,
            self.elements,
            self.rigid_links,
            self.springs.len(),
            self.sections,
            self.end,
            self.supports.join(", ")
        ));
        document.table(
            Table::of(&self.mechanisms)
                .words("mechanism", |one| &one.name)
                .words("chains", |one| one.chains.join(" "))
                .numbers("elements", |one| one.elements.len())
                .numbers("rigid links", |one| one.rigid_links.len())
                .numbers("joints", |one| one.joints.len()),
        );
        document.table(
            Table::of(&self.variables)
                .words("variable", |one| &one.name)
                .numbers("smallest, deg", |one| one.min_deg)
                .numbers("largest, deg", |one| one.max_deg)
                .numbers("nominal, deg", |one| one.nominal_deg),
        );
        let variables = self.variables.iter().map(|variable| &variable.name);
        document.table(
            Table::of(&self.poses)
                .words("pose", |pose| &pose.id)
                .numbers_each(variables, |pose| pose.pose.angles_deg.clone()),
        );
        let sets = self.factors.keys().cloned().collect::<Vec<_>>().join(", ");
        let sets = if sets.is_empty() { "none" } else { &sets };
        document.paragraph(format!("Factor sets: {sets}."));
        document
    }
}

/// The freedoms of a robot: counted by formula, and by the rank of its loops.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct MobilityReport {
    /// Count of each chain by the paper's eqs. (2) to (5).
    pub chains: Vec<ChainMobility>,
    /// Their sum, eq. (1); `null` without chains.
    pub total: Option<i64>,
    /// The rank of each mechanism.
    pub mechanisms: Vec<MechanismRank>,
}

/// The rank of the conditions that the loops of a mechanism close.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct MechanismRank {
    /// Name of the mechanism.
    pub mechanism: String,
    /// Its rank.
    pub rank_check: Mobility,
}

impl MobilityReport {
    /// Both counts.
    #[must_use]
    pub fn new(chains: Vec<ChainMobility>, mechanisms: Vec<MechanismRank>) -> Self {
        let total = chains.iter().map(|chain| chain.freedoms).sum();
        Self {
            total: (!chains.is_empty()).then_some(total),
            chains,
            mechanisms,
        }
    }

    /// Count by formula beside count by rank.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut document = Document::new();
        if let Some(total) = self.total {
            let equations = |host: bool| if host { "(2) and (3)" } else { "(4) and (5)" };
            document.table(
                Table::of(&self.chains)
                    .words("chain", |one| &one.chain)
                    .numbers("n", |one| one.components)
                    .numbers("g", |one| one.joints)
                    .numbers("mu", |one| one.overconstraints)
                    .numbers("nu", |one| one.redundant_constraints)
                    .numbers("lambda", |one| one.general_constraints)
                    .words("equations", |one| equations(one.host))
                    .numbers("F", |one| one.freedoms),
            );
            document.paragraph(format!("Total by eq. (1): F = {total}."));
        } else {
            document.paragraph(
                "No body of the robot file names its `chain`, so eqs. (1) to (5) do not apply.",
            );
        }
        document.table(
            Table::of(&self.mechanisms)
                .words("mechanism", |one| &one.mechanism)
                .numbers("joints", |one| one.rank_check.joints)
                .numbers("loops", |one| one.rank_check.loops)
                .numbers("rank of 6 x loops conditions", |one| {
                    one.rank_check.rank.to_string()
                })
                .numbers("freedoms", |one| one.rank_check.freedoms),
        );
        document.paragraph("The second table is the rank of the loop-closure conditions in the first pose of the robot.");
        document
    }
}

/// The end compliance of a robot in a pose.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ComplianceReport {
    /// Displacements and rotations of the end per force and moment, SI; `null` where they depend on a spring that has no value yet.
    pub compliance: [[Option<f64>; 6]; 6],
    /// What the rows are.
    pub rows: [&'static str; 6],
    /// What the columns are.
    pub columns: [&'static str; 6],
    /// The units.
    pub unit: &'static str,
    /// Positions of the nodes, m.
    pub nodes: IndexMap<String, [f64; 3]>,
    /// Effects beside the beams.
    pub physics: Vec<Effect>,
}

impl ComplianceReport {
    /// A compliance with the nodes of the model behind it.
    #[must_use]
    pub fn new(
        compliance: [[Option<f64>; 6]; 6],
        model: &MechanismModel<'_>,
        physics: &ActingPhysics,
    ) -> Self {
        let nodes = model.structure().nodes.iter();
        Self {
            compliance,
            rows: Compliance6::DISPLACEMENTS,
            columns: Compliance6::LOADS,
            unit: "SI: m/N, rad/N, m/(N*m), rad/(N*m)",
            nodes: nodes
                .map(|node| (node.name.to_string(), node.position_m))
                .collect(),
            physics: physics.effects.clone(),
        }
    }

    /// The effects beside the beams, the end compliance and the stiffness along each axis.
    #[must_use]
    pub fn document(&self) -> Document {
        let printed = |entry: Option<f64>| match entry {
            Some(entry) => format!("{entry:.6e}"),
            None => "unknown".to_owned(),
        };
        let stiffness = |i: usize| stiffness_words(self.compliance[i][i], &|k| significant(k, 5));
        let mut document = physics_document(BESIDE_BEAMS, &self.physics);
        document.table(
            Table::of(self.rows.iter().zip(&self.compliance))
                .words("", |(name, _)| *name)
                .numbers_each(self.columns, |(_, row)| row.map(printed)),
        );
        document.paragraph(format!(
            "{}. Stiffness along x, y, z: {} N/µm.",
            self.unit,
            [0, 1, 2].map(stiffness).join(", ")
        ));
        document
    }
}

/// How effects act in a robot without a fit.
pub const BESIDE_BEAMS: &str = "Physics beside the beams:";

/// Effects under a sentence that says how they act; empty without effects.
#[must_use]
pub fn physics_document(sentence: &str, effects: &[Effect]) -> Document {
    let mut document = Document::new();
    if !effects.is_empty() {
        document.paragraph(sentence);
    }
    document.items(effects.iter().map(ToString::to_string));
    document
}

/// A robot file, tried, for people.
#[must_use]
pub fn robot_check_document(check: &RobotCheck) -> Document {
    let stiffness = |compliance| stiffness_words(compliance, &|k| format!("{k:.5}"));
    let mark = |is_plausible: bool| if is_plausible { "yes" } else { "no" }.to_owned();
    let mut document = Document::new();
    document.table(
        Table::of(&check.checked)
            .words("mechanism", |one| &one.mechanism)
            .words("pose", |one| &one.pose)
            .numbers("tool x, y, z, m", |one| {
                one.tool_m.map(|m| format!("{m:.3}")).join(", ")
            })
            .numbers_each(["Kx, N/µm", "Ky, N/µm", "Kz, N/µm"], |one| {
                one.compliance_m_per_n.map(stiffness)
            })
            .words("plausible", |one| or_dash(one.plausible, mark)),
    );
    let reach = check.reach_m;
    document.items(reach.map(|reach| format!("Reach in these poses: {reach:.3} m.")));
    document.item(match check.mass_kg {
        Some(mass) => format!("Mass: {} kg.", significant(mass, 4)),
        None => "Mass: not stated; the robot's own weight is neglected.".to_owned(),
    });
    let rigid = format!("Springs {}", ModelParameter::RIGID);
    for (what, names) in [
        ("Held to the ground", &check.held),
        (
            "Rigid, because no beam leads there",
            &check.added_rigid_links,
        ),
        ("Free springs, which a fit determines", &check.free_springs),
        (&rigid, &check.rigid_springs),
    ] {
        if !names.is_empty() {
            document.item(format!("{what}: {}.", names.join(", ")));
        }
    }
    for words in &check.unknown_springs {
        document.item(format!("{words}."));
    }
    let mm = |length_m: f64| (1e3 * length_m).round() + 0.0;
    if let Some(floor_m) = check.floor_m {
        document.item(format!(
            "Proposed poses keep joints and tool at least {} mm high.",
            mm(floor_m)
        ));
    }
    if let Some(radius_m) = check.base_radius_m {
        document.item(format!(
            "Proposed poses keep the tool {} mm from the vertical through the base.",
            mm(radius_m)
        ));
    }
    if !check.free_springs.is_empty() {
        document.lines(format!(
            "Columns of a table of load cases for `fit`: {}",
            check.load_case_columns.join(",")
        ));
    }
    document.paragraph(if check.findings.is_empty() {
        "No problems found."
    } else {
        "See the notes."
    });
    document
}

/// A robot file that was begun.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct NewRobotReport {
    /// The file.
    pub file: String,
    /// Name of the robot.
    pub name: String,
    /// Names of the joints that move.
    pub joints: Vec<String>,
    /// Names of the variables.
    pub variables: Vec<String>,
    /// Names of the poses.
    pub poses: Vec<String>,
    /// Stated positions that fit.
    pub positions: Vec<String>,
}

impl NewRobotReport {
    /// Of a robot that was written to a file.
    #[must_use]
    pub fn new(robot: &Robot, file: &str, positions: Vec<String>) -> Self {
        Self {
            file: file.to_owned(),
            name: robot.name.clone(),
            joints: robot
                .joints
                .iter()
                .map(|joint| joint.name.clone())
                .collect(),
            variables: robot.variables.iter().map(|v| v.name.clone()).collect(),
            poses: robot
                .poses
                .iter()
                .map(|named| named.id.to_string())
                .collect(),
            positions,
        }
    }

    /// What there is, and what comes next.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut document = Document::of(format!(
            "{}: {}, {} joints ({}), poses {}.",
            self.file,
            self.name,
            self.joints.len(),
            self.joints.join(", "),
            self.poses.join(", ")
        ));
        document.items(&self.positions);
        document.next(format!("robot check {}", self.file));
        document
    }
}
