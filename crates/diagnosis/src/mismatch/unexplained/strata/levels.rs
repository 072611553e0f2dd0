//! Which readings of a cell have the same load, whatever the order in which the loads came.

use std::collections::BTreeMap;

use crate::mismatch::observed::Observations;
use crate::search::{RowVector, largest};
use stiffbench_units_and_text::test_point::Branch;

/// Forces closer than this share of the usual distance between loads are one level (1). By judgement (f10797f).
const ONE_LEVEL: f64 = 0.3;

/// Forces closer than this share of the largest are one level in any case (1): no jack is set more closely. By judgement (f10797f).
const SAME_FORCE: f64 = 0.01;

/// For each reading of a cell the index of its level of load; levels count up with the force.
///
/// The levels are those of the longest run's loading branch, and what is far from all of these; every reading belongs to the nearest. A step number would not do: in a
/// shuffled order the same step is another load in every run, and unloading goes on counting.
pub(super) fn levels(observations: &Observations, cell: usize) -> Vec<usize> {
    let cell = &observations.cells[cell];
    let force = |reading: usize| observations.loads[reading].force_n;
    let longest = observations.runs[cell.runs.clone()]
        .iter()
        .max_by_key(|run| run.readings.len());
    let Some(longest) = longest else {
        return Vec::new();
    };
    let mut forces: Vec<f64> = longest
        .readings
        .clone()
        .filter(|&reading| observations.readings[reading].branch == Branch::Loading)
        .map(force)
        .collect();
    if forces.is_empty() {
        forces.extend(longest.readings.clone().map(force));
    }
    forces.sort_by(f64::total_cmp);
    let mut gaps: Vec<f64> = forces.windows(2).map(|pair| pair[1] - pair[0]).collect();
    gaps.sort_by(f64::total_cmp);
    let usual = gaps.get(gaps.len() / 2).copied().unwrap_or(0.0);
    let largest_n = largest(&forces);
    let tolerance_n = (ONE_LEVEL * usual).max(SAME_FORCE * largest_n);
    let mut levels: Vec<f64> = Vec::new();
    for force in forces {
        if levels.last().is_none_or(|last| force - last > tolerance_n) {
            levels.push(force);
        }
    }
    // Loads that the longest run meets on the other branch only, or not at all.
    for reading in cell.readings.clone() {
        if levels
            .iter()
            .all(|level| (force(reading) - level).abs() > tolerance_n)
        {
            levels.push(force(reading));
        }
    }
    levels.sort_by(f64::total_cmp);
    cell.readings
        .clone()
        .map(|reading| {
            let distance = |level: &f64| (force(reading) - level).abs();
            let nearest = levels
                .iter()
                .enumerate()
                .min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
            nearest.map_or(0, |(place, _)| place)
        })
        .collect()
}

/// Columns of ones, one for each key that occurs, in the order of the keys.
///
/// # Arguments
/// - `first`: the first reading.
/// - `keys`: of it and those that follow.
pub(super) fn indicators<K: Ord>(
    first: usize,
    keys: impl Iterator<Item = Option<K>>,
) -> Vec<RowVector> {
    let mut columns: BTreeMap<K, RowVector> = BTreeMap::new();
    for (reading, key) in (first..).zip(keys) {
        let Some(key) = key else { continue };
        let column = columns.entry(key).or_insert_with(|| RowVector {
            first: reading,
            values: Vec::new(),
        });
        column.values.resize(reading - column.first, 0.0);
        column.values.push(1.0);
    }
    columns.into_values().collect()
}
