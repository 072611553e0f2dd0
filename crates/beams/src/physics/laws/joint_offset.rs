//! A joint stands at another angle than the pose says.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording, MistakePrior};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::{Place, PlaceKind};
use crate::physics::search::{SearchSpec, Shape};

/// Most by which a joint stands beside its angle and is not seen, rad: five degrees.
const OVERLOOKED_RAD: f64 = 0.087;

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "joint-offset",
    row: "joint-offset",
    kind: LawKind::Setup(MistakePrior::Size(0.0175)),
    equation: "true angle = angle of the pose + angle",
    place_kind: PlaceKind::JointAngle,
    parameters: &[ParameterSpec {
        name: "angle",
        word: "offset",
        dimension: Dimension::Angle,
        sign: SignConstraint::Either,
        plausible: PlausibleRange {
            bounds: |_, _| [-OVERLOOKED_RAD, OVERLOOKED_RAD],
            reason: "up to five degrees: lost mastering, an angle noted for the wrong pose; more would be visible",
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
        heading: |place| format!("{place}"),
        explanation: "The angle of a joint differs from that of the robot file and the pose.",
    },
    check: Some(Check {
        rank: 0,
        text: |place| match place {
            Place::JointAngle { joint, pose: Some(pose) } => {
                format!("measure the angle of joint {joint} in pose {pose} with an inclinometer, and compare it with the robot file")
            }
            Place::JointAngle { joint, pose: None } => {
                format!("measure the angle of joint {joint} with an inclinometer, compare it with the robot file, and check the mastering marks")
            }
            other => format!("measure {other} with an inclinometer"),
        },
        minutes: 10.0,
    }),
};
