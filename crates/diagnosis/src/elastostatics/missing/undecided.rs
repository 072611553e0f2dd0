//! Load cases that are too few for a diagnosis.

use crate::mismatch::{Verdict, VerdictGrade};
use stiffbench_units_and_text::count::counted;

use super::candidates::not_tested;
use super::outcome::LoadCaseDiagnosis;
use crate::elastostatics::outcome::LoadCaseFit;
use crate::elastostatics::problem::LoadCaseModel;

/// Degrees of freedom that load cases must leave beside the baseline: with fewer no candidate can be believed.
pub(super) const FEWEST_DOF: usize = 6;

/// Poses without which nothing can be distinguished.
pub(super) const FEWEST_POSES: usize = 3;

/// The diagnosis of load cases that are too few.
pub(super) fn undecided(
    model: &LoadCaseModel<'_>,
    baseline: LoadCaseFit,
    dof: usize,
) -> LoadCaseDiagnosis {
    let mut lacking = Vec::new();
    if dof < FEWEST_DOF {
        lacking.push(format!(
            "the free parameters leave {}, and {FEWEST_DOF} are needed: read more components or poses",
            counted(dof, "degree of freedom")
        ));
    }
    let poses = model.posed.labels.len();
    if poses < FEWEST_POSES {
        lacking.push(format!(
            "the data have {}, and {FEWEST_POSES} are needed",
            counted(poses, "pose")
        ));
    }
    LoadCaseDiagnosis {
        verdict: Verdict::InsufficientData,
        grade: VerdictGrade::Undecided,
        lacking,
        not_tested: not_tested(&[], &baseline),
        findings: Vec::new(),
        p_family: 1.0,
        unexplained: None,
        share_of_misfit: None,
        share_unseen: None,
        before_unseen_m: None,
        after_unseen_m: None,
        after_m: baseline.rms_m()[1].unwrap_or_default(),
        parameters_after: Vec::new(),
        candidates: 0,
        from_repeats: false,
        taken_back: 0,
        implausible: Vec::new(),
        bad_values: Vec::new(),
        table_mistake: None,
        baseline,
    }
}
