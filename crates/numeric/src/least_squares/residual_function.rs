//! The problem a fit minimises, and how its failures are named.

use std::error::Error;

use thiserror::Error as ThisError;

/// Residuals as a function of the parameters, weights included.
///
/// A residual is measured minus predicted (or the reverse), divided by its standard deviation if that is known. Implementations may
/// keep scratch memory, hence `&mut self`; the result must depend on the parameters only.
pub trait ResidualFunction {
    /// Number of residuals; constant during a fit.
    fn residual_count(&self) -> usize;

    /// Residuals, and if asked for their derivatives, at `parameters` (the full vector, in the order of the `ParameterSet`).
    ///
    /// # Arguments
    /// - `residuals`: to be filled, one for each residual.
    /// - `jacobian`: derivatives of the residuals; its columns arrive filled with zeros. Columns of parameters that
    ///   cannot move are not there, so their derivatives need not be computed.
    ///
    /// # Errors
    /// `EvaluationFailure::Model` if there is no value here. Numbers that are not finite need not be searched for: the caller does.
    fn evaluate(
        &mut self,
        parameters: &[f64],
        residuals: &mut [f64],
        jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure>;

    /// What residual number `residual` is, for messages: "pose P3, y, -40 N, repeat 2".
    fn label(&self, residual: usize) -> String {
        format!("residual {residual}")
    }
}

/// Derivatives of the residuals: one column for each parameter that can move, one row for each residual.
#[derive(Debug)]
pub struct JacobianView<'a> {
    data: &'a mut [f64],
    rows: usize,
    slots: &'a [Option<usize>],
}

impl<'a> JacobianView<'a> {
    /// `data` holds the columns one after the other; `slots` states which of them belongs to a parameter.
    pub(super) fn new(data: &'a mut [f64], rows: usize, slots: &'a [Option<usize>]) -> Self {
        Self { data, rows, slots }
    }

    /// Derivatives of all residuals to parameter number `parameter` of the full vector; `None` if it cannot move.
    pub fn column_mut(&mut self, parameter: usize) -> Option<&mut [f64]> {
        let slot = (*self.slots.get(parameter)?)?;
        self.data.get_mut(slot * self.rows..(slot + 1) * self.rows)
    }

    /// Whether parameter number `parameter` can move, so that its derivatives are wanted.
    #[must_use]
    pub fn wants(&self, parameter: usize) -> bool {
        self.slots.get(parameter).is_some_and(Option::is_some)
    }

    /// Sets one derivative; of a parameter that cannot move it is ignored.
    pub fn set(&mut self, residual: usize, parameter: usize, derivative: f64) {
        if let Some(entry) = self
            .column_mut(parameter)
            .and_then(|column| column.get_mut(residual))
        {
            *entry = derivative;
        }
    }
}

/// Why a problem has no value at some parameters.
#[derive(Debug, ThisError)]
pub enum EvaluationFailure {
    /// A residual is NaN or infinite.
    #[error("the model returned {value} at {label}")]
    ResidualNotFinite {
        /// Which residual, from 0.
        residual: usize,
        /// The problem's own name for it.
        label: String,
        /// What it was.
        value: f64,
    },
    /// A derivative is NaN or infinite.
    #[error("the derivative to `{parameter}` is {value} at {label}")]
    DerivativeNotFinite {
        /// Which residual, from 0.
        residual: usize,
        /// The problem's own name for it.
        label: String,
        /// Derivative to which parameter.
        parameter: String,
        /// What it was.
        value: f64,
    },
    /// Each residual is finite, but their squares or their products with the derivatives are not.
    #[error("the sum of squares overflows")]
    Overflow,
    /// The model itself states that it has no value.
    #[error("the model has no value")]
    Model {
        /// The model's own error.
        #[source]
        source: Box<dyn Error + Send + Sync>,
    },
}

impl EvaluationFailure {
    /// A failure of the model as a whole.
    #[must_use]
    pub fn of_model(source: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::Model {
            source: source.into(),
        }
    }
}

/// Where an analytic derivative and central differences differ most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DerivativeCheck {
    /// Residual of the largest difference.
    pub residual: usize,
    /// Parameter of the largest difference.
    pub parameter: usize,
    /// The derivative the problem gives there.
    pub analytic: f64,
    /// The derivative from differences.
    pub numeric: f64,
    /// Their difference over the largest derivative to that parameter.
    pub relative_difference: f64,
}

/// Compares the derivatives of a problem with central differences at `parameters`.
///
/// The difference quotient uses two steps h and h/2 and Richardson's extrapolation, with h = 1e-3 of the parameter (or
/// `scale` of it if the parameter is zero), which leaves about ten digits of a smooth model.
///
/// # Errors
/// The failure of the problem at one of the points.
pub fn check_derivatives(
    problem: &mut dyn ResidualFunction,
    parameters: &[f64],
    scale: f64,
) -> Result<Option<DerivativeCheck>, EvaluationFailure> {
    let rows = problem.residual_count();
    let slots: Vec<Option<usize>> = (0..parameters.len()).map(Some).collect();
    let mut data = vec![0.0; rows * parameters.len()];
    let mut residuals = vec![0.0; rows];
    let mut view = JacobianView::new(&mut data, rows, &slots);
    problem.evaluate(parameters, &mut residuals, Some(&mut view))?;

    let mut worst: Option<DerivativeCheck> = None;
    let mut shifted = parameters.to_vec();
    let mut low = vec![0.0; rows];
    let mut quotient = |problem: &mut dyn ResidualFunction, index: usize, step: f64| {
        let mut high = vec![0.0; rows];
        shifted[index] = parameters[index] + step;
        problem.evaluate(&shifted, &mut high, None)?;
        shifted[index] = parameters[index] - step;
        problem.evaluate(&shifted, &mut low, None)?;
        shifted[index] = parameters[index];
        for (h, l) in high.iter_mut().zip(&low) {
            *h = (*h - l) / (2.0 * step);
        }
        Ok::<_, EvaluationFailure>(high)
    };
    for parameter in 0..parameters.len() {
        let size = if parameters[parameter] == 0.0 {
            scale
        } else {
            parameters[parameter].abs()
        };
        let coarse = quotient(problem, parameter, 1e-3 * size)?;
        let fine = quotient(problem, parameter, 5e-4 * size)?;
        let column = &data[parameter * rows..(parameter + 1) * rows];
        let largest = column
            .iter()
            .fold(0.0_f64, |largest, d| largest.max(d.abs()));
        for residual in 0..rows {
            let numeric = (4.0 * fine[residual] - coarse[residual]) / 3.0;
            let difference = (numeric - column[residual]).abs();
            let relative_difference = if difference == 0.0 {
                0.0
            } else {
                difference / largest
            };
            if worst.is_none_or(|w| {
                relative_difference.is_nan() || relative_difference > w.relative_difference
            }) {
                worst = Some(DerivativeCheck {
                    residual,
                    parameter,
                    analytic: column[residual],
                    numeric,
                    relative_difference,
                });
            }
        }
    }
    Ok(worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals exp(p0 i) − p1, with a factor on the derivative to p1 that should be 1.
    struct Exponential {
        factor: f64,
    }

    impl ResidualFunction for Exponential {
        fn residual_count(&self) -> usize {
            4
        }

        fn evaluate(
            &mut self,
            p: &[f64],
            residuals: &mut [f64],
            mut jacobian: Option<&mut JacobianView<'_>>,
        ) -> Result<(), EvaluationFailure> {
            if p[0] > 1.0 {
                return Err(EvaluationFailure::of_model("too steep"));
            }
            for (i, residual) in residuals.iter_mut().enumerate() {
                let x = i as f64;
                *residual = (p[0] * x).exp() - p[1];
                if let Some(jacobian) = jacobian.as_deref_mut() {
                    jacobian.set(i, 0, x * (p[0] * x).exp());
                    jacobian.set(i, 1, if i == 2 { -self.factor } else { -1.0 });
                }
            }
            Ok(())
        }
    }

    #[test]
    fn a_wrong_derivative_is_found_with_its_place_and_a_right_one_passes() {
        let check = |factor, p: &[f64]| check_derivatives(&mut Exponential { factor }, p, 1.0);
        let right = check(1.0, &[0.3, 0.0]).unwrap().unwrap();
        assert!(right.relative_difference < 1e-10, "{right:?}");
        let wrong = check(1.01, &[0.3, 0.0]).unwrap().unwrap();
        assert_eq!((wrong.residual, wrong.parameter), (2, 1));
        assert!((wrong.relative_difference - 0.01 / 1.01).abs() < 1e-9);
        assert!(check(1.0, &[2.0, 0.0]).is_err());
        assert_eq!(
            check(f64::NAN, &[0.3, 1.0])
                .unwrap()
                .map(|worst| worst.residual),
            Some(2)
        );
    }

    #[test]
    fn columns_of_parameters_that_cannot_move_are_not_there() {
        let mut data = [0.0; 4];
        let slots = [Some(1), None, Some(0)];
        let mut view = JacobianView::new(&mut data, 2, &slots);
        assert!(view.wants(0) && !view.wants(1) && !view.wants(3));
        assert_eq!(view.column_mut(1), None);
        view.set(1, 0, 5.0);
        view.set(1, 1, 6.0);
        view.set(7, 0, 7.0);
        view.column_mut(2).unwrap()[0] = 8.0;
        assert_eq!(data, [8.0, 0.0, 0.0, 5.0]);
    }
}
