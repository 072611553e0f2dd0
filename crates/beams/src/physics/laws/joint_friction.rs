//! A joint that sticks until its friction moment, then turns as a spring, and sticks again on reversal.

use crate::physics::joint_path::JointPath;
use super::joint_compliance::{ACROSS_THE_JOINT, COMPLIANCE, NO_SUCH_JOINT, UNSEEN_AT_JOINT};
use crate::physics::action::{
    Driven, LawAction, RotationLaw, SimulatedRotation, Values,
};
use crate::physics::dimension::Dimension;
use crate::physics::law::{LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{FitBy, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::PlaceKind;
use crate::physics::search::{PlaceScale, SearchSpec, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "joint-friction",
    row: "joint-friction",
    kind: LawKind::Physics,
    equation: "stuck for |tau| <= friction_moment, then twist = c (tau -/+ friction_moment); stuck again on reversal",
    place_kind: PlaceKind::Joint,
    parameters: &[
        COMPLIANCE,
        ParameterSpec {
            name: "friction_moment",
            word: "friction",
            dimension: Dimension::Moment,
            sign: SignConstraint::Positive,
            plausible: PlausibleRange {
                bounds: |scale, _| scale.moments([MOMENTS[0], MOMENTS[MOMENTS.len() - 1]]),
                reason: "within the moments of the session: beyond them the joint sticks",
            },
            typical: Typical {
                value: |scale| 0.22 * scale.moment_nm,
                spread: 2.0,
            },
            fit: FitBy::Search,
        },
    ],
    contains: &["joint-compliance"],
    combination: None,
    action: LawAction::Joint(&Friction),
    search: SearchSpec {
        shapes,
        unseen_at_place: UNSEEN_AT_JOINT,
        unseen: NO_SUCH_JOINT,
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("friction in {at}"),
        heading: |place| format!("friction in {place}"),
        explanation: "The joint sticks until the load on it exceeds its friction, then gives way like a spring; when the load is taken \
                      off it sticks again, so that loading and unloading differ.",
    },
    check: Some(ACROSS_THE_JOINT),
};

/// Friction moments as shares of the largest moment: what sticks gives way little by little.
const MOMENTS: [f64; 7] = [0.02, 0.1, 0.2, 0.33, 0.48, 0.65, 0.83];

fn shapes(scale: &PlaceScale) -> Vec<Shape> {
    let with_moment = |level: f64| {
        scale.compliances().into_iter().map(move |mut shape| {
            shape.values.push(level * scale.moment_nm);
            shape
        })
    };
    MOMENTS.into_iter().flat_map(with_moment).collect()
}

#[derive(Debug)]
struct Friction;

#[inline]
fn rotation([c, friction_moment]: [f64; 2], driving_nm: f64, k: f64, before_rad: f64) -> f64 {
    if c == 0.0 {
        return 0.0;
    }
    let slider = driving_nm - (k + 1.0 / c) * before_rad;
    if slider.abs() <= friction_moment {
        before_rad
    } else {
        c * (driving_nm - friction_moment.copysign(slider)) / (1.0 + c * k)
    }
}

impl RotationLaw for Friction {
    fn rotation_rad(&self, &[c, friction_moment, ..]: &Values, driven: Driven) -> f64 {
        let Driven {
            moment_nm,
            stiffness_nm_per_rad,
            before_rad,
        } = driven;
        rotation([c, friction_moment], moment_nm, stiffness_nm_per_rad, before_rad)
    }

    fn slope_rad_per_nm(&self, values: &Values, driven: Driven) -> f64 {
        let c = values[0];
        if self.rotation_rad(values, driven) == driven.before_rad {
            0.0
        } else {
            c / (1.0 + c * driven.stiffness_nm_per_rad)
        }
    }

    fn stiffness_at_rest_nm_per_rad(&self, &[c, friction_moment, ..]: &Values) -> f64 {
        if friction_moment == 0.0 {
            1.0 / c
        } else {
            f64::INFINITY
        }
    }

    fn added_m(&self, &[c, friction_moment, ..]: &Values, path: &JointPath, out: &mut [f64]) {
        path.in_sequence(|t, k, before| rotation([c, friction_moment], t, k, before), out);
    }

    fn is_linear(&self) -> bool {
        false
    }

    fn in_simulators(&self, &[c, friction_moment, ..]: &Values) -> SimulatedRotation {
        SimulatedRotation {
            compliance_rad_per_nm: c,
            friction_nm: friction_moment,
            ..SimulatedRotation::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::laws::tests::at;

    #[test]
    fn it_sticks_slips_and_sticks_until_twice_its_moment() {
        let mut rotation = 0.0;
        let path = [
            (1.0, 0.0),
            (5.0, 3e-3),
            (2.0, 3e-3),
            (1.0, 3e-3),
            (0.0, 2e-3),
        ];
        for (moment, expected) in path {
            rotation = Friction.rotation_rad(&[1e-3, 2.0, 0.0, 0.0], at(moment, 0.0, rotation));
            assert!((rotation - expected).abs() < 1e-15, "{moment}: {rotation}");
        }
    }
}
