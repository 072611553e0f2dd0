//! What readings of a series may be without being noise: the mean of every load step of each gauge.

use std::collections::BTreeMap;
use std::ops::Range;

use stiffbench_units_and_text::test_point::Branch;

use crate::mismatch::observed::{Observations, about_means};
use crate::search::constants::LEAST_INDEPENDENT;
use crate::search::{dot, largest, push_orthonormal};

/// Scatter of forces within a load step, as a share of the largest force, above which repeats of the step are not the same load (1). By
/// judgement (750d6b5).
const SAME_STEP: f64 = 0.05;

/// Fixed part of one series, cells whose readings have noise in common: what may be anything without being noise.
#[derive(Default)]
pub(crate) struct FixedPart {
    pub(crate) readings: Range<usize>,
    /// For each reading the number of its step, whose mean is free; empty where no step has a mean of its own.
    pub(crate) step_of: Vec<usize>,
    pub(crate) steps: usize,
    /// Further columns.
    pub(crate) further: Vec<Vec<f64>>,
}

impl FixedPart {
    /// All columns: the indicators of the steps, then the further ones.
    pub(crate) fn columns(&self) -> Vec<Vec<f64>> {
        let of_step = |step: usize| {
            let is_of_step = |other: &usize| f64::from(u8::from(*other == step));
            self.step_of.iter().map(is_of_step).collect()
        };
        let steps = (0..self.steps).map(of_step);
        steps.chain(self.further.iter().cloned()).collect()
    }

    /// Values of the cell's readings without their means over each step: what the steps leave free makes no difference, but costs digits.
    pub(crate) fn centred(&self, values: Vec<f64>) -> Vec<f64> {
        about_means(values, self.step_of.iter().copied(), self.steps)
    }

    /// Of all readings, which nothing repeats: what a model can make of them.
    ///
    /// # Arguments
    /// - `columns`: derivatives of the readings to its parameters; those that the ones before contain are left out.
    pub(crate) fn of_model(observations: &Observations, columns: Vec<Vec<f64>>) -> Self {
        let mut part = Self {
            readings: 0..observations.len(),
            ..Self::default()
        };
        let mut units = Vec::new();
        for column in columns {
            let length = dot(&column, &column).sqrt();
            let unit = column.into_iter().map(|value| value / length);
            push_orthonormal(&mut units, unit.collect(), LEAST_INDEPENDENT, 0.0);
        }
        part.further = units;
        part
    }

    /// Of the cells of a series.
    ///
    /// # Arguments
    /// - `follows_force`: whether readings of a step follow the force that was read.
    pub(crate) fn of_series(
        observations: &Observations,
        cells: Range<usize>,
        follows_force: bool,
    ) -> Self {
        let cells = cells.map(|cell| fixed_part(observations, cell, follows_force));
        let whole = cells.reduce(|mut series, cell| {
            series.add(cell);
            series
        });
        whole.unwrap_or_default()
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
///
/// # Arguments
/// - `follows_force`: whether readings of a step follow the force that was read: else its scatter is noise.
pub(crate) fn fixed_part(
    observations: &Observations,
    cell: usize,
    follows_force: bool,
) -> FixedPart {
    let cell = &observations.cells[cell];
    let readings = cell.readings.clone();
    let loads = &observations.loads[readings.clone()];
    let details = &observations.readings[readings.clone()];
    let force_scale = largest(loads.iter().map(|load| &load.force_n)).max(1e-12);
    let force = loads.iter().map(|load| load.force_n / force_scale);
    let force: Vec<f64> = force.collect();
    let mut part = FixedPart {
        readings,
        ..FixedPart::default()
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
        if spread > 1e-6 && follows_force {
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
        let mut units = Vec::new();
        for column in all {
            push_orthonormal(&mut units, column.clone(), 1e-4, 0.0);
            if units.len() > part.further.len() {
                part.further.push(column);
            }
        }
    }
    part
}
