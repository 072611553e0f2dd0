//! The screw jack and the operator who turns it.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// How loads are applied.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Jack {
    /// The operator stops within this of the target, N.
    pub force_tolerance_n: f64,
    /// From one reading to the next, s.
    pub seconds_per_reading: f64,
    /// From the last reading of a run to the first of the next, s.
    pub seconds_per_zero: f64,
    /// From load to capture, s.
    pub hold_s: f64,
}

impl Default for Jack {
    /// The tolerance of the shipped procedures; times as an operator with a hand jack takes them.
    fn default() -> Self {
        Self {
            force_tolerance_n: 0.5,
            seconds_per_reading: 12.0,
            seconds_per_zero: 45.0,
            hold_s: 5.0,
        }
    }
}

impl Jack {
    /// The force that acts when `target_n` was aimed at; without load the gauge hangs free and the force is exactly zero.
    pub(super) fn force_n(&self, target_n: f64, rng: &mut ChaCha8Rng) -> f64 {
        if target_n == 0.0 {
            return 0.0;
        }
        target_n + self.force_tolerance_n * (2.0 * rng.random::<f64>() - 1.0)
    }

    /// A time that varies by a fifth from one to the next.
    pub(super) fn seconds(mean_s: f64, rng: &mut ChaCha8Rng) -> f64 {
        mean_s * (0.8 + 0.4 * rng.random::<f64>())
    }
}
