//! What agrees with the robot once the table is put right: readings of a pose or a component in another unit, with another decimal point or
//! sign; components that are exchanged; a joint whose values have the other sign.

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_numeric::least_squares::{LeastSquaresSettings, minimise};
use stiffbench_units_and_text::test_point::PoseId;

use crate::fit::{FitError, FitOptions, FitOutcome};
use crate::search::constants::MOST_OF_THE_MISFIT;
use crate::search::dot;

use super::fitted_rows::{FittedRows, moved_columns, moves, plain_sd};
use crate::fit::load_cases::fit::fit_load_cases;
use crate::fit::load_cases::problem::LoadCaseModel;
use crate::fit::load_cases::scatter::RowScatter;
use crate::fit::load_cases::white_rows::LinearRows;

/// Values of which a common factor can be seen: two agree with any line by chance.
const FEWEST: usize = 3;

/// Cosine between readings and prediction from which on they are proportional (1): a seventh of their length may differ.
const PROPORTIONAL: f64 = 0.99;

/// A factor is meant if it is within this share (1): the springs of the others are known to some percent at best.
const NEAR: f64 = 0.1;

/// Inch over mm, pound-force over N, kilogram-force over N.
const OF_UNITS: [f64; 3] = [25.4, 4.448_221_6, 9.806_65];

/// Sets of more rows are tried in full in any case: a table has one for each component.
const MOST_DELETED: usize = 40;

/// Share of the squares of all readings below which too little is left for a joint to have the other sign (1): then a tenth of every reading is
/// not left.
const LEFT_BY_A_SIGN: f64 = 0.01;

/// What a table has wrong, if it agrees with the robot once that is put right.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
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
    let basis = Basis::new(model, fit, fit.residuals())?;
    if basis.changes.is_empty() {
        return Ok(None);
    }
    let mut found = multiplied(fit, &basis)?;
    found.extend(exchanged(fit, &basis)?);
    let before = basis.scatter.squares(&basis.residuals);
    let explains = |after: f64| after < (1.0 - MOST_OF_THE_MISFIT) * before;
    found.extend(other_signs(model, options, fit, &basis, &explains));
    found.retain(|(after, _)| explains(*after));
    let best = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.map(|(_, mistake)| mistake))
}

/// A fit with the poses solved at its values: what a mistake of the table is compared with.
struct Basis {
    residuals: Vec<f64>,
    /// The column of each parameter that moves, with the smallest and largest change of its value that the bounds allow.
    changes: Vec<(Vec<f64>, [f64; 2])>,
    /// The scatter of each kind of rows without a part that grows with the load: a mistake of the table must not pass for it.
    scatter: RowScatter,
}

impl Basis {
    /// # Arguments
    /// - `residuals`: what the values of the fit leave in the poses of the model.
    ///
    /// # Errors
    /// [`FitError`] for a structure that carries nothing.
    fn new(
        model: &LoadCaseModel<'_>,
        fit: &FitOutcome,
        residuals: Vec<f64>,
    ) -> Result<Self, FitError> {
        let (places, columns) = moved_columns(model, fit, moves)?;
        let changes = places.into_iter().zip(columns).map(|(place, column)| {
            let one = &fit.estimates[place];
            let bounds = one.bounds.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            (column, bounds.map(|end| end - one.value))
        });
        Ok(Self {
            residuals,
            changes: changes.collect(),
            scatter: RowScatter::plain(model.posed, model.steps, plain_sd(model.posed, fit)),
        })
    }

    /// What a fit without some rows leaves of all rows.
    fn left_without(&self, without: &[usize], rows: &[f64]) -> Result<Vec<f64>, FitError> {
        let mut is_out = vec![false; rows.len()];
        for row in without {
            is_out[*row] = true;
        }
        let scatter = self.scatter.without(|row| is_out[row]);
        let (mut problem, set) = LinearRows::new(rows, &self.changes, scatter)?;
        let fit = minimise(&mut problem, &set, &LeastSquaresSettings::default())?;
        let rows = rows.iter().zip(problem.at(&fit.values));
        Ok(rows.map(|(row, predicted)| row - predicted).collect())
    }

    /// Weighted squares that a fit leaves of rows.
    fn squares_left(&self, rows: &[f64]) -> Result<f64, FitError> {
        Ok(self.scatter.squares(&self.left_without(&[], rows)?))
    }
}

/// Readings that agree with all others once they are multiplied by a usual factor, with the squares that are left then.
fn multiplied(fit: &FitOutcome, basis: &Basis) -> Result<Vec<(f64, TableMistake)>, FitError> {
    let white = |mut rows: Vec<f64>| {
        basis.scatter.whiten(&mut rows);
        rows
    };
    let read: Vec<f64> = fit.components.iter().map(|one| one.measured).collect();
    let columns = basis
        .changes
        .iter()
        .map(|(column, _)| white(column.clone()));
    let fitted = FittedRows::new(white(basis.residuals.clone()), columns).projected();
    let white_read = white(read.clone());
    // A factor by which these rows agree with what is measured less left.
    let factor = |read: &[f64], rows: &[usize], left: &[f64], wide: bool| {
        let read: Vec<f64> = rows.iter().map(|row| read[*row]).collect();
        let predicted = read.iter().zip(left).map(|(read, left)| read - left);
        let (near, proportional) = if wide { (2.0, 0.9) } else { (1.0, 1.0) };
        let predicted: Vec<f64> = predicted.collect();
        usual_factor(&read, &predicted, near * NEAR, proportional * PROPORTIONAL)
    };
    let mut found = Vec::new();
    for (set, rows) in sets(fit) {
        let others = read.len() - rows.len();
        if rows.len() < FEWEST || others < basis.changes.len().max(FEWEST) {
            continue;
        }
        // What the fit to the others leaves of them, cheap, and right but for bounds: with a wide margin.
        let is_small = rows.len() <= MOST_DELETED;
        let deleted = is_small.then(|| fitted.without(&rows, 1.0)).flatten();
        if deleted.is_some_and(|one| factor(&white_read, &rows, &one.off, true).is_none()) {
            continue;
        }
        let left = basis.left_without(&rows, &basis.residuals)?;
        let left: Vec<f64> = rows.iter().map(|row| left[*row]).collect();
        let Some(factor) = factor(&read, &rows, &left, false) else {
            continue;
        };
        let mut multiplied = basis.residuals.clone();
        for row in rows {
            multiplied[row] += (factor - 1.0) * read[row];
        }
        let mistake = TableMistake {
            factor: Some(factor),
            ..set
        };
        found.push((basis.squares_left(&multiplied)?, mistake));
    }
    Ok(found)
}

/// Two components of a pose, or of all poses, that are exchanged, with the squares that are left then.
fn exchanged(fit: &FitOutcome, basis: &Basis) -> Result<Vec<(f64, TableMistake)>, FitError> {
    let as_read = basis.scatter.squares(&basis.residuals);
    let all = fit.components.iter();
    let all: BTreeSet<(&'static str, bool)> =
        all.map(|one| (one.component, one.is_rotation)).collect();
    let mut found = Vec::new();
    for (set, own) in sets(fit) {
        let Some(component) = set.component else {
            continue;
        };
        let is_rotation = all.contains(&(component, true));
        let is_alike = |one: &&(&str, bool)| one.0 > component && one.1 == is_rotation;
        for (other, _) in all.iter().filter(is_alike) {
            let mut rows = basis.residuals.clone();
            for &row in &own {
                let one = &fit.components[row];
                // Components of one load stand side by side.
                let near = fit.components.iter().enumerate();
                let mut near = near.skip(row.saturating_sub(5)).take(11);
                let with = near.find(|(_, with)| {
                    with.component == *other && (with.line, with.repeat) == (one.line, one.repeat)
                });
                if let Some((place, with)) = with {
                    rows[row] += with.measured - one.measured;
                    rows[place] -= with.measured - one.measured;
                }
            }
            // A fit that was drawn to the exchanged readings is nearer to them put right.
            if basis.scatter.squares(&rows) < as_read {
                let mistake = TableMistake {
                    exchanged_with: Some(other),
                    ..set.clone()
                };
                found.push((basis.squares_left(&rows)?, mistake));
            }
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
    let scatter = &basis.scatter;
    if scatter.squares(&basis.residuals) < LEFT_BY_A_SIGN * scatter.squares(&model.measured()) {
        return Vec::new();
    }
    let variables = model.robot.variables.iter().enumerate();
    let moving = variables.filter(|(variable, _)| model.robot.moves_tool(*variable));
    let found = moving.filter_map(|(variable, named)| {
        let posed = model.posed.with_other_sign(variable)?;
        let mirrored = model.under(&posed);
        // Poses that cannot be reached are none that the robot stood in.
        let left = mirrored.left_by(fit).ok()?;
        let there = Basis::new(&mirrored, fit, left).ok()?;
        if !there.squares_left(&there.residuals).is_ok_and(explains) {
            return None;
        }
        let fit = fit_load_cases(&mirrored, options).ok()?;
        let mistake = TableMistake {
            factor: Some(-1.0),
            joint: Some(named.name.clone()),
            ..TableMistake::default()
        };
        Some((scatter.squares(&fit.residuals()), mistake))
    });
    found.collect()
}

/// Each pose, each component, and each component of each pose, with its rows; of equal ones the narrower comes first.
fn sets(fit: &FitOutcome) -> Vec<(TableMistake, Vec<usize>)> {
    let mut sets: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    for (row, one) in fit.components.iter().enumerate() {
        let (component, pose) = (Some(one.component), Some(&one.pose));
        for (component, pose) in [(component, pose), (component, None), (None, pose)] {
            let key = (component.is_none(), pose.is_none(), component, pose);
            sets.entry(key).or_default().push(row);
        }
    }
    let named = sets.into_iter().map(|((_, _, component, pose), rows)| {
        let set = TableMistake {
            pose: pose.cloned(),
            component,
            ..TableMistake::default()
        };
        (set, rows)
    });
    named.collect()
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
