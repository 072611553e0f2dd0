//! What data lack to decide anything.

use stiffbench_beams::physics::TestObject;
use stiffbench_units_and_text::count::counted;

use crate::mismatch::observed::Observations;
use crate::mismatch::problem::DiagnosisProblem;
use crate::search::constants::{ENOUGH_OF_A_LINE, FEWEST_LEFT};

/// Poses without which readings that are not repeated distinguish nothing. By judgement (e15065f).
const FEWEST_POSES: usize = 3;

/// What must be there before anything can be decided.
///
/// # Arguments
/// - `is_from_fit`: whether the noise is what the fit leaves.
pub(crate) fn lacking(problem: &DiagnosisProblem<'_>, is_from_fit: bool) -> Vec<String> {
    let mut lacking = Vec::new();
    let observations = problem.observations;
    // Own weight loads what a tracker sees.
    let is_loaded =
        observations.tracker.is_some() || observations.loads.iter().any(|load| load.force_n != 0.0);
    // A line through many readings shows its own scatter.
    let is_line = observations.free_zeros;
    if !is_loaded && !is_line {
        lacking.push("no reading is under load".to_owned());
    }
    let several = observations.has_repeats();
    let is_long = is_line && observations.len() >= ENOUGH_OF_A_LINE;
    let (readings, parameters) = (observations.len(), problem.baseline.parameters().len());
    if observations.object == TestObject::Robot {
        let dof = readings.saturating_sub(parameters);
        if is_from_fit && dof < FEWEST_LEFT {
            lacking.push(format!(
                "the free parameters leave {}, and {FEWEST_LEFT} are needed: read more components or poses",
                counted(dof, "degree of freedom")
            ));
        }
        let poses = observations.poses.len();
        if is_from_fit && poses < FEWEST_POSES {
            lacking.push(format!(
                "no load sequence was repeated: then at least {FEWEST_POSES} poses are needed, and the data have {poses}; or take three repeats"
            ));
        }
    } else if !several && !is_long {
        let or = if is_line {
            format!(", or {ENOUGH_OF_A_LINE} readings along the line")
        } else {
            String::new()
        };
        lacking.push(format!(
            "no load sequence was repeated: the scatter and missing physics cannot be distinguished; at least three repeats are needed{or}"
        ));
    }
    lacking.extend(observations.response_doubt.map(|doubt| doubt.to_string()));
    if readings < 3 * parameters + 6 {
        lacking.push(format!(
            "{readings} readings are too few for {}",
            counted(parameters, "factor")
        ));
    }
    lacking
}

/// Why a scatter that the fit leaves cannot show that nothing is missing.
pub(crate) fn lacking_scatter(observations: &Observations) -> String {
    let or = if observations.has_series() {
        ""
    } else {
        ", or state the scatter (--displacement-u)"
    };
    format!(
        "no load sequence was repeated: the scatter is known from the fit alone, which may hide missing physics; take at least three repeats{or}"
    )
}

/// Why a single cell cannot show that nothing is missing: the free factors fit any stiffness of it.
pub(crate) fn lacking_cells(problem: &DiagnosisProblem<'_>) -> Option<String> {
    let factors = problem.baseline.parameters().len();
    let observations = problem.observations;
    let absorbed = !observations.free_zeros && observations.cells.len() == 1 && factors > 0;
    absorbed.then(|| {
        format!(
            "1 cell for {}: they fit any stiffness, so no missing compliance can be detected; measure other directions and poses, or fix the factors with --parameter NAME=fixed",
            counted(factors, "free factor")
        )
    })
}
