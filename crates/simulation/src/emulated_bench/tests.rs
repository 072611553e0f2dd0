//! The emulated bench against the beam model, its plan, its seed, and whoever reads it.

use super::*;
use stiffbench_beams::robot::Predictor;
use stiffbench_test_files::shipped_procedure;
use stiffbench_test_files::shipped_robot;

fn robot() -> Robot {
    Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap()
}

fn procedure(name: &str) -> Procedure {
    let procedure = Procedure::parse(&shipped_procedure(name).unwrap())
        .unwrap()
        .0;
    Procedure {
        poses: Some(vec!["P1".into(), "P3".into()]),
        ..procedure
    }
}

fn bench(procedure: &Procedure, setup: EmulatedSetup, effects: &[&str]) -> EmulatedBench {
    let robot = robot();
    let mechanism = robot.mechanism(None).unwrap();
    let factors = robot.factor_set("m_fsd").unwrap();
    let effects = effects.iter().map(|text| text.parse().unwrap()).collect();
    let physics = ActingPhysics::new(&robot, mechanism, effects).unwrap();
    // A second of session time in a microsecond.
    let clock = Clock::starting_at(0.0, 1e6);
    EmulatedBench::new(&robot, &physics, &factors, procedure, setup, clock).unwrap()
}

fn quiet() -> EmulatedSetup {
    EmulatedSetup {
        noise: NoiseModel::NONE,
        ..EmulatedSetup::default()
    }
}

fn rest(bench: &EmulatedBench) -> (f64, f64) {
    while !bench.is_at_rest() {}
    (bench.force_n(), bench.displacement_m())
}

/// Force and displacement from the zero, set under no load.
fn readings(bench: &EmulatedBench, procedure: &Procedure, cell: u32) -> Vec<(f64, f64)> {
    let mut zero_m = 0.0;
    let planned = procedure.steps(cell);
    planned
        .iter()
        .filter(|planned| planned.extra_hold_s.is_none())
        .map(|planned| {
            if planned.zero_before {
                bench.begin_run(planned.repeat);
                zero_m = rest(bench).1;
            }
            bench.apply(planned.target_n, planned.step, planned.repeat);
            let (force_n, displacement_m) = rest(bench);
            (force_n, displacement_m - zero_m)
        })
        .collect()
}

#[test]
fn without_noise_it_is_the_compliance_of_the_robot() {
    let robot = robot();
    let mechanism = robot.mechanism(None).unwrap();
    let factors = robot.factor_set("m_fsd").unwrap();
    let mut predictor = Predictor::new(&robot, mechanism, &factors).unwrap();
    let procedure = procedure("sweeps");
    let bench = bench(&procedure, quiet(), &[]);
    for (pose, name) in ["P1", "P3"].into_iter().enumerate() {
        predictor.place(robot.pose(&name.into()).unwrap()).unwrap();
        let compliance = predictor.translation_compliance();
        for direction in Direction::ALL {
            bench.set_pose(&name.into()).unwrap();
            bench.set_direction(&direction.into()).unwrap();
            let i = direction.index();
            let cell = (3 * pose + i) as u32;
            let planned = procedure.steps(cell);
            for ((force_n, displacement_m), planned) in
                readings(&bench, &procedure, cell).into_iter().zip(planned)
            {
                let expected_m = compliance[i][i] * force_n;
                // The tip stands at a millimetre, of which the sixteenth digit is left.
                assert!((displacement_m - expected_m).abs() < 1e-17 + 1e-9 * expected_m.abs());
                assert!((force_n - planned.target_n).abs() <= 0.4);
            }
        }
    }
}

#[test]
fn readings_depend_on_the_seed_and_not_on_the_order_of_reading() {
    let procedure = procedure("paper");
    let setup = EmulatedSetup {
        seed: 3,
        ..EmulatedSetup::default()
    };
    let [first, again] = [(); 2].map(|()| bench(&procedure, setup, &[]));
    let whole = readings(&first, &procedure, 0);
    // Read all the time, in another order, with loads between that nobody planned, and begun in the middle.
    let planned = procedure.steps(0);
    again.begin_run(1);
    let zero_m = rest(&again).1;
    for (planned, expected) in planned.iter().zip(&whole).rev() {
        again.apply(-33.0, 99, 1);
        again.preload();
        for _ in 0..100 {
            assert!(again.force_n().is_finite() && again.displacement_m().is_finite());
        }
        again.apply(planned.target_n, planned.step, planned.repeat);
        let (force_n, displacement_m) = rest(&again);
        assert_eq!((force_n, displacement_m - zero_m), *expected);
    }
    let other = bench(&procedure, EmulatedSetup { seed: 4, ..setup }, &[]);
    assert_ne!(readings(&other, &procedure, 0), whole);
}

#[test]
fn zeros_belong_to_their_cell_or_to_their_run() {
    for (name, same) in [("paper", true), ("sweeps", false)] {
        let procedure = procedure(name);
        let bench = bench(&procedure, EmulatedSetup::default(), &[]);
        let zeros: Vec<f64> = (1..=3)
            .map(|repeat| {
                bench.begin_run(repeat);
                rest(&bench).1
            })
            .collect();
        assert_eq!(zeros.iter().all(|zero| *zero == zeros[0]), same, "{name}");
        bench.set_direction(&Direction::Z.into()).unwrap();
        assert_ne!(rest(&bench).1, zeros[0]);
    }
}

/// Loads of -10 N, then back to the zero: what the gauge shows there is what the drift added to the load.
#[test]
fn a_gauge_that_drifts_does_not_come_back_to_its_zero() {
    for (name, since_run) in [("paper", false), ("sweeps", true)] {
        let procedure = procedure(name);
        let effect = "thermal-drift@clock:rate=3600um/h";
        let [still, drifts] = [&[][..], &[effect]].map(|of| bench(&procedure, quiet(), of));
        let shown = [&still, &drifts].map(|bench| {
            bench.begin_run(1);
            let zero_m = rest(bench).1;
            bench.apply(-10.0, 1, 1);
            let loaded_m = rest(bench).1 - zero_m;
            bench.release();
            let again_m = rest(bench).1 - zero_m;
            bench.begin_run(2);
            (loaded_m, again_m, rest(bench).1 - zero_m)
        });
        let drift_m = shown[1].0 - shown[0].0;
        assert!(drift_m > 1e-6, "{name}: {drift_m}");
        assert!((shown[1].1 - drift_m).abs() < 1e-12 && shown[0].1 == 0.0);
        let next_m = if since_run { 0.0 } else { drift_m };
        assert!((shown[1].2 - next_m).abs() < 1e-12, "{name}");
    }
}

#[test]
fn the_spread_of_readings_is_that_of_the_noise() {
    let procedure = Procedure {
        repeats: 400,
        loads_n: vec![0.0, -10.0],
        ..procedure("paper")
    };
    let noise = NoiseModel {
        run_slope_sd: 0.0,
        ..NoiseModel::default()
    };
    let bench = bench(
        &procedure,
        EmulatedSetup {
            noise,
            ..EmulatedSetup::default()
        },
        &[],
    );
    let unloaded: Vec<f64> = readings(&bench, &procedure, 0)
        .into_iter()
        .filter(|(force_n, _)| *force_n == 0.0)
        .map(|(_, displacement_m)| displacement_m)
        .collect();
    let n = unloaded.len() as f64;
    let mean = unloaded.iter().sum::<f64>() / n;
    let variance = unloaded.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
    // The standard deviation of 400 is known to 3.5 %.
    assert!(
        (variance.sqrt() / noise.reading_sd_m - 1.0).abs() < 0.12,
        "{variance}"
    );
}

#[test]
fn a_joint_with_play_and_creep_under_a_hold_are_seen() {
    let procedure = procedure("load-hold-unload");
    let straight = bench(&procedure, quiet(), &[]);
    let effects = [
        "joint-backlash@A3:play=0.1mrad,seat_moment=0.1N*m",
        "creep@structure:k=1%/decade,t0=1s",
    ];
    let bent = bench(&procedure, quiet(), &effects);
    let planned = procedure.steps(1);
    let held = planned
        .iter()
        .find(|planned| planned.extra_hold_s.is_some());
    let held = held.unwrap();
    let stages = [&straight, &bent].map(|bench| {
        bench.set_direction(&Direction::Y.into()).unwrap();
        let mut inner = bench.lock();
        inner.cell().stages(held.target_n, held.step, held.repeat)
    });
    let [without, with] = stages.map(|stages| {
        let began: Vec<f64> = stages.iter().map(|stage| stage.0).collect();
        assert!(
            began.len() > 1 && began.is_sorted_by(|a, b| a < b),
            "{began:?}"
        );
        assert_eq!(began[0], 0.0);
        assert!(began[1] < held.extra_hold_s.unwrap());
        stages
            .iter()
            .map(|stage| stage.1.along_m[1])
            .collect::<Vec<_>>()
    });
    assert!(without.iter().all(|d| *d == without[0]), "{without:?}");
    assert!(
        with.is_sorted_by(|earlier, later| later < earlier),
        "{with:?}"
    );
    // Play of 0.1 mrad at half a metre from the end and more.
    assert!(with[0] < without[0] - 10e-6);
}

#[test]
fn a_hand_pushes_until_it_lets_go_and_gauges_may_be_turned_round() {
    let procedure = procedure("paper");
    let bench = bench(
        &procedure,
        EmulatedSetup {
            displacement_turned: true,
            ..quiet()
        },
        &[],
    );
    let (_, before_m) = rest(&bench);
    // The end gives way as under a load of that size.
    let moved = |force_n: f64| {
        bench.push_by_hand(force_n);
        (bench.force_n(), bench.displacement_m() - before_m)
    };
    let (firm_n, firm_m) = moved(-40.0);
    assert_eq!(firm_n, -FIRMLY * 40.0);
    let (light_n, light_m) = moved(-0.1);
    assert!((light_m - HAND_M).abs() < 1e-12, "{light_m}");
    assert!((light_m / light_n - firm_m / firm_n).abs() < 1e-12);
    bench.let_go();
    assert_eq!((bench.force_n(), bench.displacement_m()), (0.0, before_m));
}

#[test]
fn what_is_not_planned_is_refused_or_a_first_load() {
    let procedure = procedure("paper");
    let bench = bench(&procedure, quiet(), &[]);
    let refused = bench.set_pose(&"P2".into()).unwrap_err();
    assert_eq!(refused.to_string(), "the procedure has no pose P2");
    bench.apply(-33.0, 99, 1);
    let (force_n, _) = rest(&bench);
    assert!((force_n + 33.0).abs() <= 0.4);
}

/// Displacements along the base axes under loads that grow, each against the zero of its gauge.
fn along_axes(bench: &EmulatedBench, procedure: &Procedure, cell: u32) -> Vec<[f64; 3]> {
    let along = || {
        while !bench.is_at_rest() {}
        Direction::ALL.map(|axis| bench.displacement_along_m(axis))
    };
    let mut zeros_m = [0.0; 3];
    let planned = procedure.steps(cell);
    let planned = planned.iter().filter(|of| of.extra_hold_s.is_none());
    planned
        .map(|planned| {
            if planned.zero_before {
                bench.begin_run(planned.repeat);
                zeros_m = along();
            }
            bench.apply(planned.target_n, planned.step, planned.repeat);
            let along_m = along();
            [0, 1, 2].map(|axis| along_m[axis] - zeros_m[axis])
        })
        .collect()
}

#[test]
fn several_gauges_show_the_compliance_matrix_and_obey_effects_of_gauges_and_of_time() {
    let procedure = Procedure {
        directions: vec![LoadDirection::from_vector([0.0, 0.6, 0.8]).unwrap()],
        displacement_axes: Direction::ALL.to_vec(),
        loads_n: vec![0.0, 20.0, 40.0, 60.0],
        unloading: true,
        repeats: 2,
        ..procedure("sweeps")
    };
    let shown = |effects: &[&str]| along_axes(&bench(&procedure, quiet(), effects), &procedure, 0);
    let clean = shown(&[]);
    let robot = robot();
    let mechanism = robot.mechanism(None).unwrap();
    let factors = robot.factor_set("m_fsd").unwrap();
    let mut predictor = Predictor::new(&robot, mechanism, &factors).unwrap();
    predictor.place(robot.pose(&"P1".into()).unwrap()).unwrap();
    let compliance = predictor.translation_compliance();
    let bench = bench(&procedure, quiet(), &[]);
    bench.begin_run(1);
    bench.apply(60.0, 3, 1);
    let force_n = -rest(&bench).0;
    for axis in 0..3 {
        let per_n = 0.6 * compliance[axis][1] + 0.8 * compliance[axis][2];
        let off_m = clean[3][axis] - per_n * force_n;
        // Nine digits of the largest displacement.
        assert!(off_m.abs() < 1e-12, "{axis}: {:?} {force_n}", clean[3]);
    }
    let z = |readings: &[[f64; 3]]| readings.iter().map(|of| of[2]).collect::<Vec<f64>>();
    for (effect, gauges) in [
        ("thermal-drift@clock:rate=3600um/h", [true; 3]),
        ("thermal-drift@clock.y:rate=3600um/h", [false, true, false]),
        ("creep:k=5%/decade,t0=1s", [false, true, true]),
        ("setting-in:k=5%,decay=1.5", [false, true, true]),
        ("gauge-scale@displacement.z:scale=2%", [false, false, true]),
        ("gauge-stand-compliance@x:c=1um/N", [false, false, false]),
        ("gauge-stand-compliance@z:c=1um/N", [false, false, true]),
        ("gauge-misalignment@y>z:angle=2deg", [false, true, false]),
        (
            "gauge-periodic@displacement.y:amplitude=5um,period=0.15mm,phase=1rad",
            [false, true, false],
        ),
        ("slip@P1.(0,0.6,0.8).1.1:jump=20um", [true; 3]),
        ("slip@P1.(0,0.6,0.8).1.1/z:jump=20um", [false, false, true]),
        (
            "joint-backlash@A3:play=0.1mrad,seat_moment=1N*m",
            [false, true, true],
        ),
    ] {
        let with = shown(&[effect]);
        let changed = [0, 1, 2].map(|axis| (with[3][axis] - clean[3][axis]).abs() > 1e-7);
        assert_eq!(changed, gauges, "{effect}: {:?} {:?}", with[3], clean[3]);
    }
    // A slider stays behind when the load goes back.
    let stuck = z(&shown(&[
        "joint-friction@A3:c=20urad/(N*m),friction_moment=2N*m",
    ]));
    assert!((stuck[5] - stuck[1]).abs() > 1e-6, "{stuck:?}");
    let straight = z(&clean);
    assert!(
        (straight[5] / straight[1] - 1.0).abs() < 0.1,
        "{straight:?}"
    );
}

#[test]
fn gauges_along_axes_have_zeros_of_their_own_and_drift_from_them() {
    let procedure = Procedure {
        displacement_axes: vec![Direction::X, Direction::Z],
        ..procedure("sweeps")
    };
    let bench = bench(
        &procedure,
        EmulatedSetup::default(),
        &["thermal-drift@clock.z:rate=3600um/h"],
    );
    let along = || {
        rest(&bench);
        [Direction::X, Direction::Z].map(|axis| bench.displacement_along_m(axis))
    };
    bench.begin_run(1);
    let first_m = along();
    assert_ne!(first_m[0], first_m[1]);
    bench.apply(-10.0, 1, 1);
    bench.release();
    let again_m = along();
    assert_eq!(again_m[0], first_m[0]);
    assert!(again_m[1] - first_m[1] > 1e-6, "{first_m:?} {again_m:?}");
    bench.begin_run(2);
    assert_ne!(along(), first_m);
}
