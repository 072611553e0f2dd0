//! Recordings by others.

use std::fmt::Write;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::prove::{RecordingOutcome, RecordingScore};
use stiffbench::report::{Table, significant};
use stiffbench_diagnosis::mismatch::VerdictGrade;

/// Verdicts beside known answers, and known figures beside ours.
#[must_use]
pub fn recordings_text(scores: &[RecordingVerdict]) -> String {
    let counted = RecordingTotals::new(scores);
    let mut text = format!(
        "Recordings by others: of {}\n  headline right {}, led by the dominant physics {}\n  false name as dominant {}, any foreign name {}, nothing said {}\n\n",
        counted.recordings,
        counted.headline_right,
        counted.led,
        counted.false_dominant,
        counted.with_foreign_names,
        counted.mute,
    );
    let share = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| format!("{v:.2}"));
    let outcome = |one: &&RecordingVerdict| match one.score.outcome {
        RecordingOutcome::Right => "yes",
        RecordingOutcome::RightBehind => "behind",
        RecordingOutcome::FalseDominant => "FALSE",
        RecordingOutcome::Mute => "mute",
        RecordingOutcome::NotRight => "NO",
    };
    let table = Table::of(scores)
        .words("recording", |one| &one.score.name)
        .numbers("readings", |one| one.score.readings)
        .words("right", |one| one.score.expected.join(" or "))
        .words("said", |one| &one.score.verdict)
        .words("grade", |one| grade_word(one.score.grade))
        .words("leading", |one| one.score.leading.join(" or "))
        .numbers("share", |one| share(one.score.shares.share_of_misfit))
        .numbers("unseen", |one| share(one.score.shares.share_unseen))
        .words("foreign names", |one| one.score.foreign.join(", "))
        .numbers("s", |one| format!("{:.1}", one.seconds))
        .words("", outcome);
    text.push_str(&table.text());
    text.push('\n');
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| significant(v, 4));
    let figures = scores.iter().flat_map(|one| {
        let figures = one.score.figures.iter();
        figures.map(|figure| (&one.score.name, figure))
    });
    let figures = Table::of(figures)
        .words("recording", |(name, _)| *name)
        .words("figure", |(_, figure)| &figure.name)
        .numbers("known", |(_, figure)| number(figure.known))
        .numbers("ours", |(_, figure)| number(figure.ours));
    text.push_str(&figures.text());
    text.push('\n');
    for RecordingVerdict { score, .. } in scores {
        let physics = if score.physics.is_empty() {
            String::new()
        } else {
            format!("{}. ", score.physics.join(" or "))
        };
        let _ = writeln!(
            text,
            "- {}: {}\n    known: {}{}",
            score.name, score.words, physics, score.why
        );
    }
    text.push('\n');
    text
}

/// A grade as files name it.
fn grade_word(grade: Option<VerdictGrade>) -> String {
    let word = serde_json::to_value(grade).ok();
    let word = word.as_ref().and_then(serde_json::Value::as_str);
    word.unwrap_or("-").to_owned()
}

/// Recordings and what was said of them, for programs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RecordingsReport {
    /// Folder that holds them.
    pub folder: PathBuf,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Counts over those that are there.
    pub totals: RecordingTotals,
    /// Those that are there.
    pub recordings: Vec<RecordingVerdict>,
    /// Names of those that are not.
    pub absent: Vec<String>,
}

/// How many recordings count as what; the rules stand in `data/recordings/README.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct RecordingTotals {
    /// Recordings.
    pub recordings: usize,
    /// The verdict is right, and a headline holds the dominant physics.
    pub headline_right: usize,
    /// Of these, those that the dominant physics leads, or that have no headline.
    pub led: usize,
    /// A foreign name leads.
    pub false_dominant: usize,
    /// A foreign name stands anywhere.
    pub with_foreign_names: usize,
    /// Nothing was said where something is right.
    pub mute: usize,
}

impl RecordingTotals {
    /// Counts scores.
    #[must_use]
    pub fn new(scores: &[RecordingVerdict]) -> Self {
        let count = |test: &dyn Fn(&RecordingScore) -> bool| {
            scores.iter().filter(|one| test(&one.score)).count()
        };
        Self {
            recordings: scores.len(),
            headline_right: count(&|s| s.outcome.is_headline_right()),
            led: count(&|s| s.outcome == RecordingOutcome::Right),
            false_dominant: count(&|s| s.outcome == RecordingOutcome::FalseDominant),
            with_foreign_names: count(&|s| !s.foreign.is_empty()),
            mute: count(&|s| s.outcome == RecordingOutcome::Mute),
        }
    }
}

/// A recording and what was said of it.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RecordingVerdict {
    /// What was said.
    #[serde(flatten)]
    pub score: RecordingScore,
    /// Seconds that the diagnosis took.
    pub seconds: f64,
    /// Whether all is right.
    pub is_right: bool,
}
