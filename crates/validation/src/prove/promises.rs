//! What is promised of verdicts, counted over scored sessions.

use super::answers::Expected;
use super::score::{Named, Outcome, Score, TruthScore, UNKNOWN_FROM};
use super::share::{Promise, Share, Target};

/// Sizes are rounded in the answers: what is called 6 standard errors may be a little less beside other effects.
const ROUNDED: f64 = 0.97;

/// Held-out error over the error that the true model leaves.
const NEAR_THE_FLOOR: f64 = 1.3;

/// All promises on concealed sessions.
#[must_use]
pub fn promises(scores: &[Score]) -> Vec<Promise> {
    let mut promises = on_nothing(scores);
    promises.extend(on_names(scores));
    promises.extend(on_the_unknown(scores));
    promises.extend(on_numbers(scores));
    promises.push(Promise {
        what: "the published validation passes, and something is wrong: rightly said",
        target: None,
        share: Share::of(
            scores.iter().filter(|score| score.is_concealed()),
            |score| score.outcome.is_right(),
        ),
    });
    promises
}

/// Sessions in which laws of the library act.
fn of_library(scores: &[Score]) -> impl Iterator<Item = &Score> {
    let outside = [Expected::NothingMissing, Expected::Unknown];
    scores
        .iter()
        .filter(move |score| !outside.contains(&score.expected))
}

/// Effects of 6 standard errors and more.
fn strong(scores: &[Score]) -> impl Iterator<Item = &TruthScore> {
    of_library(scores)
        .flat_map(|score| &score.truths)
        .filter(|truth| truth.standard_errors >= 6.0 * ROUNDED)
}

fn on_nothing(scores: &[Score]) -> Vec<Promise> {
    let nothing = scores
        .iter()
        .filter(|score| score.expected == Expected::NothingMissing);
    vec![Promise {
        what: "false alarms where nothing is missing",
        target: Some(Target::AtMost(0.05)),
        share: Share::of(nothing, |score| score.outcome == Outcome::FalseAlarm),
    }]
}

fn on_names(scores: &[Score]) -> Vec<Promise> {
    let single = |slip: bool, least: f64, most: f64| {
        of_library(scores).filter(move |score| {
            score.truths.len() == 1
                && (score.truths[0].physics == "slip") == slip
                && (least * ROUNDED..most * ROUNDED).contains(&score.truths[0].standard_errors)
        })
    };
    let pairs = of_library(scores).filter(|score| {
        let strong = |truth: &TruthScore| truth.standard_errors >= 12.0 * ROUNDED * ROUNDED;
        score.truths.len() == 2 && score.truths.iter().all(strong)
    });
    let sets = strong(scores).filter(|truth| matches!(truth.named, Named::InSet(_)));
    vec![
        Promise {
            what: "one effect of 4.5 standard errors, not slip: rightly named",
            target: Some(Target::AtLeast(0.80)),
            share: Share::of(single(false, 4.5, 6.0), |score| {
                score.outcome == Outcome::Right
            }),
        },
        Promise {
            what: "one effect of 6 or more, not slip: rightly named, with all that are within 2",
            target: Some(Target::AtLeast(0.95)),
            share: Share::of(single(false, 6.0, f64::INFINITY), |score| {
                score.outcome == Outcome::Right
            }),
        },
        Promise {
            what: "the same, or a set that holds the truth and is not padded",
            target: Some(Target::AtLeast(0.95)),
            share: Share::of(single(false, 6.0, f64::INFINITY), |score| {
                matches!(score.outcome, Outcome::Right | Outcome::Incomplete)
            }),
        },
        Promise {
            what: "one slip of 6 or more: rightly named",
            target: None,
            share: Share::of(single(true, 6.0, f64::INFINITY), |score| {
                score.outcome == Outcome::Right
            }),
        },
        Promise {
            what: "effects of 6 or more: named alone or in a set",
            target: Some(Target::AtLeast(0.95)),
            share: Share::of(strong(scores), |truth| truth.named != Named::No),
        },
        Promise {
            what: "named in a set: the set is not padded",
            target: None,
            share: Share::of(sets, |truth| truth.padding.is_empty()),
        },
        Promise {
            what: "two effects of 12 each: both rightly named and nothing else",
            target: Some(Target::AtLeast(0.90)),
            share: Share::of(pairs, |score| score.outcome == Outcome::Right),
        },
    ]
}

fn on_the_unknown(scores: &[Score]) -> Vec<Promise> {
    let outside = || {
        scores.iter().filter(|score| {
            score.expected == Expected::Unknown
                && score
                    .left_by_library
                    .is_some_and(|left| left >= UNKNOWN_FROM)
        })
    };
    vec![
        Promise {
            what: "outside the library, 6 or more left: unknown",
            target: Some(Target::AtLeast(0.95)),
            share: Share::of(outside(), |score| score.outcome == Outcome::Right),
        },
        Promise {
            what: "outside the library, 6 or more left: a wrong name",
            target: Some(Target::AtMost(0.05)),
            share: Share::of(outside(), |score| score.outcome == Outcome::WrongName),
        },
    ]
}

fn on_numbers(scores: &[Score]) -> Vec<Promise> {
    let sizes = strong(scores).filter_map(|truth| truth.size_covered);
    let held_out = of_library(scores)
        .filter(|score| score.outcome != Outcome::MayBeMissed)
        .filter_map(|score| score.held_out_ratio);
    vec![
        Promise {
            what: "sizes of effects of 6 or more inside their 95 % intervals",
            target: Some(Target::Between(0.93, 0.97)),
            share: Share::of(sizes, |covered| *covered),
        },
        Promise {
            what: "identified factors inside their 95 % intervals",
            target: Some(Target::Between(0.93, 0.97)),
            share: scores.iter().fold(Share::default(), |sum, score| {
                let [hits, trials] = score.factors_covered;
                sum.with(Share { hits, trials })
            }),
        },
        Promise {
            what: "effect in the library: held-out error within 1.3 of its floor",
            target: Some(Target::AtLeast(0.95)),
            share: Share::of(held_out, |ratio| *ratio <= NEAR_THE_FLOOR),
        },
    ]
}
