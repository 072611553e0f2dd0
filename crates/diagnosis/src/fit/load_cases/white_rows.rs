//! Rows of load cases that are made white, and those that are linear in their coordinates.

use stiffbench_numeric::least_squares::{
    EvaluationFailure, JacobianView, LeastSquaresError, Parameter, ParameterSet, ResidualFunction,
};

use super::scatter::RowScatter;

/// White residuals of predictions, and the white columns of their derivatives where they are asked for.
pub(in crate::fit) fn fill_white(
    scatter: &RowScatter,
    (predicted, measured): (&[f64], &[f64]),
    residuals: &mut [f64],
    jacobian: Option<&mut JacobianView<'_>>,
    columns: &[Vec<f64>],
) {
    let rows = predicted.iter().zip(measured);
    for (residual, (predicted, measured)) in residuals.iter_mut().zip(rows) {
        *residual = predicted - measured;
    }
    scatter.whiten(residuals);
    let Some(jacobian) = jacobian else { return };
    for (place, derivatives) in columns.iter().enumerate() {
        if let Some(column) = jacobian.column_mut(place) {
            column.copy_from_slice(derivatives);
            scatter.whiten(column);
        }
    }
}

/// Rows that are linear in their coordinates: each the change of a value in units in which its weighed column has length one.
#[derive(Debug)]
pub(in crate::fit) struct LinearRows<'a> {
    rows: &'a [f64],
    columns: Vec<Vec<f64>>,
    scatter: RowScatter,
}

impl<'a> LinearRows<'a> {
    /// The problem, and the set of its coordinates, which start at zero.
    ///
    /// # Arguments
    /// - `columns`: change of every row per unit of a value, with the smallest and largest change of the value.
    ///
    /// # Errors
    /// [`LeastSquaresError`] without columns.
    pub(in crate::fit) fn new(
        rows: &'a [f64],
        columns: &[(Vec<f64>, [f64; 2])],
        scatter: RowScatter,
    ) -> Result<(Self, ParameterSet), LeastSquaresError> {
        let (mut scaled, mut parameters) = (Vec::new(), Vec::new());
        for (place, (column, [lowest, highest])) in columns.iter().enumerate() {
            // What the rows with weight do not show stays where it is.
            let length = scatter.length(column);
            let unit = length.map_or(0.0, f64::recip);
            let length = length.unwrap_or(1.0);
            scaled.push(column.iter().map(|value| value * unit).collect());
            let [lowest, highest] = [lowest.min(0.0), highest.max(0.0)].map(|end| end * length);
            parameters.push(Parameter::free(place.to_string(), 0.0, lowest, highest));
        }
        let problem = Self {
            rows,
            columns: scaled,
            scatter,
        };
        Ok((problem, ParameterSet::new(parameters)?))
    }

    /// All rows at a point.
    pub(in crate::fit) fn at(&self, point: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.rows.len()];
        for (column, coordinate) in self.columns.iter().zip(point) {
            for (sum, value) in sum.iter_mut().zip(column) {
                *sum += coordinate * value;
            }
        }
        sum
    }
}

impl ResidualFunction for LinearRows<'_> {
    fn residual_count(&self) -> usize {
        self.rows.len()
    }

    fn evaluate(
        &mut self,
        parameters: &[f64],
        residuals: &mut [f64],
        jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        let rows = (&self.at(parameters)[..], self.rows);
        fill_white(&self.scatter, rows, residuals, jacobian, &self.columns);
        Ok(())
    }
}
