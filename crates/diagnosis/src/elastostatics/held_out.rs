//! How well the model serves in poses that it was not fitted to.

use stiffbench_numeric::least_squares::{LeastSquaresFit, ParameterSet, minimise};

use super::error::LoadCaseFitError;
use super::problem::{LoadCaseModel, LoadCaseProblem};

/// Leaves each pose out in turn, and predicts it by a fit to the others.
///
/// # Returns
/// A prediction for each row; `None` with fewer than two poses, or too few rows without its pose.
///
/// # Errors
/// [`LoadCaseFitError`].
pub(super) fn leave_poses_out(
    model: &LoadCaseModel<'_>,
    problem: &mut LoadCaseProblem<'_>,
    set: &ParameterSet,
    fit: &LeastSquaresFit,
) -> Result<Vec<Option<f64>>, LoadCaseFitError> {
    let posed = model.posed;
    let labels: Vec<usize> = posed.rows().map(|(case, _)| case.label).collect();
    let free = set.free_indices().len();
    let mut unseen = vec![None; labels.len()];
    if posed.labels.len() < 2 {
        return Ok(unseen);
    }
    let weights = problem.weights().to_vec();
    let from_here = set.with_start(&fit.free_values)?;
    let settings = problem.settings();
    for label in 0..posed.labels.len() {
        let left_out = |row: usize| labels[row] == label;
        if labels.iter().filter(|of| **of != label).count() < free {
            continue;
        }
        let without = weights.iter().enumerate();
        let without = without.map(|(row, weight)| if left_out(row) { 0.0 } else { *weight });
        problem.set_weights(without.collect());
        let refitted = minimise(problem, &from_here, &settings)?;
        let predicted = problem.predictions_of(&refitted.values, label)?;
        let rows = (0..labels.len()).filter(|row| left_out(*row));
        for (row, predicted) in rows.zip(predicted) {
            unseen[row] = Some(predicted);
        }
    }
    problem.set_weights(weights);
    Ok(unseen)
}
