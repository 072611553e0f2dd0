//! Single values that contradict the others: their repeats where there are any, else the fit to all others.
//!
//! The scatter comes from the other repeats, or the other residuals. Values are taken away one by one ([`up_to_last_bad`]).

use stiffbench_units_and_text::test_point::Branch;

use crate::fit::{FitError, FitOptions, FitOutcome};
use crate::mismatch::{BadReading, misread_factor};
use crate::search::constants::{BAD_READING_LEVEL, MOST_BAD_READINGS};
use crate::search::{FittedRows, RowVector, up_to_last_bad};

use super::bad_positions::bad_positions;
use super::moved_columns::{fitted_rows, plain_sd};
use super::tested_values::{LEAST_SCATTER, TestedValues};
use crate::fit::load_cases::fit::fit_load_cases;
use crate::fit::load_cases::posed::PosedLoadCases;
use crate::fit::load_cases::problem::LoadCaseModel;
use crate::fit::load_cases::scatter::{kinds, repeated_rows, sizes, smallest_step};

/// Most bad values of a table: one with more has another fault, which more names would not make plainer.
pub(super) const MOST: usize = 10;

/// A value that determines more than half of its own prediction has no witness.
const LARGEST_LEVERAGE: f64 = 0.5;

/// Chance of a value without repeats below which it may be bad (1): far beyond that of a reading, because a model that lacks something
/// leaves residuals that are farther off than noise too.
pub(super) const LONE_VALUE_LEVEL: f64 = 1e-6;

/// The values that contradict others, in the order of the table; of absolute positions those that contradict the fit to all others, one after the
/// other.
///
/// # Arguments
/// - `fit`: of the model with these options.
///
/// # Errors
/// [`FitError`]: those of a fit.
pub fn bad_load_case_values(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
    fit: &FitOutcome,
) -> Result<Vec<BadReading>, FitError> {
    let posed = model.posed;
    if posed.has_positions() {
        return bad_positions(model, options, fit);
    }
    let mut bad = contradicted(posed, &fit.residuals());
    if !bad.is_empty() {
        // The model enters where loads differ a little, and where one of two repeats is bad: it is not to be drawn to bad values itself.
        let rows: Vec<usize> = bad.iter().map(|one| one.reading).collect();
        let others = posed.without_rows(&rows);
        let others = model.under(&others);
        let again = fit_load_cases(&others, options)?;
        bad = contradicted(posed, &model.left_by(&again)?);
    }
    if bad.is_empty() && options.train.is_none() {
        bad.extend(improbable(model, fit)?);
    }
    bad.sort_by_key(|one| one.reading);
    Ok(bad)
}

/// A value of a table that is off, m or rad, with the chance that noise takes any as far.
pub(super) fn bad_value(
    posed: &PosedLoadCases,
    row: usize,
    (off, standard_error): (f64, f64),
    p_family: f64,
) -> Option<BadReading> {
    let (case, read) = posed.rows().nth(row)?;
    let expected = read.value - off;
    Some(BadReading {
        reading: row,
        line: case.line,
        pose: posed.labels[case.label].clone(),
        direction: read.axis(),
        quantity: read.quantity(),
        load: None,
        repeat: case.repeat,
        step: 1,
        branch: Branch::Loading,
        is_last: false,
        repeats: Vec::new(),
        value_m: read.value,
        expected_m: expected,
        u_m: standard_error,
        p_family,
        factor: misread_factor(read.value, expected, standard_error),
        joint: None,
    })
}

/// How many values one application of a load has.
fn values_of_a_load(posed: &PosedLoadCases) -> f64 {
    posed.component_count() as f64 / posed.cases.len().max(1) as f64
}

/// The rows of each load that was applied again.
fn repeats(posed: &PosedLoadCases) -> Vec<Vec<usize>> {
    let mut repeats = repeated_rows(posed);
    repeats.retain(|rows| rows.len() > 1);
    repeats
}

/// Values that their repeats contradict.
///
/// # Arguments
/// - `residuals`: what a model leaves of all rows.
fn contradicted(posed: &PosedLoadCases, residuals: &[f64]) -> Vec<BadReading> {
    let mut groups = repeats(posed);
    let repeated: usize = groups.iter().map(Vec::len).sum();
    let most = ((MOST_BAD_READINGS * repeated as f64).ceil() as usize).min(MOST);
    let taken = up_to_last_bad(most, BAD_READING_LEVEL, |_| {
        let farthest = farthest(posed, &groups, residuals)?;
        for rows in &mut groups {
            rows.retain(|row| *row != farthest.reading);
        }
        groups.retain(|rows| rows.len() > 1);
        let chance = farthest.p_family;
        Some((farthest, chance))
    });
    taken.into_iter().map(|(bad, _)| bad).collect()
}

/// The value that is farthest from its repeats, measured by the scatter of all other repeats; `None` where these do not scatter.
///
/// # Arguments
/// - `groups`: rows of each load.
fn farthest(
    posed: &PosedLoadCases,
    groups: &[Vec<usize>],
    residuals: &[f64],
) -> Option<BadReading> {
    let (units, kinds) = (sizes(posed), kinds(posed));
    let rows = groups.concat();
    let in_units = |row: usize, value: f64| value / units[kinds[row]];
    let left = |row: &usize| in_units(*row, residuals[*row]);
    let read: Vec<_> = posed.rows().collect();
    let mut fitted = FittedRows::new(rows.iter().map(left).collect());
    let (mut group_of, mut sizes, mut suspects) = (Vec::new(), Vec::new(), Vec::new());
    let (mut tests, mut steps) = (0, [f64::INFINITY; 2]);
    for (number, own) in groups.iter().enumerate() {
        let first = group_of.len();
        let values = vec![1.0; own.len()];
        fitted.set_free(RowVector { first, values }, 0.0);
        // Two repeats have one difference: of them the one that is farther from the model may be bad.
        let is_pair = own.len() == 2;
        let far = |place: &usize| {
            let own = if is_pair {
                left(&own[*place])
            } else {
                fitted.residuals[first + place]
            };
            own.abs()
        };
        let places = (0..own.len()).rev();
        let farthest = places.max_by(|a, b| far(a).total_cmp(&far(b)));
        suspects.extend(farthest.map(|place| first + place));
        tests += if is_pair { 1 } else { own.len() };
        let values = || own.iter().map(|row| in_units(*row, read[*row].1.value));
        // A bad one is seldom smaller than it should be, and then makes the test no blunter.
        let smallest = values().fold(f64::INFINITY, |least, value| least.min(value.abs()));
        group_of.resize(first + own.len(), number);
        sizes.resize(first + own.len(), smallest * smallest);
        let step = &mut steps[kinds[own[0]]];
        *step = step.min(smallest_step(values()));
    }
    let tested = TestedValues {
        fitted,
        kinds: rows.iter().map(|row| kinds[*row]).collect(),
        sizes,
        // Two readings of one value differ by a step that neither is meant to show: the variance of rounding is the least.
        least: steps.map(|step| {
            let of_step = if step.is_finite() { step } else { 0.0 };
            (of_step / 12_f64.sqrt()).max(LEAST_SCATTER)
        }),
        together: values_of_a_load(posed),
    };
    let is_other = |one: usize, other: usize| group_of[one] != group_of[other];
    let farthest = tested.farthest(&suspects, tests, is_other)?;
    let (row, unit) = (rows[farthest.row], units[tested.kinds[farthest.row]]);
    let off = (unit * farthest.off, unit * farthest.standard_error);
    let repeats = groups[group_of[farthest.row]].iter();
    let repeats = repeats.filter(|other| **other != row);
    Some(BadReading {
        repeats: repeats.map(|other| read[*other].0.line).collect(),
        ..bad_value(posed, row, off, farthest.p)?
    })
}

/// The value without repeats that the fit to all others contradicts, if nothing else is left that noise does not leave.
///
/// # Errors
/// [`FitError`].
fn improbable(model: &LoadCaseModel<'_>, fit: &FitOutcome) -> Result<Option<BadReading>, FitError> {
    let posed = model.posed;
    let repeated = repeats(posed).concat();
    if repeated.len() == fit.components.len() {
        return Ok(None);
    }
    let (kinds, units) = (kinds(posed), plain_sd(posed, fit));
    // What is left of readings without noise is rounding of the arithmetic.
    let mut pairs = units.iter().zip(sizes(posed));
    if pairs.any(|(sd, size)| *sd <= LEAST_SCATTER * size) {
        return Ok(None);
    }
    let sizes = fit.components.iter().zip(&kinds);
    let sizes = sizes.map(|(one, kind)| (one.predicted / units[*kind]).powi(2));
    let tested = TestedValues {
        fitted: fitted_rows(model, fit, units)?,
        sizes: sizes.collect(),
        least: [LEAST_SCATTER; 2],
        together: values_of_a_load(posed),
        kinds: kinds.clone(),
    };
    let poses = posed.labels_of_rows();
    let is_suspect = |row: &usize| {
        let others_in_pose = poses.iter().filter(|pose| **pose == poses[*row]).count() > 1;
        let left = tested.fitted.shift_of_row(*row).square;
        others_in_pose && left > 1.0 - LARGEST_LEVERAGE && !repeated.contains(row)
    };
    let suspects: Vec<usize> = (0..poses.len()).filter(is_suspect).collect();
    let farthest = tested.farthest(&suspects, suspects.len(), |_, _| true);
    let farthest = farthest.filter(|one| one.stands_out && one.p <= LONE_VALUE_LEVEL);
    Ok(farthest.and_then(|one| {
        let unit = units[kinds[one.row]];
        let off = (unit * one.off, unit * one.standard_error);
        bad_value(posed, one.row, off, one.p)
    }))
}
