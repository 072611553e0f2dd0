//! Fits of joint springs, base and single sections: the list of model parameters beyond the paper's eight factors.

use rayon::prelude::*;

use stiffbench_beams::physics::{ActingPhysics, Effect};
use stiffbench_beams::robot::{FittingFactors, ModelParameter, Robot};
use stiffbench_diagnosis::fit::{
    FactorStatus, FitOptions, FitOutcome, FitProblem, FixedPhysics, MeasuredStiffness, fit_cells,
};
use stiffbench_diagnosis::parameters::{FitRole, ParameterChoice};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_measurement::stiffness::{GaugePair, Method, StiffnessOptions, stiffness_table};
use stiffbench_simulation::{Jack, NoiseModel, VirtualBench};
use stiffbench_test_files::shipped_robot;

/// Compliances of the joints of the arm, rad/(N·m), and of its base.
const JOINTS: [(&str, f64); 3] = [("S1", 3e-6), ("S2", 8e-6), ("S3", 2e-5)];
const BASE_X: f64 = 1e-6;

fn arm() -> Robot {
    Robot::parse(&shipped_robot("serial-arm").unwrap()).unwrap()
}

/// Stiffness of an arm that yields in joints and base, as effects of the laws: the fit finds them as parameters.
fn measured(robot: &Robot, noise: NoiseModel, seed: u64) -> MeasuredStiffness {
    let mechanism = robot.mechanism(None).unwrap();
    let joints = JOINTS.map(|(joint, c)| format!("joint-compliance@{joint}:c={c:e}rad/(N*m)"));
    let base = format!("base-compliance@x:c={BASE_X:e}rad/(N*m)");
    let effects: Vec<Effect> = joints
        .iter()
        .chain([&base])
        .map(|text| text.parse().unwrap())
        .collect();
    let physics = ActingPhysics::new(robot, mechanism, effects).unwrap();
    let (_, factors) = robot.default_factors();
    let bench = VirtualBench::new(robot, &physics, &factors, noise, Jack::default()).unwrap();
    let readings = bench.run(&Procedure::default(), "s", seed).unwrap();
    let options = StiffnessOptions::default();
    let table = stiffness_table(&readings.readings, &GaugePair::default(), options);
    MeasuredStiffness::from_table(&table, Method::Regression)
}

/// Springs free, the sections known.
fn springs(robot: &Robot) -> ParameterChoice {
    let mechanism = robot.mechanism(None).unwrap();
    let mut choice = ParameterChoice::default();
    for factor in ModelParameter::BEAMS {
        choice.set(&factor, FitRole::Fixed);
    }
    let joints = JOINTS.map(|(joint, _)| format!("joint.{joint}"));
    for name in joints.iter().map(String::as_str).chain(["base.rx"]) {
        let parameter = ModelParameter::find(robot, mechanism, name).unwrap();
        choice.set(&parameter, FitRole::Free);
    }
    choice
}

fn fit(
    robot: &Robot,
    measured: &MeasuredStiffness,
    choice: ParameterChoice,
    physics: Option<&FixedPhysics>,
) -> FitOutcome {
    let (_, start) = robot.default_factors();
    let problem = FitProblem {
        robot,
        mechanism: robot.mechanism(None).unwrap(),
        measured,
        start: &start,
        physics,
    };
    let options = FitOptions {
        choice,
        ..FitOptions::default()
    };
    fit_cells(&problem, &options).unwrap()
}

/// Names and true values of the springs.
fn truth() -> Vec<(String, f64)> {
    let joints = JOINTS.map(|(joint, c)| (format!("joint.{joint}"), c));
    joints
        .into_iter()
        .chain([("base.rx".to_owned(), BASE_X)])
        .collect()
}

#[test]
fn springs_of_an_arm_are_found_again() {
    let robot = arm();
    let measured = measured(&robot, NoiseModel::NONE, 1);
    let mechanism = robot.mechanism(None).unwrap();
    let nothing = ActingPhysics::new(&robot, mechanism, Vec::new()).unwrap();
    let nothing = FixedPhysics::new(nothing, Method::Regression);
    // By the beam solver, and by predicted readings.
    for physics in [None, Some(&nothing)] {
        let outcome = fit(&robot, &measured, springs(&robot), physics);
        for (name, value) in truth() {
            let estimate = outcome.estimate(&name).unwrap();
            assert!((estimate.value / value - 1.0).abs() < 1e-4, "{estimate:?}");
            assert_eq!(estimate.parameter.unit(), "rad/(N*m)");
        }
        assert_eq!(outcome.factors.springs.len(), 4);
    }
}

#[test]
fn intervals_of_springs_cover_the_truth() {
    let robot = arm();
    let hits: Vec<Option<bool>> = (0..60_u64)
        .into_par_iter()
        .flat_map_iter(|seed| {
            let measured = measured(&robot, NoiseModel::default(), seed);
            let outcome = fit(&robot, &measured, springs(&robot), None);
            let hit = move |(name, value): (String, f64)| {
                let interval = outcome.estimate(&name).unwrap().interval_95;
                interval.map(|[lower, upper]| (lower..=upper).contains(&value))
            };
            truth().into_iter().map(hit).collect::<Vec<_>>()
        })
        .collect();
    let stated: Vec<bool> = hits.iter().copied().flatten().collect();
    let covered = stated.iter().filter(|hit| **hit).count();
    println!(
        "{covered} of {} intervals, {} springs",
        stated.len(),
        hits.len()
    );
    // 240 springs: 95 % with a standard deviation of 1.4 %, of three quarters at least.
    assert!(stated.len() > 180);
    let share = covered as f64 / stated.len() as f64;
    assert!((0.90..=1.0).contains(&share), "{share}");
}

#[test]
fn a_spring_that_is_not_there_is_near_zero() {
    let robot = arm();
    let mut choice = springs(&robot);
    let mechanism = robot.mechanism(None).unwrap();
    let idle = ModelParameter::find(&robot, mechanism, "joint.S4").unwrap();
    choice.set(&idle, FitRole::Free);
    let outcome = fit(&robot, &measured(&robot, NoiseModel::NONE, 1), choice, None);
    let estimate = outcome.estimate("joint.S4").unwrap();
    assert!(estimate.value < 1e-9, "{estimate:?}");
}

#[test]
fn tied_springs_keep_their_ratio_and_bounds_hold() {
    let robot = arm();
    let measured = measured(&robot, NoiseModel::NONE, 1);
    let mechanism = robot.mechanism(None).unwrap();
    let [s2, s3] =
        ["joint.S2", "joint.S3"].map(|name| ModelParameter::find(&robot, mechanism, name).unwrap());
    let mut choice = springs(&robot);
    choice.set(&s3, FitRole::TiedTo(s2.clone()));
    let outcome = fit(&robot, &measured, choice, None);
    let [one, other] = ["joint.S2", "joint.S3"].map(|name| outcome.estimate(name).unwrap().clone());
    assert!((one.value / other.value - 1.0).abs() < 1e-12);
    assert_eq!(
        other.status,
        FactorStatus::Tied {
            to: "joint.S2".to_owned()
        }
    );
    let mut choice = springs(&robot);
    choice.bound(&s2, [0.0, 1e-6]);
    let outcome = fit(&robot, &measured, choice, None);
    let estimate = outcome.estimate("joint.S2").unwrap();
    assert!(
        matches!(estimate.status, FactorStatus::AtBound { upper: true, .. }),
        "{estimate:?}"
    );
    assert_eq!(estimate.bounds, Some([0.0, 1e-6]));
    let mut choice = springs(&robot);
    choice.set(&s2, FitRole::TiedTo(ModelParameter::BEAMS[0].clone()));
    let (_, start) = robot.default_factors();
    let problem = FitProblem {
        robot: &robot,
        mechanism,
        measured: &measured,
        start: &start,
        physics: None,
    };
    let options = FitOptions {
        choice,
        ..FitOptions::default()
    };
    assert!(fit_cells(&problem, &options).is_err());
}

#[test]
fn a_single_section_is_found_again() {
    let robot = arm();
    let mechanism = robot.mechanism(None).unwrap();
    let (_, start) = robot.default_factors();
    let section = robot.sections.keys().next().unwrap();
    let parameter =
        ModelParameter::find(&robot, mechanism, &format!("section.{section}.Iy")).unwrap();
    let mut truth: FittingFactors = start.clone();
    truth.set(&parameter, 0.6);
    let physics = ActingPhysics::new(&robot, mechanism, Vec::new()).unwrap();
    let bench =
        VirtualBench::new(&robot, &physics, &truth, NoiseModel::NONE, Jack::default()).unwrap();
    let readings = bench.run(&Procedure::default(), "s", 1).unwrap();
    let table = stiffness_table(
        &readings.readings,
        &GaugePair::default(),
        StiffnessOptions::default(),
    );
    let measured = MeasuredStiffness::from_table(&table, Method::Regression);
    let mut choice = ParameterChoice::default();
    for factor in ModelParameter::BEAMS {
        choice.set(&factor, FitRole::Fixed);
    }
    choice.set(&parameter, FitRole::Free);
    let outcome = fit(&robot, &measured, choice, None);
    let estimate = outcome.estimates.last().unwrap();
    assert_eq!(estimate.parameter, parameter);
    assert!((estimate.value - 0.6).abs() < 1e-5, "{estimate:?}");
}
