//! Another mechanism of the robot file is there than the session says.

use crate::physics::action::LawAction;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording, MistakePrior};
use crate::physics::place::{Place, PlaceKind};
use crate::physics::search::SearchSpec;

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "wrong-mechanism",
    row: "wrong-mechanism",
    kind: LawKind::Setup(MistakePrior::Sizeless),
    equation: "the robot is another mechanism of its file",
    place_kind: PlaceKind::Mechanism,
    parameters: &[],
    contains: &[],
    combination: None,
    action: LawAction::Mechanism,
    search: SearchSpec {
        // It has no size: each mechanism is solved.
        shapes: |_| Vec::new(),
        unseen_at_place: (
            "the readings would hardly change, or the fitted factors would absorb the change",
            "measure further poses, or check brakes and coupling rods",
        ),
        unseen: ("the robot file has no other mechanism that can take these poses", None),
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("another mechanism than the session names, {at}"),
        heading: |place| format!("{place} instead"),
        explanation: "The robot behaves like another mechanism of its file than the one that the session names.",
    },
    check: Some(Check {
        rank: 0,
        text: |place| {
            let mechanism = match place {
                Place::Mechanism(name) => name.clone(),
                other => other.to_string(),
            };
            format!("check which drives, brakes and coupling rods are engaged, and try `--mechanism {mechanism}`")
        },
        minutes: 5.0,
    }),
};
