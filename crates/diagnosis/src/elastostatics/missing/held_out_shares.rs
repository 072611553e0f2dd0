//! How well linear models serve in poses that were left out of their fit.

use nalgebra::{DMatrix, DVector};

use crate::search::{LinearModel, WhiteSpace, dot};

use super::findings::LoadCaseSearch;
use crate::elastostatics::posed::PosedLoadCases;

/// Residuals of every row from a fit without the rows of its pose, in the units of the rows; `None` where a pose alone determines a column.
///
/// With H the hat matrix of the white columns and b the rows of a pose, the residuals without them are (1 - H_bb)⁻¹ r_b (Cook & Weisberg,
/// Residuals and Influence in Regression, 1982, section 3.5).
///
/// # Arguments
/// - `space`: its columns are those of the model.
pub(super) fn left_out_residuals(
    posed: &PosedLoadCases,
    space: &WhiteSpace,
    rows: &[f64],
) -> Option<Vec<f64>> {
    if posed.labels.len() < 2 {
        return None;
    }
    let white = space.projected(rows);
    let labels: Vec<usize> = posed.rows().map(|(case, _)| case.label).collect();
    let mut out = vec![0.0; rows.len()];
    for label in 0..posed.labels.len() {
        let own: Vec<usize> = (0..rows.len())
            .filter(|row| labels[*row] == label)
            .collect();
        let matrix = DMatrix::from_fn(own.len(), own.len(), |i, j| {
            let hat: f64 = space
                .basis()
                .iter()
                .map(|unit| unit[own[i]] * unit[own[j]])
                .sum();
            f64::from(u8::from(i == j)) - hat
        });
        let left = DVector::from_iterator(own.len(), own.iter().map(|row| white[*row]));
        let solved = matrix.cholesky()?.solve(&left);
        for (place, &row) in own.iter().enumerate() {
            out[row] = solved[place] / space.covariance.weights()[row];
        }
    }
    Some(out)
}

/// Root mean square of the displacements among residuals, m.
pub(super) fn displacement_rms(posed: &PosedLoadCases, residuals: &[f64]) -> f64 {
    let rows = posed.rows().zip(residuals);
    let own: Vec<f64> = rows
        .filter(|((_, read), _)| !read.is_rotation())
        .map(|(_, residual)| residual * residual)
        .collect();
    (own.iter().sum::<f64>() / own.len().max(1) as f64).sqrt()
}

/// Shares of the misfit that a model explains.
pub(super) struct ExplainedShares {
    pub(super) of_misfit: Option<f64>,
    pub(super) unseen: Option<f64>,
    pub(super) before_unseen_m: Option<f64>,
    pub(super) after_unseen_m: Option<f64>,
}

/// What the findings explain of the misfit of the baseline. What noise alone would leave is what the springs of the robot leave together.
pub(super) fn explained_shares(
    search: &LoadCaseSearch<'_, '_>,
    start: &LinearModel,
    found: &LinearModel,
) -> ExplainedShares {
    let posed = search.model.posed;
    let springs = search.candidates.iter().enumerate();
    let springs = springs.filter(|(_, one)| one.kind.is_spring());
    let mut all: Vec<usize> = found.terms.clone();
    all.extend(
        springs
            .map(|(place, _)| place)
            .filter(|place| !found.terms.contains(place)),
    );
    let Ok(richest) = search.problem.with_terms(&all) else {
        return ExplainedShares {
            of_misfit: None,
            unseen: None,
            before_unseen_m: None,
            after_unseen_m: None,
        };
    };
    // One covariance for all: that of the richest model.
    let squares = |model: &LinearModel| {
        let space = search.space_under(model, &richest);
        let white = space.projected(search.residuals);
        let dof = (search.residuals.len() - space.basis().len()) as f64;
        (dot(&white, &white), dof)
    };
    let share = |baseline: f64, found: f64, noise: f64, sd: f64| {
        let visible = baseline - noise;
        (visible > 3.0 * sd).then(|| ((baseline - found) / visible).clamp(0.0, 1.0))
    };
    let ((before, dof), (after, dof_after)) = (squares(start), squares(found));
    let of_misfit = share(
        (before - dof).max(0.0),
        (after - dof_after).max(0.0),
        0.0,
        (2.0 * dof).sqrt(),
    );
    let unseen = |model: &LinearModel| {
        let space = search.space_under(model, &richest);
        left_out_residuals(posed, &space, search.residuals)
    };
    let (before, after) = (unseen(start), unseen(found));
    let sum = |residuals: Option<&Vec<f64>>| {
        let rows = residuals?.iter().zip(richest.covariance.weights());
        Some(
            rows.map(|(residual, weight)| (residual * weight).powi(2))
                .sum::<f64>(),
        )
    };
    let rows = search.residuals.len() as f64;
    let unseen_share = sum(before.as_ref())
        .zip(sum(after.as_ref()))
        .and_then(|(before, after)| {
            // Noise alone, and what the parameters of the baseline add to it in poses that they do not know.
            let noise = rows + search.columns.len() as f64;
            share(before, after, noise, (2.0 * rows).sqrt())
        });
    ExplainedShares {
        of_misfit,
        unseen: unseen_share,
        before_unseen_m: before.map(|residuals| displacement_rms(posed, &residuals)),
        after_unseen_m: after.map(|residuals| displacement_rms(posed, &residuals)),
    }
}
