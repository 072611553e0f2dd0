//! Displacement that grows with the logarithm of the time under load.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{
    Combination, Curve, Driving, LawDefinition, LawFigure, LawKind, LawWording,
};
use crate::physics::parameter::{
    OF_A_SIZE, FitBy, ParameterSpec, PlausibleRange, SignConstraint, Typical,
};
use crate::physics::place::PlaceKind;
use crate::physics::search::{Needs, PlaceScale, SHAPE_ROOM, SearchSpec, SearchedOn, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "creep",
    row: "creep",
    kind: LawKind::Physics,
    equation: "displacement * (1 + k log10(1 + hold/t0))",
    place_kind: PlaceKind::Structure,
    parameters: &[
        GROWTH,
        ParameterSpec {
            name: "t0",
            word: "t0",
            dimension: Dimension::Time,
            sign: SignConstraint::AboveZero,
            plausible: PlausibleRange {
                bounds: |_, _| [TIMES_S[0] / SHAPE_ROOM, TIMES_S[TIMES_S.len() - 1] * SHAPE_ROOM],
                reason: "from a tenth of a second to half a minute: holds of seconds to minutes reveal no other value",
            },
            typical: Typical {
                value: |_| 1.0,
                spread: 4.0,
            },
            fit: FitBy::Search,
        },
    ],
    contains: &[],
    // A large k with a late t0 makes the same of holds that are alike as a small one with an early t0.
    combination: Some(Combination {
        spec: ParameterSpec {
            name: "growth_5_to_60_s",
            word: "growth from 5 to 60 s under load",
            dimension: Dimension::Share,
            ..GROWTH
        },
        of: |&[k, t0, ..], _| k * (log_time(60.0, t0) - log_time(5.0, t0)),
    }),
    action: LawAction::Growth(|&[k, t0, ..], load, _| k * log_time(load.hold_s, t0)),
    search: SearchSpec {
        shapes,
        on: SearchedOn::FORCE_DRIVEN,
        needs: Needs::Hold,
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure {
        driving: Driving::Hold,
        pooled: None,
        large_loads_only: true,
        curve: Curve::Shape(|values, hold_s| {
            let t0_s = values.get(1).copied().unwrap_or(1.0);
            log_time(hold_s, t0_s.max(f64::MIN_POSITIVE))
        }),
    },
    words: LawWording {
        phrase: |_, _| "creep under a constant load".to_owned(),
        heading: |_| "creep".to_owned(),
        explanation: "The displacement grows with the logarithm of the time under load.",
    },
    // Holds under load are the check, and any plan may have them.
    check: None,
};

const GROWTH: ParameterSpec = ParameterSpec {
    name: "k",
    word: "growth",
    dimension: Dimension::PerDecade,
    sign: SignConstraint::Positive,
    plausible: PlausibleRange {
        bounds: |_, _| [0.0, 0.3],
        reason: "up to 30 % per decade of time: metals creep by less than 1 %, plastics by up to a third",
    },
    typical: Typical {
        value: |_| 1e-7,
        spread: 1.0,
    },
    fit: OF_A_SIZE,
};

/// Times from which creep is counted, s.
const TIMES_S: [f64; 6] = [0.1, 0.3, 1.0, 3.0, 10.0, 30.0];

fn log_time(hold_s: f64, t0_s: f64) -> f64 {
    (1.0 + hold_s / t0_s).log10()
}

fn shapes(scale: &PlaceScale) -> Vec<Shape> {
    let shape = |t0_s: f64| Shape::of_any_size(vec![1e-3, t0_s]);
    let times = TIMES_S.into_iter().filter(|_| scale.has_holds);
    times.map(shape).collect()
}
