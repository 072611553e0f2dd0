//! Stiffness of many cells of the experiment as a function of the fitting factors, with exact derivatives.

use stiffbench_beams::robot::{
    FittingFactors, Mechanism, ModelParameter, MultiPosePredictor, Robot, RobotError,
};
use stiffbench_units_and_text::test_point::{Cell, PoseId};

use super::error::FitError;
use super::fixed_physics::FixedPhysics;
use super::physics_model::PhysicsModel;
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
        let mut names: Vec<&PoseId> = Vec::new();
        let mut pose_of_cell = Vec::with_capacity(cells.len());
        for cell in cells {
            let known = names.iter().position(|name| **name == cell.pose);
            pose_of_cell.push(known.unwrap_or_else(|| {
                names.push(&cell.pose);
                names.len() - 1
            }));
        }
        let mut predictor = MultiPosePredictor::new(robot, mechanism, parameters, names.len())?;
        for (index, name) in names.into_iter().enumerate() {
            predictor.place(index, robot.pose(name)?)?;
        }
        // A structure that moves even with nominal sections is reported before any fit begins.
        predictor.solve(&FittingFactors::UNIT, false)?;
        Ok(Self {
            cells: cells.to_vec(),
            means: CellSolution::Beams {
                pose_of_cell,
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

    /// Stiffness of every cell, N/m, into `stiffness_n_per_m`, and if asked for the shares of the parameters. What those of the factors leave
    /// of one is the share of springs and of the physics beside the beams.
    ///
    /// # Errors
    /// [`FitError::Robot`] if the structure cannot carry a load with these factors; with physics also [`FitError::NoPrediction`] and
    /// [`FitError::NegativePrediction`].
    pub fn evaluate(
        &mut self,
        factors: &FittingFactors,
        stiffness_n_per_m: &mut [f64],
        mut shares: Option<&mut [Shares]>,
    ) -> Result<(), FitError> {
        let (pose_of_cell, predictor) = match &mut self.means {
            CellSolution::Beams {
                pose_of_cell,
                predictor,
            } => (pose_of_cell, predictor),
            CellSolution::Readings(model) => {
                return model.evaluate(factors, stiffness_n_per_m, shares);
            }
        };
        predictor.solve(factors, shares.is_some())?;
        for (place, (cell, &pose)) in self.cells.iter().zip(pose_of_cell.iter()).enumerate() {
            let axis = cell.direction.index();
            let compliance = predictor.direct_compliance(pose, axis);
            let compliance = compliance.expect("every pose was placed and solved");
            stiffness_n_per_m[place] = 1.0 / compliance;
            if let Some(shares) = shares.as_deref_mut() {
                let gradient = predictor.gradient(pose, axis);
                let gradient = gradient.expect("every pose was placed and solved");
                let logarithmic = gradient.iter().map(|derivative| -derivative / compliance);
                shares[place].clear();
                shares[place].extend(logarithmic);
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
