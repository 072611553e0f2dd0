//! A length of the robot is another than its file says.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording, MistakePrior};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::{Place, PlaceKind};
use crate::physics::search::{SearchSpec, Shape};

/// Most by which a length is wrong and not seen, m.
const OVERLOOKED_M: f64 = 0.05;

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "link-length",
    row: "link-length",
    kind: LawKind::Setup(MistakePrior::Size(0.010)),
    equation: "true length = length in the file + length",
    place_kind: PlaceKind::Length,
    parameters: &[ParameterSpec {
        name: "length",
        word: "change of the length",
        dimension: Dimension::Length,
        sign: SignConstraint::Either,
        plausible: PlausibleRange {
            bounds: |_, _| [-OVERLOOKED_M, OVERLOOKED_M],
            reason: "up to 50 mm: another revision of the drawing, a face taken for the axis, an adapter left out; more would be visible",
        },
        typical: Typical {
            value: |_| 1e-6,
            spread: 1.0,
        },
        fit: OF_A_SIZE,
    }],
    contains: &[],
    combination: None,
    action: LawAction::Structure,
    search: SearchSpec {
        shapes: |_| vec![Shape::of_either_sign(vec![1e-3])],
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("a wrong {at}"),
        heading: |place| format!("{place} of the robot file"),
        explanation: "A length of the robot differs from the one in its file.",
    },
    check: Some(Check {
        rank: 0,
        text: |place| match place {
            Place::Length { body, entry } => {
                format!("measure `{entry}` of {body} with a tape, from joint axis to joint axis, and compare it with the robot file")
            }
            other => format!("measure {other} with a tape, and compare them with the robot file"),
        },
        minutes: 10.0,
    }),
};
