//! What readings of a series may be without being noise: the mean of every load step of each gauge.

use std::collections::BTreeMap;
use std::ops::Range;

use stiffbench_units_and_text::test_point::Branch;

use super::observations::Observations;
use crate::search::constants::SAME_STEP;

/// Fixed part of one series, cells whose readings have noise in common: what may be anything without being noise.
pub(super) struct FixedPart {
    pub(super) readings: Range<usize>,
    /// For each reading the number of its step, whose mean is free; empty where no step has a mean of its own.
    pub(super) step_of: Vec<usize>,
    pub(super) steps: usize,
    /// Further columns.
    pub(super) further: Vec<Vec<f64>>,
}

impl FixedPart {
    /// All columns: the indicators of the steps, then the further ones.
    pub(super) fn columns(&self) -> Vec<Vec<f64>> {
        let of_step = |step: usize| {
            let is_of_step = |other: &usize| f64::from(u8::from(*other == step));
            self.step_of.iter().map(is_of_step).collect()
        };
        let steps = (0..self.steps).map(of_step);
        steps.chain(self.further.iter().cloned()).collect()
    }

    /// Values of the cell's readings without their means over each step: what the steps leave free makes no difference, but costs digits.
    pub(super) fn centred(&self, mut values: Vec<f64>) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.steps];
        for (value, step) in values.iter().zip(&self.step_of) {
            sums[*step].0 += value;
            sums[*step].1 += 1.0;
        }
        for (value, step) in values.iter_mut().zip(&self.step_of) {
            *value -= sums[*step].0 / sums[*step].1;
        }
        values
    }
}

impl FixedPart {
    /// Of the cells of a series.
    pub(super) fn of_series(observations: &Observations, cells: Range<usize>) -> Self {
        let mut cells = cells.map(|cell| fixed_part(observations, cell));
        let Some(mut series) = cells.next() else {
            return Self {
                readings: 0..0,
                step_of: Vec::new(),
                steps: 0,
                further: Vec::new(),
            };
        };
        for cell in cells {
            series.add(cell);
        }
        series
    }

    /// Adds the cell that follows.
    fn add(&mut self, mut cell: Self) {
        // Indicators of steps are for all rows or for none.
        if self.step_of.is_empty() != cell.step_of.is_empty() {
            self.spell_out();
            cell.spell_out();
        }
        let (own, added) = (self.readings.len(), cell.readings.len());
        let steps = self.steps;
        self.step_of
            .extend(cell.step_of.iter().map(|step| step + steps));
        self.steps += cell.steps;
        for column in &mut self.further {
            column.resize(own + added, 0.0);
        }
        self.further.extend(cell.further.into_iter().map(|column| {
            let mut whole = vec![0.0; own];
            whole.extend(column);
            whole
        }));
        self.readings.end = cell.readings.end;
    }

    /// Makes columns of the indicators.
    fn spell_out(&mut self) {
        self.further = self.columns();
        self.step_of.clear();
        self.steps = 0;
    }
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
    let mut part = FixedPart {
        readings,
        step_of: Vec::new(),
        steps: 0,
        further: Vec::new(),
    };
    let mut numbers: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (load, detail) in loads.iter().zip(details) {
        let next = numbers.len();
        let number = numbers
            .entry((load.step, detail.hold_number))
            .or_insert(next);
        part.step_of.push(*number);
    }
    part.steps = numbers.len();
    let within_steps = part.centred(force.clone());
    let squares: f64 = within_steps.iter().map(|f| f * f).sum();
    let spread = (squares / force.len().max(1) as f64).sqrt();
    if cell.runs.len() > 1 && spread < SAME_STEP {
        // Where forces repeat exactly, the force is already in the span of the steps.
        if spread > 1e-6 {
            part.further.push(within_steps);
        }
    } else {
        part.step_of.clear();
        part.steps = 0;
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
            if independent(&part.further, &column) {
                part.further.push(column);
            }
        }
    }
    part
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
