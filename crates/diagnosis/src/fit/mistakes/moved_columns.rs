//! What a fit of load cases may make of their rows.

use stiffbench_beams::robot::ModelParameter;

use crate::fit::load_cases::frames::frame_columns;
use crate::fit::load_cases::posed::PosedLoadCases;
use crate::fit::load_cases::prediction::{PredictedMotions, SeenRows};
use crate::fit::load_cases::problem::{LoadCaseModel, unit_length, unloaded_springs};
use crate::fit::load_cases::scatter::{kinds, sizes};
use crate::fit::{FactorStatus, FitError, FitOutcome};
use crate::search::constants::LEAST_INDEPENDENT;
use crate::search::{FittedRows, norm, push_orthonormal};

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
    for column in moved_columns(model, fit, is_inside)?.1 {
        fitted.set_free(in_units(column).into(), LEAST_INDEPENDENT);
    }
    Ok(fitted)
}

/// Whether a fit moves a parameter: also one at a bound, which what is missing may have driven there.
pub(super) fn moves(status: &FactorStatus) -> bool {
    is_inside(status) || matches!(status, FactorStatus::AtBound { .. })
}

/// Whether a fit moves a parameter that is at no bound.
fn is_inside(status: &FactorStatus) -> bool {
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
