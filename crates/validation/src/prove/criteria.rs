//! What is promised of verdicts, counted over scored sessions.

use super::answers::Expected;
use super::score::{NamedCause, Score, TruthScore, UNKNOWN_FROM, VerdictOutcome};
use super::share::{AcceptanceCriterion, Share, Target};

/// Sizes are rounded in the answers: what is called 6 standard errors may be a little less beside other effects.
const ROUNDED: f64 = 0.97;

/// Held-out error over the error that the true model leaves.
const NEAR_THE_FLOOR: f64 = 1.3;

/// All promises on concealed sessions.
#[must_use]
pub fn criteria(scores: &[Score]) -> Vec<AcceptanceCriterion> {
    let mut criteria = on_nothing(scores);
    criteria.extend(on_names(scores));
    criteria.extend(on_the_unknown(scores));
    criteria.extend(on_numbers(scores));
    criteria.push(AcceptanceCriterion {
        what: "the published validation passes, and something is wrong: rightly said",
        target: None,
        share: Share::of(
            scores.iter().filter(|score| score.is_concealed()),
            |score| score.outcome.is_right(),
        ),
    });
    criteria
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

fn on_nothing(scores: &[Score]) -> Vec<AcceptanceCriterion> {
    let nothing = scores
        .iter()
        .filter(|score| score.expected == Expected::NothingMissing);
    vec![AcceptanceCriterion {
        what: "false alarms where nothing is missing",
        target: Some(Target::AtMost(0.05)),
        share: Share::of(nothing, |score| score.outcome == VerdictOutcome::FalseAlarm),
    }]
}

fn on_names(scores: &[Score]) -> Vec<AcceptanceCriterion> {
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
    let sets = strong(scores).filter(|truth| matches!(truth.named, NamedCause::InSet(_)));
    vec![
        AcceptanceCriterion {
            what: "one effect of 4.5 standard errors, not slip: rightly named",
            target: Some(Target::AtLeast(0.80)),
            share: Share::of(single(false, 4.5, 6.0), |score| {
                score.outcome == VerdictOutcome::Right
            }),
        },
        AcceptanceCriterion {
            what: "one effect of 6 or more, not slip: rightly named, with all that are within 2",
            target: Some(Target::AtLeast(0.95)),
            share: Share::of(single(false, 6.0, f64::INFINITY), |score| {
                score.outcome == VerdictOutcome::Right
            }),
        },
        AcceptanceCriterion {
            what: "the same, or a set that holds the truth and is not padded",
            target: Some(Target::AtLeast(0.95)),
            share: Share::of(single(false, 6.0, f64::INFINITY), |score| {
                matches!(
                    score.outcome,
                    VerdictOutcome::Right | VerdictOutcome::Incomplete
                )
            }),
        },
        AcceptanceCriterion {
            what: "one slip of 6 or more: rightly named",
            target: None,
            share: Share::of(single(true, 6.0, f64::INFINITY), |score| {
                score.outcome == VerdictOutcome::Right
            }),
        },
        AcceptanceCriterion {
            what: "effects of 6 or more: named alone or in a set",
            target: Some(Target::AtLeast(0.95)),
            share: Share::of(strong(scores), |truth| truth.named != NamedCause::No),
        },
        AcceptanceCriterion {
            what: "named in a set: the set is not padded",
            target: None,
            share: Share::of(sets, |truth| truth.padding.is_empty()),
        },
        AcceptanceCriterion {
            what: "two effects of 12 each: both rightly named and nothing else",
            target: Some(Target::AtLeast(0.90)),
            share: Share::of(pairs, |score| score.outcome == VerdictOutcome::Right),
        },
    ]
}

fn on_the_unknown(scores: &[Score]) -> Vec<AcceptanceCriterion> {
    let outside = || {
        scores.iter().filter(|score| {
            score.expected == Expected::Unknown
                && score
                    .left_by_library
                    .is_some_and(|left| left >= UNKNOWN_FROM)
        })
    };
    vec![
        AcceptanceCriterion {
            what: "outside the library, 6 or more left: unknown",
            target: Some(Target::AtLeast(0.95)),
            share: Share::of(outside(), |score| score.outcome == VerdictOutcome::Right),
        },
        AcceptanceCriterion {
            what: "outside the library, 6 or more left: mostly, at its place, with what is left",
            target: None,
            share: Share::of(outside(), |score| score.outcome == VerdictOutcome::Mostly),
        },
        AcceptanceCriterion {
            what: "outside the library, 6 or more left: a wrong name",
            target: Some(Target::AtMost(0.05)),
            share: Share::of(outside(), |score| {
                score.outcome == VerdictOutcome::WrongName
            }),
        },
    ]
}

fn on_numbers(scores: &[Score]) -> Vec<AcceptanceCriterion> {
    let sizes = strong(scores).filter_map(|truth| truth.size_covered);
    let held_out = of_library(scores)
        .filter(|score| score.outcome != VerdictOutcome::MayBeMissed)
        .filter_map(|score| score.held_out_ratio);
    vec![
        AcceptanceCriterion {
            what: "sizes of effects of 6 or more inside their 95 % intervals",
            target: Some(Target::Between(0.93, 0.97)),
            share: Share::of(sizes, |covered| *covered),
        },
        AcceptanceCriterion {
            what: "identified factors inside their 95 % intervals",
            target: Some(Target::Between(0.93, 0.97)),
            share: scores.iter().fold(Share::default(), |sum, score| {
                let (hits, trials) = (score.factors_in_intervals, score.factors_identified);
                sum.with(Share { hits, trials })
            }),
        },
        AcceptanceCriterion {
            what: "effect in the library: held-out error within 1.3 of its floor",
            target: Some(Target::AtLeast(0.95)),
            share: Share::of(held_out, |ratio| *ratio <= NEAR_THE_FLOOR),
        },
    ]
}
