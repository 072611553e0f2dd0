//! What of the data cannot be right, and the data without it: the one way in which all who search look at readings first.

use super::bad_readings::{BadReading, screen_readings};
use super::bad_runs::{BadRun, screen_runs};
use super::baseline::Baseline;
use super::error::MismatchError;
use super::known_noise::KnownNoise;
use super::observations::Observations;

/// Readings without those that cannot be right.
#[derive(Debug, Clone, PartialEq)]
pub struct ScreenedData {
    /// The others.
    pub observations: Observations,
    /// Runs that their repeats contradict, and cells that cannot be.
    pub bad_runs: Vec<BadRun>,
    /// Readings that their repeats contradict, by their places among those of good runs.
    pub bad_readings: Vec<BadReading>,
    /// Degrees of freedom of Student's t that the others have; none where a normal distribution fits as well, or nothing could be tested.
    pub tails_dof: Option<f64>,
}

/// Looks for cells, runs and readings that cannot be right, in this order, each among what is left.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved at the start of the fit.
pub fn screen_data(
    baseline: &dyn Baseline,
    observations: &Observations,
    noise: &KnownNoise,
) -> Result<ScreenedData, MismatchError> {
    let runs = screen_runs(baseline, observations, noise)?;
    screen_readings(baseline, &runs, noise)
}
