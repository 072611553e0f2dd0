//! Procedures with poses of the program's own choice: before a session those that determine the parameters best, after one those that
//! determine what is open.

use crate::count::hours_and_minutes;
use crate::fit::{BestPoses, PlannedLoadCase, PoseRules, best_poses};
use crate::load_cases::{LoadAxes, LoadCase, LoadCaseTable};
use crate::parameters::{FitRole, ParameterChoice};
use crate::procedure::{Pace, Procedure};
use crate::robot::{NamedPose, Robot};
use crate::test_point::{Direction, PoseId};

use super::error::{ArgumentError, Failure};
use super::model::ResolvedModel;
use super::procedure::{SAME_VALUE, joints_of};

/// Load steps of a planned procedure as shares of its largest load.
const STEPS: [f64; 4] = [0.0, 0.25, 0.5, 1.0];

/// Repeats of a planned procedure: their scatter shows.
const REPEATS: u32 = 3;

/// The poses of the workspace that determine the free parameters best under the loads and gauges of a procedure, on a bench with usual
/// noise; the procedure then measures these poses.
///
/// # Arguments
/// - `choice`: which parameters are free.
/// - `rules`, `count`: what is stated of the poses, and their number.
///
/// # Errors
/// Without a pose or a free parameter; if no pose keeps the rules; if no choice of poses determines all parameters.
pub fn choose_poses(
    model: &ResolvedModel,
    procedure: &mut Procedure,
    choice: &ParameterChoice,
    (rules, count): (&PoseRules, usize),
) -> Result<BestPoses, Failure> {
    let free = choice
        .members
        .iter()
        .filter(|member| member.role == FitRole::Free);
    let free: Vec<_> = free.map(|member| member.parameter.clone()).collect();
    if free.is_empty() || count == 0 {
        return ArgumentError::refuse(
            "--best-poses",
            "a number of poses from 1, and one free parameter at least, are needed",
            "--best-poses 6, with --parameter joint.NAME=free for parameters that the robot file fixes",
        );
    }
    let (start, others) = model.springs_apart();
    if let Some(effect) = others.first() {
        return ArgumentError::refuse(
            format!("--effect {}", effect.compact()),
            "plans of poses know only springs: joint-compliance, joint-tilt-compliance, tool-compliance and base-compliance",
            "leave it out",
        );
    }
    let robot = (&model.robot, model.mechanism()?);
    let best = best_poses(robot, &start, &free, procedure, (rules, count))?;
    state(&model.robot, procedure, &best.poses);
    Ok(best)
}

/// Measures these poses, stated by their joint values.
fn state(robot: &Robot, procedure: &mut Procedure, poses: &[NamedPose]) {
    procedure.poses = Some(poses.iter().map(|named| named.id.clone()).collect());
    let stated = poses
        .iter()
        .map(|named| joints_of(robot, &named.id, &named.pose));
    procedure.joint_values = stated.collect();
}

/// A procedure that measures planned load cases: every planned pose under loads along every planned direction.
///
/// # Arguments
/// - `followed`: the procedure of the session that was fitted, if it has one, whose loads, repeats and gauges this one has.
#[must_use]
pub(super) fn procedure_of(
    robot: &Robot,
    followed: Option<Procedure>,
    planned: &[PlannedLoadCase],
) -> Procedure {
    let largest_n = planned.first().map_or(0.0, |one| one.force_n);
    let mut procedure = followed.unwrap_or_else(|| {
        Procedure {
            repeats: REPEATS,
            ..Procedure::default()
        }
        .with_loads(STEPS.map(|share| rounded(share * largest_n)).to_vec())
    });
    "next".clone_into(&mut procedure.name);
    procedure.directions.clear();
    for one in planned {
        if !procedure.directions.contains(&one.direction.into()) {
            procedure.directions.push(one.direction.into());
        }
    }
    if procedure.displacement_axes.is_empty() {
        procedure.displacement_axes = Direction::ALL.to_vec();
    }
    let mut poses: Vec<NamedPose> = Vec::new();
    for one in planned {
        if poses.iter().any(|known| known.pose == one.pose) {
            continue;
        }
        let is_other = |name: &PoseId| {
            let of_robot = robot.pose(name).ok();
            let differs = of_robot.is_some_and(|known| {
                let mut pairs = known.angles_deg.iter().zip(&one.pose.angles_deg);
                pairs.any(|(a, b)| (a - b).abs() > SAME_VALUE)
            });
            differs || poses.iter().any(|known| known.id == *name)
        };
        let mut id = one.name.clone();
        let mut number = 2;
        while is_other(&id) {
            id = PoseId::new(&format!("{}-{number}", one.name));
            number += 1;
        }
        poses.push(NamedPose {
            id,
            pose: one.pose.clone(),
            stated_zy_m: None,
        });
    }
    state(robot, &mut procedure, &poses);
    let minutes = procedure.minutes(&Pace::default(), poses.len());
    procedure.text = Some(format!(
        "loads that best determine the parameters that a fit left open; about {}",
        hours_and_minutes(minutes)
    ));
    procedure
}

/// Planned load cases as a table to be filled in: each row lacks its displacements.
#[must_use]
pub(super) fn table_of(robot: &Robot, planned: &[PlannedLoadCase]) -> LoadCaseTable {
    let mut table = LoadCaseTable {
        source: "planned".to_owned(),
        ..LoadCaseTable::default()
    };
    for one in planned {
        let joints = joints_of(robot, &one.name, &one.pose).values;
        let (columns, values) = joints.into_iter().unzip();
        table.joints = columns;
        table.cases.push(LoadCase {
            line: 0,
            pose: one.name.clone(),
            joints: values,
            repeat: 1,
            axes: LoadAxes::Base,
            force_n: one.direction.unit_vector().map(|share| share * one.force_n),
            moment_nm: [0.0; 3],
            displacement_m: [None; 3],
            rotation_rad: [None; 3],
            position_m: [None; 3],
        });
    }
    table
}

/// To two digits, as a load is set.
fn rounded(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let unit = 10f64.powf(value.abs().log10().floor() - 1.0);
    (value / unit).round() * unit
}
