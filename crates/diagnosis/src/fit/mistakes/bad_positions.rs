//! Absolute positions that the fit to all others contradicts: a coordinate, a target, or every position of a pose.
//!
//! What is farthest off is taken away, and the rest is fitted again, until it is noise: so several bad positions do not hide each other (backward
//! search: Simonoff, Journal of the Royal Statistical Society C 40 (1991), with groups of rows by Cook & Weisberg, Residuals and Influence in
//! Regression, 1982, section 3.2).

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use stiffbench_beams::robot::{JointMotion, Pose, TrackerFrames};
use stiffbench_numeric::statistics::f_upper_tail;

use super::bad_values::{
    LONE_VALUE_LEVEL, MOST, REST_IS_NOISE, STANDS_ALONE, TestedValue, columns, named,
};
use crate::fit::load_cases::fit::fit_load_cases;
use crate::fit::load_cases::frames::PositionFrames;
use crate::fit::load_cases::posed::PosedLoadCases;
use crate::fit::load_cases::prediction::PredictedMotions;
use crate::fit::load_cases::problem::LoadCaseModel;
use crate::fit::{FitError, FitOptions, FitOutcome};
use crate::mismatch::{BadReading, OtherJointValue};
use crate::search::constants::LEAST_INDEPENDENT;
use crate::search::{dot, push_orthonormal};

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
    /// Variances of what the fit to the others leaves of them, over that of a row.
    variances: Vec<f64>,
    /// Squares that they add to those of the fit, m².
    squares: f64,
    /// Chance that noise takes any group as far.
    p: f64,
}

/// What a fit leaves of its rows, all of one scatter.
struct Left {
    /// Places of the rows among all.
    places: Vec<usize>,
    residuals_m: Vec<f64>,
    /// Orthonormal columns of the fit.
    columns: Vec<Vec<f64>>,
    squares: f64,
}

impl Left {
    fn of(
        model: &LoadCaseModel<'_>,
        fit: &FitOutcome,
        places: Vec<usize>,
    ) -> Result<Self, FitError> {
        let mut orthonormal = Vec::new();
        for column in columns(model, fit)? {
            push_orthonormal(&mut orthonormal, column, LEAST_INDEPENDENT, 0.0);
        }
        let residuals_m = fit.residuals();
        Ok(Self {
            places,
            squares: dot(&residuals_m, &residuals_m),
            residuals_m,
            columns: orthonormal,
        })
    }

    /// Degrees of freedom without some rows.
    fn dof_without(&self, rows: usize) -> Option<f64> {
        let dof = self.places.len().checked_sub(self.columns.len() + rows)?;
        (dof > 0).then_some(dof as f64)
    }

    /// Variance of a row.
    fn variance(&self) -> f64 {
        self.squares / self.dof_without(0).unwrap_or(1.0)
    }

    /// The group that is farther off than any other for its size; `None` if none has a witness.
    fn farthest(&self, posed: &PosedLoadCases) -> Option<OffGroup> {
        let groups = groups(posed, &self.places);
        let tests = groups.len() as f64;
        let n = self.places.len() as f64;
        let mut best: Option<(f64, OffGroup)> = None;
        for rows in groups {
            let count = rows.len();
            let Some(dof) = self.dof_without(count) else {
                continue;
            };
            let hat = DMatrix::from_fn(count, count, |i, j| {
                let products = self.columns.iter();
                products.map(|one| one[rows[i]] * one[rows[j]]).sum::<f64>()
            });
            let free = DMatrix::identity(count, count) - hat;
            if free.clone().symmetric_eigenvalues().min() < 1.0 - LARGEST_SHARE {
                continue;
            }
            let Some(inverse) = free.try_inverse() else {
                continue;
            };
            let own = DVector::from_fn(count, |i, _| self.residuals_m[rows[i]]);
            let off = &inverse * &own;
            let squares = own.dot(&off);
            let rest = (self.squares - squares).max(f64::MIN_POSITIVE);
            // Information criterion of Schwarz, Annals of Statistics 6 (1978): so many numbers more say so much more.
            let score = n * (rest / self.squares).ln() + count as f64 * n.ln();
            if best.as_ref().is_some_and(|(least, _)| *least <= score) {
                continue;
            }
            let ratio = squares / count as f64 / (rest / dof);
            let p = f_upper_tail(ratio, count as f64, dof).unwrap_or(1.0);
            let group = OffGroup {
                variances: inverse.diagonal().iter().copied().collect(),
                rows: rows.iter().map(|row| self.places[*row]).collect(),
                squares,
                p: (p * tests).min(1.0),
            };
            best = Some((score, group));
        }
        best.map(|(_, group)| group)
    }
}

/// Each coordinate, the coordinates of each target, those of each pose with several targets: by their places among some rows.
fn groups(posed: &PosedLoadCases, places: &[usize]) -> Vec<Vec<usize>> {
    let cases = posed.cases.iter().enumerate();
    let of_rows = cases.flat_map(|(number, case)| case.components.iter().map(move |_| number));
    let of_rows: Vec<usize> = of_rows.collect();
    let (mut targets, mut poses) = (BTreeMap::new(), BTreeMap::new());
    for (row, place) in places.iter().enumerate() {
        let case = of_rows[*place];
        targets.entry(case).or_insert_with(Vec::new).push(row);
        let label = posed.cases[case].label;
        poses.entry(label).or_insert_with(Vec::new).push(row);
    }
    let mut groups: Vec<Vec<usize>> = (0..places.len()).map(|row| vec![row]).collect();
    for group in targets.into_values().chain(poses.into_values()) {
        if group.len() > 1 {
            groups.push(group);
        }
    }
    // Of a pose with one target both are the same.
    groups.sort();
    groups.dedup();
    groups
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
    let mut left = Left::of(model, fit, (0..posed.component_count()).collect())?;
    let mut last = fit.clone();
    // How far off the next is that is not taken, squares of it a row.
    let mut next = 0.0;
    while let Some(farthest) = left.farthest(posed)
        && farthest.p <= REST_IS_NOISE
    {
        if taken.len() == MOST {
            next = farthest.squares / farthest.rows.len() as f64;
            break;
        }
        taken.push(farthest);
        let rows: Vec<usize> = taken.iter().flat_map(|one| one.rows.clone()).collect();
        let others = posed.without_rows(&rows);
        let others = LoadCaseModel {
            posed: &others,
            ..*model
        };
        // Not enough are left, or they show no parameter any more.
        let Ok(again) = fit_load_cases(&others, options) else {
            taken.pop();
            break;
        };
        let places = (0..posed.component_count()).filter(|row| !rows.contains(row));
        left = Left::of(&others, &again, places.collect())?;
        last = again;
    }
    // What is left is noise, or those stand alone: what a model lacks spreads over many.
    if next > 0.0 {
        let sizes = taken.iter().map(|one| one.squares / one.rows.len() as f64);
        let sizes: Vec<f64> = sizes.chain([next]).collect();
        let stands = |pair: &[f64]| pair[0] >= STANDS_ALONE * STANDS_ALONE * pair[1];
        let count = sizes.windows(2).rposition(stands);
        taken.truncate(count.map_or(0, |place| place + 1));
    }
    let (variance, dof) = (left.variance(), left.dof_without(0).unwrap_or(1.0));
    let tests = groups(posed, &left.places).len() as f64;
    let chance = |one: &OffGroup| {
        let count = one.rows.len() as f64;
        let p = f_upper_tail(one.squares / count / variance, count, dof).unwrap_or(1.0);
        (p * tests).min(1.0)
    };
    taken.retain(|one| chance(one) <= LONE_VALUE_LEVEL);
    if taken.is_empty() {
        return Ok(Vec::new());
    }
    let Some(seen) = SeenPositions::of(model, &last)? else {
        return Ok(Vec::new());
    };
    let measured = model.measured();
    let mut bad = Vec::new();
    for group in &taken {
        let joint = seen.other_joint_value(model, &group.rows, variance.sqrt());
        let rows = group.rows.iter().zip(&group.variances);
        let mut own: Vec<TestedValue> = rows
            .map(|(&row, of_itself)| TestedValue {
                row,
                off: measured[row] - seen.predicted_m[row],
                standard_error: (variance * of_itself).sqrt(),
                repeats: Vec::new(),
                p: chance(group),
                joint: joint.clone(),
            })
            .collect();
        // One coordinate may have hidden in a group as long as it drew the fit to itself.
        let is_off = |one: &TestedValue| one.off.abs() > AGREES * one.standard_error;
        if own.iter().filter(|one| is_off(one)).count() == 1 {
            own.retain(is_off);
        }
        bad.extend(own);
    }
    Ok(named(posed, bad))
}

/// What a fit says of every position, those that it left out among them.
struct SeenPositions {
    frames: TrackerFrames,
    /// Motion of the tool in each load case.
    motions: Vec<[f64; 6]>,
    predicted_m: Vec<f64>,
}

impl SeenPositions {
    /// `None` without positions.
    fn of(model: &LoadCaseModel<'_>, fit: &FitOutcome) -> Result<Option<Self>, FitError> {
        let (robot, mechanism, posed) = (model.robot, model.mechanism, model.posed);
        let start = &fit.factors;
        let mechanics = LoadCaseModel { start, ..*model }.mechanics(&[])?;
        let motions = PredictedMotions::of(&mechanics, posed, false).values;
        let positions = PositionFrames::of(robot, mechanism, posed)?;
        let frames = fit.frames.as_ref().map(|fitted| fitted.frames);
        let both = positions.zip(frames);
        Ok(both.map(|(positions, frames)| Self {
            predicted_m: positions.rows(posed, &frames, &motions),
            frames,
            motions,
        }))
    }

    /// The value of one joint with which all coordinates of some rows of a pose agree; `None` of single coordinates.
    fn other_joint_value(
        &self,
        model: &LoadCaseModel<'_>,
        rows: &[usize],
        sd_m: f64,
    ) -> Option<OtherJointValue> {
        let (robot, posed) = (model.robot, model.posed);
        if rows.len() < 2 {
            return None;
        }
        let cases = posed.cases.iter().enumerate();
        let all: Vec<(usize, usize, f64)> = cases
            .flat_map(|(number, case)| {
                let read = case.components.iter();
                read.map(move |read| (number, read.axis().index(), read.value))
            })
            .collect();
        let first = &posed.cases[all[*rows.first()?].0];
        let nominal = &posed.poses[first.pose];
        let misfit = |pose: &Pose| -> Option<Vec<f64>> {
            let tool = robot.end_pose(model.mechanism, pose).ok()?;
            let own = rows.iter().map(|row| {
                let (case, axis, read_m) = all[*row];
                self.frames.position_m(&tool, &self.motions[case])[axis] - read_m
            });
            Some(own.collect())
        };
        let at = |variable: usize, value: f64| {
            let mut pose = nominal.clone();
            pose.angles_deg[variable] = value;
            pose
        };
        let moving = (0..robot.variables.len()).filter(|variable| robot.moves_tool(*variable));
        let tried = moving.filter_map(|variable| {
            let (stated, step) = (nominal.angles_deg[variable], 1e-4);
            let mut value = stated;
            for _ in 0..STEPS {
                let now = misfit(&at(variable, value))?;
                let then = misfit(&at(variable, value + step))?;
                let slope: Vec<f64> = then.iter().zip(&now).map(|(b, a)| (b - a) / step).collect();
                let square = dot(&slope, &slope);
                if square == 0.0 {
                    return None;
                }
                value -= dot(&slope, &now) / square;
            }
            let left = misfit(&at(variable, value))?;
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
}
