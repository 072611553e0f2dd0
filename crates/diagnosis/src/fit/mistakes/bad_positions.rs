//! Absolute positions that the fit to all others contradicts: a coordinate, a target, or every position of a pose.
//!
//! What is farthest off is taken away, and the rest is fitted again, until it is noise: so several bad positions do not hide each other (backward
//! search: Simonoff, Journal of the Royal Statistical Society C 40 (1991), with groups of rows by Cook & Weisberg, Residuals and Influence in
//! Regression, 1982, section 3.2).

use std::collections::BTreeMap;
use std::iter::repeat_n;

use stiffbench_beams::robot::{JointMotion, Pose};
use stiffbench_numeric::statistics::f_upper_tail;

use super::bad_values::{LONE_VALUE_LEVEL, MOST, bad_value};
use super::moved_columns::fitted_rows;
use super::tested_values::{REST_IS_NOISE, STANDS_ALONE};
use crate::fit::load_cases::fit::fit_load_cases;
use crate::fit::load_cases::posed::PosedLoadCases;
use crate::fit::load_cases::problem::LoadCaseModel;
use crate::fit::{FitError, FitOptions, FitOutcome};
use crate::mismatch::{BadReading, OtherJointValue};
use crate::search::{DeletedRows, FittedRows, chance_of_any, dot};

/// Rows that determine more than this share of their own prediction have no witness (1).
const LARGEST_SHARE: f64 = 0.75;

/// Standard errors within which a position agrees with another value of a joint.
const AGREES: f64 = 4.0;

/// Steps to the value of a joint with which a position agrees: each squares the error.
const STEPS: usize = 20;

/// Rows that are off together.
struct OffGroup {
    /// By their places among all rows.
    rows: Vec<usize>,
    deleted: DeletedRows,
    /// Chance that noise takes any group as far.
    p: f64,
}

impl OffGroup {
    /// Squares of a row.
    fn mean_square(&self) -> f64 {
        self.deleted.squares / self.rows.len() as f64
    }
}

/// What a fit leaves of its rows.
struct Left {
    /// Places of the rows among all.
    places: Vec<usize>,
    fitted: FittedRows,
    /// Each coordinate, the coordinates of each target, those of each pose: by their places among these rows.
    groups: Vec<Vec<usize>>,
}

impl Left {
    /// # Arguments
    /// - `all`: the load cases of which the model has some.
    fn of(
        model: &LoadCaseModel<'_>,
        fit: &FitOutcome,
        all: &PosedLoadCases,
        places: Vec<usize>,
    ) -> Result<Self, FitError> {
        let cases = all.cases.iter().enumerate();
        let of_rows = cases.flat_map(|(case, one)| {
            let components = one.components.len();
            repeat_n((case, one.label), components)
        });
        let of_rows: Vec<(usize, usize)> = of_rows.collect();
        let mut groups: BTreeMap<(u8, usize), Vec<usize>> = BTreeMap::new();
        for (row, place) in places.iter().enumerate() {
            let (case, pose) = of_rows[*place];
            for key in [(0, row), (1, case), (2, pose)] {
                groups.entry(key).or_default().push(row);
            }
        }
        let mut groups: Vec<Vec<usize>> = groups.into_values().collect();
        // Of a pose with one target both are the same.
        groups.sort();
        groups.dedup();
        Ok(Self {
            places,
            fitted: fitted_rows(model, fit, [1.0; 2])?,
            groups,
        })
    }

    /// Chance that noise takes any group as far as one of so many rows.
    fn chance(&self, mean_square: f64, rows: usize, variance: f64, dof: f64) -> f64 {
        let p = f_upper_tail(mean_square / variance, rows as f64, dof).unwrap_or(1.0);
        chance_of_any(p, self.groups.len() as f64)
    }

    /// The group that is farther off than any other for its size; `None` if none has a witness.
    fn farthest(&self) -> Option<OffGroup> {
        let (n, whole) = (self.places.len() as f64, self.fitted.squares());
        let tested = self.groups.iter().filter_map(|rows| {
            let dof = self.fitted.dof_without(rows.len())?;
            let deleted = self.fitted.without(rows, LARGEST_SHARE)?;
            let rest = (whole - deleted.squares).max(f64::MIN_POSITIVE);
            let mut group = OffGroup {
                rows: rows.iter().map(|row| self.places[*row]).collect(),
                deleted,
                p: 1.0,
            };
            group.p = self.chance(group.mean_square(), rows.len(), rest / dof, dof);
            // Information criterion of Schwarz, Annals of Statistics 6 (1978): so many numbers more say so much more.
            let score = n * (rest / whole).ln() + rows.len() as f64 * n.ln();
            Some((score, group))
        });
        let farthest = tested.min_by(|a, b| a.0.total_cmp(&b.0));
        farthest.map(|(_, group)| group)
    }
}

/// Positions that the fit to all others contradicts, in the order of the table; none beside held-out poses.
///
/// # Errors
/// [`FitError`]: those of a fit.
pub(super) fn bad_positions(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
    fit: &FitOutcome,
) -> Result<Vec<BadReading>, FitError> {
    let posed = model.posed;
    if options.train.is_some() {
        return Ok(Vec::new());
    }
    let mut taken: Vec<OffGroup> = Vec::new();
    let all = 0..posed.component_count();
    let mut left = Left::of(model, fit, posed, all.clone().collect())?;
    let mut last = fit.clone();
    // How far off the next is that is not taken, squares of it a row.
    let mut next = 0.0;
    while let Some(farthest) = left.farthest()
        && farthest.p <= REST_IS_NOISE
    {
        if taken.len() == MOST {
            next = farthest.mean_square();
            break;
        }
        taken.push(farthest);
        let rows: Vec<usize> = taken.iter().flat_map(|one| one.rows.clone()).collect();
        let others = posed.without_rows(&rows);
        let others = model.under(&others);
        // Not enough are left, or they show no parameter any more.
        let Ok(again) = fit_load_cases(&others, options) else {
            taken.pop();
            break;
        };
        let places = all.clone().filter(|row| !rows.contains(row));
        left = Left::of(&others, &again, posed, places.collect())?;
        last = again;
    }
    // What is left is noise, or those stand alone: what a model lacks spreads over many.
    if next > 0.0 {
        let sizes = taken.iter().map(OffGroup::mean_square);
        let sizes: Vec<f64> = sizes.chain([next]).collect();
        let stands = |pair: &[f64]| pair[0] >= STANDS_ALONE * STANDS_ALONE * pair[1];
        let count = sizes.windows(2).rposition(stands);
        taken.truncate(count.map_or(0, |place| place + 1));
    }
    let dof = left.fitted.dof_without(0).unwrap_or(1.0);
    let variance = left.fitted.squares() / dof;
    for one in &mut taken {
        one.p = left.chance(one.mean_square(), one.rows.len(), variance, dof);
    }
    taken.retain(|one| one.p <= LONE_VALUE_LEVEL);
    let left_m = model.left_by(&last)?;
    let mut bad = Vec::new();
    for group in &taken {
        let joint = other_joint_value(model, &last, &group.rows, variance.sqrt());
        let rows = group.rows.iter().zip(&group.deleted.variances);
        let own = rows.filter_map(|(&row, of_itself)| {
            let off = (left_m[row], (variance * of_itself).sqrt());
            let value = bad_value(posed, row, off, group.p)?;
            Some(BadReading {
                joint: joint.clone(),
                ..value
            })
        });
        let mut own: Vec<BadReading> = own.collect();
        // One coordinate may have hidden in a group as long as it drew the fit to itself.
        let is_off = |one: &BadReading| (one.value_m - one.expected_m).abs() > AGREES * one.u_m;
        if own.iter().filter(|one| is_off(one)).count() == 1 {
            own.retain(is_off);
        }
        bad.extend(own);
    }
    bad.sort_by_key(|one| one.reading);
    Ok(bad)
}

/// The value of one joint with which all coordinates of some rows of a pose agree; `None` of single coordinates.
///
/// # Arguments
/// - `fit`: to other rows.
/// - `sd_m`: of a row, m.
fn other_joint_value(
    model: &LoadCaseModel<'_>,
    fit: &FitOutcome,
    rows: &[usize],
    sd_m: f64,
) -> Option<OtherJointValue> {
    let (robot, posed, start) = (model.robot, model.posed, &fit.factors);
    if rows.len() < 2 {
        return None;
    }
    let frames = &fit.frames.as_ref()?.frames;
    let mechanics = LoadCaseModel { start, ..*model }.mechanics(&[]).ok()?;
    let all: Vec<_> = posed.rows().collect();
    let nominal = &posed.poses[all[*rows.first()?].0.pose];
    let misfit = |pose: &Pose| -> Option<Vec<f64>> {
        let tool = robot.end_pose(model.mechanism, pose).ok()?;
        let own = rows.iter().map(|row| {
            let (case, read) = all[*row];
            let moved = mechanics.pose(case.pose).motion(case.load);
            frames.position_m(&tool, &moved)[read.axis().index()] - read.value
        });
        Some(own.collect())
    };
    let at = |variable: usize, value: f64| {
        let mut pose = nominal.clone();
        pose.angles_deg[variable] = value;
        misfit(&pose)
    };
    let moving = (0..robot.variables.len()).filter(|variable| robot.moves_tool(*variable));
    let tried = moving.filter_map(|variable| {
        let (stated, step) = (nominal.angles_deg[variable], 1e-4);
        let mut value = stated;
        for _ in 0..STEPS {
            let (now, then) = (at(variable, value)?, at(variable, value + step)?);
            let slope: Vec<f64> = then.iter().zip(&now).map(|(b, a)| (b - a) / step).collect();
            let square = dot(&slope, &slope);
            if square == 0.0 {
                return None;
            }
            value -= dot(&slope, &now) / square;
        }
        let left = at(variable, value)?;
        let agrees = left.iter().all(|left| left.abs() <= AGREES * sd_m);
        agrees.then_some((dot(&left, &left), variable, stated, value))
    });
    let (_, variable, stated, agrees) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let named = &robot.variables[variable];
    Some(OtherJointValue {
        variable: named.name.clone(),
        stated,
        agrees,
        unit: match named.motion {
            JointMotion::Turns => "deg",
            JointMotion::Slides => "m",
        },
    })
}
