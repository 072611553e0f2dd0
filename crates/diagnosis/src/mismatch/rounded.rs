//! Noise as a coarse gauge shows it: where its step is what scatters, errors are not drawn anew with every reading but follow where the
//! gauge stands, and come back in every repeat.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::noise::NoiseCovariance;
use super::observations::Observations;
use crate::search::DrawResiduals;
use crate::search::constants::{COARSE, FINEST};

/// Noise of a coarse gauge at the places where it stood.
#[derive(Debug)]
pub(super) struct RoundedNoise<'a> {
    observations: &'a Observations,
    whitening: &'a NoiseCovariance,
    /// Where the gauge stood without noise, m.
    predicted_m: Vec<f64>,
    step_m: f64,
}

impl<'a> RoundedNoise<'a> {
    /// The noise of these observations; `None` if the step of their gauge is not what scatters.
    ///
    /// # Arguments
    /// - `predicted_m`: displacements without noise, m.
    pub(super) fn new(
        observations: &'a Observations,
        whitening: &'a NoiseCovariance,
        predicted_m: Vec<f64>,
    ) -> Option<Self> {
        let step_m = observations.steps.displacement_m?;
        let variance = whitening.noise.reading_sd_m.powi(2);
        let of_step = step_m * step_m / 12.0;
        (of_step > COARSE * variance).then_some(Self {
            observations,
            whitening,
            predicted_m,
            step_m,
        })
    }
}

impl RoundedNoise<'_> {
    /// Errors of all readings, m.
    pub(super) fn errors_m(&self, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let readings = &self.observations.readings;
        let last_zero = readings.iter().map(|reading| reading.zero as usize).max();
        let zeros: Vec<f64> = (0..=last_zero.unwrap_or(0)).map(|_| normal()).collect();
        let runs = &self.observations.runs;
        let slopes: Vec<f64> = runs.iter().map(|_| normal()).collect();
        let of_step = self.step_m * self.step_m / 12.0;
        readings
            .iter()
            .zip(&self.predicted_m)
            .zip(&self.whitening.slope_m)
            .enumerate()
            .map(|(place, ((reading, predicted), slope_m))| {
                let noise = self.whitening.noise_at(place);
                // Before it is rounded.
                let own = (noise.reading_sd_m.powi(2) - of_step).max(0.0).sqrt();
                let stood = predicted
                    + noise.zero_sd_m * zeros[reading.zero as usize]
                    + noise.run_slope_sd * slopes[reading.run] * slope_m
                    + own.max(FINEST * self.step_m) * normal();
                (stood / self.step_m).round() * self.step_m - predicted
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
    use crate::mismatch::changes::tests::observations;
    use crate::mismatch::{GaugeSteps, ReadingNoise};
    use crate::search::constants::SAMPLES_TOGETHER;
    use crate::search::put_drawn;
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
        let noise = ReadingNoise {
            reading_sd_m: (1e-12 + STEP_M * STEP_M / 12.0).sqrt(),
            zero_sd_m: 1e-9,
            run_slope_sd: 1e-9,
            ..ReadingNoise::default()
        };
        let zeros = vec![0.0; observations.len()];
        NoiseCovariance::new(observations, &noise, &zeros, &zeros)
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
        let observations = Observations {
            steps: GaugeSteps {
                displacement_m: Some(1e-5),
                ..GaugeSteps::default()
            },
            ..observations()
        };
        let noise = ReadingNoise {
            reading_sd_m: (2.5e-13_f64 + 1e-10 / 12.0).sqrt(),
            zero_sd_m: 1e-9,
            run_slope_sd: 1e-9,
            ..ReadingNoise::default()
        };
        let zeros = vec![0.0; observations.len()];
        let whitening = NoiseCovariance::new(&observations, &noise, &zeros, &zeros);
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
            let error = -stood / noise.reading_sd_m;
            assert!(
                samples
                    .iter()
                    .all(|white| (f64::from(*white) - error).abs() < 1e-3)
            );
        }
    }
}
