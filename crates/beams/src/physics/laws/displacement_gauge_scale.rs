//! The displacement gauge reads too little or too much by a share.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording, MistakePrior};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::PlaceKind;
use crate::physics::search::{SearchSpec, Shape};

use super::force_gauge_scale::ANOTHER_UNIT;

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "gauge-scale",
    row: "gauge-scale (displacement)",
    kind: LawKind::Setup(MistakePrior::Size(0.03)),
    equation: "displacement (1 + scale)",
    place_kind: PlaceKind::DisplacementGauge,
    parameters: &[ParameterSpec {
        name: "scale",
        word: "error of scale",
        dimension: Dimension::Share,
        sign: SignConstraint::Either,
        plausible: PlausibleRange {
            bounds: |_, _| [-ANOTHER_UNIT, ANOTHER_UNIT],
            reason: "up to 0.3: a lever indicator at an angle, a tip of another length; more would be a wrong unit, and obvious",
        },
        typical: Typical {
            value: |_| 1e-6,
            spread: 1.0,
        },
        fit: OF_A_SIZE,
    }],
    contains: &[],
    combination: None,
    action: LawAction::Growth(|&[scale, ..], _, _| scale),
    search: SearchSpec {
        shapes: |_| vec![Shape::of_either_sign(vec![1e-3])],
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |_, _| "a wrong scale of the displacement gauge".to_owned(),
        heading: |_| "scale of the displacement gauge".to_owned(),
        explanation: "The displacement gauge reads too much or too little by a constant fraction.",
    },
    check: Some(Check {
        rank: 0,
        text: |_| "check the displacement gauge on gauge blocks of known size; check the length of its tip and the angle of a lever indicator".to_owned(),
        minutes: 10.0,
    }),
};
