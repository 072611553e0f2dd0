//! What the laws of parts in testing machines have in common: scales of their parameters, and how they are searched for and named.

use super::dimension::Dimension;
use super::law::{Driving, LawFigure};
use super::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use super::search::{PlaceScale, SHAPE_ROOM, SearchSpec, SearchedOn, Shape};

/// A size in the unit of the answers.
pub(super) const ANSWER: ParameterSpec = ParameterSpec {
    name: "size",
    word: "size",
    dimension: Dimension::Answer,
    sign: SignConstraint::Positive,
    plausible: PlausibleRange {
        bounds: |scale, _| [0.0, 2.0 * scale.displacement_m],
        reason: "up to twice the largest answer",
    },
    typical: Typical {
        value: |scale| 1e-6 * scale.displacement_m,
        spread: 1.0,
    },
    fit: OF_A_SIZE,
};

/// A slope: what the part gives more, or carries more, than its line.
pub(super) const SLOPE: ParameterSpec = ParameterSpec {
    name: "slope",
    word: "slope",
    dimension: Dimension::AnswerPerDriver,
    plausible: PlausibleRange {
        bounds: |scale, _| [0.0, 20.0 * mean_slope(scale)],
        reason: "up to twenty times the mean slope of the part",
    },
    typical: Typical {
        value: |scale| 1e-6 * mean_slope(scale),
        spread: 1.0,
    },
    ..ANSWER
};

/// Slope of hard faces that meet, in mean slopes of the part: steel on steel beside the spring between them.
pub(super) const HARDEST: f64 = 1000.0;

/// A level of what is set, at which something begins.
pub(super) const LEVEL: ParameterSpec = ParameterSpec {
    name: "level",
    word: "level",
    dimension: Dimension::Driver,
    sign: SignConstraint::AboveZero,
    plausible: PlausibleRange {
        bounds: |scale, _| {
            [
                LEVELS[0] / SHAPE_ROOM,
                LEVELS[LEVELS.len() - 1] * SHAPE_ROOM,
            ]
            .map(|level| level * scale.force_n)
        },
        reason: "from a thousandth of the largest value that was set (less is a step) up to nearly all of it",
    },
    typical: Typical {
        value: |scale| 0.03 * scale.force_n,
        spread: 5.0,
    },
    fit: OF_A_SIZE,
};

/// Levels that are searched, as shares of the largest that was set.
pub(super) const LEVELS: [f64; 8] = [0.001, 0.01, 0.03, 0.08, 0.16, 0.3, 0.5, 0.8];

/// A time constant.
pub(super) const TIME_CONSTANT: ParameterSpec = ParameterSpec {
    name: "tau",
    word: "time constant",
    dimension: Dimension::Time,
    sign: SignConstraint::AboveZero,
    plausible: PlausibleRange {
        bounds: |scale, _| {
            [TIMES[0] / SHAPE_ROOM, TIMES[TIMES.len() - 1] * SHAPE_ROOM]
                .map(|share| share * scale.time_s)
        },
        reason: "from a thousandth of a run to three times as long: a shorter one acts at once, a longer one is a drift",
    },
    typical: Typical {
        value: |scale| 0.1 * scale.time_s,
        spread: 5.0,
    },
    fit: OF_A_SIZE,
};

/// Time constants that are searched, as shares of the longest run.
pub(super) const TIMES: [f64; 8] = [0.001, 0.004, 0.015, 0.05, 0.15, 0.4, 1.0, 3.0];

/// Mean slope of a part: largest answer over the largest that was set.
pub(super) fn mean_slope(scale: &PlaceScale) -> f64 {
    scale.displacement_m / scale.force_n
}

/// Shapes of any positive size at all levels.
pub(super) fn at_levels(scale: &PlaceScale, size: f64) -> Vec<Shape> {
    let at = |level: f64| Shape::of_any_size(vec![size, level * scale.force_n]);
    LEVELS.into_iter().map(at).collect()
}

/// Shapes of any positive size with all time constants.
pub(super) fn at_times(scale: &PlaceScale, size: f64) -> Vec<Shape> {
    let at = |share: f64| Shape::of_any_size(vec![size, share * scale.time_s]);
    let times = TIMES
        .into_iter()
        .filter(|_| scale.has_clock && scale.time_s > 0.0);
    times.map(at).collect()
}

/// How a law of a part is searched for, but for its shapes.
pub(super) const SEARCH: SearchSpec = SearchSpec {
    on: SearchedOn::PARTS,
    unseen_at_place: (
        "no plausible size would have been distinguishable from noise",
        "load the part further and more often",
    ),
    unseen: (
        "no plausible size would have been detectable in these readings",
        Some("load the part further and more often"),
    ),
    ..SearchSpec::OF_ROBOTS
};

/// A law of a part that acts with time is drawn over the clock.
pub(super) const OVER_TIME: LawFigure = LawFigure {
    driving: Driving::Clock,
    ..LawFigure::OVER_FORCE
};
