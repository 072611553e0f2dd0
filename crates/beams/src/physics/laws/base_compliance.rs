//! All supports of the robot rock as one body.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::{Place, PlaceKind};
use crate::physics::search::{SearchSpec, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "base-compliance",
    row: "base-compliance",
    kind: LawKind::Physics,
    equation: "all supports rock about the axis through the first one by c times the moment",
    place_kind: PlaceKind::Axis,
    parameters: &[ParameterSpec {
        name: "c",
        word: "compliance",
        dimension: Dimension::RotationalCompliance,
        sign: SignConstraint::Positive,
        plausible: PlausibleRange {
            bounds: |scale, _| scale.plausible_compliance(),
            reason: "up to ten times the compliance of the whole robot: a softer base would visibly rock",
        },
        typical: Typical {
            value: |_| 1e-14,
            spread: 1.0,
        },
        fit: OF_A_SIZE,
    }],
    contains: &[],
    combination: None,
    action: LawAction::Base,
    search: SearchSpec {
        shapes: |scale| vec![Shape::of_any_size(vec![scale.visible()])],
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("a base that rocks about {at}"),
        heading: |place| match place {
            Place::Axis(axis) => format!("a base that rocks about the {axis} axis"),
            other => format!("a base that rocks, {other}"),
        },
        explanation: "All supports of the robot rock together, like a plate on a soft floor.",
    },
    check: Some(Check {
        rank: 1,
        text: |place| {
            let about = match place {
                Place::Axis(axis) => axis.to_string(),
                other => other.to_string(),
            };
            format!(
                "set two dial gauges on the floor against the base, a known distance apart, and read its rocking about {about} under the \
                 largest load"
            )
        },
        minutes: 25.0,
    }),
};
