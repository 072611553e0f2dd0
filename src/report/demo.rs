//! The demonstration for programs.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::stiffness::StiffnessTable;

use super::fit_report::FitReport;

/// A demonstration.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DemoReport {
    /// Stiffness of each pose and direction of the session.
    pub stiffness: StiffnessTable,
    /// The fit to it.
    pub fit: FitReport,
    /// The paper's own measured stiffness (Table VI).
    pub paper_table_vi: DemoTableVi,
    /// A second session, with play concealed in a joint.
    pub concealed: DemoConcealed,
    /// Files that were written.
    pub files: Vec<PathBuf>,
}

/// Largest errors in poses left out of fits to the paper's Table VI, %.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DemoTableVi {
    /// The two largest that the paper states for its own model.
    pub stated_worst_percent: [f64; 2],
    /// Of the paper's procedure.
    pub procedure: Option<f64>,
    /// Of the joint fit.
    pub joint: Option<f64>,
}

/// A session with play concealed in a joint: the usual validation passes, and the diagnosis names the play.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DemoConcealed {
    /// The session folder.
    pub session: PathBuf,
    /// The report.
    pub report: PathBuf,
    /// What was concealed, as an effect.
    pub concealed: String,
    /// Largest error in poses left out with which the usual validation passes, %.
    pub limit_percent: f64,
    /// Largest error in poses left out of a fit of beams only, %.
    pub left_out_error_percent: Option<f64>,
    /// The same of a fit with the law that was found, %.
    pub left_out_error_with_law_percent: Option<f64>,
    /// The verdict of the diagnosis.
    pub verdict: String,
    /// Its first sentence.
    pub headline: String,
    /// What it found.
    pub findings: Vec<DemoFinding>,
}

/// Something that the diagnosis found.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DemoFinding {
    /// The law.
    pub law: String,
    /// The joint where it acts.
    pub joint: Option<String>,
    /// The play, microradians.
    pub play_urad: Option<f64>,
    /// The play that was concealed, microradians.
    pub true_play_urad: f64,
}
