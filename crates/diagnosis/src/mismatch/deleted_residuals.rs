//! Readings against their repeats: each with all others, its own shift free.
//!
//! What is free in one run is taken out of that run alone, so that the work grows with the number of readings.

use std::collections::BTreeMap;
use std::ops::Range;

use super::curve_residuals::{curve_residuals, with_neighbours};
use super::free_means::fixed_part;
use super::noise::NoiseCovariance;
use super::observations::Observations;
use crate::search::constants::{AFTER_A_JUMP, ENOUGH_REPEATS, ROUNDING, UNSEEN_READING};
use crate::search::{Covariance, dot, push_orthonormal, subtract, take_out};

/// A reading against its repeats.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tested {
    pub(super) reading: usize,
    /// Its shift over its standard error.
    pub(super) ratio: f64,
    /// What it shows of the scatter of good readings: the same, but for those that are compared with their neighbours.
    pub(super) scatter: f64,
    pub(super) shift_m: f64,
    /// Whether its force is larger, or smaller, than that of all its repeats.
    pub(super) is_outermost: bool,
    /// Whether it was compared with its neighbours, for want of repeats.
    pub(super) is_by_curve: bool,
    /// Share of its own error in its variance; the rest is the step of the force.
    pub(super) own_share: f64,
}

/// The applications of each load of a cell: those of one step, and of one place within it.
fn repeats(observations: &Observations, cell: usize) -> BTreeMap<(u32, u32), Vec<usize>> {
    let mut repeats: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
    for reading in observations.cells[cell].readings.clone() {
        let key = observations.load_key(reading);
        repeats.entry(key).or_default().push(reading);
    }
    repeats
}

/// Readings of a cell that can be tested.
pub(super) fn testable(observations: &Observations, cell: usize) -> Vec<usize> {
    let repeated = repeated(observations, cell);
    if repeated.is_empty() {
        with_neighbours(observations, cell)
    } else {
        repeated
    }
}

/// Readings of a cell whose load was set at least three times.
fn repeated(observations: &Observations, cell: usize) -> Vec<usize> {
    let repeats = repeats(observations, cell).into_values();
    let enough = repeats.filter(|repeats| repeats.len() >= ENOUGH_REPEATS);
    let mut readings: Vec<usize> = enough.flatten().collect();
    readings.sort_unstable();
    readings
}

/// The other readings of a cell under the load of one; none where it was set less than three times.
pub(super) fn repeats_of(observations: &Observations, reading: usize) -> Vec<usize> {
    let mut all = repeats(observations, observations.cell_of(reading)).into_values();
    let own = all.find(|repeats| repeats.contains(&reading));
    let mut others = own
        .filter(|own| own.len() >= ENOUGH_REPEATS)
        .unwrap_or_default();
    others.retain(|other| *other != reading);
    others
}

/// Readings of a cell whose force is larger, or smaller, than that of all their repeats.
fn outermost(observations: &Observations, cell: usize) -> Vec<usize> {
    let force_n = |reading: &usize| observations.loads[*reading].force_n;
    let mut found = Vec::new();
    for mut repeats in repeats(observations, cell).into_values() {
        repeats.sort_by(|a, b| force_n(a).total_cmp(&force_n(b)));
        let ends = [
            (repeats.first(), repeats.get(1)),
            (repeats.last(), repeats.iter().rev().nth(1)),
        ];
        for (end, next) in ends {
            let alone = end.filter(|end| {
                next.is_none_or(|next| force_n(next).total_cmp(&force_n(end)).is_ne())
            });
            found.extend(alone);
        }
    }
    found.sort_unstable();
    found
}

/// Deleted residuals of the readings of a cell that can be tested.
///
/// # Arguments
/// - `whitening`: only what readings have by themselves counts of the covariance.
pub(super) fn deleted_residuals(
    observations: &Observations,
    cell: usize,
    whitening: &NoiseCovariance,
) -> Vec<Tested> {
    let testable = repeated(observations, cell);
    if testable.is_empty() {
        return curve_residuals(observations, cell, whitening);
    }
    let outermost = outermost(observations, cell);
    let covariance = &whitening.covariance;
    let free = FreeMeans::new(observations, cell, covariance, &whitening.slope_m);
    let mut out = Vec::with_capacity(testable.len());
    for run in observations.cells[cell].runs.clone() {
        let readings = observations.runs[run].readings.clone();
        let later = readings.start + 1..readings.end.saturating_sub(AFTER_A_JUMP);
        let step = later
            .filter_map(|from| free.shift(run, from..readings.end))
            .max_by(|a, b| a.fall().total_cmp(&b.fall()));
        for reading in readings {
            if testable.binary_search(&reading).is_err() {
                continue;
            }
            let own = free.shift(run, reading..reading + 1);
            let own = own.and_then(|own| own.unless_a_step_explains_more(step.as_ref()));
            out.extend(own.map(|own| Tested {
                reading,
                ratio: own.product / own.square.sqrt(),
                scatter: own.product / own.square.sqrt(),
                shift_m: own.product / own.square,
                is_outermost: outermost.binary_search(&reading).is_ok(),
                is_by_curve: false,
                own_share: whitening.own_share(reading),
            }));
        }
    }
    out
}

/// What is free in a cell: the mean of each load step, and zero and slope of each run.
struct FreeMeans<'a> {
    covariance: &'a Covariance,
    runs: Vec<FreeRun>,
    first_run: usize,
}

/// A run of a cell, white.
struct FreeRun {
    rows: Range<usize>,
    /// Orthonormal columns of what is free in this run alone.
    own: Vec<Vec<f64>>,
    /// For each row what it has of the orthonormal columns of what is free in common with other runs.
    common: Vec<Vec<f64>>,
    /// What all of them leave of the readings.
    residual: Vec<f64>,
}

impl<'a> FreeMeans<'a> {
    fn new(
        observations: &Observations,
        cell: usize,
        covariance: &'a Covariance,
        slope_m: &[f64],
    ) -> Self {
        let cell_rows = observations.cells[cell].readings.clone();
        let zero = |reading: usize| observations.readings[reading].zero;
        let mut runs_of_zero: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for run in observations.cells[cell].runs.clone() {
            for reading in observations.runs[run].readings.clone() {
                let runs = runs_of_zero.entry(zero(reading)).or_default();
                if runs.last() != Some(&run) {
                    runs.push(run);
                }
            }
        }
        let is_zero =
            |wanted: u32| move |reading: usize| f64::from(u8::from(zero(reading) == wanted));
        let mut runs: Vec<FreeRun> = observations.cells[cell]
            .runs
            .clone()
            .map(|run| {
                let rows = observations.runs[run].readings.clone();
                let white = |column: &mut Vec<f64>| covariance.whiten_own(&rows, column);
                let mut own = Vec::new();
                let zeros = runs_of_zero.iter().filter(|(_, runs)| runs[..] == [run]);
                let zeros = zeros.map(|(label, _)| rows.clone().map(is_zero(*label)).collect());
                for mut column in zeros.chain([slope_m[rows.clone()].to_vec()]) {
                    white(&mut column);
                    push_orthonormal(&mut own, column, ROUNDING, 0.0);
                }
                let mut residual = observations.displacement_m[rows.clone()].to_vec();
                white(&mut residual);
                take_out(&own, &mut residual);
                FreeRun {
                    common: vec![Vec::new(); rows.len()],
                    rows,
                    own,
                    residual,
                }
            })
            .collect();
        let mut columns = fixed_part(observations, cell).columns();
        let shared = runs_of_zero.iter().filter(|(_, runs)| runs.len() > 1);
        columns.extend(shared.map(|(label, _)| cell_rows.clone().map(is_zero(*label)).collect()));
        let mut common: Vec<Vec<f64>> = Vec::new();
        for mut column in columns {
            let mut whole = 0.0;
            for run in &runs {
                let place = run.rows.start - cell_rows.start..run.rows.end - cell_rows.start;
                covariance.whiten_own(&run.rows, &mut column[place.clone()]);
                whole += dot(&column[place.clone()], &column[place.clone()]);
                take_out(&run.own, &mut column[place]);
            }
            push_orthonormal(&mut common, column, ROUNDING, ROUNDING * whole.sqrt());
        }
        for unit in &common {
            let mut product = 0.0;
            for run in &runs {
                let start = run.rows.start - cell_rows.start;
                product += dot(&run.residual, &unit[start..start + run.rows.len()]);
            }
            for run in &mut runs {
                let start = run.rows.start - cell_rows.start;
                let part = &unit[start..start + run.rows.len()];
                subtract(&mut run.residual, product, part);
                for (row, value) in run.common.iter_mut().zip(part) {
                    row.push(*value);
                }
            }
        }
        Self {
            covariance,
            runs,
            first_run: observations.cells[cell].runs.start,
        }
    }

    /// The shift of some readings of a run; `None` if what is free leaves too little of it.
    fn shift(&self, run: usize, shifted: Range<usize>) -> Option<Shift> {
        let run = &self.runs[run - self.first_run];
        let inside = |row: usize| f64::from(u8::from(shifted.contains(&row)));
        let mut column: Vec<f64> = run.rows.clone().map(inside).collect();
        self.covariance.whiten_own(&run.rows, &mut column);
        let whole = dot(&column, &column);
        take_out(&run.own, &mut column);
        let mut common = vec![0.0; run.common.first().map_or(0, Vec::len)];
        for (value, row) in column.iter().zip(&run.common) {
            subtract(&mut common, -value, row);
        }
        let shift = Shift {
            square: dot(&column, &column) - dot(&common, &common),
            product: dot(&column, &run.residual),
            whole,
            column,
            common,
        };
        shift.is_seen().then_some(shift)
    }
}

/// A shift of some readings of a run, white.
struct Shift {
    /// What the run leaves of its column, and what that has of the common columns.
    column: Vec<f64>,
    common: Vec<f64>,
    /// The square of what all leave, and its product with the residuals.
    square: f64,
    product: f64,
    /// The square of the whole column.
    whole: f64,
}

impl Shift {
    fn is_seen(&self) -> bool {
        self.square > UNSEEN_READING * self.whole
    }

    /// Fall of the squares with it.
    fn fall(&self) -> f64 {
        self.product * self.product / self.square
    }

    /// The shift of one reading; beside a jump of its run that stays, where that explains more: it is not for this reading to explain.
    fn unless_a_step_explains_more(mut self, step: Option<&Self>) -> Option<Self> {
        let Some(step) = step.filter(|step| step.fall() > (1.0 + 1e-9) * self.fall()) else {
            return Some(self);
        };
        let both = dot(&self.column, &step.column) - dot(&self.common, &step.common);
        self.product -= both / step.square * step.product;
        self.square -= both * both / step.square;
        self.is_seen().then_some(self)
    }
}
