//! The drawings of `robot check`: figures of every pose.

use std::path::{Path, PathBuf};

use crate::analysis::Inputs;
use crate::plot::{RobotDrawing, robot_pose};
use crate::report::{pose_drawing, with_equal_views};
use crate::robot::{FittingFactors, JointModel, MechanismModel, Robot, Theory};

use super::failure::Failure;
use super::figure_files::{file_part, write_figures};

/// Draws every named pose that can be taken (the nominal one if none has a name) into a folder; the others are findings of the check.
pub(super) fn draw(robot: &Robot, inputs: &Inputs, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let (names, drawings) = drawings(robot)?;
    let mechanism = &robot.mechanism(None)?.name;
    let inputs = inputs.clone().with_mechanism(mechanism);
    let figures = names.iter().zip(&drawings).map(|(name, drawing)| {
        let name = format!("pose-{}", file_part(name));
        (name, robot_pose(drawing))
    });
    write_figures(folder, figures.collect(), &inputs)
}

/// The complete robot in each pose that it can take.
fn drawings(robot: &Robot) -> Result<(Vec<String>, Vec<RobotDrawing>), Failure> {
    let mechanism = robot.mechanism(None)?;
    let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
    let mut model = MechanismModel::new(robot, mechanism, &joints, theory, &FittingFactors::UNIT)?;
    let (mut names, mut drawings) = (Vec::new(), Vec::new());
    for (name, pose) in robot.poses_or_nominal() {
        if model.place(&pose).is_ok() {
            drawings.push(pose_drawing(&model, &name));
            names.push(name);
        }
    }
    with_equal_views(&mut drawings);
    Ok((names, drawings))
}
