//! The screw jack and the operator who turns it.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use stiffbench_measurement::procedure::Pace;

/// How loads are applied; how close to its target the operator stops is a matter of the procedure.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Jack {
    /// How fast the operator works; each time varies by a fifth.
    pub pace: Pace,
}

/// Seconds by which the moment of an extra reading misses its time, at most.
const HOLD_MISSED_S: f64 = 2.0;

/// The force that acts when `target_n` was aimed at; without load the gauge hangs free and the force is exactly zero.
pub(super) fn force_n(target_n: f64, tolerance_n: f64, rng: &mut ChaCha8Rng) -> f64 {
    if target_n == 0.0 {
        return 0.0;
    }
    target_n + tolerance_n * (2.0 * rng.random::<f64>() - 1.0)
}

/// A time that varies by a fifth from one to the next.
pub(super) fn seconds(mean_s: f64, rng: &mut ChaCha8Rng) -> f64 {
    mean_s * (0.8 + 0.4 * rng.random::<f64>())
}

/// When an extra reading planned for `hold_s` is made: about then, and a second at least after the reading before it.
pub(super) fn extra_hold_s(hold_s: f64, before_s: f64, rng: &mut ChaCha8Rng) -> f64 {
    let missed_s = HOLD_MISSED_S * (2.0 * rng.random::<f64>() - 1.0);
    (hold_s + missed_s).max(before_s + 1.0)
}
