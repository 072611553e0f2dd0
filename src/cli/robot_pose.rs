//! The drawings of `robot check`: figures of every pose, and a sketch in the terminal.

use std::io::IsTerminal;
use std::path::PathBuf;

use crate::analysis::Inputs;
use crate::plot::{RobotDrawing, robot_pose};
use crate::report::{pose_drawing, with_equal_views};
use crate::robot::{FittingFactors, JointModel, MechanismModel, Robot, Theory};

use super::args::Global;
use super::failure::Failure;
use super::figure_files::{file_part, write_figures};
use super::robot_args::RobotCheckArgs;
use super::screen::Glyphs;
use super::sketch::sketch;

/// Width of a terminal that does not state it, characters.
const USUAL_WIDTH: usize = 80;

/// The poses that the complete robot can take, drawn as the arguments ask for it.
pub(super) struct PoseDrawings {
    /// The sketch; empty where none is wanted.
    pub(super) sketch: String,
    /// The files that were written.
    pub(super) written: Vec<PathBuf>,
}

/// Draws every named pose that can be taken (the nominal one if none has a name); the others are findings of the check.
pub(super) fn draw(
    robot: &Robot,
    inputs: &Inputs,
    args: &RobotCheckArgs,
    global: &Global,
) -> Result<PoseDrawings, Failure> {
    let sketched = !args.no_sketch && !global.json && std::io::stdout().is_terminal();
    let mut drawn = PoseDrawings {
        sketch: String::new(),
        written: Vec::new(),
    };
    if !sketched && args.out.is_none() {
        return Ok(drawn);
    }
    let (names, drawings) = drawings(robot)?;
    if let Some(folder) = &args.out {
        let mechanism = &robot.mechanism(None)?.name;
        let inputs = inputs.clone().with_mechanism(mechanism);
        let figures = names.iter().zip(&drawings).map(|(name, drawing)| {
            let name = format!("pose-{}", file_part(name));
            (name, robot_pose(drawing))
        });
        drawn.written = write_figures(folder, figures.collect(), &inputs)?;
    }
    if sketched {
        let named: Vec<(String, RobotDrawing)> = names.into_iter().zip(drawings).collect();
        let width = crossterm::terminal::size().map_or(USUAL_WIDTH, |(width, _)| width.into());
        let unicode = Glyphs::of_locale(|name| std::env::var(name).ok()).is_unicode();
        drawn.sketch = sketch(&named, width, unicode);
    }
    Ok(drawn)
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
