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
    let right = |score: &&Score| score.outcome == Outcome::Right;
    let of_library = || {
        scores
            .iter()
            .filter(|score| !matches!(score.expected, Expected::NothingMissing | Expected::Unknown))
    };
    let single = |slip: bool, least: f64, most: f64| {
        of_library().filter(move |score| {
            score.truths.len() == 1
                && (score.truths[0].physics == "slip") == slip
                && (least * ROUNDED..most * ROUNDED).contains(&score.truths[0].standard_errors)
        })
    };
    let pairs = || {
        of_library().filter(|score| {
            let strong = |truth: &TruthScore| truth.standard_errors >= 12.0 * ROUNDED * ROUNDED;
            score.truths.len() == 2 && score.truths.iter().all(strong)
        })
    };
    let strong = || {
        of_library()
            .flat_map(|score| &score.truths)
            .filter(|truth| truth.standard_errors >= 6.0 * ROUNDED)
    };
    let outside = || {
        scores.iter().filter(|score| {
            score.expected == Expected::Unknown
                && score
                    .left_by_library
                    .is_some_and(|left| left >= UNKNOWN_FROM)
        })
    };
    let nothing = || {
        scores
            .iter()
            .filter(|score| score.expected == Expected::NothingMissing)
    };
    let promise = |what, target, share| Promise {
        what,
        target,
        share,
    };
    let some = Option::Some;
    vec![
        promise(
            "false alarms where nothing is missing",
            some(Target::AtMost(0.05)),
            Share::of(nothing(), |score| score.outcome == Outcome::FalseAlarm),
        ),
        promise(
            "one effect of 4.5 standard errors, not slip: rightly named",
            some(Target::AtLeast(0.80)),
            Share::of(single(false, 4.5, 6.0), right),
        ),
        promise(
            "one effect of 6 or more, not slip: rightly named",
            some(Target::AtLeast(0.95)),
            Share::of(single(false, 6.0, f64::INFINITY), right),
        ),
        promise(
            "one slip of 6 or more: rightly named",
            None,
            Share::of(single(true, 6.0, f64::INFINITY), right),
        ),
        promise(
            "effects of 6 or more: named alone or in a set",
            some(Target::AtLeast(0.95)),
            Share::of(strong(), |truth| truth.named != Named::No),
        ),
        promise(
            "named in a set: the set is not padded",
            None,
            Share::of(
                strong().filter(|truth| matches!(truth.named, Named::InSet(_))),
                |truth| truth.padding.is_empty(),
            ),
        ),
        promise(
            "two effects of 12 each: both rightly named and nothing else",
            some(Target::AtLeast(0.90)),
            Share::of(pairs(), right),
        ),
        promise(
            "outside the library, 6 or more left: unknown",
            some(Target::AtLeast(0.95)),
            Share::of(outside(), right),
        ),
        promise(
            "outside the library, 6 or more left: a wrong name",
            some(Target::AtMost(0.05)),
            Share::of(outside(), |score| score.outcome == Outcome::WrongName),
        ),
        promise(
            "sizes of effects of 6 or more inside their 95 % intervals",
            some(Target::Between(0.93, 0.97)),
            Share::of(strong().filter_map(|truth| truth.size_covered), |covered| {
                *covered
            }),
        ),
        promise(
            "identified factors inside their 95 % intervals",
            some(Target::Between(0.93, 0.97)),
            scores.iter().fold(Share::default(), |sum, score| {
                let [hits, trials] = score.factors_covered;
                sum.with(Share { hits, trials })
            }),
        ),
        promise(
            "effect in the library: held-out error within 1.3 of its floor",
            some(Target::AtLeast(0.95)),
            Share::of(
                of_library()
                    .filter(|score| score.outcome != Outcome::MayBeMissed)
                    .filter_map(|score| score.held_out_ratio),
                |ratio| *ratio <= NEAR_THE_FLOOR,
            ),
        ),
        promise(
            "the published validation passes, and something is wrong: rightly said",
            None,
            Share::of(
                scores.iter().filter(|score| score.is_concealed()),
                |score| score.outcome.is_right(),
            ),
        ),
    ]
}
