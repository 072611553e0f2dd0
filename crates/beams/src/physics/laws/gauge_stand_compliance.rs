//! The stand of the displacement gauge gives way in one direction.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::{Place, PlaceKind};
use crate::physics::search::{SearchSpec, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "gauge-stand-compliance",
    row: "gauge-stand-compliance",
    kind: LawKind::Physics,
    equation: "displacement += c F",
    place_kind: PlaceKind::Direction,
    parameters: &[ParameterSpec {
        name: "c",
        word: "compliance",
        dimension: Dimension::Compliance,
        sign: SignConstraint::Positive,
        plausible: PlausibleRange {
            bounds: |scale, _| scale.plausible_compliance(),
            reason: "up to ten times the compliance of the robot where it is stiffest: a softer stand would visibly move",
        },
        typical: Typical {
            value: |_| 1e-14,
            spread: 1.0,
        },
        fit: OF_A_SIZE,
    }],
    contains: &[],
    combination: None,
    action: LawAction::Added(|&[c, ..], load| c * load.force_n),
    search: SearchSpec {
        shapes: |scale| vec![Shape::of_any_size(vec![scale.visible()])],
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("a stand of the displacement gauge that gives way in {at}"),
        heading: |place| format!("a yielding gauge stand, {place}"),
        explanation: "The gauge reads more than the robot moves, in proportion to the force and equally in every pose.",
    },
    check: Some(Check {
        rank: 1,
        text: |place| {
            let along = match place {
                Place::Direction(direction) => direction.to_string(),
                other => other.to_string(),
            };
            format!(
                "set a second dial gauge on the floor against the stand of the first and load the robot in {along}: the stand must not move"
            )
        },
        minutes: 20.0,
    }),
};
