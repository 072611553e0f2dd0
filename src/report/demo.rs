//! The demonstration for programs.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;
use stiffbench_document::{Document, Table};

use crate::fit::FitOutcome;
use crate::stiffness::StiffnessTable;

use super::fit_report::FitReport;
use super::paper::printed_rows;

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

impl DemoTableVi {
    /// Of both fits to the measured stiffness of P1 and P3, validated on P2 and P4.
    #[must_use]
    pub fn new(procedure: &FitOutcome, joint: &FitOutcome) -> Self {
        let printed = printed_rows().into_iter().filter(|row| {
            row.table == "VI"
                && row.mechanism_or_model == "M-FSD/experiment"
                && ["P2", "P4"].contains(&row.pose.as_str())
        });
        let mut errors: Vec<f64> = printed.map(|row| (row.value - 100.0).abs()).collect();
        errors.sort_by(|a, b| b.total_cmp(a));
        Self {
            stated_worst_percent: [0, 1]
                .map(|place| errors.get(place).copied().unwrap_or(f64::NAN)),
            procedure: procedure.max_error_percent(),
            joint: joint.max_error_percent(),
        }
    }

    /// The two largest errors of each.
    #[must_use]
    pub fn document(&self, procedure: &FitOutcome, joint: &FitOutcome) -> Document {
        let worst = |outcome: &FitOutcome| {
            let mut errors: Vec<(f64, String)> = outcome
                .judged_cells()
                .map(|cell| (cell.error_percent(), cell.cell.to_string()))
                .collect();
            errors.sort_by(|a, b| b.0.total_cmp(&a.0));
            let known = |(error, cell): &(f64, String)| format!("{error:.2} % ({cell})");
            [0, 1].map(|place| errors.get(place).map_or_else(String::new, known))
        };
        let stated = self.stated_worst_percent;
        let mut document = Document::of("The paper's own measured stiffness (Table VI)");
        document.table(
            Table::of([
                (
                    "the paper's model, as printed",
                    stated.map(|error| format!("{error:.2} %")),
                ),
                ("its procedure, on this reconstruction", worst(procedure)),
                ("joint least squares, on this reconstruction", worst(joint)),
            ])
            .words(
                "fit to the measured stiffness of P1 and P3, validated on P2 and P4",
                |(name, _)| *name,
            )
            .numbers("largest error", |(_, [first, _])| first.clone())
            .numbers("second", |(_, [_, second])| second.clone()),
        );
        document
    }
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
