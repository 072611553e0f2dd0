//! Stiffness of many cells of the experiment as a function of the fitting factors, with exact derivatives.

use stiffbench_beams::physics::Mechanics;
use stiffbench_beams::robot::{
    FittingFactors, Mechanism, ModelParameter, MultiPosePredictor, Robot, RobotError,
};
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
    across: Option<AcrossModel<'a>>,
}

/// Compliances of the beams along other axes than that of the load.
#[derive(Debug)]
struct AcrossModel<'a> {
    mechanics: Mechanics<'a>,
    parameters: usize,
    /// Number of the pose, axis of the displacement, load.
    places: Vec<(usize, ReadAxis, LoadDirection)>,
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
        let (poses, pose_of_cell) = poses_of_cells(robot, cells)?;
        let mut predictor = MultiPosePredictor::new(robot, mechanism, parameters, poses.len())?;
        for (index, pose) in poses.iter().enumerate() {
            predictor.place(index, pose)?;
        }
        // A structure that moves even with nominal sections is reported before any fit begins.
        predictor.solve(&FittingFactors::UNIT, false)?;
        Ok(Self {
            cells: cells.to_vec(),
            means: CellSolution::Beams {
                pose_of_cell,
                predictor: Box::new(predictor),
            },
            across: None,
        })
    }

    /// The same with compliances along other axes than that of the load, behind the cells.
    ///
    /// # Errors
    /// Those of [`CellModel::new`].
    pub(super) fn with_across(
        mut self,
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        parameters: &[ModelParameter],
        across: &[MeasuredCompliance],
    ) -> Result<Self, RobotError> {
        if across.is_empty() {
            return Ok(self);
        }
        let (poses, places) = poses_of_cells(robot, across.iter().map(|one| &one.cell))?;
        let places = places.into_iter().zip(across);
        let places = places.map(|(pose, one)| (pose, one.cell.direction.into(), one.load.clone()));
        let unit = FittingFactors::UNIT;
        let mut mechanics = Mechanics::rigid_with(robot, mechanism, parameters, &unit, &poses)?;
        mechanics.differentiate_whole()?;
        self.across = Some(AcrossModel {
            mechanics,
            parameters: parameters.len(),
            places: places.collect(),
        });
        Ok(self)
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
            across: None,
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
        let (pose_of_cell, predictor) = match &mut self.means {
            CellSolution::Beams {
                pose_of_cell,
                predictor,
            } => (pose_of_cell, predictor),
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
        if let Some(across) = &mut self.across {
            let first = self.cells.len();
            let shares = shares.map(|shares| &mut shares[first..]);
            across.evaluate(factors, &mut values[first..], shares)?;
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

impl AcrossModel<'_> {
    /// Compliances, m/N, and if asked for their derivatives to the parameters: to the logarithm of a factor, to the compliance of a spring.
    fn evaluate(
        &mut self,
        factors: &FittingFactors,
        values: &mut [f64],
        mut shares: Option<&mut [Shares]>,
    ) -> Result<(), RobotError> {
        self.mechanics.set_factors_rigid(factors)?;
        for (place, (pose, read, load)) in self.places.iter().enumerate() {
            let pose = self.mechanics.pose(*pose);
            values[place] = pose.compliance(read, load);
            if let Some(shares) = shares.as_deref_mut() {
                let derivatives =
                    (0..self.parameters).map(|parameter| pose.gradient(parameter, read, load));
                shares[place].clear();
                shares[place].extend(derivatives);
            }
        }
        Ok(())
    }
}
