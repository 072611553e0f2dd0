//! A joint that turns freely through its play once its seat is overcome.

use crate::physics::joint_path::JointPath;
use super::joint_compliance::{ACROSS_THE_JOINT, NO_SUCH_JOINT, UNSEEN_AT_JOINT};
use crate::physics::action::{
    Driven, DrivenPath, HistoryLaw, LawAction, RotationLaw, SimulatedRotation, Values,
};
use crate::physics::dimension::Dimension;
use crate::physics::law::{LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OF_A_SIZE, FitBy, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::part::{LEVEL, SEARCH, SLOPE, at_levels, mean_slope};
use crate::physics::place::PlaceKind;
use crate::physics::search::{PlaceScale, SearchSpec, SearchedOn, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "joint-backlash",
    row: "joint-backlash",
    kind: LawKind::Physics,
    equation: "twist = 0 for |tau| < seat_moment, then taken up at |tau| = seat_moment until |twist| = play",
    place_kind: PlaceKind::Joint,
    parameters: &[
        ParameterSpec {
            name: "play",
            word: "play",
            dimension: Dimension::JointRotation,
            sign: SignConstraint::Positive,
            plausible: PlausibleRange {
                bounds: |scale, _| {
                    let [_, softest] = scale.plausible_compliance();
                    let softest_rad = softest * scale.moment_nm;
                    // All that a closed loop lets the loads take up.
                    let taken_up_rad = 1.2 * scale.moment_nm / scale.loop_nm_per_rad;
                    [0.0, softest_rad.min(taken_up_rad)]
                },
                reason: "at most the rotation of the softest plausible joint under the largest moment, and at most what the loads of the session take up",
            },
            typical: Typical {
                value: |_| 1e-12,
                spread: 1.0,
            },
            fit: OF_A_SIZE,
        },
        ParameterSpec {
            name: "seat_moment",
            word: "breakaway load",
            dimension: Dimension::Moment,
            sign: SignConstraint::Positive,
            plausible: PlausibleRange {
                bounds: |scale, _| scale.moments([SEATS[0], SEATS[SEATS.len() - 1]]),
                reason: "within the moments of the session: beyond them nothing moves",
            },
            typical: Typical {
                value: |scale| 0.22 * scale.moment_nm,
                spread: 2.0,
            },
            fit: FitBy::Search,
        },
    ],
    contains: &[],
    combination: None,
    action: LawAction::Joint(&Backlash),
    search: SearchSpec {
        shapes,
        is_sharp: true,
        on: SearchedOn::FORCE_DRIVEN,
        unseen_at_place: UNSEEN_AT_JOINT,
        unseen: NO_SUCH_JOINT,
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("play in {at}"),
        heading: |place| format!("play in {place}"),
        explanation: "Once the load on the joint exceeds its breakaway load, the joint moves freely through its play; then it carries load again.",
    },
    check: Some(ACROSS_THE_JOINT),
};

/// The same part with its displacement set: it carries nothing within its play.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "joint-backlash (force read)",
    equation: "force -= k (displacement within -play/2 to play/2)",
    parameters: &[
        ParameterSpec {
            name: "k",
            word: "stiffness outside the play",
            ..SLOPE
        },
        ParameterSpec {
            name: "play",
            word: "play",
            ..LEVEL
        },
    ],
    action: LawAction::History(&DeadZone),
    search: SearchSpec {
        shapes: |scale| at_levels(scale, 1e-3 * mean_slope(scale)),
        is_sharp: true,
        on: SearchedOn::DISPLACEMENT_DRIVEN_PARTS,
        ..SEARCH
    },
    ..LAW
};

#[derive(Debug)]
struct DeadZone;

impl HistoryLaw for DeadZone {
    fn answers(&self, &[k, play, ..]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        for (answer, driver) in out.iter_mut().zip(path.driver) {
            *answer = -k * driver.clamp(-0.5 * play, 0.5 * play);
        }
    }
}

/// Seat moments of a play as shares of the largest moment: where a reading lies beyond the seat or before it the play is all there or not at
/// all, so that a fortieth changes it.
#[rustfmt::skip]
const SEATS: [f64; 23] = [
    0.015, 0.03, 0.05, 0.07, 0.09, 0.12, 0.15, 0.18, 0.21, 0.25, 0.29, 0.33, 0.37, 0.415, 0.46, 0.51, 0.56, 0.61, 0.66, 0.715, 0.77, 0.825,
    0.88,
];

fn shapes(scale: &PlaceScale) -> Vec<Shape> {
    // Play as a share of what the loads could take up, with the range of sizes each stands for.
    let plays = [
        (0.05, [0.0, 2.2]),
        (0.22, [0.5, 1.6]),
        (0.5, [0.7, 1.35]),
        (0.95, [0.8, 1.2]),
    ];
    let mut shapes = Vec::new();
    for level in SEATS {
        let seat_moment = level * scale.moment_nm;
        if scale.loop_nm_per_rad == 0.0 {
            let play = scale.visible() * scale.moment_nm;
            shapes.push(Shape::of_any_size(vec![play, seat_moment]));
            continue;
        }
        let most = (scale.moment_nm - seat_moment) / scale.loop_nm_per_rad;
        shapes.extend(plays.into_iter().map(|(share, range)| Shape {
            scale: range,
            ..Shape::of_any_size(vec![share * most, seat_moment])
        }));
    }
    shapes
}

#[derive(Debug)]
struct Backlash;

/// Twist of play behind a seat; all cases are computed, so that loads can be processed side by side.
#[inline]
fn rotation([play, seat_moment]: [f64; 2], driving_nm: f64, k: f64) -> f64 {
    let beyond = driving_nm.abs() - seat_moment;
    let partly = beyond / k;
    let taken_up = if beyond >= k * play { play } else { partly };
    let taken_up = if beyond <= 0.0 { 0.0 } else { taken_up };
    taken_up.copysign(driving_nm)
}

impl RotationLaw for Backlash {
    fn rotation_rad(&self, &[play, seat_moment, ..]: &Values, driven: Driven) -> f64 {
        rotation([play, seat_moment], driven.moment_nm, driven.stiffness_nm_per_rad)
    }

    fn slope_rad_per_nm(&self, values: &Values, driven: Driven) -> f64 {
        let rotation = self.rotation_rad(values, driven);
        if rotation == 0.0 || rotation.abs() >= values[0] {
            0.0
        } else {
            1.0 / driven.stiffness_nm_per_rad
        }
    }

    fn stiffness_at_rest_nm_per_rad(&self, &[play, seat_moment, ..]: &Values) -> f64 {
        if seat_moment == 0.0 && play > 0.0 {
            0.0
        } else {
            f64::INFINITY
        }
    }

    fn added_m(&self, &[play, seat_moment, ..]: &Values, path: &JointPath, out: &mut [f64]) {
        path.side_by_side(
            #[inline(always)]
            |t, k| rotation([play, seat_moment], t, k),
            out,
        );
    }

    fn is_linear(&self) -> bool {
        false
    }

    fn in_simulators(&self, &[play, seat_moment, ..]: &Values) -> SimulatedRotation {
        SimulatedRotation {
            play_rad: play,
            friction_nm: seat_moment,
            ..SimulatedRotation::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::laws::tests::at;
    use proptest::prelude::*;

    #[test]
    fn it_follows_its_three_pieces() {
        let values = [1e-3, 2.0, 0.0, 0.0];
        // k = 1000 N·m/rad takes up the play over 1 N·m.
        for (driving, expected) in [(1.9, 0.0), (2.5, 0.5e-3), (3.5, 1e-3), (-2.5, -0.5e-3)] {
            let rotation = Backlash.rotation_rad(&values, at(driving, 1000.0, 0.0));
            assert!((rotation - expected).abs() < 1e-15);
        }
        assert_eq!(Backlash.rotation_rad(&values, at(2.1, 0.0, 0.0)), 1e-3);
        assert_eq!(Backlash.rotation_rad(&values, at(2.0, 0.0, 0.0)), 0.0);
    }

    proptest! {
        /// Play never exceeds its size, and the moment stays at the seat while it is taken up.
        #[test]
        fn it_holds_its_seat(
            play in 1e-6..1e-2_f64, seat_moment in 0.0..20.0_f64, driving in -50.0..50.0_f64, k in 1.0..1e4_f64,
        ) {
            let rotation = Backlash.rotation_rad(&[play, seat_moment, 0.0, 0.0], at(driving, k, 0.0));
            prop_assert!(rotation.abs() <= play && rotation * driving >= 0.0);
            let moment = (driving - k * rotation).abs();
            if rotation != 0.0 && rotation.abs() < play {
                prop_assert!((moment - seat_moment).abs() < 1e-9 * driving.abs());
            }
        }
    }
}
