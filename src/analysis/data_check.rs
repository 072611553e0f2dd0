//! Readings that cannot be right, without a search for physics.

use crate::mismatch::{KnownNoise, Observations, ScreenedData, screen_data};
use crate::readings::{ReadingTable, SessionHeader};

use super::design::baseline_of;
use super::error::AnalysisError;
use super::model::ResolvedModel;

/// Looks for cells, runs and readings that cannot be right, as a diagnosis does before its search.
///
/// # Errors
/// For poses that the robot does not have, and a structure that cannot be solved.
pub fn check_data(
    table: &ReadingTable,
    header: Option<&SessionHeader>,
    model: &ResolvedModel,
) -> Result<ScreenedData, AnalysisError> {
    let observations = Observations::new(table, header);
    let parameters = model.usual_parameters()?;
    let baseline = baseline_of(model, &observations, &observations.poses, &parameters)?;
    let screened = screen_data(&baseline, &observations, &KnownNoise::Nothing)?;
    Ok(screened)
}
