//! The comparison of two sessions, for people and for programs.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM;
use crate::stiffness::{
    Agreement, Comparison, DECISION_RULE, NotCompared, format_value_uncertainty,
};

use super::text::{TextTable, significant};

/// Differences cell by cell, and the verdict with its rule.
#[must_use]
pub fn comparison_text(comparison: &Comparison, a: &str, b: &str) -> String {
    let mut rows = TextTable::new(&[
        "pose",
        "direction",
        "K of A, N/um",
        "K of B, N/um",
        "B - A, N/um",
        "U",
        "dof",
        "(B - A)/U",
        "differs",
    ]);
    for change in &comparison.changes {
        let rounded = format_value_uncertainty(
            change.change_n_per_m / N_PER_UM,
            change.expanded_n_per_m / N_PER_UM,
        );
        let (difference, uncertainty) = rounded.map_or_else(
            || {
                (
                    significant(change.change_n_per_m / N_PER_UM, 3),
                    "-".to_owned(),
                )
            },
            |rounded| (rounded.value, rounded.uncertainty),
        );
        rows.row([
            change.cell.pose.to_string(),
            change.cell.direction.to_string(),
            significant(change.a_n_per_m / N_PER_UM, 5),
            significant(change.b_n_per_m / N_PER_UM, 5),
            difference,
            uncertainty,
            if change.dof.is_finite() {
                significant(change.dof, 2)
            } else {
                "inf".to_owned()
            },
            format!("{:.2}", change.en_ratio),
            if change.differs { "yes" } else { "" }.to_owned(),
        ]);
    }
    let mut text = format!(
        "A is {a}\nB is {b}\n\n{}\nU is the expanded uncertainty of the difference for 95 %.\n",
        rows.text()
    );
    for (cell, reason) in &comparison.not_compared {
        let _ = writeln!(text, "not compared: {cell}: {}", reason_words(*reason));
    }
    if let Some(overall) = &comparison.overall {
        let _ = writeln!(
            text,
            "\nAll cells together: chi-squared {:.2} with {} degrees of freedom, {}.",
            overall.chi_squared,
            overall.dof,
            probability(overall.p)
        );
    }
    let verdict = match comparison.agreement {
        Agreement::Agrees => "The sessions agree.",
        Agreement::Differs => "The sessions differ.",
        Agreement::NothingToCompare => "There is nothing to compare.",
    };
    let _ = writeln!(text, "{verdict} Rule: {DECISION_RULE}");
    text
}

/// The same for programs.
#[must_use]
pub fn comparison_json(comparison: &Comparison) -> Value {
    let cells: Vec<Value> = comparison
        .changes
        .iter()
        .map(|change| {
            json!({
                "pose": change.cell.pose,
                "direction": change.cell.direction,
                "a": { "value": change.a_n_per_m / N_PER_UM, "unit": "N/um" },
                "b": { "value": change.b_n_per_m / N_PER_UM, "unit": "N/um" },
                "difference": {
                    "value": change.change_n_per_m / N_PER_UM,
                    "unit": "N/um",
                    "u": change.standard_uncertainty_n_per_m / N_PER_UM,
                    "U": change.expanded_n_per_m / N_PER_UM,
                    "dof": change.dof.is_finite().then_some(change.dof),
                },
                "en_ratio": change.en_ratio,
                "differs": change.differs,
            })
        })
        .collect();
    let not_compared: Vec<Value> = comparison
        .not_compared
        .iter()
        .map(|(cell, reason)| json!({ "pose": cell.pose, "direction": cell.direction, "reason": reason_words(*reason) }))
        .collect();
    json!({
        "cells": cells,
        "not_compared": not_compared,
        "overall": comparison.overall.as_ref().map(|o| json!({ "chi2": o.chi_squared, "dof": o.dof, "p": o.p })),
        "verdict": match comparison.agreement {
            Agreement::Agrees => "agrees",
            Agreement::Differs => "differs",
            Agreement::NothingToCompare => "nothing-to-compare",
        },
        "rule": DECISION_RULE,
    })
}

/// A probability in words; one that would print as zero is said to be small.
fn probability(p: f64) -> String {
    if p < 0.001 {
        "p < 0.001".to_owned()
    } else {
        format!("p = {p:.3}")
    }
}

fn reason_words(reason: NotCompared) -> &'static str {
    match reason {
        NotCompared::OnlyInA => "only in A",
        NotCompared::OnlyInB => "only in B",
        NotCompared::NoUncertainty => "without an uncertainty in one of the sessions",
    }
}
