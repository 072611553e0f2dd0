//! The virtual bench against the beam model, its plan and its seed.

use super::*;
use crate::NoiseShape;
use stiffbench_beams::robot::Predictor;
use stiffbench_test_files::shipped_procedure;
use stiffbench_test_files::shipped_robot;
use stiffbench_units_and_text::test_point::Branch;

fn robot() -> Robot {
    Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap()
}

fn sweeps(poses: &[&str]) -> Procedure {
    Procedure {
        poses: Some(poses.iter().map(|&pose| pose.into()).collect()),
        ..Procedure::default()
    }
}

fn table(noise: NoiseModel, procedure: &Procedure, seed: u64) -> ReadingTable {
    let robot = robot();
    let mechanism = robot.mechanism(None).unwrap();
    let factors = robot.factor_set("m_fsd").unwrap();
    let physics = ActingPhysics::new(&robot, mechanism, Vec::new()).unwrap();
    VirtualBench::new(&robot, &physics, &factors, noise, Jack::default())
        .unwrap()
        .run(procedure, "s", seed)
        .unwrap()
}

#[test]
fn a_bench_without_noise_reads_the_beam_model() {
    let robot = robot();
    let procedure = Procedure {
        unloading: true,
        ..sweeps(&["P1"])
    };
    let table = table(NoiseModel::NONE, &procedure, 1);
    assert_eq!(table.readings.len(), 3 * 5 * 15);
    let mechanism = robot.mechanism(None).unwrap();
    let mut predictor =
        Predictor::new(&robot, mechanism, &robot.factor_set("m_fsd").unwrap()).unwrap();
    predictor.place(robot.pose(&"P1".into()).unwrap()).unwrap();
    let compliance = predictor.translation_compliance();
    for reading in &table.readings {
        let i = reading.direction.index();
        let expected = reading.force_n * compliance[i][i];
        // The text shows nine decimals of a micrometre.
        assert!((reading.displacement_m - expected).abs() < 1e-13 + 1e-9 * expected.abs());
        assert!((reading.force_n - reading.target_n).abs() <= 0.5);
    }
}

#[test]
fn the_same_seed_gives_the_same_readings_and_another_does_not() {
    let procedure = sweeps(&["P1", "P3"]);
    let [a, b, c] = [7, 7, 8].map(|seed| table(NoiseModel::default(), &procedure, seed).readings);
    assert_eq!(a, b);
    assert_ne!(a, c);
}

#[test]
fn the_papers_order_repeats_each_load_on_one_zero() {
    let paper = Procedure::parse(&shipped_procedure("paper").unwrap())
        .unwrap()
        .0;
    let paper = Procedure {
        poses: Some(vec!["P2".into()]),
        ..paper
    };
    let table = table(NoiseModel::default(), &paper, 0);
    let first: Vec<(u32, u32)> = table
        .readings
        .iter()
        .take(6)
        .map(|r| (r.step, r.repeat))
        .collect();
    assert_eq!(first, [(0, 1), (0, 2), (0, 3), (0, 4), (0, 5), (1, 1)]);
    assert_eq!((table.runs.len(), table.zeros.len()), (15, 3));
}

#[test]
fn a_plan_without_loads_or_a_noise_below_zero_is_refused() {
    let robot = robot();
    let mechanism = robot.mechanism(None).unwrap();
    let noise = NoiseModel {
        zero_sd_m: -1.0,
        ..NoiseModel::default()
    };
    let physics = ActingPhysics::new(&robot, mechanism, Vec::new()).unwrap();
    let bench = VirtualBench::new(
        &robot,
        &physics,
        &FittingFactors::UNIT,
        noise,
        Jack::default(),
    );
    assert!(matches!(
        bench,
        Err(BenchError::Noise {
            what: "the zero error",
            ..
        })
    ));
    let bench = VirtualBench::new(
        &robot,
        &physics,
        &FittingFactors::UNIT,
        NoiseModel::NONE,
        Jack::default(),
    )
    .unwrap();
    let procedure = Procedure {
        loads_n: Vec::new(),
        ..sweeps(&["P1"])
    };
    assert!(matches!(
        bench.run(&procedure, "s", 0),
        Err(BenchError::Procedure(ProcedureProblem::Empty {
            key: "loads"
        }))
    ));
    let error = bench.run(&sweeps(&["P9"]), "s", 0).unwrap_err();
    assert!(matches!(error, BenchError::Robot(_)), "{error}");
}

#[test]
fn extra_holds_keep_the_load_and_take_their_time() {
    let procedure = Procedure {
        holds_s: vec![60.0, 120.0],
        unloading: true,
        ..sweeps(&["P1"])
    };
    let table = table(NoiseModel::default(), &procedure, 4);
    assert_eq!(table.readings.len(), 3 * 5 * 17);
    for run in table.readings.chunks(17) {
        let held = &run[7..10];
        assert!(held.iter().all(|r| r.step == 7 && r.target_n == -70.0));
        assert!(held.iter().all(|r| r.force_n == held[0].force_n));
        for (reading, planned_s) in held[1..].iter().zip([60.0, 120.0]) {
            let hold_s = reading.hold_s.unwrap();
            assert!((hold_s - planned_s).abs() <= 2.1, "{hold_s}");
            let since_s = reading.time_s.unwrap() - held[0].time_s.unwrap();
            let held_s = hold_s - held[0].hold_s.unwrap();
            assert!((since_s - held_s).abs() < 0.12, "{since_s} {held_s}");
        }
        assert_eq!(run[10].step, 8);
    }
    let holds: Vec<f64> = table.readings.iter().filter_map(|r| r.hold_s).collect();
    assert!(
        holds.contains(&4.0) && holds.contains(&6.0),
        "an operator's holds vary"
    );
}

#[test]
fn the_clock_and_the_thermometer_go_on_through_the_session() {
    let table = table(NoiseModel::default(), &sweeps(&["P1", "P2"]), 6);
    let times: Vec<f64> = table.readings.iter().filter_map(|r| r.time_s).collect();
    assert_eq!(times.len(), 240);
    assert!(times.is_sorted_by(|a, b| a < b));
    // Between the poses half an hour, give or take a fifth, and the first zero.
    let between_s = times[120] - times[119];
    assert!((1440.0..2230.0).contains(&between_s), "{between_s}");
    let temperature: Vec<f64> = table
        .readings
        .iter()
        .filter_map(|r| r.temperature_deg_c)
        .collect();
    assert_eq!(temperature.len(), 240);
    for (pair, time) in temperature.windows(2).zip(times.windows(2)) {
        let most_k = 1.3 * (time[1] - time[0]) / 3600.0 + 0.011;
        assert!((pair[1] - pair[0]).abs() <= most_k, "{pair:?}");
    }
    assert_ne!(temperature[0], temperature[239]);
}

#[test]
fn a_shuffled_run_makes_each_reading_once_and_marks_smaller_loads() {
    let shuffled = Procedure::parse(&shipped_procedure("shuffled").unwrap())
        .unwrap()
        .0;
    let table = table(NoiseModel::NONE, &shuffled, 0);
    assert_eq!(table.readings.len(), 480);
    let mut orders = std::collections::BTreeSet::new();
    for run in table.readings.chunks(8) {
        let order: Vec<i32> = run.iter().map(|r| r.target_n as i32).collect();
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, [-70, -60, -50, -40, -30, -20, -10, 0]);
        for (before, now) in run.iter().zip(&run[1..]) {
            let grew = now.target_n.abs() > before.target_n.abs();
            assert_eq!(now.branch == Branch::Loading, grew);
        }
        orders.insert(order);
    }
    assert!(orders.len() > 55, "{} orders of 60 runs", orders.len());
}

#[test]
fn skewed_noise_makes_another_session() {
    let skewed = NoiseModel {
        shape: NoiseShape::Skewed,
        ..NoiseModel::default()
    };
    let procedure = sweeps(&["P1"]);
    let [normal, skewed] = [NoiseModel::default(), skewed].map(|noise| table(noise, &procedure, 2));
    assert_ne!(normal.readings, skewed.readings);
    assert_eq!(normal.readings.len(), skewed.readings.len());
}
