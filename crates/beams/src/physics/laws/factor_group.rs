//! The fitting factors of a group of elements are wrong.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording, MistakePrior};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::{Place, PlaceKind};
use crate::physics::search::{SearchSpec, Shape};

/// Smallest and largest error: ten times either way, as the bounds of a fit.
const WITHIN_A_FIT: [f64; 2] = [-0.9, 9.0];

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "factor-group",
    row: "factor-group",
    kind: LawKind::Setup(MistakePrior::Factor(0.70)),
    equation: "true factors of the group = those of the model (1 + share)",
    place_kind: PlaceKind::Group,
    parameters: &[ParameterSpec {
        name: "share",
        word: "error of the factors",
        dimension: Dimension::Share,
        sign: SignConstraint::Either,
        plausible: PlausibleRange {
            bounds: |_, _| WITHIN_A_FIT,
            reason: "between a tenth and ten times: factors of another robot, pose or fit; these are the bounds of a fit",
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
        phrase: |at, _| format!("wrong {at}"),
        heading: |place| format!("{place}"),
        explanation: "The factors of these elements, which this fit holds fixed, are wrong.",
    },
    check: Some(Check {
        rank: 1,
        text: |place| match place {
            Place::Group { group, property } => {
                let factor = property.as_ref().map_or_else(|| group.clone(), |property| format!("{group}.{}", property.name()));
                format!("check the source of the factors of {group}, and fit them with `--parameter {factor}=free` if the poses determine them")
            }
            other => format!("check the source of {other}"),
        },
        minutes: 5.0,
    }),
};
