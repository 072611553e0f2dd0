//! Recordings by others.

use std::fmt::Write;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::prove::{ComparedFigure, RecordingOutcome, RecordingScore};
use stiffbench::report::{Table, numbers, significant, words};
use stiffbench_diagnosis::mismatch::{MisfitShares, VerdictGrade};

/// A recording's score and the seconds that it took.
pub type TimedScore = (RecordingScore, f64);

/// Verdicts beside known answers, and known figures beside ours.
#[must_use]
pub fn recordings_text(scores: &[TimedScore]) -> String {
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
    let mut table = Table::new([
        words("recording"),
        numbers("readings"),
        words("right"),
        words("said"),
        words("grade"),
        words("leading"),
        numbers("share"),
        numbers("unseen"),
        words("foreign names"),
        numbers("s"),
        words(""),
    ]);
    let share = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| format!("{v:.2}"));
    for (score, seconds) in scores {
        table.row([
            score.name.clone(),
            score.readings.to_string(),
            score.expected.join(" or "),
            score.verdict.clone(),
            grade_word(score.grade),
            score.leading.join(" or "),
            share(score.shares.share_of_misfit),
            share(score.shares.share_unseen),
            score.foreign.join(", "),
            format!("{seconds:.1}"),
            match score.outcome {
                RecordingOutcome::Right => "yes",
                RecordingOutcome::RightBehind => "behind",
                RecordingOutcome::FalseDominant => "FALSE",
                RecordingOutcome::Mute => "mute",
                RecordingOutcome::NotRight => "NO",
            }
            .to_owned(),
        ]);
    }
    text.push_str(&table.text());
    text.push('\n');
    let mut figures = Table::new([
        words("recording"),
        words("figure"),
        numbers("known"),
        numbers("ours"),
    ]);
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| significant(v, 4));
    for (score, _) in scores {
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
    for (score, _) in scores {
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
    pub fn new(scores: &[TimedScore]) -> Self {
        let count = |test: &dyn Fn(&RecordingScore) -> bool| {
            scores.iter().filter(|(score, _)| test(score)).count()
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
    /// Laws one of which must lead.
    pub physics: Vec<String>,
    /// How far the verdict may be relied on; `null` without a graded diagnosis.
    pub grade: Option<VerdictGrade>,
    /// The leading finding, or the members of its set.
    pub leading: Vec<String>,
    /// Shares of the misfit that all findings explain together.
    #[serde(flatten)]
    pub shares: MisfitShares,
    /// The same in words.
    pub words: String,
    /// Laws that were named and are foreign.
    pub false_names: Vec<String>,
    /// How it counts.
    pub outcome: RecordingOutcome,
    /// Seconds that the diagnosis took.
    pub seconds: f64,
    /// Whether all is right.
    pub is_right: bool,
    /// Known figures beside ours.
    pub figures: Vec<ComparedFigure>,
}

impl From<TimedScore> for RecordingVerdict {
    fn from((score, seconds): TimedScore) -> Self {
        Self {
            is_right: score.is_right(),
            recording: score.name,
            readings: score.readings,
            expected: score.expected,
            verdict: score.verdict,
            physics: score.physics,
            grade: score.grade,
            leading: score.leading,
            shares: score.shares,
            words: score.words,
            outcome: score.outcome,
            false_names: score.foreign,
            seconds,
            figures: score.figures,
        }
    }
}
