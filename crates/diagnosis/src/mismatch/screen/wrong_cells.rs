//! Cells that were recorded under the name of others, in another unit or with another decimal point: poses or directions exchanged.
//!
//! What is compared are the logarithms of the compliances of cells, those measured and those of the baseline, beside one more spring or another
//! structure.

use super::cell_compliance::CellCompliances;
use super::misread::{MisreadValues, NamedValue, ValueChange, ValueName, find_mistake};
use super::reading_screen::ReadingScreen;
use super::screened::BadRun;
use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::KnownNoise;
use crate::mismatch::observed::Observations;

/// Relative standard error of the compliance of a cell up to which it is compared with the model (1): far below a factor of two. By judgement.
const LEAST_KNOWN_CELL: f64 = 0.1;

/// Finds cells that are exchanged, or have another unit or a wrong decimal point, by their places among the observed cells.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved at the start of the fit.
pub(crate) fn wrong_cells(
    baseline: &dyn Baseline,
    observations: &Observations,
    noise: &KnownNoise,
) -> Result<Vec<(usize, BadRun)>, MismatchError> {
    let (mut cells, places) = measured(baseline, observations, noise)?;
    let Some(found) = find_mistake(&mut cells) else {
        return Ok(Vec::new());
    };
    let bad = |(cell, change): &(usize, ValueChange)| {
        let (factor, exchanged_with) = match change {
            ValueChange::NameOf(other) => (None, Some(observations.name_of(places[*other]))),
            ValueChange::Times(factor) => (Some(*factor), None),
        };
        let (place, expected) = (places[*cell], found.fit.predicted[*cell].exp());
        let u = found.corrected[*cell].u * found.variance.sqrt() * expected;
        let values = [cells.values()[*cell].value.exp(), expected, u];
        let bad = BadRun {
            exchanged_with,
            ..BadRun::new(observations, (place, None), values, found.p, factor)
        };
        (place, bad)
    };
    Ok(found.mistake.changes.iter().map(bad).collect())
}

/// The compliances of cells that the readings determine, their logarithms in m/N, with the places of the cells.
fn measured<'b>(
    baseline: &'b dyn Baseline,
    observations: &Observations,
    noise: &KnownNoise,
) -> Result<(CellCompliances<'b>, Vec<usize>), MismatchError> {
    let screen = ReadingScreen::new(baseline, observations, noise)?;
    let found = screen.noise_of_all();
    let uncertainties = screen.relative_uncertainties(&found);
    let compliance = |place: usize| screen.compliance[observations.cells[place].readings.start];
    // Across the load a compliance has either sign.
    let mut along: Vec<usize> = (0..observations.cells.len()).collect();
    along.retain(|place| observations.cells[*place].is_along_load());
    // Where most yield against their load, that is the convention of the session.
    let against = along
        .iter()
        .filter(|place| compliance(**place) < 0.0)
        .count();
    let is_convention = 2 * against >= along.len();
    let sign = if is_convention { -1.0 } else { 1.0 };
    let is_usual = |place: &usize| sign * compliance(*place) > 0.0;
    along.retain(|place| is_usual(place) && uncertainties[*place] < LEAST_KNOWN_CELL);
    let names = along.iter().map(|place| ValueName {
        pose: observations.cells[*place].pose,
        component: observations.cells[*place].axis().index(),
        kind: 0,
        load: 0,
    });
    let logs = along.iter().map(|place| NamedValue {
        value: compliance(*place).abs().ln(),
        u: uncertainties[*place],
    });
    let cells = CellCompliances::new(baseline, names.collect(), logs.collect())?;
    Ok((cells, along))
}
