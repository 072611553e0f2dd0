//! Single values that contradict the others: their repeats where there are any, else the fit to all others.
//!
//! The scatter comes from the other repeats, or the other residuals. Values are taken away one by one, the farthest first, and those before
//! the last that is too far for noise are bad: so two bad values do not hide each other (generalized extreme studentized deviate: Rosner,
//! Technometrics 25, 1983).

use std::collections::BTreeMap;

use stiffbench_beams::robot::ModelParameter;
use stiffbench_units_and_text::test_point::{Branch, PoseId};

use crate::fit::{FactorStatus, FitError, FitOptions, FitOutcome};
use crate::mismatch::{BadReading, OtherJointValue, slip};
use crate::search::constants::{BAD_READING_LEVEL, LEAST_INDEPENDENT, MOST_BAD_READINGS};
use crate::search::push_orthonormal;

use super::bad_positions::bad_positions;
use super::basis::{Basis, moves};
use super::far_value::{FarValue, LEAST_SCATTER, ScatterCase, scatter_of};
use crate::fit::load_cases::fit::fit_load_cases;
use crate::fit::load_cases::frames::PositionFrames;
use crate::fit::load_cases::posed::PosedLoadCases;
use crate::fit::load_cases::prediction::PredictedMotions;
use crate::fit::load_cases::problem::LoadCaseModel;
use crate::fit::load_cases::scatter::{kinds, repeated_rows, sizes, smallest_step};

/// Most bad values of a table: one with more has another fault, which more names would not make plainer.
pub(super) const MOST: usize = 10;

/// Values that are looked at closely each time: those that are farthest off by two measures of the scatter.
const LOOKED_AT: usize = 8;

/// A value that determines more than half of its own prediction has no witness.
const LARGEST_LEVERAGE: f64 = 0.5;

/// Chance of a value without repeats below which it may be bad (1): far beyond [`BAD_READING_LEVEL`], because a model that lacks something
/// leaves residuals that are farther off than noise too.
pub(super) const LONE_VALUE_LEVEL: f64 = 1e-6;

/// Without repeats the others must look like noise once the value is gone: none is so far off that noise does it in fewer tables.
pub(super) const REST_IS_NOISE: f64 = 0.05;

/// Or the value stands alone: so many times as far off as the next, in standard errors. What a model lacks spreads over many values.
pub(super) const STANDS_ALONE: f64 = 4.0;

/// What is known of a value that is tested.
pub(super) struct TestedValue {
    pub(super) row: usize,
    /// Value less expected, m or rad.
    pub(super) off: f64,
    pub(super) standard_error: f64,
    /// Lines of the repeats that contradict it; none where the fit does.
    pub(super) repeats: Vec<u32>,
    pub(super) p: f64,
    /// Of a position with others that are off by the same joint.
    pub(super) joint: Option<OtherJointValue>,
}

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
        let rows: Vec<usize> = bad.iter().map(|one| one.row).collect();
        let posed = posed.without_rows(&rows);
        let without = LoadCaseModel {
            posed: &posed,
            ..*model
        };
        let again = fit_load_cases(&without, options)?;
        let start = &again.factors;
        let predicted = LoadCaseModel { start, ..*model }.predicted()?;
        let rows = model.measured().into_iter().zip(predicted);
        let residuals: Vec<f64> = rows.map(|(read, predicted)| read - predicted).collect();
        bad = contradicted(model.posed, &residuals);
    }
    if bad.is_empty() && options.train.is_none() {
        bad.extend(improbable(model, fit)?);
    }
    Ok(named(posed, bad))
}

/// Values in the order of the table, with what belongs to them.
pub(super) fn named(posed: &PosedLoadCases, mut bad: Vec<TestedValue>) -> Vec<BadReading> {
    bad.sort_by_key(|one| one.row);
    let rows: Vec<_> = posed.rows().collect();
    let named = bad.into_iter().map(|one| {
        let (case, read) = rows[one.row];
        let expected = read.value - one.off;
        BadReading {
            reading: one.row,
            line: case.line,
            pose: posed.labels[case.label].clone(),
            direction: read.axis(),
            quantity: read.quantity(),
            load: None,
            repeat: case.repeat,
            step: 1,
            branch: Branch::Loading,
            is_last: false,
            repeats: one.repeats,
            value_m: read.value,
            expected_m: expected,
            u_m: one.standard_error,
            p_family: one.p,
            kind: slip(read.value, expected, one.standard_error),
            joint: one.joint,
        }
    });
    named.collect()
}

/// How many values one application of a load has.
fn values_of_a_load(posed: &PosedLoadCases) -> f64 {
    posed.rows().count() as f64 / posed.cases.len().max(1) as f64
}

/// The repeats of a load as long as they are not taken away.
struct RepeatedValue {
    rows: Vec<usize>,
    kind: usize,
    /// Square of the smallest of the values: a bad one is seldom smaller than it should be, and then makes the test no blunter.
    size: f64,
    /// Smallest difference between values that differ: no step of the gauge is larger.
    step: f64,
}

/// Values that their repeats contradict.
fn contradicted(posed: &PosedLoadCases, residuals: &[f64]) -> Vec<TestedValue> {
    let read: Vec<(u32, usize, f64)> = posed
        .rows()
        .map(|(case, read)| (case.line, usize::from(read.is_rotation()), read.value))
        .collect();
    let groups = repeated_rows(posed).into_iter();
    let mut groups: Vec<Vec<usize>> = groups.filter(|rows| rows.len() > 1).collect();
    let repeated: usize = groups.iter().map(Vec::len).sum();
    let most = ((MOST_BAD_READINGS * repeated as f64).ceil() as usize).min(MOST);
    let mut taken: Vec<TestedValue> = Vec::new();
    for _ in 0..most {
        let repeats: Vec<RepeatedValue> = groups
            .iter()
            .filter(|rows| rows.len() > 1)
            .map(|rows| RepeatedValue::new(rows, &read))
            .collect();
        let Some(farthest) = farthest(&repeats, residuals, &read, posed) else {
            break;
        };
        for rows in &mut groups {
            rows.retain(|row| *row != farthest.row);
        }
        taken.push(farthest);
    }
    let last = taken.iter().rposition(|one| one.p <= BAD_READING_LEVEL);
    taken.truncate(last.map_or(0, |last| last + 1));
    taken
}

impl RepeatedValue {
    fn new(rows: &[usize], read: &[(u32, usize, f64)]) -> Self {
        let values = || rows.iter().map(|row| read[*row].2);
        let size = values().map(|value| value * value);
        Self {
            kind: read[rows[0]].1,
            size: size.fold(f64::INFINITY, f64::min),
            step: smallest_step(values()),
            rows: rows.to_vec(),
        }
    }

    fn scatter(&self, residuals: &[f64]) -> ScatterCase {
        let count = self.rows.len() as f64;
        let own = || self.rows.iter().map(|row| residuals[*row]);
        let mean = own().sum::<f64>() / count;
        let squares: f64 = own().map(|value| (value - mean).powi(2)).sum();
        let dof = count - 1.0;
        ScatterCase {
            kind: self.kind,
            size: self.size,
            square: squares / dof.max(f64::EPSILON),
            dof,
        }
    }

    /// The value that is farthest from the mean of the others, with its distance; of two the one that is farther from the model.
    fn farthest(&self, residuals: &[f64]) -> (usize, f64) {
        let sum: f64 = self.rows.iter().map(|row| residuals[*row]).sum();
        let others = self.rows.len() as f64 - 1.0;
        let off = |row: usize| residuals[row] - (sum - residuals[row]) / others;
        let rows = self.rows.iter().map(|row| (*row, off(*row)));
        let first = (self.rows[0], off(self.rows[0]));
        rows.fold(first, |best, one| {
            let closer = residuals[one.0].abs() > residuals[best.0].abs();
            let is_pair = self.rows.len() == 2;
            if if is_pair {
                closer
            } else {
                one.1.abs() > best.1.abs()
            } {
                one
            } else {
                best
            }
        })
    }

    /// Variance of that distance over the variance of a value.
    fn share(&self) -> f64 {
        let count = self.rows.len() as f64;
        count / (count - 1.0)
    }
}

/// The value that is farthest from its repeats, measured by the scatter of all other repeats; `None` where these do not scatter.
fn farthest(
    repeats: &[RepeatedValue],
    residuals: &[f64],
    read: &[(u32, usize, f64)],
    posed: &PosedLoadCases,
) -> Option<TestedValue> {
    let (sizes, together) = (sizes(posed), values_of_a_load(posed));
    let cases: Vec<ScatterCase> = repeats.iter().map(|one| one.scatter(residuals)).collect();
    // Two readings of one value differ by a step that neither is meant to show: the variance of rounding is the least.
    let least = |without: Option<usize>| {
        [0, 1].map(|kind| {
            let own = repeats.iter().enumerate();
            let own = own.filter(|(place, one)| one.kind == kind && Some(*place) != without);
            let step = own.map(|(_, one)| one.step).fold(f64::INFINITY, f64::min);
            let step = if step.is_finite() { step } else { 0.0 };
            (step / 12_f64.sqrt()).max(LEAST_SCATTER * sizes[kind])
        })
    };
    let all = scatter_of(&cases, least(None))?;
    let mut places: Vec<usize> = Vec::new();
    for by_scatter in [true, false] {
        let far = |place: usize| {
            let one = &repeats[place];
            let variance = if by_scatter {
                all.variance(one.kind, one.size)
            } else {
                sizes[one.kind].powi(2)
            };
            one.farthest(residuals).1.powi(2) / (variance * one.share())
        };
        let mut order: Vec<(f64, usize)> = (0..repeats.len()).map(|one| (far(one), one)).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        places.extend(order.iter().take(LOOKED_AT).map(|(_, place)| place));
    }
    // Two repeats have one difference, more as many as they are.
    let count = |one: &RepeatedValue| match one.rows.len() {
        2 => 1,
        more => more,
    };
    let tests: usize = repeats.iter().map(count).sum();
    let tested = places.into_iter().filter_map(|place| {
        let one = &repeats[place];
        let others = cases.iter().enumerate();
        let others = others.filter(|(other, _)| *other != place);
        let others: Vec<ScatterCase> = others.map(|(_, case)| *case).collect();
        let scatter = scatter_of(&others, least(Some(place)))?;
        let (row, off) = one.farthest(residuals);
        let standard_error = (scatter.variance(one.kind, one.size) * one.share()).sqrt();
        let others = one.rows.iter().filter(|other| **other != row);
        let far = FarValue {
            kind: one.kind,
            size: one.size,
            off,
            of_itself: one.share(),
        };
        let tested = TestedValue {
            row,
            off,
            standard_error,
            repeats: others.map(|other| read[*other].0).collect(),
            p: far.p_family(&scatter, tests, together),
            joint: None,
        };
        Some(((off / standard_error).abs(), tested))
    });
    let farthest = tested.max_by(|a, b| a.0.total_cmp(&b.0));
    farthest.map(|(_, tested)| tested)
}

/// The value without repeats that the fit to all others contradicts, if nothing else is left that noise does not leave.
///
/// # Errors
/// [`FitError`].
fn improbable(
    model: &LoadCaseModel<'_>,
    fit: &FitOutcome,
) -> Result<Option<TestedValue>, FitError> {
    let posed = model.posed;
    let mut witnesses = vec![false; fit.components.len()];
    let repeats = repeated_rows(posed);
    for rows in repeats.iter().filter(|rows| rows.len() > 1) {
        for row in rows {
            witnesses[*row] = true;
        }
    }
    if witnesses.iter().all(|one| *one) {
        return Ok(None);
    }
    // Displacements and rotations in units of their usual size.
    let sizes = sizes(posed);
    let kinds = kinds(posed);
    let agreement = fit.agreement.as_ref();
    let scatter = agreement.map_or([None; 2], |agreement| agreement.component_sd);
    // What is left of readings without noise is rounding of the arithmetic.
    let is_exact = |kind: usize| scatter[kind].is_some_and(|sd| sd <= LEAST_SCATTER * sizes[kind]);
    if (0..2).any(is_exact) {
        return Ok(None);
    }
    let units = [0, 1].map(|kind| scatter[kind].unwrap_or(sizes[kind]));
    let unit = |row: usize| units[kinds[row]];
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in columns(model, fit)? {
        let white = column.iter().enumerate();
        let white = white.map(|(row, value)| value / unit(row)).collect();
        push_orthonormal(&mut basis, white, LEAST_INDEPENDENT, 0.0);
    }
    let rows = fit.components.iter().zip(&kinds);
    let rows: Vec<(f64, f64)> = rows
        .map(|(one, kind)| {
            let size = (one.predicted / units[*kind]).powi(2);
            ((one.measured - one.predicted) / units[*kind], size)
        })
        .collect();
    let fitted = FittedRows {
        leverage: (0..rows.len()).map(|row| hat(&basis, row, row)).collect(),
        rows,
        kinds,
        basis,
        together: values_of_a_load(posed),
    };
    let mut in_poses: BTreeMap<&PoseId, usize> = BTreeMap::new();
    for one in &fit.components {
        *in_poses.entry(&one.pose).or_default() += 1;
    }
    let others_in_pose = |row: usize| in_poses[&fit.components[row].pose] > 1;
    let mut order: Vec<usize> = (0..fitted.rows.len())
        .filter(|row| !witnesses[*row] && fitted.leverage[*row] < LARGEST_LEVERAGE)
        .filter(|row| others_in_pose(*row))
        .collect();
    let tests = order.len();
    let far = |row: usize| fitted.rows[row].0.abs() / (1.0 - fitted.leverage[row]).sqrt();
    order.sort_by(|a, b| far(*b).total_cmp(&far(*a)));
    order.truncate(LOOKED_AT);
    let tested = order.into_iter().filter_map(|row| {
        let tested = fitted.without(row, tests)?;
        let unit = units[fitted.kinds[row]];
        Some(TestedValue {
            off: tested.off * unit,
            standard_error: tested.standard_error * unit,
            ..tested
        })
    });
    Ok(tested.min_by(|a, b| a.p.total_cmp(&b.p)))
}

/// Derivatives of all rows to what a fit moves and is at no bound, frames among it.
///
/// # Errors
/// [`FitError`].
pub(super) fn columns(
    model: &LoadCaseModel<'_>,
    fit: &FitOutcome,
) -> Result<Vec<Vec<f64>>, FitError> {
    let is_inside =
        |status: &FactorStatus| moves(status) && !matches!(status, FactorStatus::AtBound { .. });
    let Some(frames) = PositionFrames::of(model.robot, model.mechanism, model.posed)? else {
        let basis = Basis::of(model, fit)?;
        let own = basis.free.iter().zip(basis.columns);
        let own = own.filter(|(place, _)| is_inside(&fit.estimates[**place].status));
        return Ok(own.map(|(_, column)| column).collect());
    };
    let free = fit.estimates.iter().filter(|one| is_inside(&one.status));
    let free: Vec<ModelParameter> = free.map(|one| one.parameter.clone()).collect();
    let start = &fit.factors;
    let mechanics = LoadCaseModel { start, ..*model }.mechanics(&free)?;
    let motions = PredictedMotions::of(&mechanics, model.posed, true);
    // Frames that fit the rigid robot nearly best are near enough to those of the fit: rotations between them are small.
    let there = frames.at(&[]);
    let springs = motions.columns.iter();
    let springs = springs.map(|column| frames.column(model.posed, &there, column));
    let of_frames = frames.frame_columns(model.posed, &[], &motions.values);
    Ok(springs.chain(of_frames).collect())
}

/// What a fit leaves, displacements and rotations in units of their scatter.
struct FittedRows {
    /// Residual, and square of the prediction.
    rows: Vec<(f64, f64)>,
    leverage: Vec<f64>,
    kinds: Vec<usize>,
    /// Orthonormal columns of the fit.
    basis: Vec<Vec<f64>>,
    /// Values of one application of a load.
    together: f64,
}

/// Entry of the hat matrix of orthonormal columns.
fn hat(basis: &[Vec<f64>], a: usize, b: usize) -> f64 {
    basis.iter().map(|one| one[a] * one[b]).sum()
}

impl FittedRows {
    /// The test of a row against the fit without it; `None` if noise does as much, or leaves less of the others.
    fn without(&self, row: usize, tests: usize) -> Option<TestedValue> {
        let (residual, size) = self.rows[row];
        let free = 1.0 - self.leverage[row];
        // Residuals and leverages of the others in that fit (Cook & Weisberg, Residuals and Influence in Regression, 1982, section 2.2).
        let others = (0..self.rows.len()).filter(|other| *other != row);
        let others: Vec<FarValue> = others
            .map(|other| {
                let common = hat(&self.basis, row, other);
                let (own, size) = self.rows[other];
                FarValue {
                    kind: self.kinds[other],
                    size,
                    off: own + common * residual / free,
                    of_itself: 1.0 - self.leverage[other] - common * common / free,
                }
            })
            .collect();
        let case = |one: &FarValue| {
            let dof = one.of_itself.max(f64::EPSILON);
            ScatterCase {
                kind: one.kind,
                size: one.size,
                square: one.off.powi(2) / dof,
                dof,
            }
        };
        let cases: Vec<ScatterCase> = others.iter().map(case).collect();
        let scatter = scatter_of(&cases, [LEAST_SCATTER; 2])?;
        let standard_error = (scatter.variance(self.kinds[row], size) / free).sqrt();
        let off = residual / free;
        let far = FarValue {
            kind: self.kinds[row],
            size,
            off,
            of_itself: 1.0 / free,
        };
        let p = far.p_family(&scatter, tests, self.together);
        let chances = others.iter();
        let chances = chances.map(|one| one.p_family(&scatter, others.len(), self.together));
        let next = others.iter().map(|one| one.standard_errors(&scatter));
        let stands_out = chances.fold(1.0, f64::min) > REST_IS_NOISE
            || far.standard_errors(&scatter) >= STANDS_ALONE * next.fold(0.0, f64::max);
        (stands_out && p <= LONE_VALUE_LEVEL).then_some(TestedValue {
            row,
            off,
            standard_error,
            repeats: Vec::new(),
            p,
            joint: None,
        })
    }
}
