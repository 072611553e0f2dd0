//! Balancers stiffen joints: the compliance has the slope of their torque.

use stiffbench_beams::robot::{
    Balancer, BalancerForce, BodyPoint, FittingFactors, JointMotion, Keep, ModelParameter,
    MultiPosePredictor, Pose, PoseSweep, Predictor, Robot,
};
use stiffbench_numeric::vector::{cross, dot, subtract};

use crate::support::arms;
use crate::support::robots::{self, assert_differences, predictor, shipped, swept};

/// Arms of turning joints with springs about their own axes alone and with a balancer, so that every spring is a variable of the pose;
/// with the bodies of its pivots.
fn arms_with_balancers() -> Vec<(Robot, Pose, [usize; 2])> {
    let mut all = Vec::new();
    for (mut robot, pose) in arms::of_own_springs() {
        if robot.joints.iter().any(|j| j.motion == JointMotion::Slides) {
            continue;
        }
        robot.masses.clear();
        robot.tool.payload = None;
        let count = robot.joints.len();
        // On the ground and the second body; over one joint; over several.
        let bodies = [[0, 2], [1, 2], [1, count]][all.len() % 3];
        let force = if all.len() % 2 == 0 {
            BalancerForce::Spring {
                stiffness_n_per_m: 3e4,
                preload_n: 4000.0,
                length_m: 0.5,
            }
        } else {
            BalancerForce::Gas {
                preload_n: -6000.0,
                length_m: 0.8,
                gas_column_m: 5.0,
                exponent: 1.2,
            }
        };
        let point = |body: usize, at_m: [f64; 3]| BodyPoint { body, at_m };
        robot.balancers.push(Balancer {
            name: "balancer".to_owned(),
            pivots: [
                point(bodies[0], [0.21, -0.13, 0.17]),
                point(bodies[1], [-0.12, 0.26, 0.31]),
            ],
            force,
        });
        all.push((robot, pose, bodies));
    }
    all
}

/// Torques of the balancer about the joints, from the forces on its pivots.
fn torques(robot: &Robot, pose: &Pose, bodies: [usize; 2]) -> Vec<f64> {
    let predictor = predictor(robot, pose);
    let loads = predictor.model().weight();
    assert_eq!(loads.len(), 2, "nothing but the balancer");
    let structure = predictor.model().structure();
    let torque = |(joint, (at_m, axis)): (usize, &([f64; 3], [f64; 3]))| {
        let behind = loads.iter().zip(&bodies).filter(|(_, body)| **body > joint);
        let of_load = |((at, [fx, fy, fz, mx, my, mz]), _): (
            &(stiffbench_beams::structure::Attachment, [f64; 6]),
            &usize,
        )| {
            let arm = subtract(structure.nodes[at.node].position_m, *at_m);
            dot(*axis, cross(arm, [*fx, *fy, *fz])) + dot(*axis, [*mx, *my, *mz])
        };
        behind.map(of_load).sum()
    };
    arms::hinges(&predictor)
        .iter()
        .enumerate()
        .map(torque)
        .collect()
}

#[test]
fn the_compliance_has_the_slope_of_the_torque_of_a_balancer() {
    let all = arms_with_balancers();
    assert!(all.len() > 30, "{} arms", all.len());
    let (mut largest, mut seen) = (0.0_f64, 0.0_f64);
    for (robot, pose, bodies) in &all {
        let slopes = arms::slopes(robot, pose, |pose| torques(robot, pose, *bodies));
        let mut predictor = predictor(robot, pose);
        // The balancers are far softer than the springs.
        let expected = arms::by_repetition(&predictor, &slopes);
        let found = predictor.compliance();
        let free = {
            let mut without = robot.clone();
            without.balancers.clear();
            robots::predictor(&without, pose).compliance()
        };
        largest = largest.max(arms::largest_difference(&found, &expected, &free));
        seen = seen.max(free.relative_difference(&found));
        // The other ways to the same number.
        assert!(swept(robot, pose).relative_difference(&found) < 1e-12);
        let structure = predictor.model().structure();
        let unloaded = structure.compliance_under_load([0.0; 6]).unwrap().unwrap();
        assert!(unloaded.relative_difference(&found) < 1e-9);
    }
    assert!(seen > 1e-3, "a balancer is seen: {seen:e}");
    assert!(largest < 1e-9, "{largest:e}");
}

#[test]
fn poses_beside_a_balancer_are_solved_in_batches_as_one_by_one() {
    for (robot, pose, _) in &arms_with_balancers() {
        let moved = |step: u32| -> Pose {
            let angles = pose.angles_deg.iter().enumerate();
            let moved = angles.map(|(joint, a)| a + 0.7 * f64::from(step) * (1.0 + joint as f64));
            Pose {
                angles_deg: moved.collect(),
            }
        };
        // More than a register holds; the first again with the last joint turned alone.
        let mut poses: Vec<Pose> = (0..11).map(moved).collect();
        poses.extend((0..16).map(|step| {
            let mut turned = pose.clone();
            *turned.angles_deg.last_mut().unwrap() += 5.0 * f64::from(step);
            turned
        }));
        let mechanism = robot.mechanism(None).unwrap();
        let sweep = PoseSweep::new(robot, mechanism, &FittingFactors::UNIT).unwrap();
        let swept = sweep.run(&poses, Keep::Full);
        assert_eq!(swept.alone, 0);
        for (pose, found) in poses.iter().zip(&swept.compliances) {
            let expected = predictor(robot, pose).compliance();
            let difference = found.unwrap().relative_difference(&expected);
            assert!(difference < 1e-12, "{difference:e}");
        }
    }
}

#[test]
fn a_balancer_that_pushes_a_joint_over_is_named_pose_by_pose() {
    let (mut robot, pose, _) = arms_with_balancers().swap_remove(1);
    // Straight from the axis outward: it holds the joint nowhere.
    robot.balancers[0].force = BalancerForce::Spring {
        stiffness_n_per_m: 0.0,
        preload_n: -1e12,
        length_m: 0.5,
    };
    let mechanism = robot.mechanism(None).unwrap();
    let sweep = PoseSweep::new(&robot, mechanism, &FittingFactors::UNIT).unwrap();
    assert!(!sweep.methods().is_empty());
    let mut single = Predictor::new(&robot, mechanism, &FittingFactors::UNIT).unwrap();
    let poses: Vec<Pose> = (0..24)
        .map(|step| {
            let mut turned = pose.clone();
            for angle in &mut turned.angles_deg {
                *angle += 15.0 * f64::from(step);
            }
            turned
        })
        .collect();
    let swept = sweep.run(&poses, Keep::Full);
    assert_eq!(swept.alone, swept.failed.len());
    assert!((1..24).contains(&swept.alone), "{}", swept.alone);
    for (index, error) in &swept.failed {
        let expected = single.place(&poses[*index]).unwrap_err();
        assert_eq!(error.to_string(), expected.to_string());
    }
}

#[test]
fn a_balancer_over_beams_is_left_to_the_solver_that_takes_one_pose_at_a_time() {
    let mut robot = shipped("serial-arm");
    let last = robot.bodies.len() - 1;
    let point = |body: usize, at_m: [f64; 3]| BodyPoint { body, at_m };
    robot.balancers.push(Balancer {
        name: "balancer".to_owned(),
        pivots: [point(0, [0.5, 0.0, 0.0]), point(last, [0.1, 0.2, 0.0])],
        force: BalancerForce::Spring {
            stiffness_n_per_m: 3e4,
            preload_n: 1000.0,
            length_m: 0.5,
        },
    });
    let mechanism = robot.mechanism(None).unwrap();
    let sweep = PoseSweep::new(&robot, mechanism, &FittingFactors::UNIT).unwrap();
    assert!(sweep.methods().is_empty());
    let pose = robot.nominal_pose();
    let swept = sweep.run(std::slice::from_ref(&pose), Keep::Full);
    assert_eq!(swept.alone, 1);
    let expected = predictor(&robot, &pose).compliance();
    assert_eq!(swept.compliances[0].unwrap(), expected);
}

#[test]
fn derivatives_beside_a_balancer_are_differences() {
    for (robot, pose, _) in arms_with_balancers().iter().take(6) {
        let mechanism = robot.mechanism(None).unwrap();
        let springs: Vec<ModelParameter> = robot.own_springs().map(|(spring, _)| spring).collect();
        let values = robot.with_own_springs(&FittingFactors::UNIT);
        let mut together = MultiPosePredictor::new(robot, mechanism, &springs, 1).unwrap();
        let whole = arms::derivatives(&mut together, robot, pose, &values, &springs);
        assert_differences(&mut together, &values, &springs, &whole, 1e-7);
    }
}
