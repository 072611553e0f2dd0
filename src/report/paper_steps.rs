//! The steps of the paper's method for people.

use stiffbench_document::Document;

use crate::count::counted;
use crate::fit::MonteCarloFit;

use super::fit_report::{PaperSteps, PoseFitReport};
use super::significance::sequence_text;
use super::text::significant;

impl PaperSteps {
    /// The nine steps for people, up to the combination.
    pub(super) fn document(&self, mechanism: &str) -> Document {
        let mut document = Document::of(format!(
            "Step 1. Objective: a multi-source (M-FSD) model of mechanism {mechanism}."
        ));
        let single_source = factors_text(self.single_source_factors.beam);
        if let Some(name) = &self.single_source_given {
            document.paragraph(format!(
                "Steps 2 to 4. Single-source (S-FSD) factors as given: {name} {single_source}."
            ));
        } else {
            document.paragraph(
                "Steps 2 to 4. Single-source (S-FSD) fits to the reference, beams and links alike.",
            );
            for pose in &self.single_source {
                document.append(of_pose(pose));
            }
            document.paragraph(format!("Combined: {single_source}."));
        }
        document.paragraph(format!(
            "Step 5. Beams and links part. Links keep {}.",
            factors_text(self.start.link)
        ));
        document
            .paragraph("Steps 6 and 7. Multi-source fits of the beams to the measured stiffness.");
        for pose in &self.multi_source {
            document.append(of_pose(pose));
        }
        let weights = self.multi_source.iter();
        let weights = weights.map(|pose| format!("{} {}", pose.pose, pose.weight));
        document.paragraph(format!(
            "Step 8. Weighted combination ({}): beams {}.",
            weights.collect::<Vec<_>>().join(", "),
            factors_text(self.combined.beam)
        ));
        document.paragraph("Step 9. Validation.");
        document
    }
}

fn of_pose(pose: &PoseFitReport) -> Document {
    let mut document = Document::of(format!("Pose {}: significance of the constants", pose.pose));
    document.append(pose.significance.of_constants());
    document.paragraph(format!("Sequence: {}.", sequence_text(&pose.sequence)));
    document.paragraph(trials_text(&pose.trials));
    document
}

/// The last pass of the trials.
fn trials_text(trials: &MonteCarloFit) -> String {
    let last = trials.steps.iter().map(|step| step.pass).max().unwrap_or(0);
    let steps = trials
        .steps
        .iter()
        .filter(|step| step.pass == last)
        .map(|step| {
            format!(
                "a_{} = {} (displacement {} at {:.2} % of the target)",
                step.property.name(),
                significant(step.value, 4),
                step.direction,
                100.0 * step.displacement_ratio
            )
        });
    format!(
        "Trials: {} solved; pass {last}: {}.",
        counted(trials.evaluations, "structure"),
        steps.collect::<Vec<_>>().join(", ")
    )
}

fn factors_text(factors: [f64; 4]) -> String {
    let [a, iy, iz, j] = factors.map(|factor| significant(factor, 4));
    format!("a_A = {a}, a_Iy = {iy}, a_Iz = {iz}, a_J = {j}")
}
