//! What the doors answer, and how often their intervals hold the truth.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use crate::prove::{CoverageRow, JudgedCase};
use stiffbench::report::Table;

use super::share_words;

/// Characters of an answer in the table.
const LONGEST: usize = 48;

/// The same readings by every door.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DoorsReport {
    /// Every case.
    pub cases: Vec<JudgedCase>,
    /// Where the ledger is not what was judged; empty if it is.
    pub disagreements: Vec<String>,
    /// How often intervals hold the truth; empty if it was not counted.
    pub coverage: Vec<CoverageRow>,
}

/// Tables, and where the ledger is wrong.
#[must_use]
pub fn doors_text(report: &DoorsReport) -> String {
    let right = report.cases.iter().filter(|case| case.differs.is_empty());
    let mut text = format!(
        "The same readings by every door: {} of {} cases right.\n\n",
        right.count(),
        report.cases.len()
    );
    let named = |case: &&JudgedCase| match case.effect.split(':').next() {
        None | Some("") => "nothing".to_owned(),
        Some(named) => named.to_owned(),
    };
    let table = Table::of(&report.cases)
        .words("judge", |case| case.judge.name())
        .words("bench", |case| &case.bench)
        .words("effect", named)
        .words("session", |case| shortened(&case.session))
        .words("table", |case| shortened(&case.table))
        .words("differs", |case| shortened(&case.differs.join("; ")));
    text.push_str(&table.text());
    if !report.coverage.is_empty() {
        text.push_str("\nIntervals that hold the truth; 93 to 97 % are right. The interval of all factors is from session to session.\n\n");
        let percent = |[low, high]: [f64; 2]| format!("{:.1} to {:.1}", 100.0 * low, 100.0 * high);
        let table = Table::of(&report.coverage)
            .words("door", |row| row.door)
            .words("command", |row| row.command)
            .words("factor", |row| row.parameter.as_deref().unwrap_or("all"))
            .numbers_each(["hits", "%"], |row| {
                let [hits, share, _] = share_words(&row.share);
                [hits, share]
            })
            .numbers("95 % interval", |row| {
                row.ci95.map_or_else(|| "-".to_owned(), percent)
            });
        text.push_str(&table.text());
    }
    match report.disagreements.as_slice() {
        [] => text.push_str("\nThe ledger lists these differences and no others.\n\n"),
        wrong => {
            let _ = writeln!(
                text,
                "\nThe ledger is WRONG in {}:\n{}\n",
                wrong.len(),
                wrong.join("\n")
            );
        }
    }
    text
}

/// The beginning of a long text; all of it is in the JSON.
fn shortened(text: &str) -> String {
    let short: String = text.chars().take(LONGEST).collect();
    if short == text { short } else { short + "..." }
}
