//! What makes a reading differ from the beam model.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Sizes of the errors of a virtual bench.
///
/// displacement = F C (1 + slope of the run) + zero of the run + reading error, then rounded to the step of the gauge; the force that
/// acts is what the jack gives, the force that is read is rounded to the step of its gauge.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct NoiseModel {
    /// Standard deviation of the error of a displacement reading, m.
    pub reading_sd_m: f64,
    /// Standard deviation of the error of a gauge zero, m.
    pub zero_sd_m: f64,
    /// Standard deviation of the slope from run to run, relative (1).
    pub run_slope_sd: f64,
    /// Step of the displacement gauge, m.
    pub displacement_step_m: f64,
    /// Step of the force gauge, N.
    pub force_step_n: f64,
}

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
    };
}

/// A normal error of the given standard deviation.
pub(super) fn normal(rng: &mut ChaCha8Rng, sd: f64) -> f64 {
    let z: f64 = StandardNormal.sample(rng);
    sd * z
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

    #[test]
    fn steps_round_and_show_their_digits() {
        assert!((rounded(12.34, 0.1) - 12.3).abs() < 1e-12);
        assert_eq!(rounded(12.34, 0.0), 12.34);
        assert_eq!([1.0, 0.1, 0.05, 10.0].map(decimals), [0, 1, 2, 0]);
    }
}
