//! What of the data cannot be right, and the data without it: the one way in which all who search look at readings first.

use super::bad_readings::screen_readings;
use super::bad_runs::screen_runs;
use super::screened::ScreenedData;
use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::KnownNoise;
use crate::mismatch::observed::Observations;

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
