//! Rounding to the step of a coarse gauge, which is the same in every repeat.

use std::f64::consts::TAU;
use std::ops::Range;

use super::noise::{ReadingNoise, for_each_zero};
use super::observations::Observations;

/// What the rounding of a coarse gauge does alike wherever it stands alike.
///
/// With errors much smaller than its step q a gauge rounds the same position the same way. Averaged over where it stands, the mean
/// error of a rounded reading with normal noise σ has the covariance Σₖ q²/(2π²k²) exp(-4π²k²σ²/q²) cos(2πk d/q) over a distance d
/// (Widrow and Kollár, Quantization Noise, 2008, ch. 5 and 20); of k > 2 next to nothing is left where σ is a tenth of q.
pub(super) struct Rounding {
    step_m: f64,
    harmonics: Vec<Harmonic>,
}

/// One term of the sum.
struct Harmonic {
    /// 2πk/q, 1/m.
    wave_number: f64,
    /// Variance of the cosine and of the sine that all runs of a cell share, m².
    shared: f64,
    /// The same of each zero for itself: its own scatter moves it along the step.
    own: f64,
}

impl Rounding {
    /// Terms of the sum.
    const HARMONICS: u32 = 2;

    /// Share of a reading's variance from which on a term is worth its columns.
    const WORTH: f64 = 0.02;

    /// Zeros of a group from which on what each has for itself is left out: the rank of a group is bounded.
    const MOST_ZEROS: usize = 10;

    /// For a noise whose reading error has the step in it.
    pub(super) fn new(observations: &Observations, noise: &ReadingNoise) -> Self {
        let step_m = observations.steps.displacement_m.unwrap_or(0.0);
        let variance = noise.reading_sd_m.powi(2);
        let pure = (variance - step_m * step_m / 12.0).max(0.0);
        let harmonic = |k: u32| {
            let wave_number = TAU * f64::from(k) / step_m;
            let fade = |variance: f64| (-wave_number * wave_number * variance).exp();
            let whole = 2.0 / (wave_number * wave_number) * fade(pure);
            let alike = fade(noise.zero_sd_m.powi(2));
            (whole > Self::WORTH * variance).then_some(Harmonic {
                wave_number,
                shared: whole * alike,
                own: whole * (1.0 - alike),
            })
        };
        let count = if step_m > 0.0 { Self::HARMONICS } else { 0 };
        Self {
            step_m,
            harmonics: (1..=count).filter_map(harmonic).collect(),
        }
    }

    /// The part of a reading's variance that it describes, m².
    pub(super) fn variance(&self) -> f64 {
        let sum: f64 = self.harmonics.iter().map(|h| h.shared + h.own).sum();
        // Never the whole: what is left keeps a reading's weight finite.
        sum.min(0.95 * self.step_m * self.step_m / 12.0)
    }

    /// Whether the runs of a cell share some of it.
    pub(super) fn is_shared(&self) -> bool {
        !self.harmonics.is_empty()
    }

    /// Adds the columns of a group of readings: square roots of their variance, made white.
    pub(super) fn add_columns(
        &self,
        observations: &Observations,
        position_m: &[f64],
        weights: &[f64],
        readings: &Range<usize>,
        columns: &mut Vec<f64>,
    ) {
        let mut zeros: Vec<u32> = readings
            .clone()
            .map(|r| observations.readings[r].zero)
            .collect();
        zeros.sort_unstable();
        zeros.dedup();
        for harmonic in &self.harmonics {
            let mut add = |variance: f64, member: &dyn Fn(usize) -> bool| {
                for wave in [f64::cos, f64::sin] {
                    columns.extend(readings.clone().map(|r| {
                        let here = f64::from(u8::from(member(r)));
                        let angle = harmonic.wave_number * position_m[r];
                        here * variance.sqrt() * wave(angle) * weights[r]
                    }));
                }
            };
            add(harmonic.shared, &|_| true);
            if zeros.len() <= Self::MOST_ZEROS {
                for_each_zero(observations, readings, |member| add(harmonic.own, member));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::mismatch::observations::GaugeSteps;

    /// Mean error of a rounded reading at a position, the noise integrated over, in steps.
    fn mean_error(position: f64, sd: f64) -> f64 {
        let (count, reach) = (4001, 8.0);
        let (mut sum, mut weights) = (0.0, 0.0);
        for place in 0..count {
            let z = reach * (2.0 * f64::from(place) / f64::from(count - 1) - 1.0);
            let weight = (-0.5 * z * z).exp();
            let read = position + sd * z;
            sum += weight * (read.round() - position);
            weights += weight;
        }
        sum / weights
    }

    #[test]
    fn variance_is_that_of_the_mean_error_over_all_positions() {
        for sd in [0.1, 0.15, 0.2, 0.25] {
            let positions = 200;
            let square = (0..positions)
                .map(|place| mean_error(f64::from(place) / f64::from(positions), sd).powi(2))
                .sum::<f64>()
                / f64::from(positions);
            let observations = with_step(Some(1.0));
            let rounding = Rounding::new(
                &observations,
                &ReadingNoise {
                    reading_sd_m: (sd * sd + 1.0 / 12.0).sqrt(),
                    zero_sd_m: 0.2,
                    run_slope_sd: 1e-3,
                },
            );
            // The second harmonic is left out where it is small, the third always: at a tenth of a step 5 and 0.5 % of the first.
            let left_out = |k: f64| (4.0 * (1.0 - k * k) * (PI * sd).powi(2)).exp() / (k * k);
            let ratio = rounding.variance() / square;
            assert!(
                (ratio - 1.0).abs() < left_out(2.0) + 0.01,
                "sd {sd}: {ratio}"
            );
        }
    }

    #[test]
    fn fine_gauges_have_no_columns() {
        let noise = ReadingNoise {
            reading_sd_m: 1e-6,
            zero_sd_m: 1e-6,
            run_slope_sd: 1e-3,
        };
        for step_m in [Some(1e-6), None] {
            assert_eq!(Rounding::new(&with_step(step_m), &noise).variance(), 0.0);
        }
    }

    fn with_step(displacement_m: Option<f64>) -> Observations {
        let steps = GaugeSteps {
            displacement_m,
            force_n: None,
        };
        Observations::planned(&[], steps, None)
    }
}
