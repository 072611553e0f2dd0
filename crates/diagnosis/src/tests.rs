//! Robots and numbers that tests of several rooms share.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use stiffbench_beams::physics::Effect;
use stiffbench_beams::robot::{FittingFactors, Robot};
use stiffbench_test_files::shipped_robot;
use stiffbench_units_and_text::test_point::PoseId;

use crate::mismatch::{EstimatedValue, Finding, MisfitShares, RobotBaseline, VerdictGrade};
use crate::parameters::ParameterChoice;

pub(crate) fn robot(name: &str) -> Robot {
    Robot::parse(&shipped_robot(name).unwrap()).unwrap()
}

pub(crate) fn hp_robot() -> Robot {
    robot("hp-robot")
}

/// A mechanism of a robot in some of its poses, with the parameters that a fit has free by default.
pub(crate) fn baseline<'a>(
    robot: &'a Robot,
    mechanism: &str,
    factors: FittingFactors,
    poses: &[PoseId],
) -> RobotBaseline<'a> {
    let mechanism = robot.mechanism(Some(mechanism)).unwrap();
    let poses = poses.iter().map(|pose| robot.pose(pose).unwrap().clone());
    let choice = ParameterChoice::default();
    RobotBaseline::new(robot, mechanism, factors, poses.collect(), &choice, 0.0).unwrap()
}

/// Normal numbers with a standard deviation of one.
pub(crate) fn normal(count: usize, seed: u64) -> Vec<f64> {
    let rng = ChaCha8Rng::seed_from_u64(seed);
    StandardNormal.sample_iter(rng).take(count).collect()
}

/// An effect that was found, its values known to a tenth of them.
pub(crate) fn finding(effect: Effect, alternative_group: Option<u32>) -> Finding {
    let value =
        |&value: &f64| EstimatedValue::of_covariance(value, (Some(0.1 * value.abs()), 300.0));
    Finding {
        values: effect.values.iter().map(value).collect(),
        combination: None,
        effect,
        grade: VerdictGrade::Is,
        shares: MisfitShares::default(),
        at_bound: false,
        spans_range: false,
        alternative_group,
        end_effect_m: 1e-5,
        absorbed_share: 0.2,
        log_bayes: 30.0,
        standard_errors: 10.0,
        p_family: 1e-6,
        rivals: Vec::new(),
    }
}
