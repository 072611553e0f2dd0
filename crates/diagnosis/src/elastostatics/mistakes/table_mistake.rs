//! What agrees with the robot once the table is put right: readings of a pose or a component in another unit, with another decimal point or
//! sign; components that are exchanged; a joint whose values have the other sign.

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_numeric::least_squares::minimise;
use stiffbench_units_and_text::test_point::PoseId;

use crate::search::constants::MOST_OF_THE_MISFIT;
use crate::search::dot;

use super::basis::{Basis, moves};
use crate::elastostatics::error::LoadCaseFitError;
use crate::elastostatics::fit::{LoadCaseFitOptions, fit_load_cases};
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

/// Share of the squares of all readings below which too little is left for a joint to have the other sign (1): then a tenth of every reading is
/// not left.
const LEFT_BY_A_SIGN: f64 = 0.01;

/// What a table has wrong, if it agrees with the robot once that is put right.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct TableMistake {
    /// The pose; `null` in all poses.
    pub pose: Option<PoseId>,
    /// The component; `null` of all components of a pose.
    pub component: Option<&'static str>,
    /// What readings, or values of a joint, must be multiplied by: a power of ten, a factor between units, or -1; `null` of components that are
    /// exchanged.
    pub factor: Option<f64>,
    /// The component with which it is exchanged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exchanged_with: Option<&'static str>,
    /// The variable of the robot whose values have the other sign.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
}

/// A set of readings of a table.
#[derive(Debug, Clone, PartialEq)]
struct ReadingSet {
    /// `None`: all poses.
    pose: Option<PoseId>,
    /// `None`: all components.
    component: Option<&'static str>,
}

impl ReadingSet {
    fn contains(&self, one: &FittedComponent) -> bool {
        self.pose.as_ref().is_none_or(|pose| one.pose == *pose)
            && self
                .component
                .is_none_or(|component| one.component == component)
    }

    fn mistake(self, factor: Option<f64>) -> TableMistake {
        TableMistake {
            pose: self.pose,
            component: self.component,
            factor,
            exchanged_with: None,
            joint: None,
        }
    }
}

/// The mistake of a table that explains most of the misfit, if there is one.
///
/// None is sought of absolute positions, beside held-out poses, and where factors of beams are free.
///
/// # Errors
/// [`LoadCaseFitError`].
pub fn table_mistake(
    model: &LoadCaseModel<'_>,
    options: &LoadCaseFitOptions,
    fit: &LoadCaseFit,
) -> Result<Option<TableMistake>, LoadCaseFitError> {
    let mut free = fit.estimates.iter();
    let bends = free.any(|one| one.parameter.is_factor() && moves(&one.status));
    if model.posed.has_positions() || options.train.is_some() || bends {
        return Ok(None);
    }
    let (_, basis) = Basis::of(model, fit)?;
    if basis.free.is_empty() {
        return Ok(None);
    }
    let mut found = multiplied(fit, &basis)?;
    found.extend(exchanged(fit, &basis)?);
    found.extend(other_signs(model, options, fit, &basis));
    let before = basis.baseline.scatter.squares(&basis.residuals);
    found.retain(|(after, _)| *after < (1.0 - MOST_OF_THE_MISFIT) * before);
    let best = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.map(|(_, mistake)| mistake))
}

/// Readings that agree with all others once they are multiplied by a usual factor, with the squares that are left then.
fn multiplied(
    fit: &LoadCaseFit,
    basis: &Basis,
) -> Result<Vec<(f64, TableMistake)>, LoadCaseFitError> {
    let mut found = Vec::new();
    for set in sets(fit) {
        let components = fit.components.iter();
        let is_in: Vec<bool> = components.map(|one| set.contains(one)).collect();
        let count = is_in.iter().filter(|is_in| **is_in).count();
        if count < FEWEST || is_in.len() - count < basis.free.len().max(FEWEST) {
            continue;
        }
        let left = residuals_without(basis, &is_in, &basis.residuals)?;
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
        found.push((squares_left(basis, &multiplied)?, set.mistake(Some(factor))));
    }
    Ok(found)
}

/// Two components of a pose, or of all poses, that are exchanged, with the squares that are left then.
fn exchanged(
    fit: &LoadCaseFit,
    basis: &Basis,
) -> Result<Vec<(f64, TableMistake)>, LoadCaseFitError> {
    let squares = |rows: &[f64]| basis.baseline.scatter.squares(rows);
    let before = squares(&basis.residuals);
    let mut found = Vec::new();
    for set in sets(fit) {
        let Some(component) = set.component else {
            continue;
        };
        let others: BTreeSet<(&'static str, bool)> = fit
            .components
            .iter()
            .map(|one| (one.component, one.is_rotation))
            .collect();
        let is_rotation = others.contains(&(component, true));
        let others = others
            .iter()
            .filter(|(other, rotation)| *other > component && *rotation == is_rotation);
        for (other, _) in others {
            let mut rows = basis.residuals.clone();
            let mut exchanges = 0;
            for (row, one) in fit.components.iter().enumerate() {
                if !set.contains(one) {
                    continue;
                }
                // Components of one load stand side by side.
                let near = fit.components.iter().enumerate();
                let mut near = near.skip(row.saturating_sub(5)).take(11);
                let with = near.find(|(_, with)| {
                    with.component == *other && (with.line, with.repeat) == (one.line, one.repeat)
                });
                if let Some((place, with)) = with {
                    rows[row] += with.measured - one.measured;
                    rows[place] += one.measured - with.measured;
                    exchanges += 1;
                }
            }
            // A fit that was drawn to the exchanged readings is nearer to them put right.
            if exchanges == 0 || squares(&rows) >= before {
                continue;
            }
            found.push((
                squares_left(basis, &rows)?,
                TableMistake {
                    exchanged_with: Some(other),
                    ..set.clone().mistake(None)
                },
            ));
        }
    }
    Ok(found)
}

/// Joints whose values have the other sign, with the squares that a fit leaves then; only where much is left.
fn other_signs(
    model: &LoadCaseModel<'_>,
    options: &LoadCaseFitOptions,
    fit: &LoadCaseFit,
    basis: &Basis,
) -> Vec<(f64, TableMistake)> {
    let scatter = &basis.baseline.scatter;
    let read: Vec<f64> = fit.components.iter().map(|one| one.measured).collect();
    if scatter.squares(&basis.residuals) < LEFT_BY_A_SIGN * scatter.squares(&read) {
        return Vec::new();
    }
    let mut found = Vec::new();
    for (variable, named) in model.robot.variables.iter().enumerate() {
        if !model.robot.moves_tool(variable) {
            continue;
        }
        let Some(posed) = model.posed.with_other_sign(variable) else {
            continue;
        };
        let mirrored = LoadCaseModel {
            posed: &posed,
            ..*model
        };
        // Poses that cannot be reached are none that the robot stood in.
        let Ok(fit) = fit_load_cases(&mirrored, options) else {
            continue;
        };
        found.push((
            scatter.squares(&fit.residuals()),
            TableMistake {
                pose: None,
                component: None,
                factor: Some(-1.0),
                exchanged_with: None,
                joint: Some(named.name.clone()),
            },
        ));
    }
    found
}

/// Each pose, each component, and each component of each pose.
fn sets(fit: &LoadCaseFit) -> Vec<ReadingSet> {
    let poses: BTreeSet<&PoseId> = fit.components.iter().map(|one| &one.pose).collect();
    let components: BTreeSet<&'static str> =
        fit.components.iter().map(|one| one.component).collect();
    let poses: Vec<Option<&PoseId>> = poses.into_iter().map(Some).chain([None]).collect();
    let components = components.into_iter().map(Some).chain([None]);
    components
        .flat_map(|component| poses.iter().map(move |pose| (*pose, component)))
        .filter(|(pose, component)| pose.is_some() || component.is_some())
        .map(|(pose, component)| ReadingSet {
            pose: pose.cloned(),
            component,
        })
        .collect()
}

/// Weighted squares that a fit leaves of rows.
fn squares_left(basis: &Basis, rows: &[f64]) -> Result<f64, LoadCaseFitError> {
    let none = vec![false; rows.len()];
    let left = residuals_without(basis, &none, rows)?;
    Ok(basis.baseline.scatter.squares(&left))
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
