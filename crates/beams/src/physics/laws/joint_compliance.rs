//! A joint that turns in proportion to its moment.

use crate::physics::joint_path::JointPath;
use crate::physics::action::{LawAction, Driven, RotationLaw, SimulatedRotation, Values};
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::{Place, PlaceKind};
use crate::physics::search::{PlaceScale, SearchSpec};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "joint-compliance",
    row: "joint-compliance",
    kind: LawKind::Physics,
    equation: "twist = c tau",
    place_kind: PlaceKind::Joint,
    parameters: &[COMPLIANCE],
    contains: &[],
    combination: None,
    action: LawAction::Joint(&LinearRotation),
    search: SearchSpec {
        shapes: PlaceScale::compliances,
        is_freest: true,
        unseen_at_place: UNSEEN_AT_JOINT,
        unseen: NO_SUCH_JOINT,
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("a compliant {at}"),
        heading: |place| format!("a compliant {place}"),
        explanation: "The joint gives way in proportion to the load on it, like a spring; the model takes it as rigid.",
    },
    check: Some(ACROSS_THE_JOINT),
};

/// The compliance of a joint: what all laws with a spring in a joint have in common.
pub(super) const COMPLIANCE: ParameterSpec = ParameterSpec {
    name: "c",
    word: "compliance",
    dimension: Dimension::RotationalCompliance,
    sign: SignConstraint::Positive,
    plausible: PlausibleRange {
        bounds: |scale, _| scale.plausible_compliance(),
        reason: "up to ten times the compliance of the whole structure there: drives and bearings make up to nine tenths of the compliance of a heavy arm; in a closed loop up to a pin, beyond which readings carry no information",
    },
    typical: Typical {
        value: |_| 1e-12,
        spread: 1.0,
    },
    fit: OF_A_SIZE,
};

pub(super) const UNSEEN_AT_JOINT: (&str, &str) = (
    "even if the joint moved freely, the readings would hardly change, or the fitted factors would absorb the change",
    "measure poses in which the load acts more strongly on the joint, or load and read the linkage next to it",
);

pub(super) const NO_SUCH_JOINT: (&str, Option<&str>) = (
    "the mechanism has no joint that these loads act on",
    Some("choose the mechanism that the robot really has"),
);

pub(super) const ACROSS_THE_JOINT: Check = Check {
    rank: 4,
    text: |place: &Place| {
        format!(
            "set a dial gauge across {place}, from one of its bodies to the other, and load and unload once"
        )
    },
    minutes: 25.0,
};

#[derive(Debug)]
struct LinearRotation;

/// Twist of c τ with τ = T - k twist.
#[inline]
fn rotation(c: f64, driving_nm: f64, k: f64) -> f64 {
    c * driving_nm / (1.0 + c * k)
}

impl RotationLaw for LinearRotation {
    fn rotation_rad(&self, &[c, ..]: &Values, driven: Driven) -> f64 {
        rotation(c, driven.moment_nm, driven.stiffness_nm_per_rad)
    }

    fn slope_rad_per_nm(&self, &[c, ..]: &Values, driven: Driven) -> f64 {
        c / (1.0 + c * driven.stiffness_nm_per_rad)
    }

    fn stiffness_at_rest_nm_per_rad(&self, &[c, ..]: &Values) -> f64 {
        1.0 / c
    }

    fn added_m(&self, &[c, ..]: &Values, path: &JointPath, out: &mut [f64]) {
        path.side_by_side(
            #[inline(always)]
            |t, k| rotation(c, t, k),
            out,
        );
    }

    fn is_linear(&self) -> bool {
        true
    }

    fn in_simulators(&self, &[c, ..]: &Values) -> SimulatedRotation {
        SimulatedRotation {
            compliance_rad_per_nm: c,
            ..SimulatedRotation::default()
        }
    }
}
