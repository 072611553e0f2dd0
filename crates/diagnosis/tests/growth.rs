//! Time and memory of a diagnosis as the number of readings grows:
//! `cargo test --release -p stiffbench-diagnosis -- --ignored --nocapture time_and_memory`.

use std::time::Instant;

use stiffbench_beams::physics::ActingPhysics;
use stiffbench_beams::robot::{Pose, Robot};
use stiffbench_diagnosis::mismatch::{Observations, RobotBaseline, SearchOptions, diagnose};
use stiffbench_diagnosis::parameters::ParameterChoice;
use stiffbench_measurement::procedure::Procedure;
use stiffbench_simulation::{Jack, NoiseModel, VirtualBench};
use stiffbench_test_files::{shipped_procedure, shipped_robot};

/// Largest memory of this process so far, MB, as Linux counts it.
fn peak_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes / 1024.0)
}

#[test]
#[ignore = "half a minute; `just nightly` runs it"]
fn time_and_memory_grow_with_the_readings() {
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let factors = robot.factor_set("m_fsd").unwrap();
    let poses: Vec<Pose> = robot.poses.iter().map(|named| named.pose.clone()).collect();
    let choice = ParameterChoice::default();
    let baseline = RobotBaseline::new(&robot, mechanism, factors.clone(), poses, &choice).unwrap();
    let springy = "joint-compliance@A3:c=2urad/(N*m)".parse().unwrap();
    let physics = ActingPhysics::new(&robot, mechanism, vec![springy]).unwrap();
    let (noise, jack) = (NoiseModel::default(), Jack::default());
    let bench = VirtualBench::new(&robot, &physics, &factors, noise, jack).unwrap();
    let (mut procedure, _) = Procedure::parse(&shipped_procedure("load-unload").unwrap()).unwrap();
    procedure.poses = Some(robot.poses.iter().map(|named| named.id.clone()).collect());
    let mut seconds = Vec::new();
    let mut memory = Vec::new();
    // The smallest first: memory is counted from the beginning of the process.
    for (repeats, readings) in [(13, 2340), (25, 4500), (50, 9000)] {
        procedure.repeats = repeats;
        let session = bench.run(&procedure, "bench", 7).unwrap();
        let observations = Observations::new(&session, None);
        assert_eq!(observations.len(), readings);
        let start = Instant::now();
        diagnose(&baseline, &observations, &SearchOptions::default(), None).unwrap();
        seconds.push(start.elapsed().as_secs_f64());
        memory.extend(peak_mb());
        println!(
            "{readings} readings: {:.2} s, {memory:.0?} MB",
            seconds[seconds.len() - 1]
        );
    }
    // Twice the readings take about twice as long; three times leaves room for a busy machine.
    assert!(seconds[2] < 3.0 * seconds[1], "{seconds:?}");
    if let [_, half, whole] = memory[..] {
        assert!(whole < 300.0, "{memory:?}");
        assert!(whole < 2.2 * half, "{memory:?}");
    }
}
