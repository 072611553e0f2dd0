//! A reading that drifts with the clock.

use super::base_compliance::{TOO_LITTLE, TOO_LITTLE_AT_PLACE};
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
    parameters: &[ParameterSpec {
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
    }],
    contains: &[],
    action: LawAction::Added(|&[rate, ..], load| rate * load.since_zero_s),
    search: SearchSpec {
        shapes: |scale| {
            let shape = |time_s: f64| Shape::of_either_sign(vec![1e-6 / time_s]);
            (scale.time_s > 0.0).then(|| shape(scale.time_s)).into_iter().collect()
        },
        wide_shapes: None,
        phase: None,
        is_freest: false,
        is_sharp: false,
        on: SearchedOn::ALL,
        needs: Needs::Clock,
        unseen_at_place: TOO_LITTLE_AT_PLACE,
        unseen: TOO_LITTLE,
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
        explanation: "The displacement reading moves with the clock, loaded or not.",
    },
    check: Some(BESIDE_A_THERMOMETER),
};

pub(super) const MOST_DRIFT: &str =
    "up to the largest displacement within one run: a larger drift is seen as the readings come";

pub(super) const BESIDE_A_THERMOMETER: Check = Check {
    rank: 1,
    text: |_| {
        "leave the gauges on the unloaded robot for half an hour beside a thermometer, a reading a minute"
            .to_owned()
    },
    minutes: 30.0,
};
