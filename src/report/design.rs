//! What a procedure would show, for people.

use std::fmt::Write;

use stiffbench_document::table_of;

use crate::mismatch::DesignReport;

use super::text::or_dash;
use crate::count::{counted, hours_and_minutes};

/// Rows of the printed tables.
const ROWS: usize = 40;

/// What a procedure can and cannot show, as tables.
#[must_use]
pub fn design_text(report: &DesignReport) -> String {
    let mut text = format!(
        "Procedure {}: {}, about {}. What it would show, with a dial gauge of 10 um read to 6 um:\n\n",
        report.procedure,
        counted(report.readings, "reading"),
        hours_and_minutes(report.minutes)
    );
    let rows = report.laws.iter().take(ROWS);
    text.push_str(
        &table_of(
            rows.map(|law| (law, law.nearest.first())),
            &[
                ("law and place", &|(law, _)| law.suspect.to_string()),
                ("found in 80 % from, um at the end", &|(law, _)| {
                    format!("{:.1}", law.end_effect_80_um)
                }),
                ("hardest to distinguish from", &|(_, nearest)| {
                    or_dash(*nearest, |one| one.rival.to_string())
                }),
                ("distinguished from, um at the end", &|(law, nearest)| {
                    if nearest.is_some_and(|rival| rival.never) {
                        return "never".to_owned();
                    }
                    // What is not found is not distinguished either.
                    or_dash(nearest.and_then(|rival| rival.end_effect_5_m), |m| {
                        format!("{:.1}", (m * 1e6).max(law.end_effect_80_um))
                    })
                }),
            ],
        )
        .text(),
    );
    if report.laws.len() > ROWS {
        let _ = writeln!(
            text,
            "… and {} more: --json lists all.",
            report.laws.len() - ROWS
        );
    }
    if !report.inseparable.is_empty() {
        text.push_str("\nIndistinguishable at any plausible size:\n");
        for group in &report.inseparable {
            let names: Vec<String> = group.iter().map(ToString::to_string).collect();
            let _ = writeln!(text, "- {}", names.join(" = "));
        }
    }
    if !report.unseen.is_empty() {
        let names: Vec<String> = report
            .unseen
            .iter()
            .map(|u| u.suspect.to_string())
            .collect();
        let _ = writeln!(
            text,
            "\nNot shown at any plausible size: {}.",
            names.join(", ")
        );
    }
    text
}
