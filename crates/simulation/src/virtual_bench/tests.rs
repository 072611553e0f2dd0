//! The virtual bench against the beam model, its plan and its seed.

use super::*;
use crate::NoiseShape;
use stiffbench_beams::robot::Predictor;
use stiffbench_measurement::readings::{Reading, WrittenRows, read_readings, write_rows};
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
    table_with(noise, procedure, seed, &[])
}

fn table_with(
    noise: NoiseModel,
    procedure: &Procedure,
    seed: u64,
    effects: &[&str],
) -> ReadingTable {
    let robot = robot();
    let mechanism = robot.mechanism(None).unwrap();
    let factors = robot.factor_set("m_fsd").unwrap();
    let effects = effects.iter().map(|text| text.parse().unwrap()).collect();
    let physics = ActingPhysics::new(&robot, mechanism, effects).unwrap();
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
        Err(BenchError::Procedure(problem)) if problem.key == "loads"
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

/// Three gauges, loads against an axis, along an oblique direction and along an axis.
fn three_gauges() -> Procedure {
    Procedure {
        directions: [[0.0, -1.0, 0.0], [0.0, 0.6, 0.8], [1.0, 0.0, 0.0]]
            .map(|vector| LoadDirection::from_vector(vector).unwrap())
            .to_vec(),
        displacement_axes: Direction::ALL.to_vec(),
        loads_n: vec![0.0, 20.0, 40.0, 60.0],
        unloading: true,
        repeats: 3,
        ..sweeps(&["P1", "P2"])
    }
}

#[test]
fn several_gauges_without_noise_read_the_compliance_matrix() {
    let robot = robot();
    let table = table(NoiseModel::NONE, &three_gauges(), 1);
    assert_eq!(table.readings.len(), 2 * 3 * 3 * 7 * 3);
    let mechanism = robot.mechanism(None).unwrap();
    let mut predictor =
        Predictor::new(&robot, mechanism, &robot.factor_set("m_fsd").unwrap()).unwrap();
    for reading in &table.readings {
        predictor.place(robot.pose(&reading.pose).unwrap()).unwrap();
        let compliance = predictor.translation_compliance();
        let row = compliance[reading.direction.index()];
        let unit = table.load_direction(reading).unit_vector();
        let along: f64 = (0..3).map(|axis| row[axis] * unit[axis]).sum();
        let expected = along * reading.force_n;
        // The text shows nine decimals of a micrometre and of a newton; of the largest compliance nine digits are right.
        let largest = compliance
            .iter()
            .flatten()
            .fold(0.0, |m: f64, c| m.max(c.abs()));
        let rounding = 1e-14 + 1e-9 * largest * (1.0 + reading.force_n.abs());
        assert!(
            (reading.displacement_m - expected).abs() < rounding,
            "{reading:?}: {expected}"
        );
    }
}

#[test]
fn readings_of_several_gauges_are_written_and_read_again() {
    for zero in [ZeroScope::Run, ZeroScope::Cell] {
        let procedure = Procedure {
            zero,
            displacement_axes: vec![Direction::X, Direction::Z],
            ..three_gauges()
        };
        let table = table(NoiseModel::default(), &procedure, 3);
        let mut written = Vec::new();
        let rows = WrittenRows {
            of_vectors: true,
            ..WrittenRows::default()
        };
        write_rows(&table, rows, &mut written).unwrap();
        let again = read_readings("readings.csv", written.as_slice()).unwrap();
        assert_eq!(again.fields.rows.len(), 2 * 3 * 3 * 7);
        assert_eq!(again.loads().count(), again.fields.rows.len());
        for (read, made) in again.loads().zip(table.readings.chunks(2)) {
            assert!(read.iter().all(|one| one.direction != Direction::Y));
            for (read, made) in read.iter().zip(made) {
                let key = |of: &Reading| (of.seq, of.run, of.zero, of.direction, of.step);
                assert_eq!(key(read), key(made));
                let units = [again.load_direction(read), table.load_direction(made)];
                let [unit, other] = units.map(|load| load.unit_vector());
                let apart = unit.iter().zip(other).map(|(a, b)| (a - b).abs());
                assert!(apart.fold(0.0, f64::max) < 1e-12, "{unit:?} {other:?}");
                assert!((read.force_n - made.force_n).abs() < 1e-12);
                assert!((read.displacement_m - made.displacement_m).abs() < 1e-18);
            }
        }
        assert_eq!(table.loads().count(), again.fields.rows.len());
        let zeros = if zero == ZeroScope::Run { 3 } else { 1 };
        assert_eq!(again.zeros.len(), 2 * 3 * 2 * zeros);
        assert_eq!(again.runs.len(), 2 * 3 * 3);
    }
}

#[test]
fn gauges_have_their_own_errors_and_share_the_load() {
    // By far the largest errors are those of the zeros, of the runs, or of the readings.
    let quiet = NoiseModel::NONE;
    let procedure = three_gauges();
    let clean = table(quiet, &procedure, 5);
    let errors = |noise: NoiseModel| -> Vec<f64> {
        let noisy = table(noise, &procedure, 5);
        let pairs = noisy.readings.iter().zip(&clean.readings);
        pairs
            .map(|(noisy, clean)| noisy.displacement_m - clean.displacement_m)
            .collect()
    };
    let zeros = errors(NoiseModel {
        zero_sd_m: 1e-3,
        ..quiet
    });
    for run in zeros.chunks(7 * 3) {
        let first = &run[..3];
        assert!(first[0] != first[1] && first[1] != first[2]);
        assert!(run.chunks(3).all(|gauges| {
            let same = gauges.iter().zip(first);
            same.into_iter().all(|(a, b)| (a - b).abs() < 1e-4)
        }));
    }
    let readings = errors(NoiseModel {
        reading_sd_m: 1e-3,
        ..quiet
    });
    let n = readings.len() as f64 / 3.0;
    let products = readings.chunks(3).map(|of| of[0] * of[1]);
    let correlation = products.sum::<f64>() / n / 1e-6;
    // Of 126 pairs without correlation: standard error 0.09.
    assert!(correlation.abs() < 0.3, "{correlation}");
}

#[test]
fn a_run_is_stiffer_for_all_gauges_alike() {
    let noise = NoiseModel {
        run_slope_sd: 0.1,
        ..NoiseModel::NONE
    };
    let [noisy, clean] = [noise, NoiseModel::NONE].map(|of| table(of, &three_gauges(), 5));
    let pairs: Vec<_> = noisy.readings.iter().zip(&clean.readings).collect();
    for run in pairs.chunks(7 * 3) {
        // The loads of a seed are the same, whatever the noise.
        let slopes = run.iter().filter_map(|(noisy, clean)| {
            let moved_m = clean.displacement_m;
            (moved_m.abs() > 1e-5).then(|| noisy.displacement_m / moved_m - 1.0)
        });
        let slopes: Vec<f64> = slopes.collect();
        let first = slopes[0];
        assert!(first != 0.0 && slopes.iter().all(|slope| (slope - first).abs() < 1e-6));
    }
}

/// By how much an effect changes the readings of three gauges, um, without noise.
fn changes(effect: &str) -> Vec<(Reading, f64)> {
    let procedure = Procedure {
        holds_s: vec![120.0],
        ..three_gauges()
    };
    let [with, without] = [&[effect][..], &[]]
        .map(|effects| table_with(NoiseModel::NONE, &procedure, 2, effects).readings);
    let pairs = with.into_iter().zip(without);
    pairs
        .map(|(with, without)| {
            let um = (with.displacement_m - without.displacement_m) * 1e6;
            (with, um)
        })
        .collect()
}

/// Whether an effect should change a reading; `None` if it may or may not.
type Changes = fn(&Reading) -> Option<bool>;

/// Whether an effect on what gives way in the y-z plane should: the loads along x, and the displacements across the plane, may stay.
fn in_plane(reading: &Reading) -> Option<bool> {
    let is_of_plane = reading.direction != Direction::X && reading.load.is_some_and(|of| of < 2);
    (reading.target_n == 0.0)
        .then_some(false)
        .or(is_of_plane.then_some(true))
}

/// The same of an effect of one gauge.
fn of_gauge(reading: &Reading, axis: Direction) -> Option<bool> {
    if reading.direction == axis {
        in_plane(reading)
    } else {
        Some(false)
    }
}

fn after_slip(reading: &Reading) -> bool {
    let run = (reading.pose.as_str(), reading.load, reading.repeat);
    run == ("P2", Some(0), 2) && reading.step >= 2
}

#[test]
fn every_kind_of_effect_changes_the_readings_it_should() {
    let cases: [(&str, Changes); 14] = [
        ("joint-backlash@A3:play=0.1mrad,seat_moment=1N*m", in_plane),
        // It leaves a twist at zero load.
        (
            "joint-friction@A3:c=2urad/(N*m),friction_moment=0.1N*m",
            |r| in_plane(r).filter(|_| r.target_n != 0.0),
        ),
        ("base-compliance@x:c=1urad/(N*m)", in_plane),
        ("creep:k=2%/decade,t0=1s", in_plane),
        ("setting-in:k=5%,decay=1.5", in_plane),
        ("gauge-scale@force:scale=2%", in_plane),
        ("thermal-drift@clock:rate=360um/h", |_| Some(true)),
        ("thermal-drift@clock.z:rate=360um/h", |r| {
            Some(r.direction == Direction::Z)
        }),
        (
            // At another phase it moves the zero too.
            "gauge-periodic@displacement.y:amplitude=2um,period=0.15mm,phase=0rad",
            |r| of_gauge(r, Direction::Y),
        ),
        ("gauge-scale@displacement.z:scale=2%", |r| {
            of_gauge(r, Direction::Z)
        }),
        ("gauge-stand-compliance@y:c=1um/N", |r| {
            of_gauge(r, Direction::Y)
        }),
        ("load-misalignment@x>y:angle=2deg", |r| {
            let is_along_x = match r.load {
                None => true,
                Some(load) => load == 2,
            };
            let moves = is_along_x && r.direction != Direction::X && r.target_n != 0.0;
            (!is_along_x).then_some(false).or(moves.then_some(true))
        }),
        ("slip@P2.-y.2.2:jump=20um", |r| Some(after_slip(r))),
        ("slip@P2.-y.2.2/z:jump=20um", |r| {
            Some(after_slip(r) && r.direction == Direction::Z)
        }),
    ];
    for (effect, expected) in cases {
        let (mut moved, mut should) = (0, 0);
        for (reading, um) in changes(effect) {
            match expected(&reading) {
                // Digits behind the ninth of a micrometre.
                Some(false) => assert!(um.abs() < 1e-6, "{effect}: {um} in {reading:?}"),
                Some(true) => {
                    should += 1;
                    moved += u32::from(um.abs() > 1e-3);
                }
                None => {}
            }
        }
        // A gauge's period passes its zeros.
        assert!(
            should > 0 && 10 * moved > 9 * should,
            "{effect}: {moved} of {should}"
        );
    }
}
