//! Recordings by others.

use std::fmt::Write;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::prove::{ComparedFigure, RecordingScore};
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

/// Recordings and what was said of them, for programs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RecordingsReport {
    /// Folder that holds them.
    pub folder: PathBuf,
    /// Seed of everything random.
    pub seed: u64,
    /// Those that are there.
    pub recordings: Vec<RecordingVerdict>,
    /// Names of those that are not.
    pub absent: Vec<String>,
}

/// A recording and what was said of it.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RecordingVerdict {
    /// Its name.
    pub recording: String,
    /// How many readings it has.
    pub readings: usize,
    /// Verdicts that are right.
    #[serde(rename = "right")]
    pub expected: Vec<String>,
    /// The verdict.
    #[serde(rename = "said")]
    pub verdict: String,
    /// The same in words.
    pub words: String,
    /// Laws that were named and would be false names.
    pub false_names: Vec<String>,
    /// Whether all is right.
    pub is_right: bool,
    /// Known figures beside ours.
    pub figures: Vec<ComparedFigure>,
}

impl From<RecordingScore> for RecordingVerdict {
    fn from(score: RecordingScore) -> Self {
        Self {
            is_right: score.is_right(),
            recording: score.name,
            readings: score.readings,
            expected: score.expected,
            verdict: score.verdict,
            words: score.words,
            false_names: score.false_names,
            figures: score.figures,
        }
    }
}
