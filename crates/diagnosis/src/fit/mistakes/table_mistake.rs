//! What agrees with the robot once the table is put right: readings of a pose or a component in another unit, with another decimal point or
//! sign; components that are exchanged; a joint whose values have the other sign.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_numeric::least_squares::{LeastSquaresSettings, minimise};
use stiffbench_units_and_text::test_point::PoseId;

use crate::fit::{FitError, FitOptions, FitOutcome};
use crate::search::constants::{LEAST_INDEPENDENT, MOST_OF_THE_MISFIT};
use crate::search::{dot, push_orthonormal, take_out};

use super::basis::{Basis, moves};
use crate::fit::load_cases::fit::fit_load_cases;
use crate::fit::load_cases::problem::LoadCaseModel;
use crate::fit::load_cases::white_rows::LinearRows;

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
/// [`FitError`].
pub fn table_mistake(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
    fit: &FitOutcome,
) -> Result<Option<TableMistake>, FitError> {
    let mut free = fit.estimates.iter();
    let bends = free.any(|one| one.parameter.is_factor() && moves(&one.status));
    if model.posed.has_positions() || options.train.is_some() || bends {
        return Ok(None);
    }
    let basis = Basis::of(model, fit)?;
    if basis.free.is_empty() {
        return Ok(None);
    }
    let mut found = multiplied(fit, &basis)?;
    found.extend(exchanged(fit, &basis)?);
    let before = basis.plain_scatter.squares(&basis.residuals);
    let explains = |after: f64| after < (1.0 - MOST_OF_THE_MISFIT) * before;
    found.extend(other_signs(model, options, fit, &basis, &explains));
    found.retain(|(after, _)| explains(*after));
    let best = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.map(|(_, mistake)| mistake))
}

/// Readings that agree with all others once they are multiplied by a usual factor, with the squares that are left then.
fn multiplied(fit: &FitOutcome, basis: &Basis) -> Result<Vec<(f64, TableMistake)>, FitError> {
    let deleted = DeletedRows::new(basis, fit);
    let mut found = Vec::new();
    for (set, rows) in sets(fit) {
        let others = fit.components.len() - rows.len();
        if rows.len() < FEWEST
            || others < basis.free.len().max(FEWEST)
            || !deleted.may_be_usual(&rows)
        {
            continue;
        }
        let mut is_in = vec![false; fit.components.len()];
        for row in &rows {
            is_in[*row] = true;
        }
        let left = residuals_without(basis, &is_in, &basis.residuals)?;
        // Left is measured less predicted, and so is a residual of the baseline.
        let (read, predicted): (Vec<f64>, Vec<f64>) = rows
            .iter()
            .map(|row| {
                (
                    fit.components[*row].measured,
                    fit.components[*row].measured - left[*row],
                )
            })
            .unzip();
        let Some(factor) = usual_factor(&read, &predicted, NEAR, PROPORTIONAL) else {
            continue;
        };
        let mut multiplied = basis.residuals.clone();
        for row in rows {
            multiplied[row] += (factor - 1.0) * fit.components[row].measured;
        }
        found.push((squares_left(basis, &multiplied)?, set.mistake(Some(factor))));
    }
    Ok(found)
}

/// What a fit without some rows leaves of them, by the rows that all fits have: cheap, and right but for bounds and for what readings of one load
/// have in common.
struct DeletedRows {
    /// White rows as read, and what the fit leaves of them.
    read: Vec<f64>,
    residuals: Vec<f64>,
    /// Orthonormal white columns of the fit.
    columns: Vec<Vec<f64>>,
}

impl DeletedRows {
    /// Sets of more rows are refitted in any case: a table has one for each component.
    const MOST: usize = 40;

    fn new(basis: &Basis, fit: &FitOutcome) -> Self {
        let white = |mut rows: Vec<f64>| {
            basis.plain_scatter.whiten(&mut rows);
            rows
        };
        let mut columns = Vec::new();
        for column in &basis.columns {
            push_orthonormal(&mut columns, white(column.clone()), LEAST_INDEPENDENT, 0.0);
        }
        let read = fit.components.iter().map(|one| one.measured).collect();
        let mut residuals = white(basis.residuals.clone());
        take_out(&columns, &mut residuals);
        Self {
            read: white(read),
            residuals,
            columns,
        }
    }

    /// Whether a usual factor may be what some rows lack: with a wide margin.
    fn may_be_usual(&self, rows: &[usize]) -> bool {
        if rows.len() > Self::MOST {
            return true;
        }
        // (1 - H) of these rows (Cook & Weisberg, Residuals and Influence in Regression, 1982, section 3.2).
        let free = DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
            let hat: f64 = self
                .columns
                .iter()
                .map(|one| one[rows[i]] * one[rows[j]])
                .sum();
            f64::from(u8::from(i == j)) - hat
        });
        let own = DVector::from_fn(rows.len(), |i, _| self.residuals[rows[i]]);
        let Some(left) = free.lu().solve(&own) else {
            return true;
        };
        let read: Vec<f64> = rows.iter().map(|row| self.read[*row]).collect();
        let predicted: Vec<f64> = read
            .iter()
            .zip(left.iter())
            .map(|(read, left)| read - left)
            .collect();
        usual_factor(&read, &predicted, 2.0 * NEAR, 0.9 * PROPORTIONAL).is_some()
    }
}

/// Two components of a pose, or of all poses, that are exchanged, with the squares that are left then.
fn exchanged(fit: &FitOutcome, basis: &Basis) -> Result<Vec<(f64, TableMistake)>, FitError> {
    let scatter = &basis.plain_scatter;
    let as_read = scatter.squares(&basis.residuals);
    let others: BTreeSet<(&'static str, bool)> = fit
        .components
        .iter()
        .map(|one| (one.component, one.is_rotation))
        .collect();
    let mut found = Vec::new();
    for (set, own) in sets(fit) {
        let Some(component) = set.component else {
            continue;
        };
        let is_rotation = others.contains(&(component, true));
        let others = others
            .iter()
            .filter(|(other, rotation)| *other > component && *rotation == is_rotation);
        for (other, _) in others {
            let pairs = own.iter().filter_map(|&row| {
                let one = &fit.components[row];
                // Components of one load stand side by side.
                let near = fit.components.iter().enumerate();
                let mut near = near.skip(row.saturating_sub(5)).take(11);
                let (place, _) = near.find(|(_, with)| {
                    with.component == *other && (with.line, with.repeat) == (one.line, one.repeat)
                })?;
                let by = fit.components[place].measured - one.measured;
                Some([(row, by), (place, -by)])
            });
            let changes: Vec<(usize, f64)> = pairs.flatten().collect();
            let mut rows = basis.residuals.clone();
            for (row, by) in &changes {
                rows[*row] += by;
            }
            // A fit that was drawn to the exchanged readings is nearer to them put right.
            if changes.is_empty() || scatter.squares(&rows) >= as_read {
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

/// Joints whose values have the other sign, with the squares that a fit leaves then; only where much is left, and where the linear structure at
/// the values of the fit explains it.
fn other_signs(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
    fit: &FitOutcome,
    basis: &Basis,
    explains: &dyn Fn(f64) -> bool,
) -> Vec<(f64, TableMistake)> {
    let scatter = &basis.plain_scatter;
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
        let Ok(there) = Basis::in_poses_of(&mirrored, fit) else {
            continue;
        };
        if !squares_left(&there, &there.residuals).is_ok_and(explains) {
            continue;
        }
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

/// Each pose, each component, and each component of each pose, with its rows.
fn sets(fit: &FitOutcome) -> Vec<(ReadingSet, Vec<usize>)> {
    let mut sets: BTreeMap<(Option<&'static str>, Option<&PoseId>), Vec<usize>> = BTreeMap::new();
    for (row, one) in fit.components.iter().enumerate() {
        let (component, pose) = (Some(one.component), Some(&one.pose));
        for set in [(component, pose), (component, None), (None, pose)] {
            sets.entry(set).or_default().push(row);
        }
    }
    let named = sets.into_iter().map(|((component, pose), rows)| {
        let pose = pose.cloned();
        (ReadingSet { pose, component }, rows)
    });
    let mut named: Vec<(ReadingSet, Vec<usize>)> = named.collect();
    // Of equal ones the narrower comes first.
    named.sort_by_key(|(set, _)| (set.component.is_none(), set.pose.is_none()));
    named
}

/// Weighted squares that a fit leaves of rows.
fn squares_left(basis: &Basis, rows: &[f64]) -> Result<f64, FitError> {
    let none = vec![false; rows.len()];
    let left = residuals_without(basis, &none, rows)?;
    Ok(basis.plain_scatter.squares(&left))
}

/// What a fit without some rows leaves of all rows.
fn residuals_without(basis: &Basis, without: &[bool], rows: &[f64]) -> Result<Vec<f64>, FitError> {
    let scatter = basis.plain_scatter.without(|row| without[row]);
    let (mut problem, set) = LinearRows::new(rows, &basis.changes(), scatter)?;
    let fit = minimise(&mut problem, &set, &LeastSquaresSettings::default())?;
    let predicted = problem.at(&fit.values);
    let rows = rows.iter().zip(predicted);
    Ok(rows.map(|(row, predicted)| row - predicted).collect())
}

/// The usual factor by which readings agree with a prediction, if they are proportional to it.
///
/// # Arguments
/// - `near`: share by which a factor may be off; `proportional`: least cosine between both.
fn usual_factor(read: &[f64], predicted: &[f64], near: f64, proportional: f64) -> Option<f64> {
    let common = dot(read, predicted);
    let cosine = common / (dot(read, read) * dot(predicted, predicted)).sqrt();
    if cosine.is_nan() || cosine.abs() < proportional {
        return None;
    }
    let factor = common / dot(read, read);
    let tens = (1..=6).flat_map(|power| [10_f64.powi(power), 10_f64.powi(-power)]);
    let units = OF_UNITS.into_iter().flat_map(|unit| [unit, 1.0 / unit]);
    let usual = tens.chain(units).chain([-1.0]);
    let off = |usual: f64| (factor / usual - 1.0).abs();
    usual
        .filter(|usual| off(*usual) < near)
        .min_by(|a, b| off(*a).total_cmp(&off(*b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_factors_are_found_and_others_are_not() {
        let predicted = [3.0, -5.0, 8.0, 1.0];
        let usual = |read: &[f64]| usual_factor(read, &predicted, NEAR, PROPORTIONAL);
        let times = |factor: f64| predicted.map(|value| value / factor);
        for factor in [1000.0, 0.1, 25.4, 1.0 / 4.448_221_6, -1.0] {
            let found = usual(&times(1.005 * factor)).unwrap();
            assert!((found / factor - 1.0).abs() < 1e-6, "{factor}: {found}");
        }
        for factor in [1.0, 2.0, 0.8, 50.0] {
            assert_eq!(usual(&times(factor)), None, "{factor}");
        }
        let turned_in_part = [0.003, 0.005, 0.008, 0.001];
        assert_eq!(usual(&turned_in_part), None);
        assert_eq!(usual(&[0.0; 4]), None);
    }
}
