//! Many poses at once against one at a time, on the shipped robot: random poses, random factors, every mechanism.

use proptest::prelude::*;

use crate::support::robots::{factors_of_powers, lattice, pose_at, shipped};
use stiffbench_beams::robot::{
    ElementClass, FittingFactors, JointModel, ModelParameter, MultiPosePredictor, Pose, Predictor,
    Robot, RobotError, Theory,
};

/// Largest difference allowed with random factors, relative to the diagonal of the compliance: both solvers are exact but for rounding,
/// and the condition of structures whose constants differ by up to a hundredfold more than nominal leaves this much of it.
const RANDOM_FACTORS: f64 = 2e-8;

/// The same with the paper's factors.
const PAPER_FACTORS: f64 = 5e-9;

/// Compares all poses that the mechanism reaches; returns how many, and the largest relative difference.
fn compare(
    robot: &Robot,
    mechanism: &str,
    theory: Theory,
    poses: &[Pose],
    factors: &FittingFactors,
) -> (usize, f64) {
    let mechanism = robot.mechanism(Some(mechanism)).unwrap();
    let rigid = JointModel::Rigid;
    let mut single = Predictor::with(robot, mechanism, &rigid, theory, factors).unwrap();
    let mut together = MultiPosePredictor::with(
        robot,
        mechanism,
        &rigid,
        theory,
        &ModelParameter::CLASSES,
        poses.len(),
    )
    .unwrap();
    let mut reached = Vec::new();
    for (index, pose) in poses.iter().enumerate() {
        match together.place(index, pose) {
            Ok(()) => reached.push((index, pose)),
            Err(RobotError::Unreachable { .. }) => {}
            Err(error) => panic!("{error}"),
        }
    }
    together.solve(factors, true).unwrap();
    let classes: Vec<usize> = single
        .model()
        .members()
        .map(|member| usize::from(member.class == ElementClass::Link))
        .collect();
    let mut gradient = vec![[0.0; 4]; classes.len()];
    let mut largest = 0.0_f64;
    for (index, pose) in &reached {
        single.place(pose).unwrap();
        let expected = single.compliance();
        let found = together.compliance(*index).unwrap();
        let difference = found.relative_difference(&expected);
        assert!(!difference.is_nan());
        largest = largest.max(difference);
        for axis in 0..3 {
            single.compliance_gradient(axis, &mut gradient);
            let found = together.gradient(*index, axis).unwrap();
            for class in 0..2 {
                for property in 0..4 {
                    let of_class = gradient.iter().zip(&classes).filter(|(_, c)| **c == class);
                    let expected: f64 = of_class.map(|(g, _)| g[property]).sum();
                    let scale = together.direct_compliance(*index, axis).unwrap();
                    let difference = (found[4 * class + property] - expected).abs() / scale;
                    assert!(!difference.is_nan());
                    largest = largest.max(difference);
                }
            }
        }
    }
    (reached.len(), largest)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn every_mechanism_in_random_poses_with_random_factors(
        shares in prop::collection::vec(prop::collection::vec(0.0..1.0, 6), 1..12),
        exponents in prop::collection::vec(-1.0..1.0, 8),
        timoshenko in any::<bool>(),
    ) {
        let robot = shipped("hp-robot");
        let theory = if timoshenko { Theory::Timoshenko } else { Theory::EulerBernoulli };
        let poses: Vec<Pose> = shares.iter().map(|shares| pose_at(&robot, shares)).collect();
        let factors = factors_of_powers(&exponents);
        for mechanism in robot.mechanisms.keys() {
            let (_, largest) = compare(&robot, mechanism, theory, &poses, &factors);
            prop_assert!(largest < RANDOM_FACTORS, "mechanism {}: {:e}", mechanism, largest);
        }
    }
}

#[test]
fn the_paper_factors_in_many_poses() {
    let robot = shipped("hp-robot");
    let factors = robot.factor_set("m_fsd").unwrap();
    let poses = lattice(&robot, 200);
    for mechanism in robot.mechanisms.keys() {
        let (reached, largest) =
            compare(&robot, mechanism, Theory::EulerBernoulli, &poses, &factors);
        println!("mechanism {mechanism}: {reached} poses, largest difference {largest:e}");
        assert!(reached > 40, "mechanism {mechanism}: {reached} poses");
        assert!(
            largest < PAPER_FACTORS,
            "mechanism {mechanism}: {largest:e}"
        );
    }
}

#[test]
fn a_pose_has_the_same_result_alone_and_among_others() {
    let robot = shipped("hp-robot");
    let mechanism = robot.mechanism(None).unwrap();
    let factors = robot.factor_set("m_fsd").unwrap();
    let compliance = |count: usize, at: usize| {
        let mut together =
            MultiPosePredictor::new(&robot, mechanism, &ModelParameter::CLASSES, count).unwrap();
        for index in 0..count {
            let named = &robot.poses
                [(index + robot.poses.len() - at % robot.poses.len()) % robot.poses.len()];
            together.place(index, &named.pose).unwrap();
        }
        together.solve(&factors, false).unwrap();
        together.compliance(at).unwrap()
    };
    let alone = compliance(1, 0);
    for (count, at) in [(2, 1), (4, 3), (5, 4), (8, 7), (19, 16)] {
        assert_eq!(compliance(count, at), alone, "{count} poses, number {at}");
    }
}
