//! Balancers stiffen joints: the compliance has the slope of their torque.

use stiffbench_beams::robot::{
    Balancer, BalancerForce, BodyPoint, FittingFactors, JointMotion, Keep, ModelParameter,
    MultiPosePredictor, Pose, PoseSweep, Predictor, Robot,
};
use stiffbench_numeric::vector::{cross, dot, subtract};

use crate::support::arms;

fn predictor<'a>(robot: &'a Robot, pose: &Pose) -> Predictor<'a> {
    let mechanism = robot.mechanism(None).unwrap();
    let mut predictor = Predictor::new(robot, mechanism, &FittingFactors::UNIT).unwrap();
    predictor.place(pose).unwrap();
    predictor
}

/// Arms of turning joints with springs about their own axes alone and with a balancer, so that every spring is a variable of the pose;
/// with the bodies of its pivots.
fn arms_with_balancers() -> Vec<(Robot, Pose, [usize; 2])> {
    let mut all = Vec::new();
    for (mut robot, pose) in arms::all() {
        if robot.joints.iter().any(|j| j.motion == JointMotion::Slides) {
            continue;
        }
        for joint in &mut robot.joints {
            joint.springs.about = Default::default();
        }
        robot.base = Default::default();
        robot.tool.springs = Default::default();
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

/// Where each joint stands, and its axis.
fn hinges(predictor: &Predictor<'_>) -> Vec<([f64; 3], [f64; 3])> {
    let structure = predictor.model().structure();
    let members = &structure.rigid_members;
    let hinge = |hinge: usize| {
        let mut ends = members.iter().flat_map(|member| &member.ends);
        let at = ends.find(|at| at.hinges.contains(&hinge)).unwrap();
        (
            structure.nodes[at.node].position_m,
            structure.hinges[hinge].axis,
        )
    };
    (0..structure.hinges.len()).map(hinge).collect()
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
    hinges(&predictor).iter().enumerate().map(torque).collect()
}

#[test]
fn the_compliance_has_the_slope_of_the_torque_of_a_balancer() {
    let all = arms_with_balancers();
    assert!(all.len() > 30, "{} arms", all.len());
    let (mut largest, mut seen) = (0.0_f64, 0.0_f64);
    for (robot, pose, bodies) in &all {
        let count = robot.joints.len();
        let slope = |joint: usize, step: f64| -> Vec<f64> {
            let at = |step: f64| {
                let mut moved = pose.clone();
                moved.angles_deg[joint] += step.to_degrees();
                torques(robot, &moved, *bodies)
            };
            let (up, down) = (at(step), at(-step));
            up.iter()
                .zip(down)
                .map(|(u, d)| (u - d) / (2.0 * step))
                .collect()
        };
        // By differences with Richardson's extrapolation: -dτ_i/dq_j in column j.
        let columns: Vec<Vec<f64>> = (0..count)
            .map(|joint| {
                let (wide, fine) = (slope(joint, 2e-3), slope(joint, 1e-3));
                let pairs = fine.iter().zip(wide);
                pairs.map(|(f, w)| -(4.0 * f - w) / 3.0).collect()
            })
            .collect();
        let mut predictor = predictor(robot, pose);
        let structure = predictor.model().structure();
        let end_m = structure.nodes[structure.end.node].position_m;
        let compliances: Vec<f64> = structure
            .hinges
            .iter()
            .map(|hinge| 1.0 / hinge.stiffness_nm_per_rad)
            .collect();
        let motions: Vec<[f64; 6]> = hinges(&predictor)
            .into_iter()
            .map(|(at_m, axis)| {
                let [x, y, z] = cross(axis, subtract(end_m, at_m));
                [x, y, z, axis[0], axis[1], axis[2]]
            })
            .collect();
        // q = C (Jᵀ w - H q), by repetition: the balancers are far softer than the springs.
        let found = predictor.compliance();
        let free = {
            let mut without = robot.clone();
            without.balancers.clear();
            self::predictor(&without, pose).compliance()
        };
        for load in 0..6 {
            let mut turned = vec![0.0; count];
            for _ in 0..300 {
                turned = (0..count)
                    .map(|i| {
                        let held: f64 = (0..count).map(|j| columns[j][i] * turned[j]).sum();
                        compliances[i] * (motions[i][load] - held)
                    })
                    .collect();
            }
            for row in 0..6 {
                let expected: f64 = (0..count).map(|j| motions[j][row] * turned[j]).sum();
                let scale = (free.0[row][row] * free.0[load][load]).sqrt();
                if scale > 0.0 {
                    largest = largest.max((found.0[row][load] - expected).abs() / scale);
                }
            }
        }
        seen = seen.max(free.relative_difference(&found));
        // The other ways to the same number.
        let mechanism = robot.mechanism(None).unwrap();
        let sweep = PoseSweep::new(robot, mechanism, &FittingFactors::UNIT).unwrap();
        let swept = sweep.run(std::slice::from_ref(pose), Keep::Full);
        assert_eq!(swept.alone, 0, "in batches");
        assert!(swept.compliances[0].unwrap().relative_difference(&found) < 1e-12);
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
    let text = stiffbench_test_files::shipped_robot("serial-arm").unwrap();
    let mut robot = Robot::parse(&text).unwrap();
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
        let start = together.compliance(0).unwrap();
        for (place, spring) in springs.iter().enumerate() {
            let value = values.get(spring);
            let mut at = |factor: f64| {
                let mut moved = values.clone();
                moved.set(spring, value * factor);
                together.solve(&moved, false).unwrap();
                together.compliance(0).unwrap()
            };
            let (up, down) = (at(1.001), at(0.999));
            for i in 0..6 {
                for j in 0..6 {
                    let slope = (up.0[i][j] - down.0[i][j]) / 2e-3;
                    let scale = (start.0[i][i] * start.0[j][j]).sqrt();
                    let error = (whole[place].0[i][j] * value - slope).abs();
                    assert!(error <= 1e-7 * scale, "{spring} {i} {j}: {error:e}");
                }
            }
        }
    }
}
