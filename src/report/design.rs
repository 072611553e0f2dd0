//! What a procedure would show, for people and for programs.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::mismatch::{DesignReport, Suspect};
use crate::physics::{ParameterSpec, title};

use super::text::TextTable;

/// Rows of the printed tables.
const ROWS: usize = 40;

/// What a procedure can and cannot show, as tables.
#[must_use]
pub fn design_text(report: &DesignReport) -> String {
    let mut text = format!(
        "Procedure {}: {} readings, about {:.0} minutes. What it would show, with a dial gauge of 10 um read to 6 um:\n\n",
        report.procedure, report.readings, report.minutes
    );
    let mut table = TextTable::new(&[
        "law and place",
        "found in 80 % from, um at the end",
        "hardest to tell apart from",
        "told apart from, um at the end",
    ]);
    for law in report.laws.iter().take(ROWS) {
        let nearest = law.nearest.first();
        let name = nearest.map_or_else(|| "-".to_owned(), |n| title(n.rival.law, &n.rival.place));
        let from = match nearest {
            None => "-".to_owned(),
            Some(rival) if rival.never => "never".to_owned(),
            Some(rival) => rival
                .end_effect_5_m
                .map_or_else(|| "-".to_owned(), |m| format!("{:.1}", m * 1e6)),
        };
        table.row([
            title(law.suspect.law, &law.suspect.place),
            format!("{:.1}", law.end_effect_80_m * 1e6),
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
        text.push_str("\nCannot be told apart at any plausible size:\n");
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

/// The JSON contract's `data` of a design.
#[must_use]
pub fn design_json(report: &DesignReport) -> Value {
    let suspect = |suspect: &Suspect| json!({ "physics": suspect.law.name, "place": suspect.place.to_json() });
    json!({
        "procedure": report.procedure,
        "readings": report.readings,
        "minutes": report.minutes,
        "laws": report.laws.iter().map(|law| json!({
            "physics": law.suspect.law.name,
            "place": law.suspect.place.to_json(),
            "size_80": law.size_80,
            "unit": law.suspect.law.parameters.first().map(ParameterSpec::unit),
            "end_effect_80_um": law.end_effect_80_m * 1e6,
            "nearest": law.nearest.iter().map(|near| json!({
                "physics": near.rival.law.name,
                "place": near.rival.place.to_json(),
                "cosine": near.cosine,
                "size_3": near.size_3,
                "size_5": near.size_5,
                "never": near.never,
            })).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "inseparable": report.inseparable.iter().map(|group| group.iter().map(suspect).collect::<Vec<_>>()).collect::<Vec<_>>(),
        "unseen": report.unseen.iter().map(|unseen| {
            let mut value = suspect(&unseen.suspect);
            value["size_needed"] = json!(unseen.size_needed);
            value
        }).collect::<Vec<_>>(),
    })
}
