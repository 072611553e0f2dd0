//! What a procedure would show, for people.

use stiffbench_document::{Document, Table};

use crate::mismatch::DesignReport;

use super::text::or_dash;
use crate::count::{counted, hours_and_minutes};

/// Rows of the printed tables.
const ROWS: usize = 40;

/// What a procedure can and cannot show, as tables.
#[must_use]
pub fn design_document(report: &DesignReport) -> Document {
    let mut document = Document::of(format!(
        "Procedure {}: {}, about {}. What it would show, with a dial gauge of 10 µm read to 6 µm:",
        report.procedure,
        counted(report.readings, "reading"),
        hours_and_minutes(report.minutes)
    ));
    let rows = report.laws.iter().take(ROWS);
    document.table(
        Table::of(rows.map(|law| (law, law.nearest.first())))
            .words("law and place", |(law, _)| law.suspect.to_string())
            .numbers("found in 80 % from, µm at the end", |(law, _)| {
                format!("{:.1}", law.end_effect_80_um)
            })
            .words("hardest to distinguish from", |(_, nearest)| {
                or_dash(*nearest, |one| one.rival.to_string())
            })
            .numbers("distinguished from, µm at the end", |(law, nearest)| {
                if nearest.is_some_and(|rival| rival.never) {
                    return "never".to_owned();
                }
                // What is not found is not distinguished either.
                or_dash(nearest.and_then(|rival| rival.end_effect_5_m), |m| {
                    format!("{:.1}", (m * 1e6).max(law.end_effect_80_um))
                })
            }),
    );
    if report.laws.len() > ROWS {
        document.paragraph(format!(
            "… and {} more: --json lists all.",
            report.laws.len() - ROWS
        ));
    }
    if !report.inseparable.is_empty() {
        document.paragraph("Indistinguishable at any plausible size:");
        for group in &report.inseparable {
            let names: Vec<String> = group.iter().map(ToString::to_string).collect();
            document.item(names.join(" = "));
        }
    }
    if !report.unseen.is_empty() {
        let unseen = report.unseen.iter();
        let names: Vec<String> = unseen.map(|one| one.suspect.to_string()).collect();
        document.paragraph(format!(
            "Not shown at any plausible size: {}.",
            names.join(", ")
        ));
    }
    document
}
