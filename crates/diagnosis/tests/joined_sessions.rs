//! Two sessions of one arm with one effect: together they determine its size better than either alone.

use stiffbench_beams::physics::{ActingPhysics, Effect};
use stiffbench_beams::robot::{Pose, Robot};
use stiffbench_diagnosis::mismatch::{
    Diagnosis, Observations, RobotBaseline, SearchOptions, Verdict, diagnose, noise_alone,
};
use stiffbench_diagnosis::parameters::ParameterChoice;
use stiffbench_measurement::procedure::Procedure;
use stiffbench_simulation::{Jack, NoiseModel, VirtualBench};
use stiffbench_test_files::{shipped_procedure, shipped_robot};

#[test]
fn together_two_sessions_determine_an_effect_better_than_each() {
    let robot = Robot::parse(&shipped_robot("serial-arm").unwrap()).unwrap();
    let mechanism = robot.mechanism(None).unwrap();
    let (_, factors) = robot.default_factors();
    let truth = 3e-6;
    let springy: Effect = format!("joint-compliance@S2:c={truth}rad/(N*m)")
        .parse()
        .unwrap();
    let physics = ActingPhysics::new(&robot, mechanism, vec![springy]).unwrap();
    let session = |place: usize, noise: NoiseModel| {
        let bench = VirtualBench::new(&robot, &physics, &factors, noise, Jack::default()).unwrap();
        let (procedure, _) = Procedure::parse(&shipped_procedure("sweeps").unwrap()).unwrap();
        let poses = &robot.poses[place..place + 3];
        let procedure = Procedure {
            poses: Some(poses.iter().map(|named| named.id.clone()).collect()),
            ..procedure
        };
        let table = bench.run(&procedure, "bench", 3 + place as u64).unwrap();
        let poses: Vec<Pose> = poses.iter().map(|named| named.pose.clone()).collect();
        (Observations::new(&table, None), poses)
    };
    let noisy = NoiseModel {
        reading_sd_m: 9e-6,
        ..NoiseModel::default()
    };
    let (first, second) = (session(0, NoiseModel::default()), session(1, noisy));
    let baseline = |poses: Vec<Pose>| {
        let choice = ParameterChoice::default();
        RobotBaseline::new(&robot, mechanism, factors.clone(), poses, &choice).unwrap()
    };
    let noise = |(observations, poses): &(Observations, Vec<Pose>)| {
        noise_alone(&baseline(poses.clone()), observations).unwrap()
    };
    let search = |observations: &Observations, poses: Vec<Pose>| -> Diagnosis {
        let options = SearchOptions::default();
        diagnose(&baseline(poses), observations, &options, None)
            .unwrap()
            .0
    };
    let joined = Observations::joined(&[
        ("first", &first.0, noise(&first)),
        ("second", &second.0, noise(&second)),
    ]);
    let both = search(&joined, [&first.1[..], &second.1[..]].concat());
    assert_eq!(both.verdict, Verdict::Explained);
    let size = |diagnosis: &Diagnosis| {
        let mut found = diagnosis.findings.iter();
        let own = found.find(|one| one.effect.to_string().contains("S2"));
        let value = &own.unwrap().values[0];
        (value.value, value.u.unwrap())
    };
    let (value, u) = size(&both);
    assert!((value - truth).abs() < 4.0 * u, "{value} ± {u}");
    let each =
        [&first, &second].map(|(observations, poses)| size(&search(observations, poses.clone())).1);
    assert!(each.iter().all(|alone| u < 0.98 * alone), "{u} {each:?}");
    let sd = |session| {
        joined
            .noise_of_session(session, &both.noise)
            .unwrap()
            .reading_sd_m
    };
    assert!((2.5e-6..3.8e-6).contains(&sd(0)), "{}", sd(0));
    assert!((8e-6..10.5e-6).contains(&sd(1)), "{}", sd(1));
}
