//! How well linear models serve in poses that were left out of their fit.

use stiffbench_numeric::statistics::root_mean_square;

use crate::search::constants::MOST_EFFECTS;
use crate::search::{LinearModel, NotIndependent, dot};

use super::find::Basis;
use super::findings::LoadCaseSearch;
use crate::elastostatics::error::LoadCaseFitError;
use crate::elastostatics::held_out::{LinearRows, leave_poses_out};
use crate::elastostatics::posed::PosedLoadCases;

/// What is left of every row by a fit without its pose, in the units of the rows; `None` where the other poses have too few rows.
///
/// Without terms that is what the fit itself states; with terms the same refits are made with the columns of the terms beside.
///
/// # Errors
/// [`LoadCaseFitError`].
fn unseen_residuals(
    search: &LoadCaseSearch<'_, '_>,
    terms: &[usize],
) -> Result<Option<Vec<f64>>, LoadCaseFitError> {
    let basis = search.basis;
    if terms.is_empty() {
        let components = basis.baseline.components.iter();
        return Ok(components
            .map(|one| Some(one.measured - one.without_its_pose?))
            .collect());
    }
    let terms = terms.iter().map(|&term| {
        let candidate = &search.candidates[term];
        (candidate.column.as_slice(), candidate.bounds)
    });
    let columns: Vec<(&[f64], [f64; 2])> = basis.changes().into_iter().chain(terms).collect();
    let scatter = basis.baseline.scatter.clone();
    let (mut problem, set) = LinearRows::new(&basis.residuals, &columns, scatter)?;
    let unseen = leave_poses_out(search.model.posed, &mut problem, &set)?;
    let rows = basis.residuals.iter().zip(unseen);
    Ok(rows
        .map(|(row, predicted)| Some(row - predicted?))
        .collect())
}

impl Basis {
    /// The columns of the free parameters, each with the smallest and largest change of its value that the bounds allow.
    pub(super) fn changes(&self) -> Vec<(&[f64], [f64; 2])> {
        let free = self.free.iter().zip(&self.columns);
        free.map(|(&place, column)| {
            let one = &self.baseline.estimates[place];
            let bounds = one.bounds.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            let change = |end: f64| {
                if one.parameter.is_factor() {
                    (end / one.value).ln()
                } else {
                    end - one.value
                }
            };
            (column.as_slice(), bounds.map(change))
        })
        .collect()
    }
}

/// Those of the selected candidates that lower the error in poses left out, at most three: the one that lowers it most, then the next.
///
/// # Errors
/// [`LoadCaseFitError`].
pub(super) fn helpful_terms(
    search: &LoadCaseSearch<'_, '_>,
    selected: &[usize],
) -> Result<Vec<usize>, LoadCaseFitError> {
    let error = |terms: &[usize]| -> Result<Option<f64>, LoadCaseFitError> {
        let rows = unseen_residuals(search, terms)?;
        Ok(rows.map(|rows| search.basis.baseline.scatter.squares(&rows)))
    };
    let mut kept = Vec::new();
    let Some(mut least) = error(&kept)? else {
        return Ok(kept);
    };
    while kept.len() < MOST_EFFECTS {
        let mut best: Option<(f64, usize)> = None;
        for &term in selected.iter().filter(|term| !kept.contains(*term)) {
            let with = [&kept[..], &[term]].concat();
            if let Some(error) = error(&with)?
                && best.is_none_or(|(lowest, _)| error < lowest)
            {
                best = Some((error, term));
            }
        }
        let Some((error, term)) = best.filter(|(error, _)| *error < least) else {
            break;
        };
        least = error;
        kept.push(term);
    }
    Ok(kept)
}

/// Root mean square of the displacements among residuals, m.
pub(super) fn displacement_rms(posed: &PosedLoadCases, residuals: &[f64]) -> f64 {
    let rows = posed.rows().zip(residuals);
    let own = rows.filter(|((_, read), _)| !read.is_rotation());
    root_mean_square(own.map(|(_, residual)| *residual)).unwrap_or_default()
}

/// Shares of the misfit that a model explains.
pub(super) struct ExplainedShares {
    pub(super) of_misfit: Option<f64>,
    pub(super) unseen: Option<f64>,
    pub(super) before_unseen_m: Option<f64>,
    pub(super) after_unseen_m: Option<f64>,
}

/// What the findings explain of the misfit of the baseline. What noise alone would leave is what the springs of the robot leave together;
/// without repeats nothing says what it is, and only the share in poses left out is given, of all that is left in them.
pub(super) fn explained_shares(
    search: &LoadCaseSearch<'_, '_>,
    start: &LinearModel,
    found: &LinearModel,
) -> Result<ExplainedShares, LoadCaseFitError> {
    let posed = search.model.posed;
    let springs = search.candidates.iter().enumerate();
    let springs = springs.filter(|(_, one)| one.kind.is_spring());
    let mut all: Vec<usize> = found.terms.clone();
    all.extend(
        springs
            .map(|(place, _)| place)
            .filter(|place| !found.terms.contains(place)),
    );
    // Springs that the findings contain leave the covariance as it is.
    let richest = search.problem.with_terms(&all);
    let richest = richest.unwrap_or_else(|NotIndependent| found.clone());
    // One covariance for all: that of the richest model.
    let squares = |model: &LinearModel| {
        let space = search.space_under(model, &richest);
        let white = space.projected(&search.basis.residuals);
        let dof = (search.basis.residuals.len() - space.basis().len()) as f64;
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
    )
    .filter(|_| search.from_repeats);
    let before = unseen_residuals(search, &[])?;
    let after = unseen_residuals(search, &found.terms)?;
    let sum = |residuals: Option<&Vec<f64>>| {
        let mut white = residuals?.clone();
        richest.covariance.whiten(&mut white);
        Some(dot(&white, &white))
    };
    let rows = search.basis.residuals.len() as f64;
    let unseen_share = sum(before.as_ref())
        .zip(sum(after.as_ref()))
        .and_then(|(before, after)| {
            // Noise alone, and what the parameters of the baseline add to it in poses that they do not know; a scatter from the fit is no
            // measure of noise, and all that is left counts.
            if !search.from_repeats {
                return share(before, after, 0.0, 0.0);
            }
            let noise = rows + search.basis.columns.len() as f64;
            share(before, after, noise, (2.0 * rows).sqrt())
        });
    Ok(ExplainedShares {
        of_misfit,
        unseen: unseen_share,
        before_unseen_m: before.map(|residuals| displacement_rms(posed, &residuals)),
        after_unseen_m: after.map(|residuals| displacement_rms(posed, &residuals)),
    })
}
