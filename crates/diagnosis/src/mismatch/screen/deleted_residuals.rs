//! Readings against their repeats: each with all others, its own shift free.
//!
//! What is free in one run is taken out of that run alone, so that the work grows with the number of readings.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::ops::Range;

use super::curve_residuals::{Tested, curve_residuals, has_neighbours};
use crate::mismatch::noise::{NoiseCovariance, fixed_part};
use crate::mismatch::observed::Observations;
use crate::search::constants::{AFTER_A_JUMP, ENOUGH_REPEATS, ROUNDING, UNSEEN_READING};
use crate::search::{Covariance, RowVector, dot, push_orthonormal_rows, subtract};

/// The applications of each load of a cell: those of one step, and of one place within it.
fn repeats(observations: &Observations, cell: usize) -> BTreeMap<(u32, u32), Vec<usize>> {
    let mut repeats: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
    for reading in observations.cells[cell].readings.clone() {
        let key = observations.load_key(reading);
        repeats.entry(key).or_default().push(reading);
    }
    repeats
}

/// Whether readings of a cell can be tested.
pub(crate) fn is_testable(observations: &Observations, cell: usize) -> bool {
    is_repeated(&repeats(observations, cell)) || has_neighbours(observations, cell)
}

/// Whether a load of a cell was set at least three times.
fn is_repeated(repeats: &BTreeMap<(u32, u32), Vec<usize>>) -> bool {
    repeats.values().any(|own| own.len() >= ENOUGH_REPEATS)
}

/// The other readings of a cell under the load of one; none where it was set less than three times.
pub(crate) fn repeats_of(observations: &Observations, reading: usize) -> Vec<usize> {
    let all = repeats(observations, observations.cell_of(reading));
    let own = &all[&observations.load_key(reading)];
    if own.len() < ENOUGH_REPEATS {
        return Vec::new();
    }
    let others = own.iter().copied();
    others.filter(|other| *other != reading).collect()
}

/// Whether the force of a reading is larger, or smaller, than that of all its repeats.
fn is_outermost(observations: &Observations, repeats: &[usize], reading: usize) -> bool {
    let force_n = |one: usize| observations.loads[one].force_n;
    let is_beyond = |way: Ordering| {
        let mut others = repeats.iter().filter(|other| **other != reading);
        others.all(|other| force_n(*other).total_cmp(&force_n(reading)) == way)
    };
    is_beyond(Ordering::Less) || is_beyond(Ordering::Greater)
}

/// Deleted residuals of the readings of a cell that can be tested.
///
/// # Arguments
/// - `whitening`: only what readings have by themselves counts of the covariance.
pub(crate) fn deleted_residuals(
    observations: &Observations,
    cell: usize,
    whitening: &NoiseCovariance,
) -> Vec<Tested> {
    let repeats = repeats(observations, cell);
    if !is_repeated(&repeats) {
        return curve_residuals(observations, cell, whitening);
    }
    let (covariance, slope_m) = (&whitening.covariance, &whitening.slope_m);
    let free = FreeMeans::new(observations, cell, covariance, slope_m);
    let mut out = Vec::new();
    for run in observations.cells[cell].runs.clone() {
        let readings = observations.runs[run].readings.clone();
        let later = readings.start + 1..readings.end.saturating_sub(AFTER_A_JUMP);
        let step = later
            .filter_map(|from| free.shift(run, from..readings.end))
            .max_by(|a, b| a.fall().total_cmp(&b.fall()));
        for reading in readings {
            let repeats = &repeats[&observations.load_key(reading)];
            if repeats.len() < ENOUGH_REPEATS {
                continue;
            }
            let own = free.shift(run, reading..reading + 1);
            let own = own.and_then(|own| own.unless_a_step_explains_more(step.as_ref()));
            out.extend(own.map(|own| Tested {
                reading,
                ratio: own.product / own.square.sqrt(),
                scatter: own.product / own.square.sqrt(),
                shift_m: own.product / own.square,
                is_outermost: is_outermost(observations, repeats, reading),
                is_by_curve: false,
                own_share: whitening.own_share(reading),
            }));
        }
    }
    out
}

/// What is free in a cell, white: the mean of each load step, each zero, and the slope of each run.
struct FreeMeans<'a> {
    observations: &'a Observations,
    covariance: &'a Covariance,
    /// Readings of the cell.
    rows: Range<usize>,
    /// Orthonormal columns.
    free: Vec<RowVector>,
    /// What all of them leave of the readings.
    residual: Vec<f64>,
}

impl<'a> FreeMeans<'a> {
    fn new(
        observations: &'a Observations,
        cell: usize,
        covariance: &'a Covariance,
        slope_m: &[f64],
    ) -> Self {
        let of_cell = &observations.cells[cell];
        let mut means = Self {
            observations,
            covariance,
            rows: of_cell.readings.clone(),
            free: Vec::new(),
            residual: Vec::new(),
        };
        // First what is free in one run alone, of which alone it takes work.
        for run in &observations.runs[of_cell.runs.clone()] {
            means.set_free(&run.readings, |reading| slope_m[reading]);
        }
        let mut zeros: BTreeMap<u32, Range<usize>> = BTreeMap::new();
        for reading in means.rows.clone() {
            let detail = &observations.readings[reading];
            let run = &observations.runs[detail.run].readings;
            let rows = zeros.entry(detail.zero).or_insert_with(|| run.clone());
            rows.end = run.end;
        }
        for (zero, rows) in zeros {
            let is_of_zero = |reading: usize| observations.readings[reading].zero == zero;
            means.set_free(&rows, |reading| f64::from(u8::from(is_of_zero(reading))));
        }
        for column in fixed_part(observations, cell).columns() {
            means.set_free(&of_cell.readings, |reading| {
                column[reading - of_cell.readings.start]
            });
        }
        means.residual = means.white(&of_cell.readings, |one| observations.displacement_m[one]);
        for unit in &means.free {
            let product = unit.dot(&means.residual);
            subtract(&mut means.residual[unit.rows()], product, &unit.values);
        }
        means
    }

    /// Values of readings of whole runs, white.
    fn white(&self, readings: &Range<usize>, of: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut values: Vec<f64> = readings.clone().map(of).collect();
        let mut rest = &mut values[..];
        while !rest.is_empty() {
            let run = self.observations.readings[readings.end - rest.len()].run;
            let run = &self.observations.runs[run].readings;
            let (own, others) = std::mem::take(&mut rest).split_at_mut(run.len());
            self.covariance.whiten_own(run, own);
            rest = others;
        }
        values
    }

    fn column(&self, readings: &Range<usize>, of: impl Fn(usize) -> f64) -> RowVector {
        RowVector {
            first: readings.start - self.rows.start,
            values: self.white(readings, of),
        }
    }

    fn set_free(&mut self, readings: &Range<usize>, of: impl Fn(usize) -> f64) {
        let column = self.column(readings, of);
        push_orthonormal_rows(&mut self.free, column, ROUNDING);
    }

    /// The shift of some readings of a run; `None` if what is free leaves too little of it.
    fn shift(&self, run: usize, shifted: Range<usize>) -> Option<Shift> {
        let readings = &self.observations.runs[run].readings;
        let inside = |reading: usize| f64::from(u8::from(shifted.contains(&reading)));
        let column = self.column(readings, inside);
        let free: Vec<f64> = self.free.iter().map(|one| one.dot_part(&column)).collect();
        let whole = dot(&column.values, &column.values);
        let shift = Shift {
            square: whole - dot(&free, &free),
            product: column.dot(&self.residual),
            whole,
            column: column.values,
            free,
        };
        shift.is_seen().then_some(shift)
    }
}

/// A shift of some readings of a run, white.
struct Shift {
    /// Its column in the readings of the run, and what that has of what is free.
    column: Vec<f64>,
    free: Vec<f64>,
    /// The square of what is not free, and its product with the residuals.
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
        let both = dot(&self.column, &step.column) - dot(&self.free, &step.free);
        self.product -= both / step.square * step.product;
        self.square -= both * both / step.square;
        self.is_seen().then_some(self)
    }
}
