//! An element that carries nothing.

use crate::physics::action::LawAction;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::place::{Place, PlaceKind};
use crate::physics::search::SearchSpec;

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "loose-member",
    row: "loose-member",
    kind: LawKind::Physics,
    equation: "the element carries nothing",
    place_kind: PlaceKind::Element,
    parameters: &[],
    contains: &[],
    combination: None,
    action: LawAction::Missing,
    search: SearchSpec {
        // It has no size: each structure without an element is solved.
        shapes: |_| Vec::new(),
        unseen_at_place: (
            "without it the readings would hardly change, or the fitted factors would absorb the change",
            "measure further poses, or inspect both of its ends",
        ),
        unseen: (
            "no element can be missing without the mechanism falling apart",
            None,
        ),
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("a loose {at}"),
        heading: |place| format!("{place} loose"),
        explanation: "The robot behaves as if this member were not there.",
    },
    check: Some(Check {
        rank: 2,
        text: |place| {
            let element = match place {
                Place::Element(name) => name.clone(),
                other => other.to_string(),
            };
            format!("inspect and tighten both ends of {element}, or remove it, and repeat the stiffest cell")
        },
        minutes: 30.0,
    }),
};
