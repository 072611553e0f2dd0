//! A joint gives way about an axis across its own: its bearing tilts.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::PlaceKind;
use crate::physics::search::{PlaceScale, SearchSpec};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "joint-tilt-compliance",
    row: "joint-tilt-compliance",
    kind: LawKind::Physics,
    equation: "the second body of the joint turns about the axis of its frame by c times the moment there",
    place_kind: PlaceKind::AcrossJoint,
    parameters: &[ParameterSpec {
        name: "c",
        word: "compliance",
        dimension: Dimension::RotationalCompliance,
        sign: SignConstraint::Positive,
        plausible: PlausibleRange {
            bounds: |scale, _| scale.plausible_compliance(),
            reason: "up to ten times the compliance of the whole robot: a softer bearing would visibly tilt",
        },
        typical: Typical {
            value: |_| 1e-14,
            spread: 1.0,
        },
        fit: OF_A_SIZE,
    }],
    contains: &[],
    combination: None,
    action: LawAction::Structure,
    search: SearchSpec {
        shapes: PlaceScale::compliances,
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("tilt compliance of {at}"),
        heading: |place| format!("tilt compliance, {place}"),
        explanation: "The joint yields about an axis perpendicular to its own: its bearing tilts under the moment there.",
    },
    check: Some(Check {
        rank: 1,
        text: |place| {
            format!(
                "set two dial gauges on the bodies of the joint, a known distance apart, and read the tilt between them under the largest load ({place})"
            )
        },
        minutes: 25.0,
    }),
};
