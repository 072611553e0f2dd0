//! Recordings by others.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::prove::RecordingScore;
use stiffbench::report::{AlignedTable, significant};

/// Verdicts beside known answers, and known figures beside ours.
#[must_use]
pub fn recordings_text(scores: &[RecordingScore]) -> String {
    let right = scores.iter().filter(|score| score.is_right()).count();
    let mut text = format!(
        "Recordings by others: {right} of {} verdicts as known\n\n",
        scores.len()
    );
    let mut table =
        AlignedTable::new(&["recording", "readings", "right", "said", "false names", ""]);
    for score in scores {
        table.row([
            score.name.clone(),
            score.readings.to_string(),
            score.expected.join(" or "),
            score.verdict.clone(),
            score.false_names.join(", "),
            if score.is_right() { "yes" } else { "NO" }.to_owned(),
        ]);
    }
    text.push_str(&table.text());
    text.push('\n');
    let mut figures = AlignedTable::new(&["recording", "figure", "known", "ours"]);
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| significant(v, 4));
    for score in scores {
        for figure in &score.figures {
            figures.row([
                score.name.clone(),
                figure.name.clone(),
                number(figure.known),
                number(figure.ours),
            ]);
        }
    }
    text.push_str(&figures.text());
    text.push('\n');
    for score in scores {
        let _ = writeln!(
            text,
            "- {}: {}\n    known: {}",
            score.name, score.words, score.why
        );
    }
    text.push('\n');
    text
}

/// The same for programs.
#[must_use]
pub fn recordings_json(scores: &[RecordingScore]) -> Value {
    scores
        .iter()
        .map(|score| {
            json!({
                "recording": score.name,
                "readings": score.readings,
                "right": score.expected,
                "said": score.verdict,
                "words": score.words,
                "false_names": score.false_names,
                "is_right": score.is_right(),
                "figures": score.figures.iter().map(|figure| json!({
                    "name": figure.name, "known": figure.known, "ours": figure.ours,
                })).collect::<Vec<_>>(),
            })
        })
        .collect()
}
