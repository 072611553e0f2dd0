//! What readings of a cell may be without being noise: the mean of every load step.

use std::ops::Range;

use stiffbench_units_and_text::test_point::Branch;

use super::observations::Observations;
use crate::search::constants::SAME_STEP;

/// Fixed part of one cell: what may be anything without being noise.
pub(super) struct FixedPart {
    pub(super) columns: Vec<Vec<f64>>,
    pub(super) readings: Range<usize>,
}

/// Indicator of each step (and hold) of a cell with several runs, and the force, which differs from its target from run to run; in a
/// cell with one run a smooth curve with a loop.
pub(super) fn fixed_part(observations: &Observations, cell: usize) -> FixedPart {
    let cell = &observations.cells[cell];
    let readings = cell.readings.clone();
    let loads = &observations.loads[readings.clone()];
    let details = &observations.readings[readings.clone()];
    let force_scale = loads
        .iter()
        .map(|load| load.force_n.abs())
        .fold(0.0, f64::max)
        .max(1e-12);
    let force: Vec<f64> = loads
        .iter()
        .map(|load| load.force_n / force_scale)
        .collect();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut keys: Vec<(u32, u32)> = Vec::new();
    let key = |place: usize| (loads[place].step, details[place].hold_number);
    for place in 0..loads.len() {
        if !keys.contains(&key(place)) {
            keys.push(key(place));
        }
    }
    if cell.runs.len() > 1 && within_steps(&keys, &force, key) < SAME_STEP {
        for wanted in &keys {
            columns.push(
                (0..loads.len())
                    .map(|place| f64::from(u8::from(key(place) == *wanted)))
                    .collect(),
            );
        }
        // Where forces repeat exactly, the force is already in the span of the steps.
        let spread = within_steps(&keys, &force, key);
        if spread > 1e-6 {
            columns.push(force);
        }
    } else {
        let unloading: Vec<f64> = details
            .iter()
            .map(|reading| f64::from(u8::from(reading.branch == Branch::Unloading)))
            .collect();
        let product =
            |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<f64>>();
        let square = product(&force, &force);
        let all = [
            vec![1.0; force.len()],
            force.clone(),
            square,
            unloading.clone(),
            product(&unloading, &force),
        ];
        for column in all {
            if independent(&columns, &column) {
                columns.push(column);
            }
        }
    }
    FixedPart { columns, readings }
}

/// Root mean square of the force about its mean in each step.
fn within_steps(keys: &[(u32, u32)], force: &[f64], key: impl Fn(usize) -> (u32, u32)) -> f64 {
    let mut squares = 0.0;
    for wanted in keys {
        let members: Vec<f64> = (0..force.len())
            .filter(|&place| key(place) == *wanted)
            .map(|place| force[place])
            .collect();
        let mean = members.iter().sum::<f64>() / members.len().max(1) as f64;
        squares += members.iter().map(|f| (f - mean).powi(2)).sum::<f64>();
    }
    (squares / force.len().max(1) as f64).sqrt()
}

/// Whether a column adds something to those already there.
fn independent(columns: &[Vec<f64>], column: &[f64]) -> bool {
    let mut rest = column.to_vec();
    let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
    let whole = length(&rest);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for other in columns {
        let mut vector = other.clone();
        for b in &basis {
            remove(&mut vector, b);
        }
        let norm = length(&vector).sqrt();
        if norm > 0.0 {
            for x in &mut vector {
                *x /= norm;
            }
            remove(&mut rest, &vector);
            basis.push(vector);
        }
    }
    length(&rest) > 1e-8 * whole && whole > 0.0
}

fn remove(vector: &mut [f64], unit: &[f64]) {
    let product: f64 = vector.iter().zip(unit).map(|(a, b)| a * b).sum();
    for (value, u) in vector.iter_mut().zip(unit) {
        *value -= product * u;
    }
}
