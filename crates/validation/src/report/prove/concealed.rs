//! Scored verdicts on concealed sessions.

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

    /// Promises, a table of modes for each list, and every failure with both texts.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        for (set, list) in [
            (Set::Development, &self.development),
            (Set::Proof, &self.proof),
            (Set::Second, &self.second),
        ] {
            if list.sessions == 0 {
                continue;
            }
            let _ = writeln!(
                text,
                "Concealed sessions, {} list: {} sessions, verdicts written before the answers were opened\n\n{}\n{}\n{}",
                set.name(),
                list.sessions,
                list.modes_table(),
                criteria_table(&list.criteria),
                failures(&list.scores)
            );
        }
        text
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

    fn modes_table(&self) -> String {
        let all: Vec<&Score> = self.scores.iter().collect();
        let all = ConcealedMode::of(&all);
        let modes = MODES.iter().filter_map(|(mode, what)| {
            let counted = self.modes.get(mode)?;
            Some((format!("{mode}: {what}"), counted))
        });
        let counts = |mode: &ConcealedMode| {
            let counts = all
                .outcomes
                .keys()
                .map(|outcome| mode.outcomes.get(outcome));
            counts
                .map(|count| count.copied().unwrap_or_default())
                .collect::<Vec<_>>()
        };
        Table::of(modes.chain([("all".to_owned(), &all)]))
            .words("mode", |(name, _)| name.clone())
            .numbers("sessions", |(_, mode)| mode.right.trials)
            .numbers_each(all.outcomes.keys().map(ToString::to_string), |(_, mode)| {
                counts(mode)
            })
            .numbers_each(["right, %", "95 % interval"], |(_, mode)| {
                let [_, share, interval] = share_words(&mode.right);
                [share, interval]
            })
            .text()
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
