//! A reading that drifts with the temperature.

use super::drift_per_second::{BESIDE_A_THERMOMETER, MOST_DRIFT};
use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Curve, Driving, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::PlaceKind;
use crate::physics::search::{Needs, SearchSpec, SearchedOn, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "thermal-drift",
    row: "thermal-drift (temperature)",
    kind: LawKind::Physics,
    equation: "displacement += rate (T - T at the zero)",
    place_kind: PlaceKind::Clock,
    parameters: &[ParameterSpec {
        name: "rate",
        word: "rate",
        dimension: Dimension::LengthPerTemperature,
        sign: SignConstraint::Either,
        plausible: PlausibleRange {
            bounds: |scale, _| [-1.0, 1.0].map(|side| side * scale.displacement_m / scale.warming_k),
            reason: MOST_DRIFT,
        },
        typical: Typical {
            value: |_| 1e-10,
            spread: 1.0,
        },
        fit: OF_A_SIZE,
    }],
    contains: &[],
    combination: None,
    action: LawAction::Added(|&[rate, ..], load| rate * load.warming_k),
    search: SearchSpec {
        shapes: |scale| {
            let shape = |warming_k: f64| Shape::of_either_sign(vec![scale.small_answer() / warming_k]);
            (scale.warming_k > 0.0).then(|| shape(scale.warming_k)).into_iter().collect()
        },
        on: SearchedOn::ALL,
        needs: Needs::Temperature,
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure {
        driving: Driving::Clock,
        pooled: None,
        large_loads_only: false,
        curve: Curve::Lines,
    },
    words: LawWording {
        phrase: |_, _| "a drift of the displacement gauge with temperature".to_owned(),
        heading: |_| "drift with temperature".to_owned(),
        explanation: "The displacement reading drifts with the temperature, with and without load.",
    },
    check: Some(BESIDE_A_THERMOMETER),
};
