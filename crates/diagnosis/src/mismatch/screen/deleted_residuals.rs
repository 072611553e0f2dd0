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
use crate::search::{Covariance, FittedRows, RowVector, Shift};

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
            let own = own.and_then(|own| unless_a_step_explains_more(own, step.as_ref()));
            out.extend(own.map(|own| Tested {
                reading,
                ratio: own.ratio(),
                scatter: own.ratio(),
                shift_m: own.size(),
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
    fitted: FittedRows,
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
            fitted: FittedRows::default(),
        };
        let readings = means.white(&of_cell.readings, |one| observations.displacement_m[one]);
        means.fitted = FittedRows::new(readings);
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
        for column in fixed_part(observations, cell, true).columns() {
            means.set_free(&of_cell.readings, |reading| {
                column[reading - of_cell.readings.start]
            });
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
        self.fitted.set_free(column, ROUNDING);
    }

    /// The shift of some readings of a run; `None` if what is free leaves too little of it.
    fn shift(&self, run: usize, shifted: Range<usize>) -> Option<Shift> {
        let readings = &self.observations.runs[run].readings;
        let inside = |reading: usize| f64::from(u8::from(shifted.contains(&reading)));
        let shift = self.fitted.shift(self.column(readings, inside));
        Some(shift).filter(|shift| shift.is_seen(UNSEEN_READING))
    }
}

/// The shift of one reading; beside a jump of its run that stays, where that explains more: it is not for this reading to explain.
fn unless_a_step_explains_more(own: Shift, step: Option<&Shift>) -> Option<Shift> {
    match step.filter(|step| step.fall() > (1.0 + 1e-9) * own.fall()) {
        Some(step) => Some(own.beside(step)).filter(|own| own.is_seen(UNSEEN_READING)),
        None => Some(own),
    }
}
