//! The section of an element is stiffer or softer than the robot file says.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording, MistakePrior};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::{Place, PlaceKind};
use crate::physics::search::{SearchSpec, Shape};

/// Smallest and largest error that is overlooked: three times either way is another profile.
const OVERLOOKED: [f64; 2] = [-2.0 / 3.0, 2.0];

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "section-error",
    row: "section-error",
    kind: LawKind::Setup(MistakePrior::Factor(0.30)),
    equation: "true A, Iy, Iz, J of the section = those in the file (1 + share)",
    place_kind: PlaceKind::Element,
    parameters: &[ParameterSpec {
        name: "share",
        word: "error of the section",
        dimension: Dimension::Share,
        sign: SignConstraint::Either,
        plausible: PlausibleRange {
            bounds: |_, _| OVERLOOKED,
            reason: "between a third and three times: the next wall thickness, a cut-out, a casting; more is another profile",
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
        shapes: |_| vec![Shape::of_either_sign(vec![1e-2])],
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("a wrong section of {at}"),
        heading: |place| format!("section of {place}"),
        explanation: "The section of this element, and of all that share its entry in the robot file, is stiffer or softer than the file says.",
    },
    check: Some(Check {
        rank: 1,
        text: |place| match place {
            Place::Element(element) => format!("measure the section of {element} with a caliper (width, wall), and compare it with the robot file"),
            other => format!("measure the section of {other} with a caliper, and compare them with the robot file"),
        },
        minutes: 15.0,
    }),
};
