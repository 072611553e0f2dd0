//! Absolute positions that are off together: a coordinate, a target, or every position of a pose; and the value of a joint with which they agree.

use std::collections::BTreeMap;

use stiffbench_beams::robot::{JointMotion, Pose};

use crate::fit::FitOutcome;
use crate::fit::load_cases::posed::PosedLoadCases;
use crate::fit::load_cases::problem::LoadCaseModel;
use crate::mismatch::OtherJointValue;
use crate::search::dot;

/// Standard errors within which a position agrees with another value of a joint.
pub(super) const AGREES: f64 = 4.0;

/// Steps to the value of a joint with which a position agrees: each squares the error.
const STEPS: usize = 20;

/// Each coordinate, the coordinates of each target, those of each pose: by their places among all rows.
pub(super) fn groups_of_positions(posed: &PosedLoadCases) -> Vec<Vec<usize>> {
    let cases = posed.cases.iter().enumerate();
    let of_rows =
        cases.flat_map(|(case, one)| one.components.iter().map(move |_| (case, one.label)));
    let mut groups: BTreeMap<(u8, usize), Vec<usize>> = BTreeMap::new();
    for (row, (case, pose)) in of_rows.enumerate() {
        for key in [(0, row), (1, case), (2, pose)] {
            groups.entry(key).or_default().push(row);
        }
    }
    let mut groups: Vec<Vec<usize>> = groups.into_values().collect();
    // Of a pose with one target both are the same.
    groups.sort();
    groups.dedup();
    groups
}

/// The value of one joint with which all coordinates of some rows of a pose agree; `None` of single coordinates.
///
/// # Arguments
/// - `fit`: to other rows.
/// - `sd_m`: of a row, m.
pub(super) fn other_joint_value(
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
