//! The minimum of ½‖r(p)‖² within bounds, and why the search ended where it did.

use std::fmt;

use super::error::LeastSquaresError;
use super::parameter::{Bound, ParameterSet};
use super::residual_function::{EvaluationFailure, ResidualFunction};
use super::search::LeastSquaresSearch;

/// When a fit has converged, and when it gives up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastSquaresSettings {
    /// Evaluations of the problem after which the fit stops where it is.
    pub max_evaluations: usize,
    /// Converged when the next step is predicted to reduce ‖r‖² by no more than this share of it.
    ///
    /// A remaining share of ε is a remaining step of √(ε dof) standard errors.
    pub reduction_tolerance: f64,
    /// Converged when the next step is predicted to reduce ‖r‖² by no more than this, in its own unit.
    ///
    /// For models whose values carry an error of their own (a finite-element solution keeps about ten digits): below that error a
    /// reduction can be promised but not seen.
    pub negligible_reduction: f64,
    /// Converged when the next step changes no parameter by more than this share of its value.
    pub step_tolerance: f64,
    /// Converged when the cosine between the residuals and each column of the Jacobian is at most this.
    pub gradient_tolerance: f64,
}

impl Default for LeastSquaresSettings {
    /// As exact as `f64` allows: 1e-20 of ‖r‖² is a step of 1e-10 standard errors, which the certified digits of the NIST problems
    /// need. 2000 evaluations let the slowest of these problems arrive (1139 from the far start of Bennett5).
    fn default() -> Self {
        Self {
            max_evaluations: 2000,
            reduction_tolerance: 1e-20,
            negligible_reduction: 0.0,
            step_tolerance: 1e-13,
            gradient_tolerance: 4.0 * f64::EPSILON,
        }
    }
}

impl LeastSquaresSettings {
    /// For refits by the thousand (bootstrap, profiles, candidates): 1e-10 of ‖r‖² is a step of 1e-5 standard errors, far
    /// below the spread that such refits are made to measure.
    #[must_use]
    pub fn for_refits() -> Self {
        Self {
            max_evaluations: 200,
            reduction_tolerance: 1e-10,
            step_tolerance: 1e-9,
            ..Self::default()
        }
    }
}

/// Which test reported that the minimum is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Convergence {
    /// The residuals are zero, or orthogonal to every column of the Jacobian that may still move.
    Gradient,
    /// The next step would change no parameter noticeably.
    Step,
    /// The next step would not reduce the objective noticeably.
    Reduction,
    /// The next step is so short that the objective's rounding hides its effect.
    Rounding,
}

/// Why a fit ended; the state it ended with is in the fit.
#[derive(Debug)]
pub enum Termination {
    /// At a minimum.
    Converged(Convergence),
    /// The number of evaluations ran out first.
    AtLimit {
        /// The number allowed.
        max_evaluations: usize,
    },
    /// No step of any length reduced the objective, though the derivatives predict that one would: they are wrong, or the start is
    /// where the problem cannot be followed in 16 digits.
    Stalled,
    /// Every step, however short, led to where the model has no value.
    EvaluationFailed(EvaluationFailure),
}

impl Termination {
    /// Whether the fit ended at a minimum.
    #[must_use]
    pub fn is_converged(&self) -> bool {
        matches!(self, Self::Converged(_))
    }
}

impl fmt::Display for Termination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converged(_) => f.write_str("converged"),
            Self::AtLimit { max_evaluations } => {
                write!(f, "stopped after {max_evaluations} evaluations")
            }
            Self::Stalled => f.write_str("stopped: no step reduced the sum of squares"),
            Self::EvaluationFailed(failure) => write!(f, "stopped: {failure}"),
        }
    }
}

/// A fit as it stood when it ended.
#[derive(Debug)]
pub struct LeastSquaresFit {
    /// Values of all parameters, tied and fixed ones included.
    pub values: Vec<f64>,
    /// Values of the free parameters.
    pub free_values: Vec<f64>,
    /// On which bound each free parameter ended, if on one.
    pub at_bound: Vec<Option<Bound>>,
    /// Residuals at the end.
    pub residuals: Vec<f64>,
    /// Half the sum of the squared residuals.
    pub objective: f64,
    /// Why the fit ended.
    pub termination: Termination,
    /// Points at which the problem was evaluated.
    pub evaluations: usize,
    /// Of these, points at which it had no value.
    pub failed_evaluations: usize,
    /// Steps that were taken.
    pub iterations: usize,
    pub(super) jacobian: Vec<f64>,
}

impl LeastSquaresFit {
    /// Sum of the squared residuals.
    #[must_use]
    pub fn sum_of_squares(&self) -> f64 {
        2.0 * self.objective
    }

    /// Derivatives of the residuals to free parameter number `free` (place in the free vector), ties included.
    #[must_use]
    pub fn jacobian_column(&self, free: usize) -> Option<&[f64]> {
        let rows = self.residuals.len();
        self.jacobian.get(free * rows..(free + 1) * rows)
    }
}

/// Minimises half the sum of the squared residuals over the free parameters, within their bounds.
///
/// Each point is evaluated with its Jacobian at once: nearly every step is accepted, and the derivatives of the models here cost little
/// beside the values.
///
/// # Returns
/// The fit as it stood at its end. A fit that did not converge is a result, not an error: see its `termination`.
///
/// # Errors
/// `NoResiduals`, or `StartHasNoValue` if the problem cannot be evaluated at the start.
///
/// # Source
/// Moré, The Levenberg-Marquardt algorithm: implementation and theory, Lecture Notes in Mathematics 630 (1978): scaling, radius and
/// acceptance. The bounds and the last steps, where the objective has no digits left and the gradient decides, are ours.
pub fn minimise(
    problem: &mut dyn ResidualFunction,
    set: &ParameterSet,
    settings: &LeastSquaresSettings,
) -> Result<LeastSquaresFit, LeastSquaresError> {
    let mut search = LeastSquaresSearch::start(problem, set, settings)?;
    let termination = search.run();
    Ok(search.finish(termination))
}

#[cfg(test)]
mod tests;
