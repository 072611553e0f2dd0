//! Scored verdicts on concealed sessions.

use std::collections::BTreeSet;
use std::fmt::Write;

use serde_json::{Value, json};

use crate::prove::{NamedCause, Score, Set, Share, TruthScore, VerdictOutcome, criteria};

use super::{criteria_json, criteria_table, share_json, share_words};
use stiffbench::report::AlignedTable;

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
    let mut heads = vec!["mode", "sessions"];
    heads.extend(outcomes.iter().map(|outcome| outcome.name()));
    heads.extend(["right, %", "95 % interval"]);
    let mut rows = AlignedTable::new(&heads);
    let mut add = |name: String, of_mode: &[&Score]| {
        let mut cells = vec![name, of_mode.len().to_string()];
        for outcome in &outcomes {
            let count = of_mode.iter().filter(|s| s.outcome == *outcome).count();
            cells.push(count.to_string());
        }
        let right = Share::of(of_mode.iter(), |score| score.outcome.is_right());
        let [_, share, interval] = share_words(&right);
        cells.extend([share, interval]);
        rows.row(cells);
    };
    for (mode, what) in MODES {
        let of_mode: Vec<&Score> = scores.iter().filter(|s| s.mode == mode).collect();
        if !of_mode.is_empty() {
            add(format!("{mode}: {what}"), &of_mode);
        }
    }
    add("all".to_owned(), &scores.iter().collect::<Vec<_>>());
    rows.text()
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
            score.outcome.name(),
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

/// The same for programs, session by session.
#[must_use]
pub fn concealed_json(scores: &[Score]) -> Value {
    let of = |set: Set| -> Value {
        let of_set: Vec<Score> = scores.iter().filter(|s| s.set == set).cloned().collect();
        let modes: serde_json::Map<String, Value> = MODES
            .iter()
            .filter_map(|(mode, _)| {
                let of_mode: Vec<&Score> = of_set.iter().filter(|s| s.mode == *mode).collect();
                let right = Share::of(of_mode.iter(), |score| score.outcome.is_right());
                let outcomes: serde_json::Map<String, Value> = VerdictOutcome::ALL
                    .iter()
                    .filter_map(|outcome| {
                        let count = of_mode.iter().filter(|s| s.outcome == *outcome).count();
                        (count > 0).then(|| (outcome.name().to_owned(), json!(count)))
                    })
                    .collect();
                let entry = json!({ "right": share_json(&right), "outcomes": outcomes });
                (!of_mode.is_empty()).then(|| ((*mode).to_owned(), entry))
            })
            .collect();
        json!({
            "sessions": of_set.len(),
            "modes": modes,
            "promises": criteria_json(&criteria(&of_set)),
            "scores": of_set.iter().map(score_json).collect::<Vec<_>>(),
        })
    };
    json!({ "development": of(Set::Development), "proof": of(Set::Proof), "second": of(Set::Second) })
}

fn score_json(score: &Score) -> Value {
    json!({
        "session": score.session,
        "bench": score.bench,
        "mode": score.mode,
        "expected": score.expected.name(),
        "verdict": score.verdict,
        "outcome": score.outcome.name(),
        "answer": score.answer_words,
        "said": score.verdict_words,
        "truths": score.truths.iter().map(truth_json).collect::<Vec<_>>(),
        "left_by_library": score.left_by_library,
        "held_out_over_floor": score.held_out_ratio,
        "published_validation_passes": score.published_passes,
        "factors_in_intervals": score.factors_covered[0],
        "factors_identified": score.factors_covered[1],
    })
}

fn truth_json(truth: &TruthScore) -> Value {
    json!({
        "title": truth.title,
        "standard_errors": truth.standard_errors,
        "named": match truth.named {
            NamedCause::Alone => json!("alone"),
            NamedCause::InSet(count) => json!({ "in_set_of": count }),
            NamedCause::No => json!("no"),
        },
        "padding": truth.padding,
        "left_out": truth.left_out,
        "size_in_interval": truth.size_covered,
        "size_over_truth": truth.size_ratio,
    })
}
