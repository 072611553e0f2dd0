//! The same fit again and again to other stiffness values: bootstrap, simulation, planning.

use stiffbench_beams::robot::FittingFactors;
use stiffbench_numeric::least_squares::{ParameterSet, Termination};

use super::error::FitError;
use super::joint::JointProblem;
use super::parameters::FitParameters;
use super::problem::FitProblem;
use super::weighed_problem::WeighedProblem;
use crate::parameters::ParameterChoice;

/// A fit whose cells, weights, start and choice of parameters stay, while the measured values change.
///
/// All that does not depend on the values is set up once: geometry, order of elimination, whitening.
#[derive(Debug)]
pub struct Refitter<'a> {
    problem: JointProblem<'a>,
    set: ParameterSet,
}

/// One of the refits.
#[derive(Debug)]
pub struct Refit {
    /// The factors it ended with.
    pub factors: FittingFactors,
    /// Half the sum of the squared residuals.
    pub objective: f64,
    /// Points at which the stiffness was computed.
    pub evaluations: usize,
    /// Why it ended.
    pub termination: Termination,
}

impl<'a> Refitter<'a> {
    /// Sets up refits of the cells of `problem` from its start.
    ///
    /// # Errors
    /// [`FitError::Robot`] for a pose or structure, [`FitError::LeastSquares`] for bounds that leave no room.
    pub fn new(problem: &FitProblem<'a>, choice: &ParameterChoice) -> Result<Self, FitError> {
        let parameters = FitParameters::new(problem, choice)?;
        Ok(Self {
            problem: JointProblem::new(problem, &parameters)?,
            set: parameters.set()?,
        })
    }

    /// The same, each refit beginning at these factors; bounds stay where the start of the problem put them.
    ///
    /// # Errors
    /// [`FitError::LeastSquares`] for factors that are no numbers.
    pub fn beginning_at(mut self, factors: &FittingFactors) -> Result<Self, FitError> {
        let coordinates = self.problem.parameters().coordinates(factors);
        let free = self.set.free_indices().iter();
        let start: Vec<f64> = free.map(|&index| coordinates[index]).collect();
        self.set = self.set.with_start(&start)?;
        Ok(self)
    }

    /// From now on each cell counts so many times.
    ///
    /// # Panics
    /// If there is not one count a cell.
    pub(super) fn count_cells(&mut self, times: &[u32]) {
        self.problem.count_cells(times);
    }

    /// Fits other values of ln K (K in N/m), in the order of the cells.
    ///
    /// # Errors
    /// [`FitError::LeastSquares`] if the stiffness cannot be computed at the start.
    ///
    /// # Panics
    /// If there is not one value a cell.
    pub fn refit(&mut self, ln_stiffness: &[f64]) -> Result<Refit, FitError> {
        self.problem.set_measured(ln_stiffness);
        let fit = self.problem.minimise(&self.set)?;
        Ok(Refit {
            factors: self.problem.factors(&fit.values),
            objective: fit.objective,
            evaluations: fit.evaluations,
            termination: fit.termination,
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;
    use crate::fit::{CellModel, MeasuredCell, MeasuredStiffness, WeightBasis};
    use crate::tests::hp_robot;
    use stiffbench_beams::robot::{ModelParameter, Robot};
    use stiffbench_units_and_text::test_point::{Cell, Direction};

    /// Every pose of a robot in every direction.
    pub(in crate::fit) fn cells_of(robot: &Robot) -> Vec<Cell> {
        let poses = robot.poses.iter().map(|named| &named.id);
        poses
            .flat_map(|pose| Direction::ALL.map(|direction| Cell::new(pose.clone(), direction)))
            .collect()
    }

    /// Stiffness of cells that all weigh the same.
    pub(in crate::fit) fn measured(
        cells: &[Cell],
        stiffness_n_per_m: impl Iterator<Item = f64>,
    ) -> MeasuredStiffness {
        let cells = cells.iter().zip(stiffness_n_per_m);
        let measured_cell = |(cell, stiffness_n_per_m): (&Cell, f64)| MeasuredCell {
            cell: cell.clone(),
            line: 0,
            stiffness_n_per_m,
            ln_uncertainty: None,
            reading_noise: None,
        };
        MeasuredStiffness {
            cells: cells.map(measured_cell).collect(),
            basis: WeightBasis::Equal,
            ..MeasuredStiffness::default()
        }
    }

    #[test]
    fn refits_without_weights_all_converge_and_scatter_about_the_truth() {
        let robot = hp_robot();
        let mechanism = robot.mechanism(Some("F")).unwrap();
        let start = robot.factor_set("m_fsd").unwrap();
        let cells = cells_of(&robot);
        let mut model =
            CellModel::new(&robot, mechanism, &ModelParameter::CLASSES, &cells).unwrap();
        let truth = model.stiffness(&start).unwrap();
        let measured = measured(&cells, truth.iter().copied());
        let problem = FitProblem {
            robot: &robot,
            mechanism,
            measured: &measured,
            start: &start,
            physics: None,
        };
        let mut refitter = Refitter::new(&problem, &ParameterChoice::default()).unwrap();
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let scatter = Normal::new(0.0, 0.02).unwrap();
        let (mut sum, count) = (0.0, 300);
        for _ in 0..count {
            let mut value = |k: &f64| k.ln() + scatter.sample(&mut random);
            let values: Vec<f64> = truth.iter().map(&mut value).collect();
            let refit = refitter.refit(&values).unwrap();
            assert!(refit.termination.is_converged(), "{refit:?}");
            assert!(refit.evaluations < 20, "{refit:?}");
            sum += 2.0 * refit.objective / (0.02 * 0.02);
        }
        // Twelve values less four factors: chi-squared with 8 degrees of freedom, mean 8, standard deviation 4 over the root of 300.
        let mean = sum / f64::from(count);
        assert!((mean - 8.0).abs() < 4.0 * 4.0 / 300.0_f64.sqrt(), "{mean}");
    }
}
