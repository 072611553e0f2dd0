//! What makes a reading differ from the beam model.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Gamma, StandardNormal};

use super::virtual_bench::BenchError;

/// Sizes of the errors of a virtual bench.
///
/// displacement = mechanics + slope of the run × F C + zero + reading error, then rounded to the step of the gauge; the force that acts is
/// what the jack gives, the force that is read is rounded to the step of its gauge.
#[derive(
    Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
pub struct NoiseModel {
    /// Standard deviation of the error of a displacement reading, m.
    pub reading_sd_m: f64,
    /// Standard deviation of the error of a gauge zero, m.
    pub zero_sd_m: f64,
    /// Standard deviation of the slope from run to run, relative (1).
    pub run_slope_sd: f64,
    /// Step of the displacement gauge, m.
    pub displacement_step_m: f64,
    /// Display step of the force gauge, N.
    pub force_step_n: f64,
    /// How the errors are distributed.
    pub shape: NoiseShape,
}

/// How errors of a given standard deviation are distributed; their mean is zero in every shape.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    serde::Serialize,
    serde::Deserialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum NoiseShape {
    /// Normal.
    #[default]
    Normal,
    /// A shifted gamma distribution: sd (G − k)/√k with G from the gamma distribution of shape k = 4 and scale 1.
    ///
    /// Skewness 2/√k = 1, excess kurtosis 6/k = 1.5: no error is below −2 sd, one in a thousand above 4.5 sd.
    Skewed,
}

/// Shape parameter of the skewed errors.
const SKEWED_K: f64 = 4.0;

impl Default for NoiseModel {
    /// A dial gauge that shows micrometres, read to 3 µm, and a force gauge that shows tenths of a newton; zero and seating as on a
    /// careful bench.
    fn default() -> Self {
        Self {
            reading_sd_m: 3e-6,
            zero_sd_m: 2.5e-6,
            run_slope_sd: 0.004,
            displacement_step_m: 1e-6,
            force_step_n: 0.1,
            shape: NoiseShape::Normal,
        }
    }
}

impl NoiseModel {
    /// A bench without any error.
    pub const NONE: Self = Self {
        reading_sd_m: 0.0,
        zero_sd_m: 0.0,
        run_slope_sd: 0.0,
        displacement_step_m: 0.0,
        force_step_n: 0.0,
        shape: NoiseShape::Normal,
    };

    /// Checks that every size can be.
    ///
    /// # Errors
    /// [`BenchError::Noise`].
    pub(super) fn check(&self) -> Result<(), BenchError> {
        for (what, value) in [
            ("the reading error", self.reading_sd_m),
            ("the zero error", self.zero_sd_m),
            ("the run-to-run slope", self.run_slope_sd),
            (
                "the step of the displacement gauge",
                self.displacement_step_m,
            ),
            ("the step of the force gauge", self.force_step_n),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(BenchError::Noise { what, value });
            }
        }
        Ok(())
    }

    /// An error of the given standard deviation.
    pub(super) fn error(&self, sd: f64, rng: &mut ChaCha8Rng) -> f64 {
        match self.shape {
            NoiseShape::Normal => {
                let z: f64 = StandardNormal.sample(rng);
                sd * z
            }
            NoiseShape::Skewed => {
                let gamma = Gamma::new(SKEWED_K, 1.0).expect("the shape is above zero");
                sd * (gamma.sample(rng) - SKEWED_K) / SKEWED_K.sqrt()
            }
        }
    }
}

/// A number rounded to a step; unchanged for a step of zero.
pub(super) fn rounded(value: f64, step: f64) -> f64 {
    if step > 0.0 {
        (value / step).round() * step
    } else {
        value
    }
}

/// Digits behind the decimal point that a step of this size shows.
pub(super) fn decimals(step: f64) -> usize {
    if step > 0.0 {
        (-step.log10()).ceil().clamp(0.0, 9.0) as usize
    } else {
        9
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn both_shapes_have_the_mean_and_the_spread_and_one_is_skewed() {
        for (shape, skewness) in [(NoiseShape::Normal, 0.0), (NoiseShape::Skewed, 1.0)] {
            let noise = NoiseModel {
                shape,
                ..NoiseModel::default()
            };
            let mut rng = ChaCha8Rng::seed_from_u64(5);
            let n = 200_000;
            let errors: Vec<f64> = (0..n).map(|_| noise.error(3.0, &mut rng)).collect();
            let moment =
                |power| errors.iter().map(|e| (e / 3.0).powi(power)).sum::<f64>() / f64::from(n);
            // Standard errors of the moments are 0.0022, 0.0042 at most, 0.018 at most.
            assert!(moment(1).abs() < 0.01, "{shape:?}: {}", moment(1));
            assert!((moment(2) - 1.0).abs() < 0.02, "{shape:?}: {}", moment(2));
            assert!(
                (moment(3) - skewness).abs() < 0.08,
                "{shape:?}: {}",
                moment(3)
            );
        }
    }

    #[test]
    fn steps_round_and_show_their_digits() {
        assert!((rounded(12.34, 0.1) - 12.3).abs() < 1e-12);
        assert_eq!(rounded(12.34, 0.0), 12.34);
        assert_eq!([1.0, 0.1, 0.05, 10.0].map(decimals), [0, 1, 2, 0]);
    }
}
