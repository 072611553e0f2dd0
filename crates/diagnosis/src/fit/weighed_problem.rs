//! What every fit does with its rows: parameters on one side, rows that can be left out on the other.

use stiffbench_numeric::least_squares::{
    LeastSquaresSettings, ParameterSet, ResidualFunction, minimise,
};

use super::error::FitError;
use super::parameters::FitParameters;
use crate::mismatch::folds_of;

/// Weighed residuals of rows in the coordinates of parameters.
pub(crate) trait WeighedProblem: ResidualFunction {
    /// The parameters, whose coordinates come first.
    fn parameters(&self) -> &FitParameters;

    /// When a fit has converged.
    fn settings(&self) -> LeastSquaresSettings;

    /// Whether every row is linear in the coordinates.
    fn is_linear(&self) -> bool {
        false
    }

    /// From now on these rows weigh nothing, and all others what they weighed at first.
    fn leave_out(&mut self, is_left_out: &dyn Fn(usize) -> bool);

    /// Predictions of all rows at a point of the coordinates.
    ///
    /// # Errors
    /// [`FitError`].
    fn predict(&mut self, point: &[f64]) -> Result<Vec<f64>, FitError>;
}

/// Leaves each pose out in turn with all its rows, of many poses some together, and predicts it by a fit to the others within the bounds of the
/// parameters.
///
/// # Arguments
/// - `set`: where each fit starts. What the other poses do not determine stays there.
/// - `poses`: the place of the pose of each row among all poses.
///
/// # Returns
/// A prediction for each row; `None` with fewer than two poses, or too few rows without its pose.
///
/// # Errors
/// [`FitError`].
pub(crate) fn leave_poses_out(
    problem: &mut impl WeighedProblem,
    set: &ParameterSet,
    poses: &[usize],
) -> Result<Vec<Option<f64>>, FitError> {
    let mut unseen = vec![None; poses.len()];
    let count = poses.iter().map(|pose| pose + 1).max().unwrap_or(0);
    if count < 2 {
        return Ok(unseen);
    }
    let settings = problem.settings();
    let folds = folds_of(count);
    for fold in 0..folds {
        let is_left_out = |row: usize| poses[row] % folds == fold;
        let kept = (0..poses.len()).filter(|row| !is_left_out(*row)).count();
        if kept < set.free_indices().len() {
            continue;
        }
        problem.leave_out(&is_left_out);
        let refitted = minimise(problem, set, &settings)?;
        let predicted = problem.predict(&refitted.values)?;
        for (row, predicted) in predicted.into_iter().enumerate() {
            if is_left_out(row) {
                unseen[row] = Some(predicted);
            }
        }
    }
    problem.leave_out(&|_| false);
    Ok(unseen)
}
