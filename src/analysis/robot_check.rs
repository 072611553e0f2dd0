//! A robot file tried: every mechanism in every named pose, with what is odd.

use schemars::JsonSchema;
use serde::Serialize;

use crate::digits::significant;
use crate::load_cases::VectorQuantity;
use crate::robot::{ModelParameter, Pose, Predictor, Robot, RobotError, RoleInFit, SpringDefault};
use crate::source_text::SourceText;
use crate::test_point::Direction;
use crate::toml_text::DocumentStep::Key;
use crate::vector::norm;

use super::unknown_springs::{RIGID_M_PER_N, UnknownSprings};

/// Stiffness of the end, N/µm, below and above which a robot is hardly meant: a millimetre of sag by 0.1 N, a machine tool.
const PLAUSIBLE_N_PER_UM: [f64; 2] = [1e-4, 1e3];

/// Distance of the tool from the origin, m: a finger, the largest industrial robots and gantries.
const PLAUSIBLE_REACH_M: [f64; 2] = [0.05, 10.0];

/// A robot file, tried.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct RobotCheck {
    /// Name of the robot.
    pub name: String,
    /// Largest distance of the tool from the origin in these poses, m; `null` if no pose can be reached.
    pub reach_m: Option<f64>,
    /// Mass of what moves and bends, kg, with the payload; `null` if the file states none.
    pub mass_kg: Option<f64>,
    /// What could be solved.
    pub checked: Vec<CheckedPose>,
    /// What is wrong or odd, in words.
    pub findings: Vec<String>,
    /// Points that are held to the ground.
    pub held: Vec<String>,
    /// Rigid links between points of a body that the file does not ask for, because no beam of it leads there.
    pub added_rigid_links: Vec<String>,
    /// What a fit is to find.
    pub free_springs: Vec<String>,
    /// Springs of joints that the file makes rigid, of a robot that has other springs or no beams.
    pub rigid_springs: Vec<String>,
    /// Which springs of a mechanism have no value yet, in words; empty if all have.
    pub unknown_springs: Vec<String>,
    /// Height below which the file lets no joint and no tool be in a proposed pose, m; `null` if it states none.
    pub floor_m: Option<f64>,
    /// Least distance of the tool from the vertical through the base that the file lets a proposed pose have, m; `null` if it states none.
    pub base_radius_m: Option<f64>,
    /// Columns of a table of load cases for this robot: pose, the joints that move the tool, force and displacement.
    pub load_case_columns: Vec<String>,
}

/// A mechanism in a pose.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CheckedPose {
    /// Name of the mechanism.
    pub mechanism: String,
    /// Name of the pose.
    pub pose: String,
    /// Where the tool centre is, m.
    pub tool_m: [f64; 3],
    /// Stiffness of the end along x, y and z, N/µm; `null` where nothing gives way, and where it depends on a spring that has no value yet.
    #[serde(rename = "stiffness_N_per_um")]
    pub stiffness_n_per_um: [Option<f64>; 3],
    /// The compliances behind it, m/N; none that depends on a spring without a value.
    #[serde(skip)]
    pub compliance_m_per_n: [Option<f64>; 3],
    /// Whether these are stiffnesses that robots have; `null` where none is known.
    pub plausible: Option<bool>,
}

/// Tries every mechanism of a robot in every named pose (the nominal one if there is none); `source` gives the lines.
///
/// # Errors
/// [`RobotError`] if a mechanism cannot be solved.
pub fn check_robot(robot: &Robot, source: &SourceText) -> Result<RobotCheck, RobotError> {
    let added = robot.rigid_links.iter().filter(|link| link.is_added);
    let mut check = RobotCheck {
        name: robot.name.clone(),
        findings: robot.warnings.clone(),
        added_rigid_links: added.map(|link| link.name.clone()).collect(),
        rigid_springs: rigid_springs(robot),
        floor_m: robot.floor_m,
        base_radius_m: robot.base_radius_m,
        load_case_columns: load_case_columns(robot),
        ..RobotCheck::default()
    };
    let poses = robot.poses_or_nominal();
    for (name, pose) in &poses {
        check.look_at_pose(robot, source, name, pose);
    }
    let springs = robot.own_springs();
    let free = springs.filter(|(_, spring)| spring.in_fit != RoleInFit::Fixed);
    check.free_springs = free.map(|(parameter, _)| parameter.to_string()).collect();
    let (_, factors) = robot.default_factors();
    let mut nodes = Vec::new();
    for mechanism in robot.mechanisms.values() {
        let mut predictor = Predictor::new(robot, mechanism, &factors)?;
        let unknown = UnknownSprings::new(robot, mechanism, &factors, &[]);
        check.unknown_springs.extend(unknown.words());
        let assembled = predictor.model().structure().nodes.iter();
        nodes.extend(assembled.map(|node| node.name.to_string()));
        for (name, pose) in &poses {
            match predictor.place(pose) {
                Ok(()) => check.try_pose(robot, &unknown, (name, pose), &mut predictor)?,
                Err(error @ RobotError::Unreachable { .. }) => {
                    let line = line_of(source, name);
                    check
                        .findings
                        .push(format!("{line}mechanism {}: {error}", mechanism.name));
                }
                Err(error) => return Err(error),
            }
        }
    }
    let supports = robot.supports.iter().map(|&held| &robot.nodes[held].name);
    let supports = supports.map(ToString::to_string);
    let (held, loose): (Vec<_>, Vec<_>) = supports.partition(|name| nodes.contains(name));
    check.held = held;
    if !loose.is_empty() {
        let loose = loose.join(", ");
        let words = format!("{loose}: held to the ground, but no link leads there");
        check.findings.push(words);
    }
    check.judge_size(source);
    Ok(check)
}

/// The springs of joints that are rigid, of a robot that has other springs or no beams.
fn rigid_springs(robot: &Robot) -> Vec<String> {
    if robot.own_springs().next().is_none() && !robot.members.is_empty() {
        return Vec::new();
    }
    let joints = robot.joints.iter();
    let rigid = joints.filter(|joint| joint.springs.own == SpringDefault::default());
    rigid
        .map(|joint| ModelParameter::of_joint(&joint.name, joint.motion).to_string())
        .collect()
}

/// The columns of a table of load cases; of joints those that move the tool.
fn load_case_columns(robot: &Robot) -> Vec<String> {
    let variables = (0..robot.variables.len()).filter(|&variable| robot.moves_tool(variable));
    let joints = variables.map(|variable| {
        let variable = &robot.variables[variable];
        format!("joint_{}_{}", variable.name, variable.motion.usual_unit())
    });
    let vectors = [VectorQuantity::Force, VectorQuantity::Displacement];
    let vectors = vectors
        .into_iter()
        .flat_map(|quantity| Direction::ALL.map(|axis| quantity.column(axis)));
    std::iter::once("pose".to_owned())
        .chain(joints)
        .chain(vectors)
        .collect()
}

/// The place of a pose in the file.
fn line_of(source: &SourceText, pose: &str) -> String {
    let span = source.toml_key_span(&[Key("poses"), Key(pose)]);
    if span.is_empty() {
        return String::new();
    }
    format!("{}:{}: ", source.name, source.line_and_column(span.start).0)
}

impl RobotCheck {
    /// Limits and loops of a pose.
    fn look_at_pose(&mut self, robot: &Robot, source: &SourceText, name: &str, pose: &Pose) {
        for violation in robot.violated_limits(pose) {
            self.findings.push(format!(
                "pose {name} lies {} degrees beyond the limit {}",
                significant(violation.excess_deg, 3),
                violation.limit
            ));
        }
        for point in robot.crossed_loops(pose).unwrap_or_default() {
            let tables =
                ["points", "nodes"].map(|table| source.toml_key_span(&[Key(table), Key(&point)]));
            let span = tables
                .into_iter()
                .find(|span| !span.is_empty())
                .unwrap_or(0..0);
            let (line, _) = source.line_and_column(span.start);
            self.findings.push(format!(
                "{}:{line}: in pose {name} the parallelogram that closes in `{point}` is crossed: is the other side of its circles meant?",
                source.name
            ));
        }
    }

    fn try_pose(
        &mut self,
        robot: &Robot,
        unknown: &UnknownSprings<'_>,
        (name, pose): (&str, &Pose),
        predictor: &mut Predictor<'_>,
    ) -> Result<(), RobotError> {
        let tool_m = robot.tool_pose(pose)?.position_m;
        let reach_m = norm(tool_m);
        self.reach_m = Some(self.reach_m.map_or(reach_m, |largest| largest.max(reach_m)));
        let mass_kg = predictor.model().mass_kg();
        if mass_kg > 0.0 {
            self.mass_kg = Some(self.mass_kg.map_or(mass_kg, |largest| largest.max(mass_kg)));
        }
        let compliance = unknown.known(predictor.compliance().0, pose)?;
        let compliance = [0, 1, 2].map(|axis| compliance[axis][axis]);
        let stiffness = compliance.map(|own| {
            let own = own.filter(|own| *own > RIGID_M_PER_N);
            own.map(|own| 1e-6 / own)
        });
        let [low, high] = PLAUSIBLE_N_PER_UM;
        self.checked.push(CheckedPose {
            mechanism: predictor.model().mechanism().name.clone(),
            pose: name.to_owned(),
            tool_m,
            stiffness_n_per_um: stiffness,
            compliance_m_per_n: compliance,
            plausible: {
                let mut known = stiffness.iter().flatten().peekable();
                let any = known.peek().is_some();
                any.then(|| known.all(|k| (low..=high).contains(k)))
            },
        });
        Ok(())
    }

    /// Size and stiffness as a whole.
    fn judge_size(&mut self, source: &SourceText) {
        let [short, long] = PLAUSIBLE_REACH_M;
        if let Some(reach) = self.reach_m.filter(|reach| !(short..=long).contains(reach)) {
            let guess = if reach > long {
                "are lengths in mm taken for m?"
            } else {
                "are lengths in m taken for mm?"
            };
            self.findings.push(format!(
                "{}: the tool is {reach:.3} m from the origin, robots reach {short} to {long} m: {guess} (a key says its unit: at_mm, at_m)",
                source.name
            ));
        }
        let odd: Vec<&str> = self
            .checked
            .iter()
            .filter(|checked| checked.plausible == Some(false))
            .map(|checked| checked.pose.as_str())
            .collect();
        if let Some(first) = odd.first() {
            let [low, high] = PLAUSIBLE_N_PER_UM;
            self.findings.push(format!(
                "{}: the stiffness of pose {first} lies outside of {low} to {high} N/µm, where those of robots are: check the units of \
                 springs and sections",
                source.name
            ));
        }
    }
}
