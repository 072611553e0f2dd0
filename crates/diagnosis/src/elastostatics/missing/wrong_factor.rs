//! Readings of one pose, or of one component, that agree with all others once they are multiplied: another unit, decimal point or sign.

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_numeric::least_squares::minimise;
use stiffbench_units_and_text::test_point::PoseId;

use crate::search::constants::MOST_OF_THE_MISFIT;
use crate::search::dot;

use super::find::{Basis, moves};
use crate::elastostatics::error::LoadCaseFitError;
use crate::elastostatics::fit::LoadCaseFitOptions;
use crate::elastostatics::held_out::{LinearRows, WeighedProblem};
use crate::elastostatics::outcome::{FittedComponent, LoadCaseFit};
use crate::elastostatics::problem::LoadCaseModel;

/// Values of which a common factor can be seen: two agree with any line by chance.
const FEWEST: usize = 3;

/// Cosine between readings and prediction from which on they are proportional (1): a seventh of their length may differ.
const PROPORTIONAL: f64 = 0.99;

/// A factor is meant if it is within this share (1): the springs of the others are known to some percent at best.
const NEAR: f64 = 0.1;

/// Inch over mm, pound-force over N, kilogram-force over N.
const OF_UNITS: [f64; 3] = [25.4, 4.448_221_6, 9.806_65];

/// Readings that agree with all others once they are multiplied.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "WrongFactorReport")]
pub struct WrongFactor {
    /// The pose; `null` of a component in all poses.
    pub pose: Option<PoseId>,
    /// The component; `null` of all components of a pose.
    pub component: Option<&'static str>,
    /// What they must be multiplied by: a power of ten, a factor between units, or -1.
    pub factor: f64,
}

impl WrongFactor {
    fn contains(&self, one: &FittedComponent) -> bool {
        self.pose.as_ref().is_none_or(|pose| one.pose == *pose)
            && self
                .component
                .is_none_or(|component| one.component == component)
    }
}

/// The set of readings whose multiplication by a usual factor explains most of the misfit, if there is one.
///
/// None is sought of absolute positions, beside held-out poses, and where factors of beams are free.
///
/// # Errors
/// [`LoadCaseFitError`].
pub fn wrong_factor(
    model: &LoadCaseModel<'_>,
    options: &LoadCaseFitOptions,
    fit: &LoadCaseFit,
) -> Result<Option<WrongFactor>, LoadCaseFitError> {
    let mut free = fit.estimates.iter();
    let bends = free.any(|one| one.parameter.is_factor() && moves(&one.status));
    if model.posed.has_positions() || options.train.is_some() || bends {
        return Ok(None);
    }
    let (_, basis) = Basis::of(model, fit)?;
    if basis.free.is_empty() {
        return Ok(None);
    }
    let squares = |rows: &[f64]| basis.baseline.scatter.squares(rows);
    let before = squares(&basis.residuals);
    let mut best: Option<(f64, WrongFactor)> = None;
    for mut set in sets(fit) {
        let components = fit.components.iter();
        let is_in: Vec<bool> = components.map(|one| set.contains(one)).collect();
        let count = is_in.iter().filter(|is_in| **is_in).count();
        if count < FEWEST || is_in.len() - count < basis.free.len().max(FEWEST) {
            continue;
        }
        let left = residuals_without(&basis, &is_in, &basis.residuals)?;
        let rows = fit.components.iter().zip(&left).zip(&is_in);
        let rows = rows.filter(|(_, is_in)| **is_in);
        // Left is measured less predicted, and so is a residual of the baseline.
        let (read, predicted): (Vec<f64>, Vec<f64>) = rows
            .map(|((one, left), _)| (one.measured, one.measured - left))
            .unzip();
        let Some(factor) = usual_factor(&read, &predicted) else {
            continue;
        };
        let rows = basis.residuals.iter().zip(&fit.components).zip(&is_in);
        let multiplied: Vec<f64> = rows
            .map(|((row, one), is_in)| {
                let share = if *is_in { factor - 1.0 } else { 0.0 };
                row + share * one.measured
            })
            .collect();
        let none = vec![false; is_in.len()];
        let after = squares(&residuals_without(&basis, &none, &multiplied)?);
        let explains = after < (1.0 - MOST_OF_THE_MISFIT) * before;
        if explains && best.as_ref().is_none_or(|(least, _)| after < *least) {
            set.factor = factor;
            best = Some((after, set));
        }
    }
    Ok(best.map(|(_, found)| found))
}

/// Each pose, each component, and each component of each pose.
fn sets(fit: &LoadCaseFit) -> Vec<WrongFactor> {
    let poses: BTreeSet<&PoseId> = fit.components.iter().map(|one| &one.pose).collect();
    let components: BTreeSet<&'static str> =
        fit.components.iter().map(|one| one.component).collect();
    let poses: Vec<Option<&PoseId>> = poses.into_iter().map(Some).chain([None]).collect();
    let components = components.into_iter().map(Some).chain([None]);
    components
        .flat_map(|component| poses.iter().map(move |pose| (*pose, component)))
        .filter(|(pose, component)| pose.is_some() || component.is_some())
        .map(|(pose, component)| WrongFactor {
            pose: pose.cloned(),
            component,
            factor: 1.0,
        })
        .collect()
}

/// What a fit without some rows leaves of all rows.
fn residuals_without(
    basis: &Basis,
    without: &[bool],
    rows: &[f64],
) -> Result<Vec<f64>, LoadCaseFitError> {
    let scatter = basis.baseline.scatter.without(|row| without[row]);
    let (mut problem, set) = LinearRows::new(rows, &basis.changes(), scatter)?;
    let settings = problem.settings();
    let fit = minimise(&mut problem, &set, &settings)?;
    let predicted = problem.predict(&fit.values)?;
    let rows = rows.iter().zip(predicted);
    Ok(rows.map(|(row, predicted)| row - predicted).collect())
}

/// The usual factor by which readings agree with a prediction, if they are proportional to it.
fn usual_factor(read: &[f64], predicted: &[f64]) -> Option<f64> {
    let common = dot(read, predicted);
    let cosine = common / (dot(read, read) * dot(predicted, predicted)).sqrt();
    if cosine.is_nan() || cosine.abs() < PROPORTIONAL {
        return None;
    }
    let factor = common / dot(read, read);
    let tens = (1..=6).flat_map(|power| [10_f64.powi(power), 10_f64.powi(-power)]);
    let units = OF_UNITS.into_iter().flat_map(|unit| [unit, 1.0 / unit]);
    let usual = tens.chain(units).chain([-1.0]);
    let off = |usual: f64| (factor / usual - 1.0).abs();
    usual
        .filter(|usual| off(*usual) < NEAR)
        .min_by(|a, b| off(*a).total_cmp(&off(*b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_factors_are_found_and_others_are_not() {
        let predicted = [3.0, -5.0, 8.0, 1.0];
        let times = |factor: f64| predicted.map(|value| value / factor);
        for factor in [1000.0, 0.1, 25.4, 1.0 / 4.448_221_6, -1.0] {
            let found = usual_factor(&times(1.005 * factor), &predicted).unwrap();
            assert!((found / factor - 1.0).abs() < 1e-6, "{factor}: {found}");
        }
        for factor in [1.0, 2.0, 0.8, 50.0] {
            assert_eq!(usual_factor(&times(factor), &predicted), None, "{factor}");
        }
        let turned_in_part = [0.003, 0.005, 0.008, 0.001];
        assert_eq!(usual_factor(&turned_in_part, &predicted), None);
        assert_eq!(usual_factor(&[0.0; 4], &predicted), None);
    }
}
