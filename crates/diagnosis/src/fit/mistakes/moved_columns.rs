//! What a fit of load cases may make of their rows.

use stiffbench_beams::robot::ModelParameter;

use crate::fit::load_cases::frames::frame_columns;
use crate::fit::load_cases::posed::PosedLoadCases;
use crate::fit::load_cases::prediction::{PredictedMotions, SeenRows};
use crate::fit::load_cases::problem::{LoadCaseModel, unit_length, unloaded_springs};
use crate::fit::load_cases::scatter::{kinds, sizes};
use crate::fit::{FactorEstimate, FactorStatus, FitError, FitOutcome};
use crate::search::constants::LEAST_INDEPENDENT;
use crate::search::{FittedRows, norm};

/// Derivatives of all rows to what a fit moves at no bound, without springs that no load acts on and what the ones before contain, then to the
/// frames.
///
/// # Errors
/// [`FitError`] for a structure that carries nothing.
fn moved_columns(model: &LoadCaseModel<'_>, fit: &FitOutcome) -> Result<Vec<Vec<f64>>, FitError> {
    let is_inside = |one: &&FactorEstimate| {
        matches!(
            one.status,
            FactorStatus::Free | FactorStatus::NotIdentified { .. }
        )
    };
    let moving = fit.estimates.iter().filter(is_inside);
    let parameters: Vec<ModelParameter> = moving.map(|one| one.parameter.clone()).collect();
    let (posed, start) = (model.posed, &fit.factors);
    let mechanics = LoadCaseModel { start, ..*model }.mechanics(&parameters)?;
    let motions = PredictedMotions::of(&mechanics, posed, true);
    // Frames that fit the rigid robot nearly best are near enough to those of the fit: rotations between them are small.
    let tracker = model.tracker()?;
    let seen = SeenRows::of(posed, tracker.as_ref());
    let all = motions.columns.iter();
    let all: Vec<Vec<f64>> = all.map(|column| seen.changed(column)).collect();
    let lengths: Vec<f64> = all.iter().map(|one| norm(one)).collect();
    let unloaded = unloaded_springs(&parameters, &lengths, unit_length(model)?);
    let loaded = all.into_iter().zip(unloaded);
    let loaded = loaded.filter(|(_, is_unloaded)| !is_unloaded);
    let mut columns: Vec<Vec<f64>> = loaded.map(|(column, _)| column).collect();
    if let Some(tracker) = &tracker {
        columns.extend(frame_columns(posed, tracker, &[], &motions.values));
    }
    Ok(columns)
}

/// What a fit leaves of its rows, beside what it may make of them at no bound.
///
/// # Arguments
/// - `units`: of displacements and of rotations.
///
/// # Errors
/// As of [`moved_columns`].
pub(super) fn fitted_rows(
    model: &LoadCaseModel<'_>,
    fit: &FitOutcome,
    units: [f64; 2],
) -> Result<FittedRows, FitError> {
    let kinds = kinds(model.posed);
    let in_units = |values: Vec<f64>| -> Vec<f64> {
        let values = values.into_iter().zip(&kinds);
        values.map(|(value, kind)| value / units[*kind]).collect()
    };
    let mut fitted = FittedRows::new(in_units(fit.residuals()));
    for column in moved_columns(model, fit)? {
        fitted.set_free(in_units(column).into(), LEAST_INDEPENDENT);
    }
    Ok(fitted)
}

/// Scatter of displacements, m, and of rotations, rad, by a fit, without a part that grows with the load; else their usual size.
pub(super) fn plain_sd(posed: &PosedLoadCases, fit: &FitOutcome) -> [f64; 2] {
    let (usual, agreement) = (sizes(posed), fit.agreement.as_ref());
    let known = agreement.map_or([None; 2], |agreement| agreement.component_sd);
    [0, 1].map(|kind| known[kind].unwrap_or(usual[kind]))
}
