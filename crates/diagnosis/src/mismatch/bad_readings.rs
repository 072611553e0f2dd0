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
//! of them: such readings are held against each other, and those between against each other. Several bad readings are found one after the
//! other, the noise estimated anew without each, up to the largest number that may be bad, and believed up to the last that is significant:
//! until all are out, each makes the others look like long tails (generalised extreme studentised deviate: Rosner, Technometrics 25, 1983).
//! Of these each must contradict the good readings alone.

use rayon::prelude::*;

use stiffbench_numeric::statistics::{mean, median};
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

use super::baseline::Baseline;
use super::deleted_residuals::{Tested, deleted_residuals, testable};
use super::error::MismatchError;
use super::known_noise::KnownNoise;
use super::noise::{NoiseCovariance, ReadingNoise};
use super::observations::Observations;
use super::problem::DiagnosisProblem;
use super::restricted_likelihood::estimate_noise;
use super::tails::{Beside, Tails};
use crate::search::constants::{BAD_READING_LEVEL, MOST_BAD_READINGS};

/// What may have happened to a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BadReadingKind {
    /// Anything.
    Any,
    /// With the other sign it agrees.
    Sign,
    /// With the decimal point moved by so many places to the right it agrees.
    DecimalPoint(i32),
}

/// A reading that its repeats contradict.
#[derive(Debug, Clone, PartialEq)]
pub struct BadReading {
    /// Its place among the readings that were tested.
    pub reading: usize,
    /// Its line in its file.
    pub line: u32,
    /// Its pose.
    pub pose: PoseId,
    /// Its direction.
    pub direction: Direction,
    /// Its repeat.
    pub repeat: u32,
    /// Its load step.
    pub step: u32,
    /// Its branch.
    pub branch: Branch,
    /// What was read, m.
    pub value_m: f64,
    /// What the other readings let expect, m.
    pub expected_m: f64,
    /// Standard error of that difference, m.
    pub u_m: f64,
    /// Chance that the largest of all readings is as far off by noise alone.
    pub p_family: f64,
    /// What may have happened.
    pub kind: BadReadingKind,
}

/// Readings without those that their repeats contradict.
#[derive(Debug, Clone, PartialEq)]
pub struct ScreenedReadings {
    /// The others.
    pub observations: Observations,
    /// The bad ones, the worst first.
    pub bad: Vec<BadReading>,
    /// Degrees of freedom of Student's t that the others have; none where a normal distribution fits as well, or nothing could be tested.
    pub tails_dof: Option<f64>,
    /// Readings that could not be tested: those of loads with fewer than three repeats.
    pub untested: usize,
}

/// Looks for bad readings, and lays out the others.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved at the start of the fit.
pub fn screen_readings(
    baseline: &dyn Baseline,
    observations: &Observations,
    noise: &KnownNoise,
) -> Result<ScreenedReadings, MismatchError> {
    let untested = (0..observations.cells.len())
        .map(|cell| observations.cells[cell].readings.len() - testable(observations, cell).len())
        .sum();
    let all_are_good = |tails_dof| ScreenedReadings {
        observations: observations.clone(),
        bad: Vec::new(),
        tails_dof,
        untested,
    };
    if observations.is_empty() || untested == observations.len() {
        return Ok(all_are_good(None));
    }
    let screen = ReadingScreen::new(baseline, observations, noise)?;
    let most = (MOST_BAD_READINGS * observations.len() as f64).ceil() as usize;
    let mut keep = vec![true; observations.len()];
    let of_all = screen.noise_of(&keep, None);
    let mut found = of_all;
    let mut suspects: Vec<SuspectReading> = Vec::new();
    let mut p: Vec<f64> = Vec::new();
    while suspects.len() < most {
        let Some(suspect) = screen.worst(&keep, &found) else {
            break;
        };
        // What it does to the noise must not speak for it.
        let mut without = keep.clone();
        without[suspect] = false;
        // A reading that passed for good hardly changed it.
        let similar = p.last().filter(|p| **p > BAD_READING_LEVEL).map(|_| found);
        found = screen.noise_of(&without, similar.as_ref());
        // Those before it that passed for good lie farther out than all others too.
        let passed = p.iter().rev().take_while(|p| **p > BAD_READING_LEVEL);
        let further = 1 + passed.count();
        let (Some(deviation), family_p) = screen.judged((&without, further), &found, suspect)
        else {
            break;
        };
        keep = without;
        suspects.push(deviation);
        p.push(family_p);
    }
    let Some(last) = p.iter().rposition(|p| *p <= BAD_READING_LEVEL) else {
        let tails_dof = screen.tails_dof(&vec![true; observations.len()], &of_all);
        return Ok(all_are_good(tails_dof));
    };
    suspects.truncate(last + 1);
    // Each as the good readings alone let expect it: what lay far out only beside the others is good.
    let good_without = |suspects: &[SuspectReading]| {
        let mut good = vec![true; observations.len()];
        for suspect in suspects {
            good[suspect.reading] = false;
        }
        good
    };
    let all_out = good_without(&suspects);
    let found = screen.noise_of(&all_out, None);
    let again = suspects.iter().filter_map(|suspect| {
        let (deviation, alone) = screen.judged((&all_out, 1), &found, suspect.reading);
        let is_bad = alone <= BAD_READING_LEVEL;
        Some((deviation?, alone)).filter(|_| is_bad)
    });
    let (suspects, p): (Vec<SuspectReading>, Vec<f64>) = again.unzip();
    let good = good_without(&suspects);
    let mut bad: Vec<BadReading> = suspects
        .iter()
        .zip(p)
        .map(|(one, p)| BadReading::new(observations, one.reading, (one.shift_m, one.u_m), p))
        .collect();
    bad.sort_by(|a, b| a.p_family.total_cmp(&b.p_family).then(a.line.cmp(&b.line)));
    Ok(ScreenedReadings {
        observations: observations.filtered(&good),
        bad,
        tails_dof: screen.tails_dof(&good, &found),
        untested,
    })
}

/// How far a reading is from what the others let expect.
#[derive(Debug, Clone, Copy)]
struct SuspectReading {
    reading: usize,
    shift_m: f64,
    /// Its standard error by the noise that is estimated without it, m.
    u_m: f64,
}

impl BadReading {
    /// Whether errors with tails as long as those of the other readings are as far off in fewer benches than are called bad by chance.
    #[must_use]
    pub fn is_named(&self) -> bool {
        self.p_family <= BAD_READING_LEVEL
    }

    /// The same reading with the chance that its repeats give it, if it has enough of them.
    ///
    /// # Errors
    /// [`MismatchError`] if the structure cannot be solved at the start of the fit.
    pub(super) fn against_repeats(
        self,
        baseline: &dyn Baseline,
        observations: &Observations,
        noise: &KnownNoise,
    ) -> Result<Self, MismatchError> {
        let screen = ReadingScreen::new(baseline, observations, noise)?;
        let others: Vec<bool> = (0..observations.len())
            .map(|one| one != self.reading)
            .collect();
        let found = screen.noise_of(&others, None);
        let (Some(deviation), p_family) = screen.judged((&others, 1), &found, self.reading) else {
            return Ok(self);
        };
        let shift = (deviation.shift_m, deviation.u_m);
        Ok(Self::new(observations, self.reading, shift, p_family))
    }

    /// # Arguments
    /// - `shift_m`: by how much the reading is too large, and its standard error, m.
    pub(super) fn new(
        observations: &Observations,
        reading: usize,
        (shift_m, u_m): (f64, f64),
        p_family: f64,
    ) -> Self {
        let detail = &observations.readings[reading];
        let run = &observations.runs[detail.run];
        let cell = &observations.cells[run.cell];
        let value_m = observations.displacement_m[reading];
        let expected_m = value_m - shift_m;
        Self {
            reading,
            line: detail.line,
            pose: observations.poses[cell.pose].clone(),
            direction: cell.direction,
            repeat: run.repeat,
            step: observations.loads[reading].step,
            branch: detail.branch,
            value_m,
            expected_m,
            u_m,
            p_family,
            kind: slip(value_m, expected_m, u_m),
        }
    }
}

/// What was done to a value that should be another, if it is one of the usual slips of the pen.
pub(super) fn slip(value: f64, expected: f64, u: f64) -> BadReadingKind {
    let agrees = |value: f64| (value - expected).abs() < 4.0 * u;
    // A value that lies near zero agrees with itself of any sign.
    if expected.abs() < 10.0 * u {
        return BadReadingKind::Any;
    }
    if agrees(-value) {
        return BadReadingKind::Sign;
    }
    let places = [1, -1, 2, -2, 3, -3];
    let moved = places
        .into_iter()
        .find(|places| agrees(value * 10_f64.powi(*places)));
    moved.map_or(BadReadingKind::Any, BadReadingKind::DecimalPoint)
}

impl Tested {
    /// What its ratio has besides an error with tails: what the step of the force moves, as much as it does in others that scatter mostly by it,
    /// and no less than a step does.
    fn beside(&self, others: &[Self]) -> Beside {
        let by_force = others.iter().filter(|one| one.own_share < 0.5);
        let squares: Vec<f64> = by_force.map(|one| one.ratio.powi(2)).collect();
        let as_a_step = mean(&squares).unwrap_or(1.0).max(1.0);
        Beside {
            normal_sd: ((1.0 - self.own_share) * as_a_step).sqrt(),
            own: self.own_share.sqrt(),
        }
    }
}

/// Readings that scatter by themselves more than by the step of the force, which has no tails; all where there are none.
fn show_tails(tested: &[Tested]) -> Vec<&Tested> {
    let own: Vec<&Tested> = tested.iter().filter(|one| one.own_share >= 0.5).collect();
    if own.is_empty() {
        tested.iter().collect()
    } else {
        own
    }
}

/// Median of the slopes of the runs of a cell, m/N: one bad reading does not change it.
fn measured_compliance(observations: &Observations, cell: usize) -> Option<f64> {
    let runs = observations.cells[cell].runs.clone();
    let slope = |run: usize| {
        let readings = observations.runs[run].readings.clone();
        let n = readings.len() as f64;
        let force_n = |reading: usize| observations.loads[reading].force_n;
        let mean = |of: &dyn Fn(usize) -> f64| readings.clone().map(of).sum::<f64>() / n;
        let mean_n = mean(&force_n);
        let mean_m = mean(&|reading| observations.displacement_m[reading]);
        let (mut product, mut square) = (0.0, 0.0);
        for reading in readings.clone() {
            let from_mean_n = force_n(reading) - mean_n;
            product += from_mean_n * (observations.displacement_m[reading] - mean_m);
            square += from_mean_n * from_mean_n;
        }
        (square > 0.0).then(|| product / square)
    };
    let mut slopes: Vec<f64> = runs.filter_map(slope).collect();
    median(&mut slopes)
}

/// Readings that are screened.
pub(super) struct ReadingScreen<'a> {
    observations: &'a Observations,
    /// Displacement in proportion to the force, and displacement per force, at each reading.
    pub(super) slope_m: Vec<f64>,
    pub(super) compliance: Vec<f64>,
    noise: &'a KnownNoise,
}

impl<'a> ReadingScreen<'a> {
    /// Compliances are those that the readings of each cell show: how far a step of the force moves a reading must not depend on the
    /// parameters that a fit starts from. Those of the baseline stand in where a cell was loaded with one force only.
    pub(super) fn new(
        baseline: &dyn Baseline,
        observations: &'a Observations,
        noise: &'a KnownNoise,
    ) -> Result<Self, MismatchError> {
        let bench = DiagnosisProblem::new(baseline, observations);
        let (mut slope_m, mut compliance) = bench.slope(&mut bench.predictor(), &bench.start())?;
        for cell in 0..observations.cells.len() {
            let Some(measured) = measured_compliance(observations, cell) else {
                continue;
            };
            for reading in observations.cells[cell].readings.clone() {
                compliance[reading] = measured;
                slope_m[reading] = measured * observations.loads[reading].force_n;
            }
        }
        Ok(Self {
            observations,
            slope_m,
            compliance,
            noise,
        })
    }

    fn linear(&self, keep: &[bool]) -> (Vec<f64>, Vec<f64>) {
        let kept = |values: &[f64]| {
            let pairs = values.iter().zip(keep);
            pairs
                .filter(|(_, keep)| **keep)
                .map(|(value, _)| *value)
                .collect()
        };
        (kept(&self.slope_m), kept(&self.compliance))
    }

    /// The noise of the readings that are kept, from a similar one if there is one.
    pub(super) fn noise_of(&self, keep: &[bool], similar: Option<&ReadingNoise>) -> ReadingNoise {
        if let Some(given) = self.noise.given() {
            return given.noise;
        }
        let rest = self.observations.filtered(keep);
        let (slope_m, compliance) = self.linear(keep);
        // The means of all load steps are free, so that the readings themselves serve as what a model leaves of them.
        let residual_m = &rest.displacement_m;
        let linear = (&slope_m[..], &compliance[..]);
        estimate_noise(&rest, residual_m, linear, similar, self.noise.earlier()).noise
    }

    /// The readings that are kept, each against the others.
    fn tested(&self, keep: &[bool], noise: &ReadingNoise) -> Vec<Tested> {
        let rest = self.observations.filtered(keep);
        let (slope_m, compliance) = self.linear(keep);
        let whitening = NoiseCovariance::new(&rest, noise, &slope_m, &compliance);
        let places: Vec<usize> = (0..keep.len()).filter(|&reading| keep[reading]).collect();
        (0..rest.cells.len())
            .into_par_iter()
            .flat_map_iter(|cell| deleted_residuals(&rest, cell, &whitening))
            .map(|one| Tested {
                reading: places[one.reading],
                ..one
            })
            .collect()
    }

    /// The reading that deviates most.
    fn worst(&self, keep: &[bool], noise: &ReadingNoise) -> Option<usize> {
        let tested = self.tested(keep, noise);
        let worst = tested
            .iter()
            .max_by(|a, b| a.ratio.abs().total_cmp(&b.ratio.abs()));
        worst.map(|worst| worst.reading)
    }

    /// How long the tails of readings are.
    fn tails_dof(&self, keep: &[bool], noise: &ReadingNoise) -> Option<f64> {
        let tested = self.tested(keep, noise);
        let show_tails = show_tails(&tested);
        let ratios: Vec<f64> = show_tails.iter().map(|one| one.ratio).collect();
        Tails::of(&ratios, 0).dof_if_longer_than_normal(&ratios)
    }

    /// How far a reading is off, and the chance that the largest of all is as far off by noise alone.
    ///
    /// # Arguments
    /// - `others`: the readings beside it, and how many, with it, lie farther out than all of them.
    /// - `noise`: theirs.
    fn judged(
        &self,
        (others, further): (&[bool], usize),
        noise: &ReadingNoise,
        suspect: usize,
    ) -> (Option<SuspectReading>, f64) {
        let mut with_it = others.to_vec();
        with_it[suspect] = true;
        let with_it = self.tested(&with_it, noise);
        let Some(own) = with_it.iter().find(|one| one.reading == suspect) else {
            return (None, 1.0);
        };
        // Beside a bad reading its neighbours look bad too.
        let others = self.tested(others, noise);
        // Tails are those of the errors that readings have by themselves, seen where the step of the force is the smaller part.
        let show_tails = show_tails(&others).into_iter();
        let (alike, unlike): (Vec<&Tested>, Vec<&Tested>) =
            show_tails.partition(|one| one.is_outermost == own.is_outermost);
        let ratios =
            |tested: &[&Tested]| -> Vec<f64> { tested.iter().map(|one| one.ratio).collect() };
        let (alike, unlike) = (ratios(&alike), ratios(&unlike));
        let beside = own.beside(&others);
        // Rounding alone scatters by this much: a gauge that mostly repeats itself is not finer than its step.
        let floor_m = self.observations.steps.displacement_m.unwrap_or(0.0) / 12_f64.sqrt();
        let tails = Tails::of_group(&alike, &unlike, further);
        let tails = tails.with_scale_at_least(floor_m / noise.reading_sd_m);
        let family = tails.p_of_largest(own.ratio, beside, with_it.len());
        let deviation = SuspectReading {
            reading: suspect,
            shift_m: own.shift_m,
            u_m: tails.scale(beside) * (own.shift_m / own.ratio).abs(),
        };
        (Some(deviation), family)
    }
}
