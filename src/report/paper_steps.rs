//! The steps of the paper's method for people.

use std::fmt::Write;

use crate::count::counted;
use crate::fit::MonteCarloFit;

use super::fit_report::{PaperSteps, PoseFitReport};
use super::significance::sequence_text;
use super::text::significant;

impl PaperSteps {
    /// The nine steps for people, up to the combination.
    pub(super) fn text(&self, mechanism: &str) -> String {
        let mut text =
            format!("Step 1. Objective: a multi-source (M-FSD) model of mechanism {mechanism}.\n");
        if let Some(name) = &self.single_source_given {
            let _ = writeln!(
                text,
                "\nSteps 2 to 4. Single-source (S-FSD) factors as given: {name} {}.",
                factors_text(self.single_source_factors.beam)
            );
        } else {
            text.push_str(
            "\nSteps 2 to 4. Single-source (S-FSD) fits to the reference, beams and links alike.\n",
        );
            for pose in &self.single_source {
                text.push_str(&pose_text(pose));
            }
            let _ = writeln!(
                text,
                "\nCombined: {}.",
                factors_text(self.single_source_factors.beam)
            );
        }
        let _ = writeln!(
            text,
            "\nStep 5. Beams and links part. Links keep {}.",
            factors_text(self.start.link)
        );
        text.push_str(
            "\nSteps 6 and 7. Multi-source fits of the beams to the measured stiffness.\n",
        );
        for pose in &self.multi_source {
            text.push_str(&pose_text(pose));
        }
        let weights = self
            .multi_source
            .iter()
            .map(|pose| format!("{} {}", pose.pose, pose.weight))
            .collect::<Vec<_>>()
            .join(", ");
        let _ = writeln!(
            text,
            "\nStep 8. Weighted combination ({weights}): beams {}.",
            factors_text(self.combined.beam)
        );
        text.push_str("\nStep 9. Validation.\n\n");
        text
    }
}

fn pose_text(pose: &PoseFitReport) -> String {
    format!(
        "\nPose {}: significance of the constants\n\n{}\nSequence: {}.\n{}",
        pose.pose,
        pose.significance.table(),
        sequence_text(&pose.sequence),
        trials_text(&pose.trials)
    )
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
        "Trials: {} solved; pass {last}: {}.\n",
        counted(trials.evaluations, "structure"),
        steps.collect::<Vec<_>>().join(", ")
    )
}

fn factors_text(factors: [f64; 4]) -> String {
    let [a, iy, iz, j] = factors.map(|factor| significant(factor, 4));
    format!("a_A = {a}, a_Iy = {iy}, a_Iz = {iz}, a_J = {j}")
}
