//! The same fit again and again to other stiffness values: bootstrap, simulation, planning.

use crate::least_squares::{ParameterSet, Termination};
use crate::robot::FittingFactors;

use super::choice::FactorChoice;
use super::error::FitError;
use super::joint::JointProblem;
use super::problem::FitProblem;

/// A fit whose cells, weights, start and choice of factors stay, while the measured values change.
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
    /// Points at which the stiffness was worked out.
    pub evaluations: usize,
    /// Why it ended.
    pub termination: Termination,
}

impl<'a> Refitter<'a> {
    /// Sets up refits of the cells of `problem` from its start.
    ///
    /// # Errors
    /// [`FitError::Robot`] for a pose or structure, [`FitError::LeastSquares`] for bounds that leave no room.
    pub fn new(problem: &FitProblem<'a>, choice: &FactorChoice) -> Result<Self, FitError> {
        Ok(Self {
            problem: JointProblem::new(problem)?,
            set: choice.parameters()?,
        })
    }

    /// Fits other values of ln K (K in N/m), in the order of the cells.
    ///
    /// # Errors
    /// [`FitError::LeastSquares`] if the stiffness cannot be worked out at the start.
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
