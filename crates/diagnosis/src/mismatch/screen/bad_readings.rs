//! Bad readings: single ones that the repeats of the same load contradict.
//!
//! The test is that of a shift of the mean of one reading (Cook & Weisberg, Residuals and Influence in Regression, 1982, section 2.2.2), with
//! everything left free that physics or the bench may do to all readings of a load step and to all readings of a run:
//!
//! ```text
//!   y = mean(step, branch, hold) + zero(zero id) + slope(run) b + shift e + error
//! ```
//!
//! So it never asks the model. Errors may have long tails, as far as the others show them (`tails`); the step of the force has
//! none. Where physics jumps at some force, a reading beyond that force differs from its repeats, and its force is the largest or the smallest
//! of them: such readings are compared with each other, and those between against each other. Several bad readings are found one after the
//! other, the noise estimated anew without each, up to the largest number that may be bad, and believed up to the last that is significant:
//! until all are out, each makes the others look like long tails (generalised extreme studentised deviate: Rosner, Technometrics 25, 1983).
//! Of these each must contradict the good readings alone. Cells with fewer than three repeats have their neighbours instead (`curve_residuals`).

use stiffbench_numeric::statistics::median;

use super::deleted_residuals::{is_testable, repeats_of};
use super::reading_screen::{ReadingScreen, TestedReadings};
use super::screened::{BadReading, ScreenedData, ScreenedRuns};
use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::KnownNoise;
use crate::mismatch::observed::Observations;
use crate::search::constants::{BAD_READING_LEVEL, MOST_BAD_READINGS};
use crate::search::up_to_last_bad;

/// Looks for bad readings in good runs, and lays out the others.
pub(crate) fn screen_readings(
    baseline: &dyn Baseline,
    runs: &ScreenedRuns,
    noise: &KnownNoise,
) -> Result<ScreenedData, MismatchError> {
    let observations = &runs.observations;
    let screened = |observations, bad_readings, tails_dof| ScreenedData {
        observations,
        bad_runs: runs.bad.clone(),
        bad_readings,
        tails_dof,
    };
    let mut cells = 0..observations.cells.len();
    if !cells.any(|cell| is_testable(observations, cell)) {
        return Ok(screened(observations.clone(), Vec::new(), None));
    }
    let screen = ReadingScreen::new(baseline, observations, noise)?;
    let most = (MOST_BAD_READINGS * observations.len() as f64).ceil() as usize;
    let noise_of_all = runs.noise.unwrap_or_else(|| screen.noise_of_all());
    let all = vec![true; observations.len()];
    let mut tested = TestedReadings::new(&screen, all, noise_of_all);
    let tails_of_all = tested.tails_dof();
    let suspects = up_to_last_bad(most, BAD_READING_LEVEL, |before| {
        let suspect = tested.take_worst()?;
        let (suspect, is_clearly_good) = (suspect.own.reading, suspect.is_clearly_good());
        if is_clearly_good {
            return Some((suspect, 1.0));
        }
        // What it does to the noise must not speak for it; a reading that passed for good hardly changed it.
        let passed = before.iter().rev();
        let passed = passed.take_while(|(_, p)| *p > BAD_READING_LEVEL).count();
        let similar = (passed > 0).then_some(tested.noise);
        let noise = screen.noise_of(&tested.keep, similar.as_ref());
        let keep = std::mem::take(&mut tested.keep);
        tested = TestedReadings::new(&screen, keep, noise);
        // Those before it that passed for good lie farther out than all others too.
        let judged = tested.judged(suspect, 1 + passed);
        Some((suspect, judged.map_or(1.0, |judged| judged.p_family)))
    });
    if suspects.is_empty() {
        return Ok(screened(observations.clone(), Vec::new(), tails_of_all));
    }
    let suspects: Vec<usize> = suspects.into_iter().map(|(reading, _)| reading).collect();
    // Each as the good readings alone let expect it: what lay far out only beside the others is good.
    let good_without = |suspects: &[usize]| observations.mask(|one| !suspects.contains(&one));
    let all_out = good_without(&suspects);
    let found = screen.noise_of(&all_out, None);
    let tested = TestedReadings::new(&screen, all_out, found);
    let again = suspects.iter().filter_map(|one| tested.judged(*one, 1));
    let named = again.filter(BadReading::is_named);
    let mut bad: Vec<BadReading> = named
        .filter(|bad| !is_of_another_state(observations, bad))
        .collect();
    let places: Vec<usize> = bad.iter().map(|one| one.reading).collect();
    let good = good_without(&places);
    bad.sort_by(|a, b| a.p_family.total_cmp(&b.p_family).then(a.line.cmp(&b.line)));
    let others = observations.filtered(&good);
    let tails_dof = TestedReadings::new(&screen, good, found).tails_dof();
    Ok(screened(others, bad, tails_dof))
}

/// Whether a reading with which its run begins agrees with its repeats as recorded, so that the rest of the run is what was displaced.
///
/// Zeros are free, so that either would look the same. Where a joint sticks, the first run of a cell begins before it slipped for the first
/// time and the others after it; all are zeroed where they begin.
fn is_of_another_state(observations: &Observations, bad: &BadReading) -> bool {
    let run = &observations.runs[observations.readings[bad.reading].run];
    if run.readings.start != bad.reading {
        return false;
    }
    let recorded = |reading: usize| observations.displacement_m[reading];
    let repeats = repeats_of(observations, bad.reading).into_iter();
    let mut repeats: Vec<f64> = repeats.map(recorded).collect();
    let shift_m = bad.value_m - bad.expected_m;
    median(&mut repeats).is_some_and(|usual| (bad.value_m - usual).abs() < 0.5 * shift_m.abs())
}
