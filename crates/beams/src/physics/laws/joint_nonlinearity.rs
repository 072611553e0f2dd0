//! A joint that turns by a linear and a quadratic term of its moment.

use super::one_of;
use crate::physics::joint_path::JointPath;
use super::joint_compliance::{ACROSS_THE_JOINT, COMPLIANCE, NO_SUCH_JOINT, UNSEEN_AT_JOINT};
use crate::physics::action::{LawAction, Driven, RotationLaw, SimulatedRotation, Values};
use crate::physics::dimension::Dimension;
use crate::physics::law::{LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{FitBy, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::PlaceKind;
use crate::physics::search::{PlaceScale, SHAPE_ROOM, SearchSpec, SearchedOn, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "joint-nonlinearity",
    row: "joint-nonlinearity",
    kind: LawKind::Physics,
    equation: "twist = c tau + q tau |tau|",
    place_kind: PlaceKind::Joint,
    parameters: &[
        ParameterSpec {
            word: "linear part",
            ..COMPLIANCE
        },
        ParameterSpec {
            name: "q",
            word: "quadratic part",
            dimension: Dimension::QuadraticRotationalCompliance,
            sign: SignConstraint::Either,
            plausible: PlausibleRange {
                bounds: plausible_ratio,
                reason: "between minus half and twenty times the linear part at the largest moment: below that the joint would move backwards",
            },
            typical: Typical {
                value: |scale| 0.8e-12 / scale.moment_nm,
                spread: 2.0,
            },
            fit: FitBy::RatioToFirst,
        },
    ],
    contains: &["joint-compliance"],
    combination: None,
    action: LawAction::Joint(&Nonlinearity),
    search: SearchSpec {
        shapes,
        on: SearchedOn::ALL,
        unseen_at_place: UNSEEN_AT_JOINT,
        unseen: NO_SUCH_JOINT,
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, values| match values.get(1) {
            Some(q) if *q < 0.0 => format!("{} that grows stiffer under load", one_of(at)),
            Some(q) if *q > 0.0 => format!("{} that grows softer under load", one_of(at)),
            _ => format!("{} whose stiffness changes with the load", one_of(at)),
        },
        heading: |place| format!("nonlinearity of {place}"),
        explanation: "The joint gives way under the load on it, but not in proportion: it has a linear and a quadratic part.",
    },
    check: Some(ACROSS_THE_JOINT),
};

/// Quadratic share of the twist at the largest moment; below -0.5 the law would turn back.
const SHARES: [f64; 8] = [-0.48, -0.3, -0.12, 0.2, 0.6, 1.6, 5.0, 20.0];

/// Ratio q/c of a share, where the loop leaves the joint 1/(1 + saturation) of its moment.
fn ratio(share: f64, saturation: f64, scale: &PlaceScale) -> f64 {
    share * (1.0 + saturation) / scale.moment_nm
}

fn plausible_ratio(scale: &PlaceScale, _: &[f64]) -> [f64; 2] {
    let most = scale
        .compliances()
        .iter()
        .map(|shape| shape.saturation)
        .fold(0.0, f64::max);
    [SHARES[0], SHARES[SHARES.len() - 1]].map(|share| SHAPE_ROOM * ratio(share, most, scale))
}

fn shapes(scale: &PlaceScale) -> Vec<Shape> {
    let with_share = |share: f64| {
        scale.compliances().into_iter().map(move |mut shape| {
            // The same twist at the largest moment as the linear law of this compliance.
            let c = shape.values[0] / (1.0 + share);
            shape.values = vec![c, c * ratio(share, shape.saturation, scale)];
            shape
        })
    };
    SHARES.into_iter().flat_map(with_share).collect()
}

#[derive(Debug)]
struct Nonlinearity;

/// Twist of c τ + q τ|τ| with τ = T - k twist; all cases are computed, so that loads can be processed side by side.
///
/// With q below zero the law has a largest twist, c²/(4|q|), at the moment c/(2|q|): beyond it the joint is at its stop.
#[inline]
fn rotation([c, q]: [f64; 2], driving_nm: f64, k: f64) -> f64 {
    let driving = driving_nm.abs();
    let linear = 1.0 + c * k;
    let root = linear * linear + 4.0 * q * k * driving;
    let stop = c / (-2.0 * q);
    let at_the_stop = q < 0.0 && driving >= stop + k * c * stop * 0.5;
    let moment = 2.0 * driving / (linear + root.sqrt());
    let rotation = if at_the_stop || root < 0.0 {
        c * c / (-4.0 * q)
    } else {
        (c + q * moment) * moment
    };
    rotation.copysign(driving_nm)
}

impl RotationLaw for Nonlinearity {
    fn rotation_rad(&self, &[c, q, ..]: &Values, driven: Driven) -> f64 {
        rotation([c, q], driven.moment_nm, driven.stiffness_nm_per_rad)
    }

    fn slope_rad_per_nm(&self, values: &Values, driven: Driven) -> f64 {
        let &[c, q, ..] = values;
        let k = driven.stiffness_nm_per_rad;
        // φ = c τ + q τ |τ|, τ = T - k φ.
        let moment_nm = driven.moment_nm - k * self.rotation_rad(values, driven);
        let growth = (c + 2.0 * q * moment_nm.abs()).max(0.0);
        growth / (1.0 + growth * k)
    }

    fn stiffness_at_rest_nm_per_rad(&self, &[c, ..]: &Values) -> f64 {
        1.0 / c
    }

    fn added_m(&self, &[c, q, ..]: &Values, path: &JointPath, out: &mut [f64]) {
        path.side_by_side(
            #[inline(always)]
            |t, k| rotation([c, q], t, k),
            out,
        );
    }

    fn is_linear(&self) -> bool {
        false
    }

    fn in_simulators(&self, &[c, ..]: &Values) -> SimulatedRotation {
        SimulatedRotation {
            compliance_rad_per_nm: c,
            left_out: Some("simulators hold the linear part of this spring only"),
            ..SimulatedRotation::default()
        }
    }
}
