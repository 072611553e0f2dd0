//! What a fit leaves of its rows, and what the fit without some of them leaves of these: deleted residuals.

use nalgebra::{DMatrix, DVector};

use stiffbench_beams::robot::ModelParameter;

use crate::fit::load_cases::frames::frame_columns;
use crate::fit::load_cases::posed::PosedLoadCases;
use crate::fit::load_cases::prediction::{PredictedMotions, SeenRows};
use crate::fit::load_cases::problem::{LoadCaseModel, unit_length, unloaded_springs};
use crate::fit::load_cases::scatter::sizes;
use crate::fit::{FactorStatus, FitError, FitOutcome};
use crate::search::constants::LEAST_INDEPENDENT;
use crate::search::{RowVector, dot, norm, push_orthonormal};

/// Rows, all of one scatter, and what a fit may make of them.
pub(super) struct FittedRows {
    /// What the fit leaves of them.
    pub(super) residuals: Vec<f64>,
    /// Orthonormal columns of the fit.
    columns: Vec<RowVector>,
}

/// Some rows beside the fit to all others.
pub(super) struct DeletedRows {
    /// Variances of what that fit leaves of them, over that of a row.
    pub(super) variances: Vec<f64>,
    /// Squares that they add to those of the fit.
    pub(super) squares: f64,
}

impl FittedRows {
    pub(super) fn new(residuals: Vec<f64>, columns: impl IntoIterator<Item = Vec<f64>>) -> Self {
        let mut units = Vec::new();
        for column in columns {
            push_orthonormal(&mut units, column, LEAST_INDEPENDENT, 0.0);
        }
        let columns = units.into_iter().map(RowVector::from).collect();
        Self { residuals, columns }
    }

    /// Groups of values one after the other, the mean of each free.
    pub(super) fn about_means(groups: impl IntoIterator<Item = Vec<f64>>) -> Self {
        let (mut residuals, mut columns) = (Vec::new(), Vec::new());
        for mut own in groups {
            columns.push(RowVector {
                first: residuals.len(),
                values: vec![(own.len() as f64).sqrt().recip(); own.len()],
            });
            let mean = own.iter().sum::<f64>() / own.len() as f64;
            for value in &mut own {
                *value -= mean;
            }
            residuals.extend(own);
        }
        Self { residuals, columns }
    }

    pub(super) fn squares(&self) -> f64 {
        dot(&self.residuals, &self.residuals)
    }

    /// Degrees of freedom without some rows; `None` if there are none.
    pub(super) fn dof_without(&self, rows: usize) -> Option<f64> {
        let dof = self
            .residuals
            .len()
            .checked_sub(self.columns.len() + rows)?;
        (dof > 0).then_some(dof as f64)
    }

    /// Entries of the hat matrix in a row.
    pub(super) fn hat(&self, row: usize) -> impl Fn(usize) -> f64 {
        let columns = self.columns.iter();
        let own = columns.filter_map(move |column| Some((column.at(row)?, column)));
        let own: Vec<(f64, &RowVector)> = own.collect();
        move |other| {
            let columns = own.iter();
            let products = columns.filter_map(|(value, column)| Some(value * column.at(other)?));
            products.sum()
        }
    }

    /// Some rows beside the fit to all others (Cook & Weisberg, Residuals and Influence in Regression, 1982, section 3.2).
    ///
    /// # Arguments
    /// - `largest_share`: rows that determine more than this share of their own prediction have no witness, which is `None`.
    pub(super) fn without(&self, rows: &[usize], largest_share: f64) -> Option<DeletedRows> {
        let hats: Vec<_> = rows.iter().map(|row| self.hat(*row)).collect();
        let free = DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
            f64::from(u8::from(i == j)) - hats[i](rows[j])
        });
        if free.clone().symmetric_eigenvalues().min() < 1.0 - largest_share {
            return None;
        }
        let inverse = free.try_inverse()?;
        let own = DVector::from_fn(rows.len(), |i, _| self.residuals[rows[i]]);
        Some(DeletedRows {
            squares: own.dot(&(&inverse * &own)),
            variances: inverse.diagonal().iter().copied().collect(),
        })
    }
}

/// Derivatives of all rows to what a fit moves, without springs that no load acts on and what the ones before contain, then to the frames; with
/// the places of the parameters among the estimates.
///
/// # Arguments
/// - `moves`: which parameters count.
///
/// # Errors
/// [`FitError`] for a structure that carries nothing.
pub(super) fn moved_columns(
    model: &LoadCaseModel<'_>,
    fit: &FitOutcome,
    moves: impl Fn(&FactorStatus) -> bool,
) -> Result<(Vec<usize>, Vec<Vec<f64>>), FitError> {
    let estimates = fit.estimates.iter().enumerate();
    let moving = estimates.filter(|(_, one)| moves(&one.status));
    let moving = moving.map(|(place, one)| (place, one.parameter.clone()));
    let (places, parameters): (Vec<usize>, Vec<ModelParameter>) = moving.unzip();
    let (posed, start) = (model.posed, &fit.factors);
    let mechanics = LoadCaseModel { start, ..*model }.mechanics(&parameters)?;
    let motions = PredictedMotions::of(&mechanics, posed, true);
    // Frames that fit the rigid robot nearly best are near enough to those of the fit: rotations between them are small.
    let tracker = model.tracker()?;
    let seen = SeenRows::of(posed, tracker.as_ref());
    let all = motions.columns.iter();
    let all: Vec<Vec<f64>> = all.map(|column| seen.changed(column)).collect();
    let lengths: Vec<f64> = all.iter().map(|one| norm(one)).collect();
    let unloaded = unloaded_springs(&parameters, &lengths, unit_length(posed));
    let (mut free, mut columns, mut units) = (Vec::new(), Vec::new(), Vec::new());
    let loaded = all.into_iter().zip(places).zip(unloaded);
    for ((column, place), _) in loaded.filter(|(_, is_unloaded)| !is_unloaded) {
        push_orthonormal(&mut units, column.clone(), LEAST_INDEPENDENT, 0.0);
        if units.len() > columns.len() {
            free.push(place);
            columns.push(column);
        }
    }
    if let Some(tracker) = &tracker {
        columns.extend(frame_columns(posed, tracker, &[], &motions.values));
    }
    Ok((free, columns))
}

/// Whether a fit moves a parameter: also one at a bound, which what is missing may have driven there.
pub(super) fn moves(status: &FactorStatus) -> bool {
    is_inside(status) || matches!(status, FactorStatus::AtBound { .. })
}

/// Whether a fit moves a parameter that is at no bound.
pub(super) fn is_inside(status: &FactorStatus) -> bool {
    matches!(
        status,
        FactorStatus::Free | FactorStatus::NotIdentified { .. }
    )
}

/// Scatter of displacements, m, and of rotations, rad, by a fit, without a part that grows with the load; else their usual size.
pub(super) fn plain_sd(posed: &PosedLoadCases, fit: &FitOutcome) -> [f64; 2] {
    let (usual, agreement) = (sizes(posed), fit.agreement.as_ref());
    let known = agreement.map_or([None; 2], |agreement| agreement.component_sd);
    [0, 1].map(|kind| known[kind].unwrap_or(usual[kind]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight line through some values less two of them, by the formulas of the line.
    #[test]
    fn deleted_rows_add_what_the_line_through_the_others_leaves() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        let y = [0.3, 1.1, 5.0, 2.8, 1.0, 5.2];
        let deleted = [2, 4];
        let others = [0, 1, 3, 5].map(|row: usize| (x[row], y[row]));
        let line = |points: &[(f64, f64)]| {
            let n = points.len() as f64;
            let [mx, my] = [0, 1].map(|i| {
                let values = points.iter().map(|(x, y)| [*x, *y][i]);
                values.sum::<f64>() / n
            });
            let slope = points.iter().map(|(x, y)| (x - mx) * (y - my));
            let square = points.iter().map(|(x, _)| (x - mx).powi(2));
            let slope = slope.sum::<f64>() / square.sum::<f64>();
            move |x: f64| my + slope * (x - mx)
        };
        let squares = |points: &[(f64, f64)]| {
            let at = line(points);
            points
                .iter()
                .map(|(x, y)| (y - at(*x)).powi(2))
                .sum::<f64>()
        };
        let all: Vec<(f64, f64)> = x.into_iter().zip(y).collect();
        let whole = line(&all);
        let residuals = all.iter().map(|(x, y)| y - whole(*x)).collect();
        let fitted = FittedRows::new(residuals, [vec![1.0; 6], x.to_vec()]);
        let found = fitted.without(&deleted, 1.0).unwrap();
        assert!((squares(&all) - squares(&others) - found.squares).abs() < 1e-12);
        assert_eq!(fitted.dof_without(2), Some(2.0));
        assert_eq!(fitted.dof_without(4), None);
        // One row shows no line.
        assert!(fitted.without(&[0, 1, 2, 3, 4], 0.9).is_none());
    }

    #[test]
    fn groups_of_repeats_have_their_means_free() {
        let fitted = FittedRows::about_means([vec![1.0, 3.0], vec![5.0, 6.0, 10.0]]);
        assert_eq!(fitted.residuals, [-1.0, 1.0, -2.0, -1.0, 3.0]);
        assert!((fitted.hat(0)(1) - 0.5).abs() < 1e-12);
        assert!((fitted.hat(4)(3) - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(fitted.hat(1)(2), 0.0);
        // From the mean of the others.
        let one = fitted.without(&[4], 1.0).unwrap();
        assert!((one.squares - 4.5 * 3.0).abs() < 1e-12 && (one.variances[0] - 1.5).abs() < 1e-12);
    }
}
