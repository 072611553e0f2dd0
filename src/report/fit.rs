//! A fit for people and for programs.

use std::fmt::Write;

use crate::fit::{
    FactorStatus, FitMethod, FitOutcome, MonteCarloFit, PaperFit, PoseFit, WeightBasis,
};
use crate::least_squares::SigmaMode;
use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM;

use super::significance::{sequence_text, significance_text};
use super::text::{AlignedTable, interval, significant};

/// Factors, cells, and what to think of them.
#[must_use]
pub fn fit_text(outcome: &FitOutcome) -> String {
    let mut text = format!(
        "Mechanism {}, {}, {}.\n\n",
        outcome.mechanism,
        method_words(outcome.method),
        outcome.termination
    );
    if !outcome.physics.is_empty() {
        text.push_str("Physics beside the beams, held fixed:\n");
        for effect in &outcome.physics {
            let _ = writeln!(text, "  {effect}");
        }
        text.push('\n');
    }
    let bootstrap = outcome
        .estimates
        .iter()
        .any(|estimate| estimate.bootstrap_interval_95.is_some());
    let mut heads = vec!["parameter", "start", "value", "95 % interval", "status"];
    if bootstrap {
        heads.insert(4, "95 %, runs drawn again");
    }
    let mut rows = AlignedTable::new(&heads);
    for estimate in &outcome.estimates {
        let mut cells = vec![
            match estimate.parameter.unit() {
                "1" => estimate.name.clone(),
                unit => format!("{}, {unit}", estimate.name),
            },
            significant(estimate.start, 4),
            significant(estimate.value, 4),
            islands(&estimate.parts_95()),
            estimate.status.word().replace('_', " "),
        ];
        if bootstrap {
            cells.insert(4, interval(estimate.bootstrap_interval_95, 4));
        }
        rows.row(cells);
    }
    text.push_str(&rows.text());
    text.push_str(&words(outcome));
    text.push_str(&agreement_text(outcome));
    text.push('\n');
    text.push_str(&cells_text(outcome));
    for warning in &outcome.warnings {
        let _ = writeln!(text, "\nnote: {warning}");
    }
    text
}

/// The 95 % interval, or the islands that it consists of.
fn islands(parts: &[[f64; 2]]) -> String {
    if parts.is_empty() {
        return interval(None, 4);
    }
    let parts = parts.iter().map(|part| interval(Some(*part), 4));
    parts.collect::<Vec<_>>().join(" or ")
}

/// Sentences about factors that the data do not determine, and what would.
fn words(outcome: &FitOutcome) -> String {
    let mut text = String::new();
    for estimate in &outcome.estimates {
        if let FactorStatus::AtBound { words, .. } | FactorStatus::NotIdentified { words } =
            &estimate.status
        {
            let _ = writeln!(text, "{}: {words}.", estimate.name);
        }
    }
    for advice in &outcome.advice {
        let percent = |ln: f64| format!("{:.0} %", 100.0 * (ln.exp() - 1.0));
        let (now, then) = (
            percent(advice.ln_uncertainty_now),
            percent(advice.ln_uncertainty_then),
        );
        let (factor, at) = (&advice.factor, &advice.measure);
        let _ = if advice.helps() {
            writeln!(
                text,
                "{factor}: a further measurement along {} at {} would help most (standard uncertainty {now} now, {then} then).",
                at.direction, at.pose
            )
        } else {
            writeln!(
                text,
                "{factor}: no single further cell in the robot's poses halves its uncertainty (best: {} at {}, {now} to {then}); more of them, \
                 less scatter, or fixing or tying the parameter would.",
                at.direction, at.pose
            )
        };
    }
    if let Some(correlation) = &outcome.correlation {
        for (i, a) in correlation.names.iter().enumerate() {
            for (j, b) in correlation.names.iter().enumerate().skip(i + 1) {
                let rho = correlation.matrix[i][j];
                if rho.abs() > 0.95 {
                    let _ = writeln!(
                        text,
                        "{a} and {b} can hardly be distinguished: correlation {rho:+.3}."
                    );
                }
            }
        }
    }
    if text.is_empty() {
        text
    } else {
        format!("\n{text}")
    }
}

fn agreement_text(outcome: &FitOutcome) -> String {
    let Some(agreement) = &outcome.agreement else {
        return String::new();
    };
    let sigma = match agreement.sigma {
        SigmaMode::Known if matches!(agreement.basis, WeightBasis::FromResiduals { .. }) => {
            "scatter from run to run taken from the residuals"
        }
        SigmaMode::Known => "uncertainties of the stiffnesses taken as known",
        SigmaMode::Estimated => "scatter about the fit taken as the uncertainty of the stiffnesses",
    };
    let basis = match agreement.basis {
        WeightBasis::Pooled { run_slope_sd, dof } => {
            format!(
                "weights from scatter pooled over the cells (slope from run to run {:.2} %, {dof:.0} degrees of freedom)",
                100.0 * run_slope_sd
            )
        }
        WeightBasis::FromResiduals { run_slope_sd, dof } => {
            format!(
                "weights from reading noise and {:.2} % from run to run ({dof:.0} degrees of freedom)",
                100.0 * run_slope_sd
            )
        }
        WeightBasis::EachCell => "weights from each cell's own scatter".to_owned(),
        WeightBasis::Stated => "weights from the stated uncertainties".to_owned(),
        WeightBasis::Equal => "equal weights".to_owned(),
    };
    let chi = agreement
        .reduced_chi_squared
        .map_or_else(String::new, |chi| match agreement.p_value {
            Some(p) => format!(
                "; reduced chi-squared {chi:.3} with {} degrees of freedom ({})",
                agreement.dof,
                if p < 0.01 {
                    format!("p = {p:.1e}")
                } else {
                    format!("p = {p:.2}")
                }
            ),
            // Of weights that the residuals gave it is 1 by construction, or less.
            None if matches!(agreement.basis, WeightBasis::FromResiduals { .. }) => String::new(),
            None => format!(
                "; scatter about the fit {:.2} % with {} degrees of freedom",
                100.0 * chi.sqrt(),
                agreement.dof
            ),
        });
    format!("\nIntervals: likelihood ratio, {sigma}; {basis}{chi}.\n")
}

fn cells_text(outcome: &FitOutcome) -> String {
    let left_out = outcome
        .cells
        .iter()
        .any(|cell| cell.predicted_without_its_pose_n_per_m.is_some());
    let mut heads = vec![
        "pose",
        "direction",
        "measured, N/um",
        "predicted, N/um",
        "predicted/measured, %",
    ];
    heads.push(if left_out {
        "without its pose, %"
    } else {
        "held out"
    });
    let mut rows = AlignedTable::new(&heads);
    for cell in &outcome.cells {
        rows.row([
            cell.cell.pose.to_string(),
            format!("{} {}", cell.cell.direction, cell.cell.direction.word()),
            significant(cell.measured_n_per_m / N_PER_UM, 4),
            significant(cell.predicted_n_per_m / N_PER_UM, 4),
            format!("{:.2}", cell.ratio_percent()),
            if left_out {
                cell.predicted_without_its_pose_n_per_m.map_or_else(
                    || "-".to_owned(),
                    |k| format!("{:.2}", 100.0 * k / cell.measured_n_per_m),
                )
            } else if cell.held_out {
                "yes".to_owned()
            } else {
                String::new()
            },
        ]);
    }
    let mut text = rows.text();
    if let Some(worst) = outcome.max_error_percent() {
        let unseen = outcome.judged_cells().count() < outcome.cells.len() || left_out;
        let which = if unseen {
            "cells the fit did not see"
        } else {
            "cells of the fit itself"
        };
        let _ = writeln!(text, "\nLargest error over the {which}: {worst:.2} %.");
    }
    text
}

fn method_words(method: FitMethod) -> &'static str {
    match method {
        FitMethod::LeastSquares => "least squares on ln K of all training cells",
        FitMethod::Paper => "the paper's procedure",
    }
}

/// The nine steps for people, up to the combination; step 9 is [`fit_text`].
#[must_use]
pub fn paper_steps_text(fit: &PaperFit) -> String {
    let mut text = format!(
        "Step 1. Objective: a multi-source (M-FSD) model of mechanism {}.\n",
        fit.outcome.mechanism
    );
    if let Some(name) = &fit.single_source_given {
        let _ = writeln!(
            text,
            "\nSteps 2 to 4. Single-source (S-FSD) factors as given: {name} {}.",
            factors_text(fit.single_source_factors.beam)
        );
    } else {
        text.push_str(
            "\nSteps 2 to 4. Single-source (S-FSD) fits to the reference, beams and links alike.\n",
        );
        for pose in &fit.single_source {
            text.push_str(&pose_text(pose));
        }
        let _ = writeln!(
            text,
            "\nCombined: {}.",
            factors_text(fit.single_source_factors.beam)
        );
    }
    let _ = writeln!(
        text,
        "\nStep 5. Beams and links part. Links keep {}.",
        factors_text(fit.start.link)
    );
    text.push_str("\nSteps 6 and 7. Multi-source fits of the beams to the measured stiffness.\n");
    for pose in &fit.multi_source {
        text.push_str(&pose_text(pose));
    }
    let weights = fit
        .multi_source
        .iter()
        .map(|pose| format!("{} {}", pose.pose, pose.weight))
        .collect::<Vec<_>>()
        .join(", ");
    let _ = writeln!(
        text,
        "\nStep 8. Weighted combination ({weights}): beams {}.",
        factors_text(fit.outcome.factors.beam)
    );
    text.push_str("\nStep 9. Validation.\n\n");
    text
}

fn pose_text(pose: &PoseFit) -> String {
    format!(
        "\nPose {}: significance of the constants\n\n{}\nSequence: {}.\n{}",
        pose.pose,
        significance_text(&pose.significance),
        sequence_text(&pose.sequence),
        trials_text(&pose.fit)
    )
}

/// The last pass of the trials.
fn trials_text(fit: &MonteCarloFit) -> String {
    let last = fit.steps.iter().map(|step| step.pass).max().unwrap_or(0);
    let steps = fit
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
        "Trials: {} structures solved; pass {last}: {}.\n",
        fit.evaluations,
        steps.collect::<Vec<_>>().join(", ")
    )
}

fn factors_text(factors: [f64; 4]) -> String {
    let [a, iy, iz, j] = factors.map(|factor| significant(factor, 4));
    format!("a_A = {a}, a_Iy = {iy}, a_Iz = {iz}, a_J = {j}")
}
