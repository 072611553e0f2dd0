//! Springs of the structure as effects: the same compliances as from the parameters of those names, also under laws of joints.

use stiffbench_beams::physics::{ActingPhysics, Effect, FileSuspects, Mechanics, StructureEdit};
use stiffbench_beams::robot::{FittingFactors, ModelParameter, Pose, Robot};

use crate::support::robots::{named_poses, shipped};

/// A robot with its mechanism, its poses and its factors.
fn with_robot(
    name: &str,
    check: impl Fn(&Robot, &stiffbench_beams::robot::Mechanism, &[Pose], &FittingFactors),
) {
    let robot = shipped(name);
    let mechanism = robot.mechanism(None).unwrap();
    let poses = named_poses(&robot);
    let (_, factors) = robot.default_factors();
    check(&robot, mechanism, &poses, &factors);
}

#[test]
fn a_spring_of_the_structure_is_the_parameter_of_its_name() {
    for name in ["hp-robot", "fanuc-r2000ic"] {
        with_robot(name, |robot, mechanism, _, factors| {
            let suspects = FileSuspects::new(robot, mechanism, &[], &[]);
            let springs: Vec<Effect> = suspects
                .places()
                .iter()
                .filter(|(_, place)| place.spring().is_some())
                .map(|(law, place)| Effect::new(*law, place.clone(), vec![3e-6]).unwrap())
                .collect();
            assert!(springs.len() > 6, "{name}");
            for effect in springs {
                let text = effect.compact();
                assert_eq!(text.parse::<Effect>().unwrap(), effect, "{text}");
                let (spring, compliance) = effect.spring_of_structure().unwrap();
                let mut expected = factors.clone();
                expected.set(&spring, factors.get(&spring) + compliance);
                let edit =
                    StructureEdit::new(robot, mechanism, &suspects, std::slice::from_ref(&effect));
                assert_eq!(edit.unwrap().factors(factors), expected, "{text}");
                let physics = ActingPhysics::new(robot, mechanism, vec![effect]).unwrap();
                assert_eq!(physics.with_springs(factors), expected, "{text}");
            }
            // What is not free is a place, what is free none.
            let free = [ModelParameter::Tool(stiffbench_beams::robot::SpringAxis::Z)];
            let rest = FileSuspects::new(robot, mechanism, &[], &free);
            assert_eq!(rest.places().len() + 1, suspects.places().len());
        });
    }
}

/// Beside a spring of the structure a joint turns as in the whole structure solved with both.
#[test]
fn joints_turn_beside_a_spring_of_the_structure() {
    with_robot("hp-robot", |robot, mechanism, poses, factors| {
        let joint = mechanism.joints(robot)[1];
        let joint = robot.joints[joint].name.as_str();
        let mut sprung = factors.clone();
        let tilt = format!("joint.{joint}.y");
        let tilt = ModelParameter::find(robot, mechanism, &tilt).unwrap();
        sprung.set(&tilt, 2e-6);
        let mechanics = Mechanics::new(robot, mechanism, &sprung, poses).unwrap();
        let mut both = sprung.clone();
        both.set(&ModelParameter::Joint(joint.into()), 5e-6);
        let whole = Mechanics::rigid(robot, mechanism, &both, poses).unwrap();
        let lever = mechanics
            .joints()
            .position(|place| place.joint() == Some(joint));
        for pose in 0..poses.len() {
            let influence = &mechanics.pose(pose).influence;
            let lever = lever.unwrap();
            let twist = 5e-6 / (1.0 + 5e-6 * influence.stiffness(lever, lever));
            let expected = &whole.pose(pose).influence.compliance;
            for (axis, row) in expected.iter().enumerate() {
                let own = influence.levers[lever][axis];
                let found = influence.compliance[axis][axis] + twist * own * own;
                assert!(
                    (found / row[axis] - 1.0).abs() < 1e-7,
                    "pose {pose}, axis {axis}: {found:e} {:e}",
                    row[axis]
                );
            }
        }
    });
}
