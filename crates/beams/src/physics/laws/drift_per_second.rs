//! A reading that drifts with the clock.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, Curve, Driving, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::PlaceKind;
use crate::physics::search::{Needs, SearchSpec, SearchedOn, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "thermal-drift",
    row: "thermal-drift (time)",
    kind: LawKind::Physics,
    equation: "displacement += rate (t - t at the zero)",
    place_kind: PlaceKind::Clock,
    parameters: &[RATE],
    contains: &[],
    combination: None,
    action: LawAction::Added(|&[rate, ..], load| rate * load.since_zero_s),
    search: SearchSpec {
        shapes: |scale| {
            let shape = |time_s: f64| Shape::of_either_sign(vec![scale.small_answer() / time_s]);
            (scale.time_s > 0.0).then(|| shape(scale.time_s)).into_iter().collect()
        },
        on: SearchedOn::ALL,
        needs: Needs::Clock,
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure {
        driving: Driving::Clock,
        pooled: Some("all cells"),
        large_loads_only: false,
        curve: Curve::Lines,
    },
    words: LawWording {
        phrase: |_, _| "a drift of the displacement gauge with time".to_owned(),
        heading: |_| "drift with time".to_owned(),
        explanation: "The displacement reading drifts with time, with and without load.",
    },
    check: Some(BESIDE_A_THERMOMETER),
};

/// The same drift where it moved the gauge by much between its zeroing and the first reading, which no table records.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "thermal-drift (time since zeroing)",
    equation: "displacement += rate (t - t of the first reading + zeroed_before)",
    parameters: &[RATE, ZEROED_BEFORE],
    contains: &["thermal-drift (time)"],
    combination: None,
    action: LawAction::Added(|&[rate, zeroed_before_s, ..], load| rate * (load.since_zero_s + zeroed_before_s)),
    search: SearchSpec {
        shapes: |scale| {
            let of_share = |share: f64| Shape::of_either_sign(vec![scale.small_answer() / scale.time_s, share * scale.time_s]);
            let shares = SHARES_BEFORE.into_iter().filter(|_| scale.time_s > 0.0);
            shares.map(of_share).collect()
        },
        // The zero of a part is its first reading.
        on: SearchedOn::ROBOTS,
        ..LAW.search
    },
    words: LawWording {
        explanation: "The displacement reading drifts with time, with and without load, and had drifted before the first reading.",
        ..LAW.words
    },
    ..LAW
};

/// Times between zeroing and the first reading, as shares of the longest time on one zero.
const SHARES_BEFORE: [f64; 3] = [0.1, 0.3, 1.0];

const RATE: ParameterSpec = ParameterSpec {
    name: "rate",
    word: "rate",
    dimension: Dimension::LengthPerTime,
    sign: SignConstraint::Either,
    plausible: PlausibleRange {
        bounds: |scale, _| [-1.0, 1.0].map(|side| side * scale.displacement_m / scale.time_s),
        reason: MOST_DRIFT,
    },
    typical: Typical {
        value: |_| 1e-13,
        spread: 1.0,
    },
    fit: OF_A_SIZE,
};

const ZEROED_BEFORE: ParameterSpec = ParameterSpec {
    name: "zeroed_before",
    word: "time from the zeroing to the first reading",
    dimension: Dimension::Time,
    sign: SignConstraint::Positive,
    plausible: PlausibleRange {
        bounds: |scale, _| [0.0, scale.time_s],
        reason: "no longer than the duration of the readings on one zero",
    },
    typical: Typical {
        value: |scale| 0.1 * scale.time_s,
        spread: 3.0,
    },
    fit: OF_A_SIZE,
};

pub(super) const MOST_DRIFT: &str =
    "up to the largest displacement within one run: a larger drift would be noticed while measuring";

pub(super) const BESIDE_A_THERMOMETER: Check = Check {
    rank: 1,
    text: |_| {
        "leave the gauges on the unloaded robot for half an hour beside a thermometer, and take a reading every minute"
            .to_owned()
    },
    minutes: 30.0,
};
