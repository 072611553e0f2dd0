//! Physics beside the beams: simulated by every law, read from models, refused where it is wrong.

use std::fs::File;

use stiffbench::physics::{ActingPhysics, Effect, LoadPoint, Mechanics, RunLoads, Twists};
use stiffbench::readings::{ReadOptions, Reading, read_readings};
use stiffbench::robot::{Robot, shipped_robot};
use stiffbench::test_point::PoseId;

use super::Desk;

/// One effect of every law, and what the clock's hundredths and the tenths of a hold leave open in its readings, m.
const EFFECTS: [(&str, f64); 15] = [
    ("joint-compliance@A4:c=4urad/(N*m)", 0.0),
    ("joint-backlash@B3:play=0.12mrad,seat_moment=0.14N*m", 0.0),
    (
        "joint-friction@A4B:c=0.19mrad/(N*m),friction_moment=0.4N*m",
        0.0,
    ),
    (
        "joint-nonlinearity@B3:c=0.2mrad/(N*m),q=30urad/(N*m)^2",
        0.0,
    ),
    ("base-compliance@x:c=0.2urad/(N*m)", 0.0),
    ("gauge-stand-compliance@z:c=1um/N", 0.0),
    ("load-misalignment@y>z:angle=0.9deg", 0.0),
    ("loose-member@B1B2", 0.0),
    ("force-gauge-nonlinearity:q=0.007%/N", 0.0),
    // 0.05 s of 4 s: 0.05/(5 ln 10) of 1 % of some millimetres.
    ("creep:k=1%/decade,t0=1s", 3e-7),
    ("thermal-drift@clock:rate=36um/h", 2e-10),
    ("thermal-drift@clock:rate=6um/K", 7e-8),
    ("setting-in:k=3%,decay=1.5", 0.0),
    ("slip@P3.z.2.5:jump=-30um", 0.0),
    (
        "gauge-periodic:amplitude=2um,period=0.15mm,phase=0.3rad",
        0.0,
    ),
];

/// Numbers of a reading in the file: nine decimals of a micrometre and of a newton.
const ROUNDED_M: f64 = 2e-15;

/// Displacements of the readings of one run by the laws alone, m.
fn predicted(mechanics: &Mechanics<'_>, physics: &ActingPhysics, run: &[&Reading]) -> Vec<f64> {
    let first = run[0];
    let since = |now: Option<f64>, then: Option<f64>| now.unwrap() - then.unwrap();
    let loads: Vec<LoadPoint> = run
        .iter()
        .map(|reading| LoadPoint {
            force_n: reading.force_n,
            step: reading.step,
            hold_s: reading.hold_s.unwrap(),
            since_zero_s: since(reading.time_s, first.time_s),
            warming_k: since(reading.temperature_deg_c, first.temperature_deg_c),
            position_m: None,
        })
        .collect();
    let pose = ["P1", "P3"]
        .iter()
        .position(|p| first.pose == PoseId::new(p));
    let run = RunLoads {
        pose: &first.pose,
        direction: first.direction,
        repeat: first.repeat,
        release_n: None,
        loads: &loads,
    };
    let mut out = vec![0.0; loads.len()];
    let pose = mechanics.pose(pose.unwrap());
    physics
        .laws
        .displacements_m(pose, &run, &mut Twists::default(), &mut out);
    out
}

#[test]
fn a_simulation_without_noise_is_the_prediction_of_the_laws() {
    let desk = Desk::new();
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let factors = robot.factor_set("m_fsd").unwrap();
    let poses = ["P1", "P3"].map(|pose| robot.pose(&PoseId::new(pose)).unwrap().clone());
    for (number, (text, left_open_m)) in EFFECTS.into_iter().enumerate() {
        let plan = "--noise-free --poses P1,P3 --procedure load-hold-unload --repeats 2";
        desk.run(&format!(
            "simulate s{number} {plan} --mechanism F --effect {text}"
        ))
        .succeeds();
        let effect: Effect = text.parse().unwrap();
        let physics = ActingPhysics::new(&robot, mechanism, vec![effect]).unwrap();
        let mechanics = Mechanics::new(&robot, &physics.mechanism, &factors, &poses).unwrap();
        let file = File::open(desk.path(&format!("s{number}/readings.csv"))).unwrap();
        let table = read_readings("readings.csv", file, &ReadOptions::default()).unwrap();
        let mut largest = 0.0_f64;
        for run in 0..table.runs.len() {
            let readings: Vec<&Reading> = table
                .readings
                .iter()
                .filter(|reading| reading.run as usize == run)
                .collect();
            let expected = predicted(&mechanics, &physics, &readings);
            // Drift before the first reading of a run is part of its zero, which the file does not tell.
            let drifts = text.starts_with("thermal-drift");
            let zero = if drifts {
                readings[0].displacement_m - expected[0]
            } else {
                0.0
            };
            for (reading, expected) in readings.iter().zip(&expected) {
                let error = (reading.displacement_m - zero - expected).abs();
                let allowed = ROUNDED_M + 2e-9 * expected.abs() + left_open_m;
                assert!(error <= allowed, "{text}: {error:e} at {reading:?}");
                largest = largest.max(expected.abs());
            }
        }
        assert!(largest > 1e-5, "{text}");
    }
}
