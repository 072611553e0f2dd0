//! Noise as a coarse gauge shows it: where its step is what scatters, errors are not drawn anew with every reading but follow where the
//! gauge stands, and come back in every repeat.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::covariance::NoiseCovariance;
use super::free_means::{FixedPart, fixed_part};
use crate::mismatch::observed::Observations;
use crate::search::DrawResiduals;
use crate::search::constants::{COARSE, COUNTED, NULL_SAMPLES, SAMPLES_TOGETHER};

/// Standard deviation of a reading before it is rounded by a coarse gauge, as a share of its step, where no repeats show it (1). By hand (aed7720).
const FINEST: f64 = 0.05;

/// The smallest chance that [`RoundedNoise::chances`] can show (1).
pub(crate) const LEAST_COUNTED: f64 = 1.0 / (NULL_SAMPLES as f64 + 1.0);

/// Noise of a coarse gauge at the places where it stood.
#[derive(Debug)]
pub(crate) struct RoundedNoise<'a> {
    observations: &'a Observations,
    whitening: &'a NoiseCovariance,
    /// Where the gauge stood without noise, m.
    predicted_m: Vec<f64>,
    step_m: f64,
    /// How far that is unknown: changes of all readings, m, each to be taken a standard normal number of times.
    pub(crate) unknown_m: Vec<Vec<f64>>,
    /// Least standard deviation of a reading before it is rounded, m.
    least_sd_m: f64,
}

impl<'a> RoundedNoise<'a> {
    /// The noise of these observations; `None` if the step of their gauge is not what scatters.
    ///
    /// # Arguments
    /// - `predicted_m`: displacements without noise, m.
    pub(crate) fn new(
        observations: &'a Observations,
        whitening: &'a NoiseCovariance,
        predicted_m: Vec<f64>,
    ) -> Option<Self> {
        let step_m = observations.steps.displacement_m?;
        let variance = whitening.noise.reading_sd_m.powi(2);
        let of_step = step_m * step_m / 12.0;
        (of_step > COARSE * variance).then(|| {
            let rounded = Self {
                observations,
                whitening,
                predicted_m,
                step_m,
                unknown_m: Vec::new(),
                least_sd_m: FINEST * step_m,
            };
            rounded.scattered_as_measured()
        })
    }

    /// The same with as much noise before rounding as makes repeats differ as much as the measured ones: a quieter gauge than its step gives
    /// mostly the same number in each. Unchanged where nothing was repeated.
    fn scattered_as_measured(mut self) -> Self {
        let observations = self.observations;
        let cells = 0..observations.cells.len();
        let mut repeated: Vec<FixedPart> = cells
            .map(|cell| fixed_part(observations, cell, true))
            .collect();
        repeated.retain(|part| part.steps > 0);
        let scatter = |errors_m: &[f64]| -> f64 {
            let of_cell = |part: &FixedPart| {
                let centred = part.centred(errors_m[part.readings.clone()].to_vec());
                centred.iter().map(|error| error * error).sum::<f64>()
            };
            repeated.iter().map(of_cell).sum()
        };
        let both = observations.displacement_m.iter().zip(&self.predicted_m);
        let measured: Vec<f64> = both.map(|(read, predicted)| read - predicted).collect();
        let measured = scatter(&measured);
        // Shares of the step: below the first every reading of a place is rounded alike, beyond the last it scatters like a finer gauge.
        let (mut low, mut high): (f64, f64) = (0.002, 0.3);
        if repeated.is_empty() {
            return self;
        }
        for _ in 0..COUNTED {
            let middle = (low * high).sqrt();
            self.least_sd_m = middle * self.step_m;
            let draws = (0..COUNTED as u64).map(|stream| {
                let mut rng = ChaCha8Rng::seed_from_u64(0);
                rng.set_stream(stream);
                scatter(&self.errors_m(&mut rng))
            });
            if draws.sum::<f64>() > measured * COUNTED as f64 {
                high = middle;
            } else {
                low = middle;
            }
        }
        self
    }
}

impl RoundedNoise<'_> {
    /// Errors of all readings, m.
    pub(crate) fn errors_m(&self, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let readings = &self.observations.readings;
        let zeros = (0..self.observations.zero_count()).map(|_| normal());
        let zeros: Vec<f64> = zeros.collect();
        let runs = &self.observations.runs;
        let slopes: Vec<f64> = runs.iter().map(|_| normal()).collect();
        let mut stood = self.predicted_m.clone();
        for change in &self.unknown_m {
            let times = normal();
            for (stood, change) in stood.iter_mut().zip(change) {
                *stood += times * change;
            }
        }
        let of_step = self.step_m * self.step_m / 12.0;
        readings
            .iter()
            .zip(self.predicted_m.iter().zip(stood))
            .zip(&self.whitening.slope_m)
            .enumerate()
            .map(|(place, ((reading, (predicted, stood)), slope_m))| {
                let noise = self.whitening.noise_at(place);
                // Before it is rounded.
                let own = (noise.reading_sd_m.powi(2) - of_step).max(0.0).sqrt();
                let stood = stood
                    + noise.zero_sd_m * zeros[reading.zero as usize]
                    + noise.run_slope_sd * slopes[reading.run] * slope_m
                    + own.max(self.least_sd_m) * normal();
                (stood / self.step_m).round() * self.step_m - predicted
            })
            .collect()
    }
}

impl RoundedNoise<'_> {
    /// For each of several tests how often drawn and rounded readings show at most the chance that it states: [`NULL_SAMPLES`] draws, fewer
    /// where each test was reached [`COUNTED`] times before (Besag & Clifford, Biometrika 78 (1991) 301).
    ///
    /// # Arguments
    /// - `stated`: chance that each test states of the readings.
    /// - `tests`: the same of white errors.
    pub(crate) fn chances(
        &self,
        stated: &[f64],
        tests: impl Fn(&[f64]) -> Vec<f64> + Sync,
    ) -> Vec<f64> {
        let mut as_rare = vec![0_usize; stated.len()];
        let mut count = 0;
        while count < NULL_SAMPLES && as_rare.iter().any(|rare| *rare < COUNTED) {
            for drawn in self.samples(count, &tests) {
                let each = as_rare.iter_mut().zip(stated).zip(drawn);
                for ((rare, stated), drawn) in each {
                    *rare += usize::from(drawn <= *stated);
                }
            }
            count += SAMPLES_TOGETHER;
        }
        let chance = |rare: usize| (rare + 1) as f64 / (count + 1) as f64;
        as_rare.into_iter().map(chance).collect()
    }

    /// How large drawn and rounded readings make something on average that white noise makes 1: root mean square, not below 1.
    ///
    /// # Arguments
    /// - `square`: of white errors.
    pub(crate) fn standard_error(&self, square: impl Fn(&[f64]) -> f64 + Sync) -> f64 {
        let firsts = (0..COUNTED).map(|block| block * SAMPLES_TOGETHER);
        let sum: f64 = firsts.flat_map(|first| self.samples(first, &square)).sum();
        let count = (COUNTED * SAMPLES_TOGETHER) as f64;
        (sum / count).max(1.0).sqrt()
    }

    /// Some statistic of [`SAMPLES_TOGETHER`] draws, each from a stream of its own.
    fn samples<T: Send>(&self, first: usize, of: impl Fn(&[f64]) -> T + Sync) -> Vec<T> {
        let draws = (first..first + SAMPLES_TOGETHER).into_par_iter();
        draws
            .map(|number| {
                let mut rng = ChaCha8Rng::seed_from_u64(0);
                rng.set_stream(number as u64);
                of(&self.draw(&mut rng))
            })
            .collect()
    }
}

impl DrawResiduals for RoundedNoise<'_> {
    fn draw(&self, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let mut white = self.errors_m(rng);
        self.whitening.covariance.whiten(&mut white);
        white
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;
    use crate::mismatch::observed::tests::observations;
    use crate::mismatch::problem::DiagnosisProblem;
    use crate::mismatch::unexplained::strata_tests::{UP_AND_DOWN, baseline, cells};
    use crate::mismatch::{
        Contrast, GaugeSteps, Located, ReadingNoise, SearchOptions, StratumTest, locate,
    };
    use crate::search::put_drawn;
    use crate::tests::{hp_robot, normal};
    use stiffbench_numeric::statistics::normal_upper_tail;

    const STEP_M: f64 = 1e-5;

    fn with_step(step_m: f64) -> Observations {
        Observations {
            steps: GaugeSteps {
                displacement_m: Some(step_m),
                ..GaugeSteps::default()
            },
            ..observations()
        }
    }

    /// The noise of a gauge with errors of 1 um and zeros that hardly scatter.
    fn whitening(observations: &Observations) -> NoiseCovariance {
        with_scatter(observations, (1e-12 + STEP_M * STEP_M / 12.0).sqrt())
    }

    /// The same with readings that scatter otherwise.
    fn with_scatter(observations: &Observations, reading_sd_m: f64) -> NoiseCovariance {
        let noise = ReadingNoise {
            reading_sd_m,
            zero_sd_m: 1e-9,
            run_slope_sd: 1e-9,
            ..ReadingNoise::default()
        };
        let zeros = vec![0.0; observations.len()];
        NoiseCovariance::new(observations, &noise, &zeros, &zeros[..])
    }

    #[test]
    fn errors_are_those_of_a_rounded_normal_number_at_its_place() {
        const NULL_SAMPLES: usize = 4000;
        let observations = with_step(STEP_M);
        let whitening = whitening(&observations);
        let loads = observations.loads.iter();
        let predicted: Vec<f64> = loads.map(|load| 4e-7 * load.force_n).collect();
        let rounded = RoundedNoise::new(&observations, &whitening, predicted.clone()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut means = vec![0.0; observations.len()];
        for _ in 0..NULL_SAMPLES {
            let mut null_vectors = rounded.draw(&mut rng);
            whitening.covariance.unwhiten(&mut null_vectors);
            for (mean, error) in means.iter_mut().zip(null_vectors) {
                *mean += error / NULL_SAMPLES as f64;
            }
        }
        for (mean, predicted) in means.iter().zip(&predicted) {
            // Beyond each edge of a step the number read is one step further.
            let edges = (-8..8).map(|edge| (f64::from(edge) + 0.5) * STEP_M);
            let read: f64 = edges
                .map(|edge| {
                    let beyond = normal_upper_tail((edge - predicted) / 1e-6);
                    STEP_M * if edge < 0.0 { beyond - 1.0 } else { beyond }
                })
                .sum();
            // Five standard errors of a mean, no error being larger than half a step and a few micrometres.
            let tolerance = 5.0 * 5e-6 / (NULL_SAMPLES as f64).sqrt();
            assert!(
                (mean - (read - predicted)).abs() < tolerance,
                "{mean:e} at {predicted:e}"
            );
        }
        // The second load, 5.5 um: read as 10 um two times of three, in every repeat.
        let repeats = [1, 6].map(|place: usize| means[place]);
        assert!(
            repeats.iter().all(|mean| (mean + 1.36e-6).abs() < 4e-7),
            "{repeats:?}"
        );
    }

    #[test]
    fn a_gauge_that_is_fine_enough_is_left_to_other_noise() {
        let fine = with_step(1e-6);
        let predicted = vec![0.0; fine.len()];
        assert!(RoundedNoise::new(&fine, &whitening(&fine), predicted.clone()).is_none());
        let unknown = observations();
        assert!(RoundedNoise::new(&unknown, &whitening(&unknown), predicted).is_none());
    }

    #[test]
    fn errors_of_a_coarse_gauge_keep_their_readings_in_every_draw() {
        // A gauge of 10 um with errors of 0.5 um, always at 3 um in the first run and at -3 um in the others: it reads zero.
        let observations = with_step(STEP_M);
        let whitening = with_scatter(&observations, (2.5e-13_f64 + 1e-10 / 12.0).sqrt());
        let stood_m = |run: usize| if run == 0 { 3e-6 } else { -3e-6 };
        let stood: Vec<f64> = observations
            .readings
            .iter()
            .map(|r| stood_m(r.run))
            .collect();
        let rounded = RoundedNoise::new(&observations, &whitening, stood.clone()).unwrap();
        let mut block = vec![f32::NAN; observations.len() * SAMPLES_TOGETHER];
        put_drawn(&mut block, &rounded, &mut ChaCha8Rng::seed_from_u64(1));
        for (samples, stood) in block.chunks(SAMPLES_TOGETHER).zip(&stood) {
            let error = -stood / whitening.noise.reading_sd_m;
            assert!(
                samples
                    .iter()
                    .all(|white| (f64::from(*white) - error).abs() < 1e-3)
            );
        }
    }

    #[test]
    fn chances_are_counted_among_draws() {
        let observations = with_step(STEP_M);
        let whitening = whitening(&observations);
        // 3 um everywhere: the gauge reads zero, but once in a hundred times with errors of 1 um (2 sd), where it reads 10 um.
        let stood = vec![3e-6; observations.len()];
        let rounded = RoundedNoise::new(&observations, &whitening, stood).unwrap();
        // What every draw shows, what no draw shows, and what the first reading alone shows.
        let seen = |white: &[f64]| vec![0.5, 0.2, if white[0] > 0.0 { 0.1 } else { 0.9 }];
        let found = rounded.chances(&[0.5, 0.1, 0.1], seen);
        assert_eq!(found[..2], [1.0, LEAST_COUNTED]);
        let step_up = normal_upper_tail(2.0);
        assert!((found[2] - step_up).abs() < 5.0 * (step_up / NULL_SAMPLES as f64).sqrt());
        // Errors of -3 um, and of 7 um where it reads 10 um, in units of the noise as it is taken.
        let squares = 9e-12 * (1.0 - step_up) + 49e-12 * step_up;
        let expected = (squares / (1e-12 + STEP_M * STEP_M / 12.0)).sqrt();
        let found = rounded.standard_error(|white| 2.0 * white[0] * white[0]);
        assert!(
            (found / (expected * 2_f64.sqrt()) - 1.0).abs() < 0.05,
            "{found} {expected}"
        );
        assert_eq!(rounded.standard_error(|_| 0.01), 1.0);
    }

    #[test]
    fn noise_before_rounding_is_that_of_the_repeats() {
        const COARSE_M: f64 = 5e-5;
        let planned = cells(&["P1", "P2"], &UP_AND_DOWN, false);
        let observations = Observations::planned(&planned, with_step(COARSE_M).steps, None);
        let both = observations.loads.iter().zip(&observations.readings);
        let predicted: Vec<f64> = both
            .map(|(load, reading)| -4e-6 * load.force_n * (1.0 + 0.03 * reading.run as f64))
            .collect();
        let whitening = with_scatter(&observations, COARSE_M / 12_f64.sqrt());
        for sd_m in [2.5e-6, 5e-6, 1e-5] {
            let errors = normal(predicted.len(), 2);
            let read = predicted.iter().zip(errors).map(|(predicted, normal)| {
                ((predicted + sd_m * normal) / COARSE_M).round() * COARSE_M
            });
            let read = observations.with_displacements(read.collect());
            let rounded = RoundedNoise::new(&read, &whitening, predicted.clone()).unwrap();
            // 450 readings, of which one in twenty stands near an edge: a third is two standard errors.
            let found = rounded.least_sd_m / sd_m;
            assert!((0.6..1.5).contains(&found), "{sd_m:e}: {found}");
        }
    }

    /// A session with nothing missing, as a gauge reads it that is quiet beside its step; its factors are drawn.
    fn located(seed: u64) -> Located {
        const COARSE_M: f64 = 5e-5;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let robot = hp_robot();
        let baseline = baseline(&robot, "F");
        let steps = GaugeSteps {
            force_n: Some(0.1),
            displacement_m: Some(COARSE_M),
        };
        let planned = cells(&["P1", "P2"], &UP_AND_DOWN, false);
        let observations = Observations::planned(&planned, steps, None);
        let problem = DiagnosisProblem::new(&baseline, &observations);
        let mut model = problem.start();
        for factor in &mut model.parameters {
            *factor += 0.2 * normal();
        }
        let predicted = problem.predicted(&model).unwrap();
        let zeros: Vec<f64> = (0..observations.len()).map(|_| 2e-6 * normal()).collect();
        let readings = observations.readings.iter().zip(&predicted);
        let read = readings.map(|(reading, predicted)| {
            let stood = predicted + zeros[reading.zero as usize] + 3e-6 * normal();
            (stood / COARSE_M).round() * COARSE_M
        });
        let read = observations.with_displacements(read.collect());
        locate(&baseline, &read, &SearchOptions::default()).unwrap()
    }

    #[test]
    fn on_a_coarse_gauge_chances_of_strata_are_nearly_uniform() {
        const SESSIONS: u64 = 100;
        let sessions: Vec<Located> = (0..SESSIONS).into_par_iter().map(located).collect();
        let tests = || sessions.iter().flat_map(|session| &session.tests);
        let counted = |test: &&StratumTest| test.contrast != Contrast::Outlier;
        let mut contrasts: Vec<Contrast> = tests().filter(counted).map(|t| t.contrast).collect();
        contrasts.sort_unstable();
        contrasts.dedup();
        assert_eq!(contrasts.len(), 9, "{contrasts:?}");
        for contrast in contrasts {
            let of = tests().filter(|test| test.contrast == contrast);
            let mut p: Vec<f64> = of.map(|test| test.p).collect();
            p.sort_by(f64::total_cmp);
            let share = |place: usize| (place + 1) as f64 / SESSIONS as f64;
            let early = p.iter().enumerate().map(|(place, p)| share(place) - p);
            // Farther once in twenty thousand (Smirnov: exp(-2 n d²)), on one side: where a place decides the rounding, every draw repeats it.
            let early = early.fold(0.0, f64::max);
            // The rounding is itself a period, which scatters less than that of any draw.
            let most = if contrast == Contrast::Period {
                0.5
            } else {
                0.22
            };
            assert!(early < most, "{contrast}: {early}, {p:?}");
            assert!(p[10] < 0.7, "{contrast}: {p:?}");
        }
        let small = tests().filter(|test| test.p <= 0.05).count();
        let families = sessions.iter().filter(|session| {
            let passes = |test: &StratumTest| test.p_family <= 0.05;
            session.tests.iter().any(passes)
        });
        // Three standard deviations above 5 % of 900 and of 100, were all independent.
        let families = families.count();
        assert!(
            (10..=65).contains(&small) && families <= 12,
            "{small}, {families}"
        );
    }
}
