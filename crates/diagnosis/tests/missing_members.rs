//! How far a missing member is from another effect, in standard errors: what the score of concealed benches counts as alike.

use crate::support::{acting, hp_robot};
use stiffbench_beams::physics::Effect;
use stiffbench_beams::robot::{FittingFactors, Pose};
use stiffbench_diagnosis::mismatch::{
    Baseline, Observations, ReadingNoise, RobotBaseline, TrialNoise, Truth, scale_to,
    standard_errors, standard_errors_between,
};
use stiffbench_diagnosis::parameters::ParameterChoice;
use stiffbench_measurement::procedure::Procedure;
use stiffbench_simulation::{Jack, NoiseModel, VirtualBench};
use stiffbench_test_files::shipped_procedure;

fn truth(effects: Vec<Effect>) -> Truth {
    Truth {
        // Factors between 0.6 and 1.6.
        parameters: vec![0.2, -0.3, 0.45, -0.4],
        effects,
        noise: TrialNoise {
            noise: ReadingNoise {
                reading_sd_m: 1.2e-6,
                zero_sd_m: 2e-6,
                run_slope_sd: 0.002,
                ..ReadingNoise::default()
            },
            displacement_step_m: 1e-6,
            force_step_n: 0.1,
            skewed: false,
        },
    }
}

/// A member is loose or it is not: what it leaves of another effect is what they differ by, not what its best multiple would leave.
#[test]
fn a_missing_member_is_compared_with_an_effect_of_its_size() {
    let robot = hp_robot();
    let mechanism = robot.mechanism(None).unwrap();
    let (procedure, _) = Procedure::parse(&shipped_procedure("load-unload").unwrap()).unwrap();
    let poses = &robot.poses[..4];
    let procedure = Procedure {
        poses: Some(poses.iter().map(|named| named.id.clone()).collect()),
        ..procedure
    };
    let physics = acting(&robot, None, &[]);
    let factors = FittingFactors::UNIT;
    let (noise, jack) = (NoiseModel::default(), Jack::default());
    let bench = VirtualBench::new(&robot, &physics, &factors, noise, jack).unwrap();
    let plan = &Observations::new(&bench.run(&procedure, "plan", 1).unwrap(), None);
    let poses: Vec<Pose> = poses.iter().map(|named| named.pose.clone()).collect();
    let choice = ParameterChoice::default();
    let baseline = &RobotBaseline::new(&robot, mechanism, factors, poses, &choice, 0.0).unwrap();
    let length = |truth: &Truth| standard_errors(baseline, plan, truth).unwrap();
    let between = |truth: &Truth, rival: &Effect| {
        standard_errors_between(baseline, plan, truth, rival).unwrap()
    };
    let loose = baseline.other_structures();
    assert!(!loose.is_empty());
    let curved = "force-gauge-nonlinearity:q=1e-10 1/N".parse().unwrap();
    let curved = truth(vec![curved]);
    let curved = scale_to(baseline, plan, &curved, 12.0).unwrap().unwrap();
    for member in &loose {
        let own = truth(vec![member.clone()]);
        let size = length(&own);
        assert!(between(&own, member) < 1e-6 * size.max(1.0));
        let apart = between(&curved, member);
        // Triangle inequality, both ways; both solve the same structure, so that rounding is all that separates them.
        assert!(
            ((12.0 - size).abs() - 1e-3..=12.0 + size + 1e-3).contains(&apart),
            "{}: {size} {apart}",
            member.title()
        );
    }
    assert!(
        loose
            .iter()
            .any(|member| length(&truth(vec![member.clone()])) > 30.0)
    );
}
