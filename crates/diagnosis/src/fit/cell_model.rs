//! Stiffness of many cells of the experiment as a function of the fitting factors, with exact derivatives.

use stiffbench_beams::robot::{
    FittingFactors, Mechanism, ModelParameter, MultiPosePredictor, Robot, RobotError,
};
use stiffbench_numeric::vector::dot6;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::read_axis::ReadAxis;
use stiffbench_units_and_text::test_point::Cell;

use super::error::FitError;
use super::fixed_physics::FixedPhysics;
use super::measured::MeasuredCompliance;
use super::physics_model::PhysicsModel;
use super::problem::poses_of_cells;
use super::shares::Shares;

/// Predicts the stiffness of cells (pose and direction) of one mechanism.
///
/// The structure stays placed in all poses, so that a change of factors costs the solution of all of them at once, not a move.
#[derive(Debug)]
pub struct CellModel<'a> {
    cells: Vec<Cell>,
    means: CellSolution<'a>,
}

/// How the stiffness is computed.
#[derive(Debug)]
enum CellSolution<'a> {
    /// Beams alone, all poses at once.
    Beams {
        /// Number of the pose of each cell.
        pose_of_cell: Vec<usize>,
        /// Number of the pose, axis of the displacement and load of the compliances behind the cells.
        across: Vec<(usize, ReadAxis, LoadDirection)>,
        predictor: Box<MultiPosePredictor<'a>>,
    },
    /// From predicted readings, with the physics beside the beams.
    Readings(Box<PhysicsModel<'a>>),
}

impl<'a> CellModel<'a> {
    /// Places the mechanism in the poses of `cells`, whose names must be the robot's; shares are those of `parameters`.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`] for a pose, [`RobotError::Unreachable`], [`RobotError::Structure`].
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        parameters: &[ModelParameter],
        cells: &[Cell],
    ) -> Result<Self, RobotError> {
        Self::with_across(robot, mechanism, parameters, cells, &[])
    }

    /// The same with compliances along other axes than that of the load, behind the cells.
    ///
    /// # Errors
    /// Those of [`CellModel::new`].
    pub(super) fn with_across(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        parameters: &[ModelParameter],
        cells: &[Cell],
        across: &[MeasuredCompliance],
    ) -> Result<Self, RobotError> {
        let all = cells.iter().chain(across.iter().map(|one| &one.cell));
        let (poses, mut pose_of_cell) = poses_of_cells(robot, all)?;
        let mut predictor = MultiPosePredictor::new(robot, mechanism, parameters, poses.len())?;
        for (index, pose) in poses.iter().enumerate() {
            predictor.place(index, pose)?;
        }
        if !across.is_empty() {
            predictor.differentiate_whole();
        }
        // A structure that moves even with nominal sections is reported before any fit begins.
        predictor.solve(&FittingFactors::UNIT, false)?;
        let places = pose_of_cell.split_off(cells.len()).into_iter().zip(across);
        let places = places.map(|(pose, one)| (pose, one.cell.direction.into(), one.load.clone()));
        Ok(Self {
            cells: cells.to_vec(),
            means: CellSolution::Beams {
                pose_of_cell,
                across: places.collect(),
                predictor: Box::new(predictor),
            },
        })
    }

    /// The same with physics beside the beams: stiffness as the estimator of the data makes it of predicted readings.
    ///
    /// # Errors
    /// Those of [`CellModel::new`].
    pub fn with_physics(
        robot: &'a Robot,
        physics: &'a FixedPhysics,
        parameters: &[ModelParameter],
        cells: &[Cell],
    ) -> Result<Self, RobotError> {
        let model = PhysicsModel::new(robot, physics, parameters, cells)?;
        Ok(Self {
            cells: cells.to_vec(),
            means: CellSolution::Readings(Box::new(model)),
        })
    }

    /// The cells, in the order of every result.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Stiffness of every cell, N/m, into `values`, and if asked for the shares of the parameters. What those of the factors leave of one is the
    /// share of springs and of the physics beside the beams. Behind the cells stand compliances along other axes than that of the load, m/N,
    /// with their derivatives.
    ///
    /// # Errors
    /// [`FitError::Robot`] if the structure cannot carry a load with these factors; with physics also [`FitError::NoPrediction`] and
    /// [`FitError::NegativePrediction`].
    pub fn evaluate(
        &mut self,
        factors: &FittingFactors,
        values: &mut [f64],
        mut shares: Option<&mut [Shares]>,
    ) -> Result<(), FitError> {
        let (pose_of_cell, across, predictor) = match &mut self.means {
            CellSolution::Beams {
                pose_of_cell,
                across,
                predictor,
            } => (pose_of_cell, across, predictor),
            CellSolution::Readings(model) => {
                return model.evaluate(factors, values, shares);
            }
        };
        predictor.solve(factors, shares.is_some())?;
        for (place, (cell, &pose)) in self.cells.iter().zip(pose_of_cell.iter()).enumerate() {
            let axis = cell.direction.index();
            let compliance = predictor.direct_compliance(pose, axis);
            let compliance = compliance.expect("every pose was placed and solved");
            values[place] = 1.0 / compliance;
            if let Some(shares) = shares.as_deref_mut() {
                let gradient = predictor.gradient(pose, axis);
                let gradient = gradient.expect("every pose was placed and solved");
                let logarithmic = gradient.iter().map(|derivative| -derivative / compliance);
                shares[place].clear();
                shares[place].extend(logarithmic);
            }
        }
        for (place, (pose, read, load)) in (self.cells.len()..).zip(across.iter()) {
            let compliance = predictor.compliance(*pose);
            let compliance = compliance.expect("every pose was placed and solved");
            let along = |moved: [f64; 6]| dot6(read.unit(), moved);
            values[place] = along(compliance.times(load.wrench()));
            if let Some(shares) = shares.as_deref_mut() {
                let whole = predictor.whole_gradient(*pose).iter();
                let derivatives = whole.map(|whole| along(whole.times(load.wrench())));
                shares[place].clear();
                shares[place].extend(derivatives);
            }
        }
        Ok(())
    }

    /// Sequence number and displacement of every reading that the physics beside the beams was given, m; none for beams alone, of which
    /// the stiffness says all.
    ///
    /// # Errors
    /// [`FitError::Robot`].
    pub fn displacements_m(
        &mut self,
        factors: &FittingFactors,
    ) -> Result<Vec<(u32, f64)>, FitError> {
        match &mut self.means {
            CellSolution::Beams { .. } => Ok(Vec::new()),
            CellSolution::Readings(model) => model.displacements_m(factors),
        }
    }

    /// Stiffness of every cell, N/m.
    ///
    /// # Errors
    /// As [`CellModel::evaluate`].
    pub fn stiffness(&mut self, factors: &FittingFactors) -> Result<Vec<f64>, FitError> {
        let mut stiffness = vec![0.0; self.cells.len()];
        self.evaluate(factors, &mut stiffness, None)?;
        Ok(stiffness)
    }
}
