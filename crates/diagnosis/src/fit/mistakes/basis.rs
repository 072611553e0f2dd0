//! A fit with the poses solved at its values: what a mistake of the table is compared with.

use stiffbench_beams::robot::ModelParameter;

use crate::fit::load_cases::prediction::{PredictedMotions, rows_along};
use crate::fit::load_cases::problem::{LoadCaseModel, unit_length, unloaded_springs};
use crate::fit::load_cases::scatter::{RowScatter, sizes};
use crate::fit::{FactorStatus, FitError, FitOutcome};
use crate::search::constants::LEAST_INDEPENDENT;
use crate::search::{dot, push_orthonormal};

/// What the candidates are tried beside.
pub(super) struct Basis {
    pub(super) baseline: FitOutcome,
    pub(super) residuals: Vec<f64>,
    /// Places of the free parameters among the estimates.
    pub(super) free: Vec<usize>,
    /// One column for each of them.
    pub(super) columns: Vec<Vec<f64>>,
    /// The scatter of each kind of rows without a part that grows with the load: a mistake of the table must not pass for it.
    pub(super) plain_scatter: RowScatter,
}

impl Basis {
    /// That of a fit, with the poses solved at its values.
    ///
    /// # Errors
    /// [`FitError`] for a structure that carries nothing.
    pub(super) fn of(model: &LoadCaseModel<'_>, fit: &FitOutcome) -> Result<Self, FitError> {
        Self::with_residuals(model, fit, fit.residuals())
    }

    /// That of the same values in other poses.
    ///
    /// # Errors
    /// As [`Basis::of`].
    pub(super) fn in_poses_of(
        model: &LoadCaseModel<'_>,
        fit: &FitOutcome,
    ) -> Result<Self, FitError> {
        let start = &fit.factors;
        let predicted = LoadCaseModel { start, ..*model }.predicted()?;
        let rows = model.measured().into_iter().zip(predicted);
        let residuals = rows.map(|(read, predicted)| read - predicted);
        Self::with_residuals(model, fit, residuals.collect())
    }

    fn with_residuals(
        model: &LoadCaseModel<'_>,
        fit: &FitOutcome,
        residuals: Vec<f64>,
    ) -> Result<Self, FitError> {
        let estimates = fit.estimates.iter().enumerate();
        let moving = estimates.filter(|(_, one)| moves(&one.status));
        let (places, parameters): (Vec<usize>, Vec<ModelParameter>) = moving
            .map(|(place, one)| (place, one.parameter.clone()))
            .unzip();
        let (posed, start) = (model.posed, &fit.factors);
        let mechanics = LoadCaseModel { start, ..*model }.mechanics(&parameters)?;
        let motions = PredictedMotions::of(&mechanics, posed, true);
        let all = motions.columns.iter();
        let all: Vec<Vec<f64>> = all.map(|column| rows_along(posed, column)).collect();
        let lengths: Vec<f64> = all.iter().map(|one| dot(one, one).sqrt()).collect();
        let unloaded = unloaded_springs(&parameters, &lengths, unit_length(posed));
        let (mut free, mut columns) = (Vec::new(), Vec::new());
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let loaded = all.into_iter().zip(places).zip(unloaded);
        for ((column, place), _) in loaded.filter(|(_, is_unloaded)| !is_unloaded) {
            // What the ones before contain is left out.
            let before = basis.len();
            push_orthonormal(&mut basis, column.clone(), LEAST_INDEPENDENT, 0.0);
            if basis.len() > before {
                free.push(place);
                columns.push(column);
            }
        }
        let agreement = fit.agreement.as_ref();
        let known = agreement.map_or([None; 2], |agreement| agreement.component_sd);
        let usual = sizes(posed);
        let sd = [0, 1].map(|kind| known[kind].unwrap_or(usual[kind]));
        let plain_scatter =
            RowScatter::plain(posed, model.steps, sd).without(|row| fit.components[row].held_out);
        Ok(Self {
            plain_scatter,
            residuals,
            baseline: fit.clone(),
            free,
            columns,
        })
    }

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

/// Whether a parameter is a column of the baseline: also one at a bound, which what is missing may have driven there.
pub(super) fn moves(status: &FactorStatus) -> bool {
    matches!(
        status,
        FactorStatus::Free | FactorStatus::NotIdentified { .. } | FactorStatus::AtBound { .. }
    )
}
