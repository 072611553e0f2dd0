//! The force acts turned toward another axis.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording, MistakePrior};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::{Place, PlaceKind};
use crate::physics::search::{SearchSpec, Shape};

/// About three degrees, rad.
pub(super) const SEEN_BY_EYE: f64 = 0.05;

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "load-misalignment",
    row: "load-misalignment",
    kind: LawKind::Setup(MistakePrior::Size(0.026)),
    equation: "the force acts turned by angle; displacement is read along the direction",
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
    action: LawAction::Turn,
    search: SearchSpec {
        shapes: |_| vec![Shape::of_either_sign(vec![1e-3])],
        unseen_at_place: (
            "a force turned that way moves this robot along the direction of reading only to second order",
            "read the displacement along all three axes at each load",
        ),
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("a force {at}"),
        heading: |place| format!("a turned force, {place}"),
        explanation: "A component of the force acts perpendicular to the intended direction.",
    },
    check: Some(Check {
        rank: 2,
        text: |place| match place {
            Place::Toward { direction, toward } => format!(
                "read a gauge in {toward} too while loading in {direction}, then turn the force gauge by half a turn and repeat"
            ),
            other => format!("turn the force gauge by half a turn and repeat, {other}"),
        },
        minutes: 25.0,
    }),
};
