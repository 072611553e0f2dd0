//! What a procedure would show, for people.

use std::fmt::Write;

use crate::mismatch::DesignReport;

use super::text::AlignedTable;
use crate::count::counted;

/// Rows of the printed tables.
const ROWS: usize = 40;

/// What a procedure can and cannot show, as tables.
#[must_use]
pub fn design_text(report: &DesignReport) -> String {
    let mut text = format!(
        "Procedure {}: {}, about {:.0} minutes. What it would show, with a dial gauge of 10 um read to 6 um:\n\n",
        report.procedure,
        counted(report.readings, "reading"),
        report.minutes
    );
    let mut table = AlignedTable::new(&[
        "law and place",
        "found in 80 % from, um at the end",
        "hardest to distinguish from",
        "distinguished from, um at the end",
    ]);
    for law in report.laws.iter().take(ROWS) {
        let nearest = law.nearest.first();
        let name = nearest.map_or_else(|| "-".to_owned(), |n| n.rival.to_string());
        let from = match nearest {
            None => "-".to_owned(),
            Some(rival) if rival.never => "never".to_owned(),
            // What is not found is not distinguished either.
            Some(rival) => rival.end_effect_5_m.map_or_else(
                || "-".to_owned(),
                |m| format!("{:.1}", (m * 1e6).max(law.end_effect_80_um)),
            ),
        };
        table.row([
            law.suspect.to_string(),
            format!("{:.1}", law.end_effect_80_um),
            name,
            from,
        ]);
    }
    text.push_str(&table.text());
    if report.laws.len() > ROWS {
        let _ = writeln!(
            text,
            "… and {} more: --json has all.",
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
