//! A jump and its return one reading later: a bad reading, and no slip.

use stiffbench_beams::physics::Place;

use super::diagnosis::{Diagnosis, Finding};
use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::KnownNoise;
use crate::mismatch::observed::Observations;
use crate::mismatch::screen::{BadReading, against_repeats};

/// Standard errors by which a jump and its return may differ (1). Stated.
const SAME_JUMP: f64 = 3.0;

/// The reading between two slips that a diagnosis names with opposite sizes, one reading apart in one run.
///
/// Such a pair says of one reading what a shift of that reading says with one number less. How rare it is follows from its repeats, if it has
/// enough of them: where errors have long tails, the search for slips finds it rarer than it is.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved at the start of the fit.
pub fn reading_between_slips(
    baseline: &dyn Baseline,
    observations: &Observations,
    diagnosis: &Diagnosis,
) -> Result<Option<BadReading>, MismatchError> {
    let slips: Vec<NamedSlip<'_>> = diagnosis
        .findings
        .iter()
        .filter_map(|finding| NamedSlip::new(observations, finding))
        .collect();
    let between = slips.iter().find_map(|first| {
        let back = slips.iter().find(|other| first.is_taken_back_by(other))?;
        let shift_m = 0.5 * (first.jump_m - back.jump_m);
        // Two estimates of the same shift.
        let u_m = 0.5 * first.u_m.hypot(back.u_m);
        let p_family = first.finding.p_family.min(back.finding.p_family);
        Some(BadReading::new(
            observations,
            first.reading,
            (shift_m, u_m),
            p_family,
        ))
    });
    between
        .map(|bad| against_repeats(bad, baseline, observations, &KnownNoise::Nothing))
        .transpose()
}

struct NamedSlip<'a> {
    finding: &'a Finding,
    run: usize,
    /// The first reading that it moves.
    reading: usize,
    jump_m: f64,
    u_m: f64,
}

impl<'a> NamedSlip<'a> {
    fn new(observations: &Observations, finding: &'a Finding) -> Option<Self> {
        let place = &finding.effect.place;
        let Place::Run { repeat, step, .. } = place else {
            return None;
        };
        let mut runs = observations.runs.iter();
        let run = runs.position(|run| {
            let cell = &observations.cells[run.cell];
            observations.is_cell_of(place, cell) && run.repeat == *repeat
        })?;
        let mut readings = observations.runs[run].readings.clone();
        let reading = readings.find(|&reading| observations.loads[reading].step >= *step)?;
        let value = finding.values.first()?;
        Some(Self {
            finding,
            run,
            reading,
            jump_m: value.value,
            u_m: value.u?,
        })
    }

    /// Whether another ends after one reading what this one begins.
    fn is_taken_back_by(&self, other: &Self) -> bool {
        let rest = self.jump_m + other.jump_m;
        self.run == other.run
            && other.reading == self.reading + 1
            && rest.abs() < SAME_JUMP * self.u_m.hypot(other.u_m)
    }
}
