//! What every fit needs to know.

use stiffbench_beams::physics::Effect;
use stiffbench_beams::robot::{FittingFactors, Mechanism, ModelParameter, Pose, Robot, RobotError};
use stiffbench_units_and_text::test_point::{Cell, PoseId};

use super::cell_model::CellModel;
use super::fixed_physics::FixedPhysics;
use super::measured::MeasuredStiffness;
use crate::parameters::place_of;

/// A mechanism, the stiffness it was measured to have, and the factors to start from.
#[derive(Debug, Clone, Copy)]
pub struct FitProblem<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// The mechanism that was measured.
    pub mechanism: &'a Mechanism,
    /// Stiffness of the cells.
    pub measured: &'a MeasuredStiffness,
    /// Where the search starts; parameters that do not move keep these values.
    pub start: &'a FittingFactors,
    /// What acts beside the beams, held fixed; nothing if `None`.
    pub physics: Option<&'a FixedPhysics>,
}

/// The named poses of cells, each once, and the number of that of each cell.
///
/// # Errors
/// [`RobotError::UnknownName`] for a pose.
pub(super) fn poses_of_cells<'c>(
    robot: &Robot,
    cells: impl IntoIterator<Item = &'c Cell>,
) -> Result<(Vec<Pose>, Vec<usize>), RobotError> {
    let mut names: Vec<&PoseId> = Vec::new();
    let places = cells.into_iter();
    let places = places.map(|cell| place_of(&mut names, &&cell.pose));
    let places = places.collect();
    let poses = names.iter().map(|name| robot.pose(name).cloned());
    Ok((poses.collect::<Result<_, _>>()?, places))
}

impl<'a> FitProblem<'a> {
    /// The same with other measured stiffness.
    pub(super) fn measuring<'m>(&self, measured: &'m MeasuredStiffness) -> FitProblem<'m>
    where
        'a: 'm,
    {
        FitProblem { measured, ..*self }
    }

    /// The stiffness of cells by mechanism and physics, with the shares of `parameters`.
    ///
    /// # Errors
    /// Those of [`CellModel::new`].
    pub fn cell_model(
        &self,
        parameters: &[ModelParameter],
        cells: &[Cell],
    ) -> Result<CellModel<'a>, RobotError> {
        let acting = (self.robot, self.mechanism, self.physics);
        CellModel::with_across(acting, parameters, cells, &[])
    }

    /// What was measured, by mechanism and physics: stiffness of the cells, N/m, then the other compliances, m/N.
    ///
    /// # Errors
    /// Those of [`CellModel::new`].
    pub(super) fn measured_model(
        &self,
        parameters: &[ModelParameter],
    ) -> Result<CellModel<'a>, RobotError> {
        let MeasuredStiffness { cells, across, .. } = self.measured;
        let cells: Vec<Cell> = cells.iter().map(|one| one.cell.clone()).collect();
        let acting = (self.robot, self.mechanism, self.physics);
        CellModel::with_across(acting, parameters, &cells, across)
    }

    /// The effects that are held fixed.
    pub(super) fn effects(&self) -> Vec<Effect> {
        self.physics
            .map_or_else(Vec::new, |physics| physics.acting.effects.clone())
    }
}
