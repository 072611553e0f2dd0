//! Procedures by the names that a user gives them.

use std::path::Path;

use crate::nearest::nearest;
use crate::procedure::Procedure;
use crate::readings::{JointColumn, JointUnit, PoseJoints};
use crate::robot::{JointMotion, NamedPose, Pose, Robot};
use crate::shipped::{shipped_procedure, shipped_procedures};
use crate::source_text::SourceText;
use crate::test_point::PoseId;

use super::error::{ArgumentError, Failure};
use super::files::read_text;
use super::model::not_there;

/// A procedure by the name of a file or of a shipped one, and what a user should know of its file.
///
/// # Errors
/// For a name that is neither a file nor a shipped procedure, or a file that is no procedure.
pub fn named_procedure(name: &str) -> Result<(Procedure, Vec<String>), Failure> {
    Ok(Procedure::parse(&procedure_source(name)?)?)
}

/// Text of a procedure file or of a shipped procedure.
fn procedure_source(name: &str) -> Result<SourceText, Failure> {
    let path = Path::new(name);
    if path.is_file() {
        return Ok(SourceText::new(name, read_text(path)?));
    }
    let found = shipped_procedure(name);
    found.ok_or_else(|| not_there("procedure", name, shipped_procedures()).into())
}

/// Checks the specimen that is to be measured against those of a procedure; a procedure that lists none takes any.
///
/// # Errors
/// For one that is not listed, with the nearest, and for none where several are listed.
pub fn check_specimen(procedure: &Procedure, specimen: Option<&str>) -> Result<(), ArgumentError> {
    let known = &procedure.specimens;
    if known.is_empty() || specimen.is_some_and(|name| known.iter().any(|one| one == name)) {
        return Ok(());
    }
    let names = known.iter().map(String::as_str);
    let meant = specimen.and_then(|name| nearest(name, names));
    let meant = meant.map_or_else(String::new, |near| format!("did you mean {near}? "));
    Err(ArgumentError::new(
        format!("--specimen-id {}", specimen.unwrap_or_default()).trim_end(),
        match specimen {
            Some(_) => format!("procedure {} does not list this specimen", procedure.name),
            None => format!("procedure {} requires one of its specimens", procedure.name),
        },
        format!("{meant}it lists {}", known.join(", ")),
    ))
}

/// Values of joints that differ by less are the same, degrees or m: what 15 digits in a file lose.
pub(super) const SAME_VALUE: f64 = 1e-9;

/// Gives a robot the poses that a procedure states by joint values; also gives what a user should know of them.
///
/// # Errors
/// For a variable that the robot does not have, a unit of the other kind, and a pose that the robot has with other values.
pub fn add_poses(robot: &mut Robot, procedure: &Procedure) -> Result<Vec<String>, ArgumentError> {
    let mut warnings = Vec::new();
    for joints in &procedure.joint_values {
        let place = format!("procedure {}: joint_values.{}", procedure.name, joints.pose);
        let refused = |problem: String, help: String| ArgumentError::new(&*place, problem, help);
        let pose = pose_of(robot, joints).map_err(|(problem, help)| refused(problem, help))?;
        for broken in robot.violated_limits(&pose) {
            warnings.push(format!(
                "{place}: outside the limit {} by {:.3}",
                broken.limit, broken.excess_deg
            ));
        }
        if let Ok(known) = robot.pose(&joints.pose) {
            let pairs = known.angles_deg.iter().zip(&pose.angles_deg);
            if pairs.into_iter().any(|(a, b)| (a - b).abs() > SAME_VALUE) {
                return Err(refused(
                    format!(
                        "{} has a pose of this name with other joint values",
                        robot.name
                    ),
                    "give the pose of the procedure another name, there and under `poses`"
                        .to_owned(),
                ));
            }
            continue;
        }
        add_pose(robot, &joints.pose, pose);
    }
    Ok(warnings)
}

/// Gives a robot the poses that the procedure of a session states and the robot file does not have.
pub(super) fn add_missing_poses(robot: &mut Robot, poses: &[PoseJoints]) {
    for joints in poses {
        if robot.pose(&joints.pose).is_err()
            && let Ok(pose) = pose_of(robot, joints)
        {
            add_pose(robot, &joints.pose, pose);
        }
    }
}

/// States the joint values of all poses of a procedure, so that its readings are complete without the robot file.
///
/// # Errors
/// For a pose that the robot does not have.
pub fn state_joint_values(robot: &Robot, procedure: &mut Procedure) -> Result<(), Failure> {
    let poses = procedure.poses.iter().flatten();
    let stated = poses.map(|id| {
        let pose = robot.pose(id)?;
        Ok(joints_of(robot, id, pose))
    });
    procedure.joint_values = stated.collect::<Result<_, Failure>>()?;
    Ok(())
}

/// A pose by the values of its joints.
#[must_use]
pub fn joints_of(robot: &Robot, id: &PoseId, pose: &Pose) -> PoseJoints {
    let values = robot.variables.iter().zip(&pose.angles_deg);
    let values = values.map(|(variable, value)| {
        let (unit, value) = match variable.motion {
            JointMotion::Turns => (JointUnit::Angle, value.to_radians()),
            JointMotion::Slides => (JointUnit::Length, *value),
        };
        let column = JointColumn {
            variable: variable.name.clone(),
            unit,
        };
        (column, value)
    });
    PoseJoints {
        pose: id.clone(),
        values: values.collect(),
    }
}

pub(super) fn add_pose(robot: &mut Robot, id: &PoseId, pose: Pose) {
    robot.poses.push(NamedPose {
        id: id.clone(),
        pose,
        stated_zy_m: None,
    });
}

/// Gives a robot a pose, in the place of one of the same name.
pub(super) fn put_pose(robot: &mut Robot, id: &PoseId, pose: Pose) {
    match robot.poses.iter_mut().find(|known| known.id == *id) {
        Some(known) if known.pose.angles_deg != pose.angles_deg => known.pose = pose,
        Some(_) => {}
        None => add_pose(robot, id, pose),
    }
}

/// The pose of joint values, variables without one at their nominal value; else what is wrong and a remedy.
fn pose_of(robot: &Robot, joints: &PoseJoints) -> Result<Pose, (String, String)> {
    let mut pose = robot.nominal_pose();
    for (column, value) in &joints.values {
        let names = || {
            robot
                .variables
                .iter()
                .map(|variable| variable.name.as_str())
        };
        let Some(place) = names().position(|name| name == column.variable) else {
            let known = names().collect::<Vec<_>>().join(", ");
            let meant = nearest(&column.variable, names());
            return Err((
                format!("{} has no variable {}", robot.name, column.variable),
                meant.map_or_else(
                    || format!("its variables are {known}"),
                    |near| format!("is {near} meant? its variables are {known}"),
                ),
            ));
        };
        let turns = robot.variables[place].motion == JointMotion::Turns;
        if turns != (column.unit == JointUnit::Angle) {
            let (is, unit) = if turns {
                ("an angle", "_deg or _rad")
            } else {
                ("a length", "_mm or _m")
            };
            return Err((
                format!("{} is {is}", column.variable),
                format!("write {}{unit}", column.variable),
            ));
        }
        pose.angles_deg[place] = if turns { value.to_degrees() } else { *value };
    }
    Ok(pose)
}
