//! The laws of the physics library against OpenSees, joint laws in closed loops among them, and against closed forms of a serial arm.
//!
//! `fixtures/opensees/laws.csv` was made by `fixtures/opensees/generate_laws.py`: the structure is OpenSees', each law is solved from its
//! definition by bisection. Columns `o_<n>` hold the same run followed by OpenSees alone, with materials of its own.

use std::collections::BTreeMap;

use crate::support::robots::{self, shipped};
use crate::support::rows::{Row, rows};
use stiffbench_beams::physics::{ActingPhysics, Effect, Mechanics};
use stiffbench_beams::robot::{FittingFactors, Predictor, Robot};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

/// Forces of the run, N: loading, unloading, then across zero, back, and across again.
const PATH: [f64; 19] = [
    -10.0, -20.0, -30.0, -40.0, -50.0, -60.0, -70.0, -60.0, -50.0, -40.0, -30.0, -20.0, -10.0, 0.0,
    20.0, 50.0, 70.0, 0.0, -40.0,
];

/// Difference to the laws solved by bisection, as a share of the largest displacement of the run: both structures keep nine to ten digits
/// (`structure_opensees.rs`), and a law adds no loss of its own.
const ALLOWED: f64 = 1e-8;

/// Difference to OpenSees alone, as a share of the largest effect of the law: its materials have no jump. A stuck slider and a rigid seat
/// are stiff springs there, play has a slope, and a curve is a polygon.
const ALLOWED_OF_MATERIALS: f64 = 5e-3;

/// Displacements over the path, m.
fn displacements(
    robot: &Robot,
    mechanism: &str,
    (pose, direction): (&str, Direction),
    effects: &[&str],
) -> Vec<f64> {
    let mechanism = robot.mechanism(Some(mechanism)).unwrap();
    let effects: Vec<Effect> = effects.iter().map(|text| text.parse().unwrap()).collect();
    let physics = ActingPhysics::new(robot, mechanism, effects).unwrap();
    let factors = robot.factor_set("m_fsd").unwrap();
    let pose = PoseId::new(pose);
    let poses = [robot.pose(&pose).unwrap().clone()];
    let mechanics = Mechanics::new(robot, &physics.mechanism, &factors, &poses).unwrap();
    let run = (LoadDirection::of_axis(direction), direction.into());
    robots::displacements(&physics.laws, &pose, mechanics.pose(0), run, &PATH)
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// The numbers in the columns `<prefix>1`, `<prefix>2` … that are not empty.
fn series(row: &Row, prefix: &str) -> Vec<f64> {
    (1..=PATH.len())
        .filter_map(|n| row.get(&format!("{prefix}{n}")))
        .filter(|text| !text.is_empty())
        .map(|text| text.parse().unwrap())
        .collect()
}

#[test]
fn every_law_moves_the_end_as_in_opensees() {
    let robots = [
        ("host-parasite", shipped("hp-robot")),
        ("serial-arm", shipped("serial-arm")),
    ];
    let (mut cases, mut with_materials) = (0, 0);
    let mut worst = BTreeMap::new();
    for row in rows("opensees/laws.csv") {
        let robot = &robots
            .iter()
            .find(|(name, _)| *name == row["robot"])
            .unwrap()
            .1;
        let place = (row["pose"].as_str(), row["direction"].parse().unwrap());
        let effects: Vec<&str> = row["effects"].split(' ').collect();
        let ours = displacements(robot, &row["mechanism"], place, &effects);
        let expected = series(&row, "d_");
        assert_eq!(expected.len(), PATH.len());
        let size = largest(expected.iter().copied());
        let apart = largest(ours.iter().zip(&expected).map(|(a, b)| a - b)) / size;
        assert!(apart < ALLOWED, "{row:?}: {apart:e}");
        let law = effects[0].split('@').next().unwrap().to_owned();
        let case: &mut (f64, f64) = worst.entry((row["mechanism"].clone(), law)).or_default();
        case.0 = case.0.max(apart);
        cases += 1;

        let materials = series(&row, "o_");
        if !materials.is_empty() {
            let bare = displacements(robot, &row["mechanism"], place, &[]);
            let effect = largest(ours.iter().zip(&bare).map(|(with, without)| with - without));
            let apart = largest(ours.iter().zip(&materials).map(|(a, b)| a - b));
            // Their stiff springs cost digits, too.
            let allowed = ALLOWED_OF_MATERIALS * effect + 1e-6 * size;
            assert!(apart < allowed, "{row:?}: {apart:e} of {effect:e}");
            case.1 = case.1.max(apart / effect);
            with_materials += 1;
        }
    }
    assert!(
        cases >= 90 && with_materials >= 70,
        "{cases} {with_materials}"
    );
    for ((mechanism, law), (bisection, materials)) in worst {
        println!(
            "{mechanism} {law}: {bisection:.1e}, OpenSees alone {materials:.1e} of the effect"
        );
    }
}

/// A joint in no loop carries the moment of statics, whatever it does: lever and displacement in closed form.
#[test]
fn a_serial_arm_agrees_with_closed_forms() {
    let arm = shipped("serial-arm");
    let mechanism = arm.mechanism(None).unwrap();
    let pose = arm.pose(&"P2".into()).unwrap();
    let factors = arm.factor_set("m_fsd").unwrap();
    let mut predictor = Predictor::new(&arm, mechanism, &factors).unwrap();
    predictor.place(pose).unwrap();
    let structure = predictor.model().structure();
    let node = |name: &str| {
        let found = structure.nodes.iter().find(|node| &*node.name == name);
        found.unwrap().position_m
    };
    // S3 turns about x at N5: the end moves by x × (end - N5), and -F z_arm is the moment of a vertical force.
    let (end, joint) = (node("N8"), node("N5"));
    let lever = -(end[2] - joint[2]);
    let y = ("P2", Direction::Y);
    let bare = displacements(&arm, "A", y, &[]);
    let over = |effect: &str| -> Vec<f64> {
        let with = displacements(&arm, "A", y, &[effect]);
        with.iter()
            .zip(&bare)
            .map(|(with, bare)| with - bare)
            .collect()
    };
    let top = 70.0 * lever.abs();
    let (c, q, seat, play, friction): (f64, f64, f64, f64, f64) =
        (1e-5, 1e-7, 0.35 * top, 1e-4, 0.2 * top);
    let follows = |effect: &str, twist: &mut dyn FnMut(f64) -> f64| {
        for (force, moved) in PATH.iter().zip(over(effect)) {
            let expected = lever * twist(lever * force);
            let allowed = 1e-9 * top * lever.abs() * c + 1e-9 * bare[6].abs();
            assert!(
                (moved - expected).abs() < allowed,
                "{effect} at {force}: {moved} {expected}"
            );
        }
    };
    follows(
        &format!("joint-compliance@S3:c={c:?}rad/(N*m)"),
        &mut |tau| c * tau,
    );
    follows(
        &format!("joint-nonlinearity@S3:c={c:?}rad/(N*m),q={q:?}rad/(N*m)^2"),
        &mut |tau| c * tau + q * tau * tau.abs(),
    );
    follows(
        &format!("joint-backlash@S3:play={play:?}rad,seat_moment={seat:?}N*m"),
        &mut |tau| {
            if tau.abs() > seat {
                play.copysign(tau)
            } else {
                0.0
            }
        },
    );
    let mut twist = 0.0;
    follows(
        &format!("joint-friction@S3:c={c:?}rad/(N*m),friction_moment={friction:?}N*m"),
        &mut |tau| {
            twist = f64::clamp(twist, c * (tau - friction), c * (tau + friction));
            twist
        },
    );
}

/// The more joints share a loop, the more their twists depend on each other: all of them compliant against the pinned structure's
/// own solution with springs in its joints.
#[test]
fn many_compliant_joints_agree_with_springs_in_the_structure() {
    use stiffbench_beams::robot::{JointModel, Theory};

    let robot = shipped("hp-robot");
    let mechanism = robot.mechanism(Some("B")).unwrap();
    let factors: FittingFactors = robot.factor_set("m_fsd").unwrap();
    for c in [1e-6, 1e-4, 1e-2] {
        let names = ["B1", "B2a", "B2b", "B3", "A4B"];
        let effects: Vec<String> = names
            .iter()
            .map(|name| format!("joint-compliance@{name}:c={c:?}rad/(N*m)"))
            .collect();
        let effects: Vec<&str> = effects.iter().map(String::as_str).collect();
        let ours = displacements(&robot, "B", ("P2", Direction::Y), &effects);
        let joints = robot.joints.iter().enumerate();
        let springs = joints.filter(|(_, joint)| names.contains(&joint.name.as_str()));
        let springs = JointModel::Hinged(springs.map(|(joint, _)| (joint, 1.0 / c)).collect());
        let theory = Theory::EulerBernoulli;
        let mut predictor = Predictor::with(&robot, mechanism, &springs, theory, &factors).unwrap();
        predictor.place(robot.pose(&"P2".into()).unwrap()).unwrap();
        let expected = -70.0 * predictor.compliance().direct(1);
        let apart = (ours[6] / expected - 1.0).abs();
        assert!(apart < 1e-6, "c {c:e}: {} {expected}: {apart:e}", ours[6]);
    }
}
