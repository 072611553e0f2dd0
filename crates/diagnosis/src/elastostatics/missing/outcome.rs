//! What a diagnosis of load cases says.

use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use stiffbench_units_and_text::test_point::PoseId;

use crate::mismatch::{Verdict, VerdictGrade};

use super::bad_values::BadLoadCaseValue;
use super::table_mistake::TableMistake;
use crate::elastostatics::outcome::{LoadCaseFit, in_micro};

/// Another candidate in the place of a finding.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "LoadCaseRivalReport")]
pub struct LoadCaseRival {
    /// Its name.
    pub name: String,
    /// Where, in words.
    pub place: String,
    /// Natural logarithm of the Bayes factor of the finding against it.
    #[serde(rename = "log_bayes_factor_to_winner")]
    pub log_bayes_to_winner: f64,
    /// Cosine of the angle between the two effects, white and projected.
    pub cosine: f64,
}

/// Whether an error of the set-up is meant, in a word.
#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes a reference"
)]
fn kind<S: Serializer>(is_set_up: &bool, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(if *is_set_up { "setup" } else { "physics" })
}

/// Something that acts beside the parameters of the baseline.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "LoadCaseFindingReport")]
pub struct LoadCaseFinding {
    /// Its name: of a spring that of the parameter, for example `joint.J3.z`, which `--free` takes.
    pub name: String,
    /// Name of the law.
    #[serde(rename = "physics")]
    pub law: &'static str,
    /// Where, in words.
    pub place: String,
    /// Whether it is an error of the set-up; else physics of the robot: in JSON `setup` or `physics`.
    #[serde(rename = "kind", serialize_with = "kind")]
    #[schemars(with = "String")]
    pub is_set_up: bool,
    /// Its size in `unit`.
    pub value: f64,
    /// Its standard error.
    #[serde(rename = "se")]
    pub standard_error: f64,
    /// 95 % interval of the size, cut at the ends of what is possible; it contains the size, which is possible too. An end that is `null` in JSON
    /// is infinite.
    #[serde(rename = "ci95")]
    #[schemars(with = "[Option<f64>; 2]")]
    pub interval_95: [f64; 2],
    /// ASCII unit.
    pub unit: &'static str,
    /// Largest change of a displacement, m, in JSON um.
    #[serde(rename = "end_effect_um", serialize_with = "in_micro")]
    pub end_effect_m: f64,
    /// Its length in standard errors, beside the others.
    pub standard_errors: f64,
    /// Natural logarithm of the Bayes factor against the model without it.
    #[serde(rename = "log_bayes_factor")]
    pub log_bayes: f64,
    /// Candidates that the load cases cannot distinguish from it.
    pub alternatives: Vec<LoadCaseRival>,
    /// The nearest that they distinguish.
    pub rivals: Vec<LoadCaseRival>,
}

/// What the final model leaves.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "LoadCaseUnexplainedReport")]
pub struct LoadCaseUnexplained {
    /// Chance that noise alone leaves as much structure.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p: f64,
    /// The test that shows most, in words.
    pub test: &'static str,
    /// The pose of the largest residual.
    pub pose: PoseId,
    /// Its component, for example `displacement y`.
    pub component: &'static str,
    /// Its size, m or rad, in JSON in `unit`.
    #[serde(serialize_with = "in_micro")]
    pub size: f64,
    /// `um` or `urad`.
    pub unit: &'static str,
    /// Its size in standard errors.
    pub standard_errors: f64,
}

/// A candidate that fitted best with a size beyond what is plausible: no explanation.
#[derive(Debug, Clone, PartialEq)]
pub struct ImplausibleSize {
    /// Its name, for example `force-axes.x`.
    pub name: String,
    /// The size that it would have to have, in `unit`.
    pub value: f64,
    /// Smallest and largest plausible size.
    pub bounds: [f64; 2],
    /// ASCII unit.
    pub unit: &'static str,
}

/// A diagnosis of load cases.
#[derive(Debug, Clone)]
pub struct LoadCaseDiagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// How far it may be relied on.
    pub grade: VerdictGrade,
    /// What the load cases lack, where they cannot decide.
    pub lacking: Vec<String>,
    /// Names of the laws of which no candidate was tried.
    pub not_tested: Vec<&'static str>,
    /// What is missing; with the verdict unknown what explains part of it.
    pub findings: Vec<LoadCaseFinding>,
    /// Chance that noise alone gives any candidate as much as the first finding, or the best candidate if there is none.
    pub p_family: f64,
    /// What is left.
    pub unexplained: Option<LoadCaseUnexplained>,
    /// Share of the misfit of the baseline that the findings explain; `None` where the misfit is too small.
    pub share_of_misfit: Option<f64>,
    /// The same in poses that were left out.
    pub share_unseen: Option<f64>,
    /// Root mean square of the displacements that the baseline leaves in poses left out, m.
    pub before_unseen_m: Option<f64>,
    /// The same with the findings.
    pub after_unseen_m: Option<f64>,
    /// Root mean square of the displacements that the final model leaves, m.
    pub after_m: f64,
    /// Values of the free parameters beside the findings, by name.
    pub parameters_after: Vec<(String, f64)>,
    /// Number of candidates that were tried.
    pub candidates: usize,
    /// Whether the scatter comes from repeats.
    pub from_repeats: bool,
    /// How many candidates of an unknown cause are not named because they raise the error in poses left out, or are more than three.
    pub taken_back: usize,
    /// Candidates that were rejected, in the order in which the search met them.
    pub implausible: Vec<ImplausibleSize>,
    /// Values that were left out of everything else here.
    pub bad_values: Vec<BadLoadCaseValue>,
    /// Readings that would agree with all others if they were multiplied.
    pub table_mistake: Option<TableMistake>,
    /// The baseline, without the bad values.
    pub baseline: LoadCaseFit,
}
