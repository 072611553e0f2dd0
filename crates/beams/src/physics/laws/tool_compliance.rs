//! What stands between the last link and the end gives way.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::PlaceKind;
use crate::physics::search::{PlaceScale, SearchSpec};

/// About an axis.
pub(super) static LAW: LawDefinition = LawDefinition {
    row: "tool-compliance (about)",
    equation: "the tool turns about an axis of its frame, at its mount, by c times the moment there",
    place_kind: PlaceKind::ToolAbout,
    parameters: &[compliance(Dimension::RotationalCompliance)],
    ..OF_THE_TOOL
};

/// Along an axis.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "tool-compliance (along)",
    equation: "the tool moves along an axis of its frame by c times the force there",
    place_kind: PlaceKind::ToolAlong,
    parameters: &[compliance(Dimension::Compliance)],
    ..OF_THE_TOOL
};

const fn compliance(dimension: Dimension) -> ParameterSpec {
    ParameterSpec {
        name: "c",
        word: "compliance",
        dimension,
        sign: SignConstraint::Positive,
        plausible: PlausibleRange {
            bounds: |scale, _| scale.plausible_compliance(),
            reason: "up to ten times the compliance of the whole robot: a softer mount would visibly move",
        },
        typical: Typical {
            value: |_| 1e-14,
            spread: 1.0,
        },
        fit: OF_A_SIZE,
    }
}

const OF_THE_TOOL: LawDefinition = LawDefinition {
    name: "tool-compliance",
    row: "tool-compliance",
    kind: LawKind::Physics,
    equation: "",
    place_kind: PlaceKind::ToolAbout,
    parameters: &[],
    contains: &[],
    combination: None,
    action: LawAction::Structure,
    search: SearchSpec {
        shapes: PlaceScale::compliances,
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("compliance of {at}"),
        heading: |place| format!("tool compliance, {place}"),
        explanation: "Something between the last link and the end yields: flange, adapter, tool or the bracket of the gauge.",
    },
    check: Some(Check {
        rank: 1,
        text: |place| {
            format!(
                "read the displacement at the flange too, under the same loads: the difference is that of {place}"
            )
        },
        minutes: 20.0,
    }),
};
