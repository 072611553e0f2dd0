//! The model of a report: fit, diagnosis, and the comparison of two sessions.

use schemars::JsonSchema;
use serde::Serialize;
use stiffbench_document::Document;

use crate::analysis::{DiagnosisReport, ResolvedModel, sha256};
use crate::fit::{FitOutcome, FittedCell};
use crate::report::{
    ComparisonReport, DiagnosisDetail, DiagnosisSummary, FitReport, diagnosis_document, micro,
    significant,
};

use crate::report::diagnosis::{headline_words, next_plans};

/// Robot, mechanism and factors.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageModel {
    /// Name of the robot.
    pub robot: String,
    /// SHA-256 of its file.
    pub robot_sha256: String,
    /// The mechanism.
    pub mechanism: String,
    /// Name of the factor set.
    pub factors: String,
    /// SHA-256 of the factors.
    pub factors_sha256: String,
}

/// A fit with its validation.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PageFit {
    /// How well it predicts cells that it did not see.
    #[serde(skip)]
    pub validation: Option<String>,
    /// Parameters, cells and what to think of them.
    #[serde(skip)]
    pub text: Document,
    /// All numbers.
    pub numbers: Box<FitReport>,
}

/// A diagnosis.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PageDiagnosis {
    /// The verdict in a sentence.
    #[serde(skip)]
    pub headline: String,
    /// What to measure next.
    #[serde(skip)]
    pub next: Vec<String>,
    /// What is missing, where, how sure, what to do next.
    #[serde(skip)]
    pub text: Document,
    /// All numbers.
    pub numbers: DiagnosisSummary,
}

/// The comparison of two sessions.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PageComparison {
    /// Whether they agree.
    #[serde(skip)]
    pub verdict: String,
    /// Differences cell by cell, and the rule.
    #[serde(skip)]
    pub text: Document,
    /// All numbers.
    pub numbers: ComparisonReport,
}

impl From<&ResolvedModel> for PageModel {
    fn from(model: &ResolvedModel) -> Self {
        Self {
            robot: model.robot.name.clone(),
            robot_sha256: sha256(&model.source.text),
            mechanism: model.mechanism.clone(),
            factors: model.factors_name.clone(),
            factors_sha256: sha256(model.factors.to_toml()),
        }
    }
}

impl PageFit {
    pub(super) fn new(outcome: &FitOutcome, numbers: FitReport) -> Self {
        Self {
            validation: if outcome.components.is_empty() {
                validation_by_cells(outcome)
            } else {
                validation_by_components(outcome)
            },
            text: numbers.document(outcome),
            numbers: Box::new(numbers),
        }
    }
}

fn validation_by_cells(outcome: &FitOutcome) -> Option<String> {
    let held_out = outcome.cells.iter().filter(|cell| cell.held_out).count();
    let left_out = |cell: &FittedCell| cell.predicted_without_its_pose_n_per_m.is_some();
    let each = outcome.cells.iter().all(left_out);
    let what = if held_out > 0 {
        format!("over {held_out} poses and directions that the fit did not see")
    } else if !each {
        "over the poses and directions that it was fitted to".to_owned()
    } else {
        "over all poses and directions, each predicted without its own pose".to_owned()
    };
    let percent = significant(outcome.max_error_percent()?, 2);
    Some(format!(
        "The fitted model differs from the measured stiffness by at most {percent} % {what}."
    ))
}

fn validation_by_components(outcome: &FitOutcome) -> Option<String> {
    let what = if outcome.frames.is_some() {
        "positions"
    } else {
        "displacements"
    };
    let [_, _, unseen] = outcome.rms_m();
    let [rigid, unseen] =
        [outcome.rigid_unseen_m()?, unseen?].map(|rms| significant(micro(rms), 3));
    Some(format!(
        "In poses left out of the fit the model differs from the measured {what} by {unseen} µm (root mean square); the rigid robot by {rigid} µm."
    ))
}

impl From<&DiagnosisReport> for PageDiagnosis {
    fn from(report: &DiagnosisReport) -> Self {
        let detail = DiagnosisDetail::Report;
        Self {
            headline: headline_words(report),
            text: diagnosis_document(report, detail),
            next: next_plans(report, detail),
            numbers: report.into(),
        }
    }
}

impl PageComparison {
    pub(super) fn new(numbers: ComparisonReport, [a, b]: [&str; 2]) -> Self {
        Self {
            verdict: numbers.sentence().to_owned(),
            text: numbers.document(a, b),
            numbers,
        }
    }
}
