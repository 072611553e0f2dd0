//! Residuals that tests give row by row.

use super::{EvaluationFailure, JacobianView, Parameter, ResidualFunction};

/// A residual and its gradient.
pub(super) type Row = (f64, Vec<f64>);

/// So many residuals, each a function of the parameters and of its number.
#[derive(Clone)]
pub(super) struct ResidualRows<F>(pub(super) usize, pub(super) F);

impl<F: FnMut(&[f64], usize) -> Row> ResidualFunction for ResidualRows<F> {
    fn residual_count(&self) -> usize {
        self.0
    }

    fn evaluate(
        &mut self,
        p: &[f64],
        residuals: &mut [f64],
        mut jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        for (i, residual) in residuals.iter_mut().enumerate() {
            let (value, gradient) = (self.1)(p, i);
            *residual = value;
            if let Some(jacobian) = jacobian.as_deref_mut() {
                for (j, derivative) in gradient.into_iter().enumerate() {
                    jacobian.set(i, j, derivative);
                }
            }
        }
        Ok(())
    }

    fn label(&self, residual: usize) -> String {
        format!("load step {residual}")
    }
}

/// Free parameters without bounds, from their starts.
pub(super) fn unbounded<const N: usize>(starts: [(&str, f64); N]) -> Vec<Parameter> {
    starts
        .map(|(name, start)| Parameter::unbounded(name, start))
        .to_vec()
}
