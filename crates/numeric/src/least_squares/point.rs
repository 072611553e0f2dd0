//! The problem evaluated at one point: residuals, derivatives to the free parameters, gradient.

use super::parameter::ParameterSet;
use super::residual_function::{EvaluationFailure, JacobianView, ResidualFunction};
use super::singular_values::dot;
use super::trust_region::Linearisation;

/// Everything known at one point.
pub(super) struct EvaluatedPoint {
    pub(super) free: Vec<f64>,
    pub(super) full: Vec<f64>,
    pub(super) residuals: Vec<f64>,
    pub(super) jacobian: Vec<f64>,
    pub(super) gradient: Vec<f64>,
    pub(super) squared_norm: f64,
}

impl EvaluatedPoint {
    pub(super) fn new(set: &ParameterSet, rows: usize) -> Self {
        let columns = set.slots().iter().flatten().count();
        let free = set.free_start();
        Self {
            full: vec![0.0; set.parameters().len()],
            residuals: vec![0.0; rows],
            jacobian: vec![0.0; rows * columns],
            gradient: vec![0.0; free.len()],
            squared_norm: 0.0,
            free,
        }
    }

    /// Fills everything from `free`.
    pub(super) fn evaluate(
        &mut self,
        problem: &mut dyn ResidualFunction,
        set: &ParameterSet,
    ) -> Result<(), EvaluationFailure> {
        let rows = self.residuals.len();
        set.fill(&self.free, &mut self.full);
        self.jacobian.fill(0.0);
        let mut view = JacobianView::new(&mut self.jacobian, rows, set.slots());
        problem.evaluate(&self.full, &mut self.residuals, Some(&mut view))?;
        self.check_finite(problem, set)?;
        for (tied, free, ratio) in set.tied_columns() {
            let (left, right) = self.jacobian.split_at_mut(tied * rows);
            for (own, from) in left[free * rows..].iter_mut().zip(&right[..rows]) {
                *own += ratio * from;
            }
        }
        for (g, column) in self
            .gradient
            .iter_mut()
            .zip(self.jacobian.chunks_exact(rows))
        {
            *g = dot(column, &self.residuals);
        }
        self.squared_norm = dot(&self.residuals, &self.residuals);
        if self.squared_norm.is_finite() && self.gradient.iter().all(|g| g.is_finite()) {
            Ok(())
        } else {
            Err(EvaluationFailure::Overflow)
        }
    }

    fn check_finite(
        &self,
        problem: &dyn ResidualFunction,
        set: &ParameterSet,
    ) -> Result<(), EvaluationFailure> {
        if let Some(residual) = self.residuals.iter().position(|r| !r.is_finite()) {
            return Err(EvaluationFailure::ResidualNotFinite {
                residual,
                label: problem.label(residual),
                value: self.residuals[residual],
            });
        }
        let Some(place) = self.jacobian.iter().position(|d| !d.is_finite()) else {
            return Ok(());
        };
        let (slot, residual) = (place / self.residuals.len(), place % self.residuals.len());
        let parameter = set.slots().iter().position(|&s| s == Some(slot));
        Err(EvaluationFailure::DerivativeNotFinite {
            residual,
            label: problem.label(residual),
            parameter: parameter
                .map(|index| set.parameters()[index].name.clone())
                .unwrap_or_default(),
            value: self.jacobian[place],
        })
    }
}

/// The problem linearised at a point.
pub(super) fn linear_model<'a>(
    point: &'a EvaluatedPoint,
    bounds: &'a [(f64, f64)],
    held: &'a [bool],
    scale: &'a [f64],
) -> Linearisation<'a> {
    Linearisation {
        residuals: &point.residuals,
        squared_norm: point.squared_norm,
        jacobian: &point.jacobian,
        gradient: &point.gradient,
        point: &point.free,
        bounds,
        held,
        scale,
    }
}

/// Marks the parameters that lie on a bound and would leave by it if they followed the negative gradient.
pub(super) fn hold(point: &EvaluatedPoint, bounds: &[(f64, f64)], held: &mut [bool]) {
    for (j, held) in held.iter_mut().enumerate() {
        let (lower, upper) = bounds[j];
        let (x, g) = (point.free[j], point.gradient[j]);
        *held = (x == lower && g >= 0.0) || (x == upper && g <= 0.0);
    }
}
