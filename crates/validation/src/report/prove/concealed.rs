//! Scored verdicts on concealed sessions.

use std::collections::BTreeSet;
use std::fmt::Write;

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::Serialize;

use crate::prove::{AcceptanceCriterion, Score, Set, Share, VerdictOutcome, criteria};

use super::{criteria_table, share_words};
use stiffbench::report::Table;

/// What the modes of concealment are.
const MODES: [(&str, &str); 10] = [
    ("a", "absorbed by the factors"),
    ("b", "averaged away"),
    ("c", "only in a held-out pose"),
    ("d", "below the noise of a reading"),
    ("e", "two at once"),
    ("f", "outside the library"),
    ("g", "nothing"),
    ("h", "an impossible value explains it"),
    ("i", "nothing, run zeros and slopes large"),
    ("law", "each law, serial and closed loops"),
];

/// Promises, a table of modes for each list, and every failure with both texts.
#[must_use]
pub fn concealed_text(scores: &[Score]) -> String {
    let mut text = String::new();
    for set in [Set::Development, Set::Proof, Set::Second] {
        let of_set: Vec<Score> = scores.iter().filter(|s| s.set == set).cloned().collect();
        if of_set.is_empty() {
            continue;
        }
        let _ = writeln!(
            text,
            "Concealed sessions, {} list: {} sessions, verdicts written before the answers were opened\n",
            set.name(),
            of_set.len()
        );
        text.push_str(&modes_table(&of_set));
        text.push('\n');
        text.push_str(&criteria_table(&criteria(&of_set)));
        text.push('\n');
        text.push_str(&failures(&of_set));
        text.push('\n');
    }
    text
}

fn modes_table(scores: &[Score]) -> String {
    let outcomes: BTreeSet<VerdictOutcome> = scores.iter().map(|score| score.outcome).collect();
    let modes = MODES.iter().map(|(mode, what)| {
        let of_mode: Vec<&Score> = scores.iter().filter(|s| s.mode == *mode).collect();
        (format!("{mode}: {what}"), of_mode)
    });
    let mut modes: Vec<(String, Vec<&Score>)> = modes.collect();
    modes.retain(|(_, of_mode)| !of_mode.is_empty());
    modes.push(("all".to_owned(), scores.iter().collect()));
    Table::of(modes)
        .words("mode", |(name, _)| name.clone())
        .numbers("sessions", |(_, of_mode)| of_mode.len())
        .numbers_each(outcomes.iter().map(ToString::to_string), |(_, of_mode)| {
            let count = |outcome| of_mode.iter().filter(|s| s.outcome == outcome).count();
            outcomes.iter().copied().map(count).collect::<Vec<_>>()
        })
        .numbers_each(["right, %", "95 % interval"], |(_, of_mode)| {
            let right = Share::of(of_mode, |score| score.outcome.is_right());
            let [_, share, interval] = share_words(&right);
            [share, interval]
        })
        .text()
}

fn failures(scores: &[Score]) -> String {
    let mut text = String::new();
    let wrong = scores.iter().filter(|score| !score.outcome.is_right());
    for score in wrong {
        let _ = writeln!(
            text,
            "- {} ({}, mode {}): {}\n    expected: {}\n    said:     {}",
            score.session,
            score.bench,
            score.mode,
            score.outcome,
            score.answer_words,
            score.verdict_words
        );
        for truth in &score.truths {
            for padding in &truth.padding {
                let _ = writeln!(
                    text,
                    "    distinguishable, and named all the same: {padding}"
                );
            }
            for rival in &truth.left_out {
                let _ = writeln!(text, "    indistinguishable, and left out: {rival}");
            }
        }
    }
    if text.is_empty() {
        "Every verdict was right.\n".to_owned()
    } else {
        format!("Not right:\n{text}")
    }
}

/// Scored verdicts on the lists of concealed sessions, for programs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ConcealedReport {
    /// The open list.
    pub development: ConcealedList,
    /// The sealed list.
    pub proof: ConcealedList,
    /// The second sealed list.
    pub second: ConcealedList,
}

/// Scored verdicts on one list.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ConcealedList {
    /// How many sessions.
    pub sessions: usize,
    /// Each mode of concealment that occurs, by its short name.
    pub modes: IndexMap<&'static str, ConcealedMode>,
    /// What was promised.
    #[serde(rename = "promises")]
    pub criteria: Vec<AcceptanceCriterion>,
    /// Each session.
    pub scores: Vec<Score>,
}

/// Verdicts on the sessions of one mode.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ConcealedMode {
    /// Right ones.
    pub right: Share,
    /// How many verdicts have each outcome that occurs.
    pub outcomes: IndexMap<VerdictOutcome, usize>,
}

impl ConcealedReport {
    /// The scores list by list.
    #[must_use]
    pub fn new(scores: &[Score]) -> Self {
        let of = |set| ConcealedList::of(scores.iter().filter(|s| s.set == set).cloned());
        Self {
            development: of(Set::Development),
            proof: of(Set::Proof),
            second: of(Set::Second),
        }
    }
}

impl ConcealedList {
    fn of(scores: impl Iterator<Item = Score>) -> Self {
        let scores: Vec<Score> = scores.collect();
        let mut modes = IndexMap::new();
        for (mode, _) in MODES {
            let of_mode: Vec<&Score> = scores.iter().filter(|s| s.mode == mode).collect();
            if !of_mode.is_empty() {
                modes.insert(mode, ConcealedMode::of(&of_mode));
            }
        }
        Self {
            sessions: scores.len(),
            modes,
            criteria: criteria(&scores),
            scores,
        }
    }
}

impl ConcealedMode {
    fn of(scores: &[&Score]) -> Self {
        let count = |outcome| scores.iter().filter(|s| s.outcome == outcome).count();
        let counts = VerdictOutcome::ALL.map(|outcome| (outcome, count(outcome)));
        Self {
            right: Share::of(scores, |score| score.outcome.is_right()),
            outcomes: counts.into_iter().filter(|(_, count)| *count > 0).collect(),
        }
    }
}
