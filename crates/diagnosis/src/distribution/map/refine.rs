//! The extremes of a map, followed from the sampled pose to where the limits hold them.

use stiffbench_beams::robot::{Pose, RobotError};

use super::column::{MapColumn, row_width};
use super::model::{MapModel, SinglePoseSolver};
use super::stiffness_map::StiffnessMap;
use crate::distribution::pose_set::PoseSample;
use crate::distribution::projected_ascent::{AscentObjective, ProjectedAscent};

/// An extreme of the stiffness over the workspace itself, next to that of the sample.
#[derive(Debug, Clone, PartialEq)]
pub struct RefinedStiffness {
    /// The pose.
    pub pose: Pose,
    /// Position of the end, m.
    pub end_m: [f64; 3],
    /// Stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// The limits that hold it, in words.
    pub limits: Vec<String>,
    /// Steepest way on that the limits leave, relative to the stiffness, a degree: below 1e-7 it is the extreme.
    pub slope_per_deg: f64,
}

impl StiffnessMap {
    /// Follows the stiffness of a column from a row to the next maximum, or minimum, within the limits.
    ///
    /// The sample is to be dense enough to have found the right hill.
    ///
    /// # Errors
    /// [`RobotError`] if a pose on the way cannot be taken: there the extreme has no slope to follow.
    pub fn refined(
        &self,
        model: &MapModel<'_>,
        poses: &PoseSample,
        column: usize,
        row: usize,
        largest: bool,
    ) -> Result<RefinedStiffness, RobotError> {
        let columns = vec![self.columns[column].clone()];
        let objective = LogStiffness {
            row: vec![0.0; row_width(&columns, None)],
            columns,
            solver: SinglePoseSolver::new(model),
            sign: if largest { 1.0 } else { -1.0 },
        };
        let start = poses.pose(self.places[row] as usize);
        let free = poses.free.clone();
        let (mut objective, top) = ProjectedAscent::ascend(model.robot(), free, objective, start)?;
        objective.solve(&top.pose)?;
        Ok(RefinedStiffness {
            end_m: [objective.row[0], objective.row[1], objective.row[2]],
            stiffness_n_per_m: objective.row[3],
            pose: top.pose,
            limits: top.limits,
            slope_per_deg: top.slope_per_deg,
        })
    }
}

/// The logarithm of a stiffness, or its opposite.
struct LogStiffness<'m, 'a> {
    solver: SinglePoseSolver<'m, 'a>,
    columns: Vec<MapColumn>,
    row: Vec<f64>,
    sign: f64,
}

impl LogStiffness<'_, '_> {
    fn solve(&mut self, pose: &Pose) -> Result<(), RobotError> {
        self.solver.row(pose, &self.columns, &mut self.row)
    }
}

impl AscentObjective for LogStiffness<'_, '_> {
    /// Rounding of the stiffness, 1e-11 or so of it, then makes slopes of 1e-9; truncation is near that.
    const STEP_DEG: f64 = 3e-3;
    /// What is left to gain over a degree is then a ten-millionth.
    const FLAT_PER_DEG: f64 = 1e-7;

    fn height(&mut self, pose: &Pose) -> Result<f64, RobotError> {
        self.solve(pose)?;
        // Where nothing yields the way ends.
        Ok(self.sign * self.row[3].min(f64::MAX).ln())
    }
}
