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
