//! A force gauge that is not linear.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::PlaceKind;
use crate::physics::search::{SearchSpec, SearchedOn, Shape, VISIBLE_SHARE};

/// Share of its reading by which a gauge may err, 1.
const BROKEN: f64 = 0.1;

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "force-gauge-nonlinearity",
    row: "force-gauge-nonlinearity",
    kind: LawKind::Physics,
    equation: "true force = F (1 + q |F|)",
    place_kind: PlaceKind::ForceGauge,
    parameters: &[ParameterSpec {
        name: "q",
        word: "error",
        dimension: Dimension::PerForce,
        sign: SignConstraint::Either,
        plausible: PlausibleRange {
            bounds: |scale, _| [-1.0, 1.0].map(|side| side * BROKEN / scale.force_n),
            reason: "up to a tenth of the largest force: a gauge that errs by more is broken",
        },
        typical: Typical {
            value: |_| 1e-10,
            spread: 1.0,
        },
        fit: OF_A_SIZE,
    }],
    contains: &[],
    combination: None,
    action: LawAction::Force(|&[q, ..], load| q * load.force_n * load.force_n.abs()),
    search: SearchSpec {
        shapes: |scale| vec![Shape::of_either_sign(vec![VISIBLE_SHARE / scale.force_n])],
        on: SearchedOn::FORCE_DRIVEN,
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |_, _| "a nonlinear force gauge".to_owned(),
        heading: |_| "the nonlinearity of the force gauge".to_owned(),
        explanation: "The true force departs from the reading of the force gauge by an amount that grows with the square of the force.",
    },
    check: Some(Check {
        rank: 0,
        text: |_| "hang known weights on the force gauge, ten steps over its range, three times".to_owned(),
        minutes: 20.0,
    }),
};
