//! Cells that were recorded under the name of others, in another unit or with another decimal point: poses, directions or components exchanged.
//!
//! What is compared are the compliances of cells, those measured and those of the baseline, beside one more spring or another structure.

use stiffbench_numeric::statistics::median;

use super::cell_compliance::CellCompliances;
use super::misread::{
    NamedValue, RecordedValues, ValueChange, ValueName, ValueScale, find_mistake,
};
use super::reading_screen::{ReadingScreen, relative_error_of_runs};
use super::screened::BadRun;
use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::observed::{Observations, ObservedCell, ReadingNoise};

/// Relative standard error of the compliance of a cell up to which its logarithm is compared with the model (1): far below a factor of two. By judgement.
const LEAST_KNOWN_CELL: f64 = 0.1;

/// Finds cells that are exchanged, or have another unit or a wrong decimal point, by their places among the observed cells.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved at the start of the fit.
pub(crate) fn wrong_cells(
    baseline: &dyn Baseline,
    observations: &Observations,
    screen: &ReadingScreen<'_>,
    noise: &ReadingNoise,
) -> Result<Vec<(usize, BadRun)>, MismatchError> {
    // A table of single loads was looked at whole, before its fit.
    if !observations.has_series() {
        return Ok(Vec::new());
    }
    let is_along = observations.cells.iter().all(ObservedCell::is_along_load);
    let compliances = by_convention(observations, screen.compliances());
    let (scale, places) = if is_along {
        let uncertainties = screen.relative_uncertainties(noise);
        let known = compliances.iter().zip(uncertainties);
        let is_known = |(_, (one, u)): &(usize, (&f64, f64))| **one > 0.0 && *u < LEAST_KNOWN_CELL;
        let known = known.enumerate().filter(is_known);
        (
            ValueScale::Logarithmic,
            known.map(|(place, _)| place).collect(),
        )
    } else {
        (
            ValueScale::Linear,
            (0..compliances.len()).collect::<Vec<usize>>(),
        )
    };
    let (cells, names) = named(observations, &places, scale);
    let errors = match scale {
        ValueScale::Logarithmic => screen.relative_uncertainties(noise),
        ValueScale::Linear => {
            let usual = usual_errors(observations, &screen.compliance_errors(noise));
            let cells = observations.cells.iter().zip(&compliances).zip(usual);
            let of_runs = cells.map(|((cell, compliance), error)| {
                error.hypot(relative_error_of_runs(cell, noise) * compliance)
            });
            of_runs.collect()
        }
    };
    let values = places.iter().map(|place| NamedValue {
        value: scale.scaled(compliances[*place]),
        u: errors[*place],
    });
    let recorded = RecordedValues {
        names,
        values: values.collect(),
        scale,
        fewest: match scale {
            ValueScale::Logarithmic => 1,
            // Two agree with any line by chance.
            ValueScale::Linear => 3,
        },
        least_variance: 1.0,
    };
    let mut model = CellCompliances::new(baseline, cells, scale)?;
    let Some(found) = find_mistake(&recorded, &mut model) else {
        return Ok(Vec::new());
    };
    let bad = |(cell, change): &(usize, ValueChange)| {
        let (factor, exchanged_with) = match change {
            ValueChange::NameOf(other) => (None, Some(observations.name_of(places[*other]))),
            ValueChange::Times(factor) => (Some(*factor), None),
        };
        let place = places[*cell];
        let u = found.corrected[*cell].u * found.variance.sqrt();
        let (expected, u) = scale.unscaled(found.fit.predicted[*cell], u);
        let (read, _) = scale.unscaled(recorded.values[*cell].value, 0.0);
        let values = [read, expected, u];
        let bad = BadRun {
            exchanged_with,
            ..BadRun::new(observations, (place, None), values, found.p, factor)
        };
        (place, bad)
    };
    Ok(found.mistake.changes.iter().map(bad).collect())
}

/// Compliances with the sign that those along their loads have by the convention of the session: that of most.
fn by_convention(observations: &Observations, mut compliances: Vec<f64>) -> Vec<f64> {
    let along = observations.cells.iter().zip(&compliances);
    let along = along.filter(|(cell, _)| cell.is_along_load());
    let (against, with): (Vec<_>, Vec<_>) = along.partition(|(_, one)| **one < 0.0);
    if against.len() >= with.len().max(1) {
        for one in &mut compliances {
            *one = -*one;
        }
    }
    compliances
}

/// The usual error of displacements per force, and that of rotations: what was read in another unit has its own error in that unit too.
fn usual_errors(observations: &Observations, errors: &[f64]) -> Vec<f64> {
    let cells = || observations.cells.iter();
    let usual = [false, true].map(|rotation| {
        let own = cells().zip(errors);
        let own = own.filter(|(cell, _)| cell.read.is_rotation() == rotation);
        let mut own: Vec<f64> = own.map(|(_, error)| *error).collect();
        median(&mut own).unwrap_or(f64::INFINITY)
    });
    let own = cells().map(|cell| usual[usize::from(cell.read.is_rotation())]);
    own.collect()
}

/// Cells with their names: along their loads the component is the direction of the load.
fn named<'o>(
    observations: &'o Observations,
    places: &[usize],
    scale: ValueScale,
) -> (Vec<&'o ObservedCell>, Vec<ValueName>) {
    let cells: Vec<&ObservedCell> = places.iter().map(|one| &observations.cells[*one]).collect();
    let load = |cell: &ObservedCell| cells.iter().position(|one| one.load == cell.load);
    let names = cells.iter().map(|cell| ValueName {
        pose: cell.pose,
        component: cell.axis().index(),
        kind: usize::from(cell.read.is_rotation()),
        load: match scale {
            ValueScale::Logarithmic => 0,
            ValueScale::Linear => load(cell).unwrap_or(0),
        },
    });
    let names = names.collect();
    (cells, names)
}
