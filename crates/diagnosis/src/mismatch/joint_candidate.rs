//! The laws of a joint at every joint, with shapes from where the structure hardly minds the twist up to a pin.

use stiffbench_beams::physics::{Law, Place};

use super::candidate::{Candidate, REFERENCE_SHARE, Shape};
use super::changes::Frozen;
use super::observations::Observations;

/// A joint whose release would add more than this many times the compliance of the structure lies in no closed loop.
const OPEN: f64 = 1e4;

/// The joint as the loads of a session see it.
#[derive(Debug, Clone, Copy)]
struct JointView {
    /// Largest moment of the rigid joint, N·m.
    moment_nm: f64,
    /// Compliance of the joint that adds the reference share to some cell, rad/(N·m).
    reference: f64,
    /// Stiffness of the structure against its twist where it matters most, N·m/rad; zero in no closed loop.
    stiffness: f64,
    /// Compliance of the structure where the joint matters most, over the square of its lever there, rad/(N·m).
    whole: f64,
}

fn view(
    observations: &Observations,
    poses: &Frozen,
    joint: usize,
    largest_force_n: f64,
) -> Option<JointView> {
    let mut best: Option<(f64, f64, f64, f64)> = None;
    let mut moment_nm = 0.0_f64;
    for cell in &observations.cells {
        let axis = cell.direction.index();
        let influence = &poses.poses[cell.pose].influence;
        let lever = influence.levers_m[joint][axis];
        let compliance = influence.compliance_m_per_n[axis][axis];
        moment_nm = moment_nm.max(lever.abs() * largest_force_n);
        let share = lever * lever / compliance;
        if best.is_none_or(|(most, ..)| share > most) {
            best = Some((share, lever, influence.stiffness(joint, joint), compliance));
        }
    }
    let (share, lever, stiffness, compliance) = best?;
    if !(share.is_finite() && share > 0.0) {
        return None;
    }
    let is_open = lever * lever > OPEN * compliance * stiffness.abs();
    Some(JointView {
        moment_nm,
        reference: REFERENCE_SHARE / share,
        stiffness: if is_open { 0.0 } else { stiffness.abs() },
        whole: 1.0 / share,
    })
}

pub(super) fn joint_candidates(
    observations: &Observations,
    poses: &Frozen,
    largest_force_n: f64,
    out: &mut Vec<Candidate>,
) {
    for (joint, name) in poses.joints.iter().enumerate() {
        let Some(view) = view(observations, poses, joint, largest_force_n) else {
            continue;
        };
        let place = || Place::Joint(name.clone());
        let mut add = |law, shapes: Vec<Shape>, largest| {
            out.push(Candidate::of_shapes(law, place(), shapes, largest, false));
        };
        // A joint as soft as a third of the whole structure is the largest that is plausible.
        let largest = 0.3 * view.whole;
        add(Law::JointCompliance, compliance_shapes(&view), largest);
        add(
            Law::JointBacklash,
            backlash_shapes(&view),
            largest * view.moment_nm,
        );
        add(Law::JointFriction, friction_shapes(&view), largest);
        add(Law::JointNonlinearity, nonlinear_shapes(&view), largest);
    }
}

/// Compliances: where the structure hardly minds the twist, and steps up to a pin; with the range of effects each stands for, and
/// with their saturation.
fn compliances(view: &JointView) -> Vec<(f64, [f64; 2], f64)> {
    if view.stiffness == 0.0 {
        return vec![(view.reference, [0.0, f64::INFINITY], 0.0)];
    }
    let relative = [
        (0.03, [0.0, 2.1]),
        (0.15, [0.47, 1.7]),
        (0.6, [0.59, 1.38]),
        (2.5, [0.73, 1.14]),
        (12.0, [0.88, 1.07]),
    ];
    relative
        .into_iter()
        .map(|(product, scale)| (product / view.stiffness, scale, product))
        .collect()
}

fn compliance_shapes(view: &JointView) -> Vec<Shape> {
    compliances(view)
        .into_iter()
        .map(|(c, scale, saturation)| Shape {
            values: vec![c],
            scale,
            saturation,
        })
        .collect()
}

/// Seat moments of a play as shares of the largest moment: where a reading lies beyond the seat or before it the play is all there or not at
/// all, so that a fortieth changes it.
#[rustfmt::skip]
const SEATS: [f64; 23] = [
    0.015, 0.03, 0.05, 0.07, 0.09, 0.12, 0.15, 0.18, 0.21, 0.25, 0.29, 0.33, 0.37, 0.415, 0.46, 0.51, 0.56, 0.61, 0.66, 0.715, 0.77, 0.825,
    0.88,
];

/// Friction moments as shares of the largest moment: what sticks gives way little by little.
const FRICTION_MOMENTS: [f64; 7] = [0.02, 0.1, 0.2, 0.33, 0.48, 0.65, 0.83];

fn backlash_shapes(view: &JointView) -> Vec<Shape> {
    // Play as a share of what the loads could take up, with the range of sizes each stands for.
    let plays = [
        (0.05, [0.0, 2.2]),
        (0.22, [0.5, 1.6]),
        (0.5, [0.7, 1.35]),
        (0.95, [0.8, 1.2]),
    ];
    let mut shapes = Vec::new();
    for level in SEATS {
        let seat_moment = level * view.moment_nm;
        let mut add = |play, scale| {
            shapes.push(Shape {
                values: vec![play, seat_moment],
                scale,
                saturation: 0.0,
            });
        };
        if view.stiffness == 0.0 {
            add(view.reference * view.moment_nm, [0.0, f64::INFINITY]);
            continue;
        }
        let most = (view.moment_nm - seat_moment) / view.stiffness;
        for (share, scale) in plays {
            add(share * most, scale);
        }
    }
    shapes
}

fn friction_shapes(view: &JointView) -> Vec<Shape> {
    let mut shapes = Vec::new();
    for level in FRICTION_MOMENTS {
        for (c, scale, saturation) in compliances(view) {
            shapes.push(Shape {
                values: vec![c, level * view.moment_nm],
                scale,
                saturation,
            });
        }
    }
    shapes
}

/// Quadratic share of the twist at the largest moment; below -0.5 the law would turn back.
const QUADRATIC: [f64; 8] = [-0.48, -0.3, -0.12, 0.2, 0.6, 1.6, 5.0, 20.0];

fn nonlinear_shapes(view: &JointView) -> Vec<Shape> {
    let mut shapes = Vec::new();
    for share in QUADRATIC {
        for (c, scale, saturation) in compliances(view) {
            // The same twist at the largest moment as the linear law of this compliance.
            let c = c / (1.0 + share);
            shapes.push(Shape {
                values: vec![c, share * c * (1.0 + saturation) / view.moment_nm],
                scale,
                saturation,
            });
        }
    }
    shapes
}
