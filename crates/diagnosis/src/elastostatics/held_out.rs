//! How well a model serves in poses that it was not fitted to.

use stiffbench_numeric::least_squares::{
    EvaluationFailure, JacobianView, LeastSquaresError, LeastSquaresSettings, Parameter,
    ParameterSet, ResidualFunction, minimise,
};

use super::error::LoadCaseFitError;
use super::posed::PosedLoadCases;
use super::scatter::RowScatter;
use crate::mismatch::folds_of;

/// A problem whose rows can be given another scatter.
pub(super) trait WeighedProblem: ResidualFunction {
    /// How its rows scatter.
    fn scatter(&mut self) -> &mut RowScatter;

    /// When a fit has converged.
    fn settings(&self) -> LeastSquaresSettings;

    /// Predictions of all rows at a point of the coordinates.
    ///
    /// # Errors
    /// [`LoadCaseFitError`].
    fn predict(&mut self, point: &[f64]) -> Result<Vec<f64>, LoadCaseFitError>;
}

/// White residuals of predictions, and the white columns of their derivatives where they are asked for.
pub(super) fn fill_white(
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

/// Leaves each pose out in turn with all its repeats, of many poses some together, and predicts it by a fit to the others within the bounds of the
/// parameters.
///
/// # Arguments
/// - `set`: where each fit starts. What the other poses do not determine stays there.
///
/// # Returns
/// A prediction for each row; `None` with fewer than two poses, or too few rows without its pose.
///
/// # Errors
/// [`LoadCaseFitError`].
pub(super) fn leave_poses_out(
    posed: &PosedLoadCases,
    problem: &mut impl WeighedProblem,
    set: &ParameterSet,
) -> Result<Vec<Option<f64>>, LoadCaseFitError> {
    let labels: Vec<usize> = posed.rows().map(|(case, _)| case.label).collect();
    let free = set.free_indices().len();
    let mut unseen = vec![None; labels.len()];
    if posed.labels.len() < 2 {
        return Ok(unseen);
    }
    let scatter = problem.scatter().clone();
    let settings = problem.settings();
    let folds = folds_of(posed.labels.len());
    for fold in 0..folds {
        let left_out = |row: usize| labels[row] % folds == fold;
        if (0..labels.len()).filter(|row| !left_out(*row)).count() < free {
            continue;
        }
        *problem.scatter() = scatter.without(left_out);
        let refitted = minimise(problem, set, &settings)?;
        let predicted = problem.predict(&refitted.values)?;
        for (row, predicted) in predicted.into_iter().enumerate() {
            if left_out(row) {
                unseen[row] = Some(predicted);
            }
        }
    }
    *problem.scatter() = scatter;
    Ok(unseen)
}

/// Rows that are linear in their coordinates: each the change of a value in units in which its weighed column has length one.
#[derive(Debug)]
pub(super) struct LinearRows<'a> {
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
    pub(super) fn new(
        rows: &'a [f64],
        columns: &[(&[f64], [f64; 2])],
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

    fn at(&self, point: &[f64]) -> Vec<f64> {
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

impl WeighedProblem for LinearRows<'_> {
    fn scatter(&mut self) -> &mut RowScatter {
        &mut self.scatter
    }

    fn settings(&self) -> LeastSquaresSettings {
        LeastSquaresSettings::default()
    }

    fn predict(&mut self, point: &[f64]) -> Result<Vec<f64>, LoadCaseFitError> {
        Ok(self.at(point))
    }
}
