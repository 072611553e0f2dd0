//! Readings that are screened: the noise of those that are kept, and each of them against its repeats.

use rayon::prelude::*;

use stiffbench_numeric::statistics::{LeastSquaresLine, mean, median, root_mean_square};

use super::curve_residuals::Tested;
use super::deleted_residuals::deleted_residuals;
use super::screened::BadReading;
use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::{
    Beside, KnownNoise, NoiseCovariance, Tails, chance_if_normal, estimate_noise,
};
use crate::mismatch::observed::{Observations, ObservedCell, ReadingNoise};
use crate::mismatch::problem::DiagnosisProblem;
use crate::search::constants::{BAD_READING_LEVEL, CLEARLY_GOOD};

/// Median of the slopes of the runs of a cell, m/N: one bad reading does not change it.
fn measured_compliance(observations: &Observations, cell: usize) -> Option<f64> {
    let point = |one: usize| {
        (
            observations.loads[one].force_n,
            observations.displacement_m[one],
        )
    };
    let runs = observations.runs[observations.cells[cell].runs.clone()].iter();
    let lines = runs.filter_map(|run| LeastSquaresLine::through(run.readings.clone().map(point)));
    let mut slopes: Vec<f64> = lines.map(|line| line.slope).collect();
    median(&mut slopes)
}

/// Readings that are screened.
pub(crate) struct ReadingScreen<'a> {
    observations: &'a Observations,
    /// Displacement in proportion to the force, and displacement per force, at each reading.
    pub(crate) slope_m: Vec<f64>,
    pub(crate) compliance: Vec<f64>,
    noise: &'a KnownNoise,
}

impl<'a> ReadingScreen<'a> {
    /// Compliances are those that the readings of each cell show: how far a step of the force moves a reading must not depend on the
    /// parameters that a fit starts from. Those of the baseline stand in where a cell was loaded with one force only.
    pub(crate) fn new(
        baseline: &dyn Baseline,
        observations: &'a Observations,
        noise: &'a KnownNoise,
    ) -> Result<Self, MismatchError> {
        let problem = DiagnosisProblem::new(baseline, observations);
        let slopes = problem.slope(&problem.start())?;
        let (mut slope_m, mut compliance) = (slopes.slope_m, slopes.compliance);
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

    /// The noise of the readings that are kept, from a similar one if there is one.
    pub(crate) fn noise_of(&self, keep: &[bool], similar: Option<&ReadingNoise>) -> ReadingNoise {
        if let Some(given) = self.noise.given() {
            return given.noise;
        }
        let rest = self.observations.filtered(keep);
        let (slope_m, compliance) = (kept(&self.slope_m, keep), kept(&self.compliance, keep));
        // The means of all load steps are free, so that the readings themselves serve as what a model leaves of them.
        let residual_m = &rest.displacement_m;
        let linear = (&slope_m[..], compliance.as_slice().into());
        estimate_noise(
            &rest,
            residual_m,
            linear,
            similar,
            self.noise.earlier(),
            None,
        )
        .noise
    }

    /// What makes all readings white under a noise.
    pub(crate) fn whitening(&self, noise: &ReadingNoise) -> NoiseCovariance {
        let compliance = &self.compliance[..];
        NoiseCovariance::new(self.observations, noise, &self.slope_m, compliance)
    }

    /// The noise of all readings.
    pub(crate) fn noise_of_all(&self) -> ReadingNoise {
        self.noise_of(&vec![true; self.observations.len()], None)
    }

    /// Compliance of each cell, m/N.
    pub(crate) fn compliances(&self) -> Vec<f64> {
        let cells = self.observations.cells.iter();
        cells
            .map(|cell| self.compliance[cell.readings.start])
            .collect()
    }

    /// Standard error of the compliance of each cell by what its readings have by themselves, m/N.
    pub(crate) fn compliance_errors(&self, noise: &ReadingNoise) -> Vec<f64> {
        let whitening = self.whitening(noise);
        let weights = whitening.covariance.weights();
        let of_cell = |cell: &ObservedCell| {
            let forces = cell.readings.clone().map(|reading| {
                let force_n = self.observations.loads[reading].force_n;
                (weights[reading] * force_n).powi(2)
            });
            forces.sum::<f64>().sqrt().recip()
        };
        self.observations.cells.iter().map(of_cell).collect()
    }

    /// Relative standard uncertainty of the compliance of each cell, by its readings and by the scatter of its runs.
    pub(crate) fn relative_uncertainties(&self, noise: &ReadingNoise) -> Vec<f64> {
        let errors = self.compliance_errors(noise).into_iter();
        let cells = self.observations.cells.iter().zip(errors);
        let of_cell = |(cell, error): (&ObservedCell, f64)| {
            let by_readings = error / self.compliance[cell.readings.start];
            relative_error_of_runs(cell, noise).hypot(by_readings)
        };
        cells.map(of_cell).collect()
    }

    /// The readings of a cell that are kept, each against the others.
    fn tested(&self, cell: usize, keep: &[bool], noise: &ReadingNoise) -> Vec<Tested> {
        let readings = self.observations.cells[cell].readings.clone();
        let rest = self.observations.filtered_cell(cell, keep);
        if rest.is_empty() {
            return Vec::new();
        }
        let kept = |values: &[f64]| kept(&values[readings.clone()], &keep[readings.clone()]);
        let (slope_m, compliance) = (kept(&self.slope_m), kept(&self.compliance));
        let whitening = NoiseCovariance::new(&rest, noise, &slope_m, &compliance[..]);
        let places: Vec<usize> = readings.clone().filter(|&reading| keep[reading]).collect();
        let tested = deleted_residuals(&rest, 0, &whitening).into_iter();
        let in_its_place = |one: Tested| Tested {
            reading: places[one.reading],
            ..one
        };
        tested.map(in_its_place).collect()
    }
}

/// Relative standard error of the compliance of a cell by the scatter of its runs: of all gauges together, and of each by itself.
pub(super) fn relative_error_of_runs(cell: &ObservedCell, noise: &ReadingNoise) -> f64 {
    let of_a_run = noise.run_slope_sd.hypot(noise.gauges.own_slope_sd);
    of_a_run / (cell.runs.len() as f64).sqrt()
}

/// Values of what is kept.
pub(crate) fn kept<T: Copy>(values: &[T], keep: &[bool]) -> Vec<T> {
    let pairs = values.iter().zip(keep);
    pairs
        .filter(|(_, keep)| **keep)
        .map(|(value, _)| *value)
        .collect()
}

/// The readings that are kept, each against the others, under one noise.
pub(crate) struct TestedReadings<'a> {
    screen: &'a ReadingScreen<'a>,
    /// Whether each reading is kept.
    pub(crate) keep: Vec<bool>,
    pub(crate) noise: ReadingNoise,
    /// Those of each cell that can be tested.
    cells: Vec<Vec<Tested>>,
}

impl<'a> TestedReadings<'a> {
    pub(crate) fn new(screen: &'a ReadingScreen<'a>, keep: Vec<bool>, noise: ReadingNoise) -> Self {
        let cells = 0..screen.observations.cells.len();
        let of_cell = |cell| screen.tested(cell, &keep, &noise);
        let cells = cells.into_par_iter().map(of_cell).collect();
        Self {
            screen,
            keep,
            noise,
            cells,
        }
    }

    /// Leaves the reading out that deviates most: what the others of its cell let expect changes, and nothing else.
    pub(crate) fn take_worst(&mut self) -> Option<SuspectBeside> {
        let all = self.cells.iter().flatten();
        let worst = all.max_by(|a, b| a.ratio.abs().total_cmp(&b.ratio.abs()));
        let worst = *worst?;
        let count = self.cells.iter().map(Vec::len).sum();
        self.keep[worst.reading] = false;
        let cell = self.screen.observations.cell_of(worst.reading);
        self.cells[cell] = self.screen.tested(cell, &self.keep, &self.noise);
        Some(SuspectBeside::new(self, worst, count))
    }

    /// Degrees of freedom of the tails of these readings, where they are longer than normal.
    pub(crate) fn tails_dof(&self) -> Option<f64> {
        let ratios: Vec<f64> = self.showing_tails().iter().map(|one| one.scatter).collect();
        Tails::of(&ratios, 0).dof_if_longer_than_normal(&ratios)
    }

    /// Readings that scatter by themselves more than by the step of the force, which has no tails; all where there are none.
    fn showing_tails(&self) -> Vec<&Tested> {
        let all = || self.cells.iter().flatten();
        let own: Vec<&Tested> = all().filter(|one| one.own_share >= 0.5).collect();
        if own.is_empty() { all().collect() } else { own }
    }

    /// How far a reading beside these is off, with the chance that the largest of all is as far off by noise alone; `None` if it cannot be tested.
    ///
    /// # Arguments
    /// - `further`: how many readings, with it, lie farther out than all of these.
    pub(crate) fn judged(&self, suspect: usize, further: usize) -> Option<BadReading> {
        let cell = self.screen.observations.cell_of(suspect);
        let mut with_it = self.keep.clone();
        with_it[suspect] = true;
        let with_it = self.screen.tested(cell, &with_it, &self.noise);
        let of_others: usize = self.cells.iter().map(Vec::len).sum();
        let count = of_others - self.cells[cell].len() + with_it.len();
        let own = with_it.into_iter().find(|one| one.reading == suspect)?;
        Some(SuspectBeside::new(self, own, count).judged(self, further))
    }
}

/// A reading beside others, under their noise.
pub(crate) struct SuspectBeside {
    pub(crate) own: Tested,
    /// It and the others.
    count: usize,
    /// Shifts of the others over their standard errors, where they show tails: those whose forces are outermost, or are not, as its own; and the rest.
    alike: Vec<f64>,
    unlike: Vec<f64>,
    beside: Beside,
}

impl SuspectBeside {
    fn new(others: &TestedReadings<'_>, own: Tested, count: usize) -> Self {
        // Tails are those of the errors that readings have by themselves, seen where the step of the force is the smaller part.
        let show_tails = others.showing_tails().into_iter();
        let (alike, unlike): (Vec<&Tested>, Vec<&Tested>) =
            show_tails.partition(|one| one.is_outermost == own.is_outermost);
        let ratios = |tested: Vec<&Tested>| tested.iter().map(|one| one.scatter).collect();
        let beside = own.beside(others.cells.iter().flatten());
        Self {
            alike: ratios(alike),
            unlike: ratios(unlike),
            beside,
            count,
            own,
        }
    }

    /// Whether normal noise of this size makes a reading as far off so often that no noise can call it bad.
    pub(crate) fn is_clearly_good(&self) -> bool {
        let both = [&self.alike[..], &self.unlike[..]].concat();
        let sizes = [&self.alike, &both]
            .into_iter()
            .filter_map(|values| root_mean_square(values.iter().copied()));
        let others = sizes.fold(f64::INFINITY, f64::min);
        let chance = chance_if_normal(self.own.ratio, others, self.beside, self.count);
        chance > CLEARLY_GOOD * BAD_READING_LEVEL
    }

    fn judged(&self, others: &TestedReadings<'_>, further: usize) -> BadReading {
        let observations = others.screen.observations;
        // Rounding alone scatters by this much: a gauge that mostly repeats itself is not finer than its step.
        let step_m = observations.steps.displacement_m;
        let floor_m = step_m.unwrap_or(0.0) / 12_f64.sqrt();
        let tails = Tails::of_group(&self.alike, &self.unlike, further);
        // Against a curve that follows them good readings scatter less than the noise.
        let least = if self.own.is_by_curve { 1.0 } else { 0.0 };
        let tails = tails.with_scale_at_least((floor_m / others.noise.reading_sd_m).max(least));
        let p = tails.p_of_largest(self.own.ratio, self.beside, self.count);
        let shift_m = self.own.shift_m;
        let u_m = tails.scale(self.beside) * (shift_m / self.own.ratio).abs();
        BadReading::new(observations, self.own.reading, (shift_m, u_m), p)
    }
}

impl Tested {
    /// What its ratio has besides an error with tails: what the step of the force moves, as much as it does in others that scatter mostly by it,
    /// and no less than a step does.
    fn beside<'t>(&self, others: impl Iterator<Item = &'t Self>) -> Beside {
        let by_force = others.filter(|one| one.own_share < 0.5);
        let squares: Vec<f64> = by_force.map(|one| one.scatter.powi(2)).collect();
        let as_a_step = mean(&squares).unwrap_or(1.0).max(1.0);
        Beside {
            normal_sd: ((1.0 - self.own_share) * as_a_step).sqrt(),
            own: self.own_share.sqrt(),
        }
    }
}

/// A bad reading with the chance that its repeats give it, if it has enough of them.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved at the start of the fit.
pub(crate) fn against_repeats(
    bad: BadReading,
    baseline: &dyn Baseline,
    observations: &Observations,
    noise: &KnownNoise,
) -> Result<BadReading, MismatchError> {
    let screen = ReadingScreen::new(baseline, observations, noise)?;
    let others = observations.mask(|one| one != bad.reading);
    let found = screen.noise_of(&others, None);
    let tested = TestedReadings::new(&screen, others, found);
    Ok(tested.judged(bad.reading, 1).unwrap_or(bad))
}
