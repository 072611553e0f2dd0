//! The displacement gauge leans toward another axis.

use super::load_misalignment::SEEN_BY_EYE;
use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording, MistakePrior};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::{Place, PlaceKind};
use crate::physics::search::{SearchSpec, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "gauge-misalignment",
    row: "gauge-misalignment",
    kind: LawKind::Setup(MistakePrior::Size(0.026)),
    equation: "displacement is read turned by angle; the force acts along the direction",
    place_kind: PlaceKind::Toward,
    parameters: &[ParameterSpec {
        name: "angle",
        word: "angle",
        dimension: Dimension::Angle,
        sign: SignConstraint::Either,
        plausible: PlausibleRange {
            bounds: |_, _| [-SEEN_BY_EYE, SEEN_BY_EYE],
            reason: "up to three degrees: more would be visible",
        },
        typical: Typical {
            value: |_| 1e-7,
            spread: 1.0,
        },
        fit: OF_A_SIZE,
    }],
    contains: &[],
    combination: None,
    action: LawAction::Lean,
    search: SearchSpec {
        shapes: |_| vec![Shape::of_either_sign(vec![1e-3])],
        unseen_at_place: (
            "this robot hardly moves in that direction under a load in the measured direction",
            "read the displacement along all three axes at each load",
        ),
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("a displacement gauge {at}"),
        heading: |place| format!("a leaning gauge, {place}"),
        explanation: "The stem of the displacement gauge leans, so that it reads a part of the displacement across its direction.",
    },
    check: Some(Check {
        rank: 1,
        text: |place| match place {
            Place::Toward { direction, toward } => format!(
                "hold a square against the stem of the gauge in {direction}, and turn the gauge by half a turn toward {toward} and repeat"
            ),
            other => format!("hold a square against the stem of the gauge, {other}"),
        },
        minutes: 10.0,
    }),
};
