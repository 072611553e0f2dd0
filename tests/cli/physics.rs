//! Physics beside the beams: simulated by every law, read from models, refused where it is wrong.

use std::fs::File;

use stiffbench::load_direction::LoadDirection;
use stiffbench::physics::{ActingPhysics, Effect, JointRotations, LoadPoint, Mechanics, RunLoads};
use stiffbench::readings::{Reading, read_readings};
use stiffbench::robot::Robot;
use stiffbench::shipped::shipped_robot;
use stiffbench::test_point::PoseId;

use super::{Desk, desk};
use crate::support::tables::Table;
use crate::support::{Contains, Json};

/// One effect of every law, and what the clock's hundredths and the tenths of a hold leave open in its readings, m.
const EFFECTS: [(&str, f64); 16] = [
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
    ("constant-force@z:w=-0.8N", 0.0),
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
            seated_m: 0.0,
            is_unloaded: reading.target_n == 0.0,
        })
        .collect();
    let pose = ["P1", "P3"]
        .iter()
        .position(|p| first.pose == PoseId::new(p));
    let run = RunLoads {
        pose: &first.pose,
        load: LoadDirection::of_axis(first.direction),
        read: first.direction.into(),
        repeat: first.repeat,
        release_n: None,
        loads: &loads,
    };
    let mut out = vec![0.0; loads.len()];
    let pose = mechanics.pose(pose.unwrap());
    physics
        .laws
        .displacements_m(pose, &run, &mut JointRotations::default(), &mut out);
    out
}

#[test]
fn a_simulation_without_noise_is_the_prediction_of_the_laws() {
    let desk = desk();
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
        let table = read_readings("readings.csv", file).unwrap();
        let mut largest = 0.0_f64;
        for run in 0..table.runs.len() {
            let readings: Vec<&Reading> = table
                .readings
                .iter()
                .filter(|reading| reading.run as usize == run)
                .collect();
            let expected = predicted(&mechanics, &physics, &readings);
            // Drift before the first reading of a run is part of its zero, which the file does not report.
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

/// Columns of a readings file as text, without the header.
fn column(desk: &Desk, session: &str, name: &str) -> Vec<String> {
    let table = Table::parse(&desk.read(&format!("{session}/readings.csv")));
    let rows = 0..table.len();
    rows.map(|row| table.word(row, name).to_owned()).collect()
}

#[test]
fn the_force_that_acts_moves_the_robot_and_the_force_that_is_read_is_rounded() {
    let desk = desk();
    let quiet = "--reading-sd-um 0 --zero-sd-um 0 --run-slope-sd 0 --displacement-step-um 0.001";
    let effect = "--effect joint-friction@A3:c=0.1urad/(N*m),friction_moment=26N*m";
    for (session, step) in [("fine", "0.001"), ("coarse", "5")] {
        desk.run(&format!(
            "simulate {session} {quiet} --poses P2 {effect} --force-step-n {step}"
        ))
        .succeeds();
    }
    let displacements = |session: &str| column(&desk, session, "displacement_um");
    assert_eq!(displacements("fine"), displacements("coarse"));
    let forces = column(&desk, "coarse", "force_N");
    assert!(
        forces
            .iter()
            .all(|force| force.parse::<f64>().unwrap() % 5.0 == 0.0)
    );
    assert_ne!(forces, column(&desk, "fine", "force_N"));
}

#[test]
fn a_slider_may_stay_where_a_run_left_it() {
    let desk = desk();
    let plan = "--noise-free --poses P2 --directions y --repeats 2 --procedure load-unload";
    let effect = "--effect joint-friction@A4B:c=0.19mrad/(N*m),friction_moment=0.4N*m";
    desk.run(&format!("simulate virgin {plan} {effect}"))
        .succeeds();
    desk.run(&format!("simulate kept {plan} {effect} --keep-history"))
        .succeeds();
    let displacement = |session: &str| -> Vec<f64> {
        let column = column(&desk, session, "displacement_um");
        column.iter().map(|text| text.parse().unwrap()).collect()
    };
    let (virgin, kept) = (displacement("virgin"), displacement("kept"));
    assert_eq!(virgin[..15], kept[..15]);
    // A gauge that is zeroed before each run counts from what the run before left: a slider that stays there closes its loop, a virgin one does not.
    assert_eq!([virgin[15], kept[15]], [0.0, 0.0]);
    assert!(virgin[29] < -0.5, "{virgin:?}");
    assert!(kept[29].abs() < 1e-6, "{kept:?}");
    desk.read("kept/simulation.toml")
        .must_contain(&["keep_history = true"]);
}

#[test]
fn the_truth_is_recorded_as_effects_that_make_the_same_session_again() {
    let desk = desk();
    let effects = "--effect slip@P3.z.2.5:jump=-30um --effect creep:k=1%/decade,t0=1s";
    let data = desk.data(&format!("simulate first --seed 3 {effects}"));
    assert_eq!(data["physics"][0]["physics"], "slip");
    assert_eq!(data["physics"][1]["parameters"]["k"]["unit"], "1/decade");
    let truth: toml::Table = desk.read("first/simulation.toml").parse().unwrap();
    let mut again = desk.command("simulate second --seed 3");
    for effect in truth["effects"].as_array().unwrap() {
        again.args(["--effect", effect.as_str().unwrap()]);
    }
    again.assert().success();
    assert_eq!(
        desk.read("first/readings.csv"),
        desk.read("second/readings.csv")
    );
    // What is not among the readings is said.
    let late = desk.run("simulate third --poses P1 --effect slip@P3.z.2.5:jump=-30um");
    late.succeeds().stderr.must_contain(&["does not act"]);
}

/// A model with three laws, two of them with a history or a curve.
const MODEL: &str = r#"
schema = "stiffbench/model/1"
robot = "arms/robot.toml"
mechanism = "F"
[provenance]
session = "s"
[factors]
beam = { A = 1.0, Iy = 1.0, Iz = 1.0, J = 1.0 }
link = { A = 1.0, Iy = 1.0, Iz = 1.0, J = 1.0 }
[[effects]]
physics = "joint-compliance"
place = { joint = "A4" }
parameters.c = { value = 4e-6, unit = "rad/(N*m)", u = 1e-7, dof = 300.0 }
[[effects]]
physics = "joint-nonlinearity"
place = { joint = "B3" }
parameters = { c = { value = 2e-4, unit = "rad/(N*m)" }, q = { value = 3e-5, unit = "rad/(N*m)^2" } }
[[effects]]
physics = "base-compliance"
place = { axis = "x" }
parameters.c = { value = 2e-7, unit = "rad/(N*m)" }
"#;

/// A desk with the model, its robot beside it, and a session measured on it.
fn desk_with_model() -> Desk {
    let desk = desk();
    desk.write("model.toml", MODEL);
    desk.write("arms/robot.toml", &shipped_robot("hp-robot").unwrap().text);
    desk.run("simulate session --noise-free --model model.toml")
        .succeeds();
    desk
}

#[test]
fn a_fit_with_the_model_finds_the_factors_behind_it_and_one_without_does_not() {
    let desk = desk_with_model();
    let largest_error = |model: &str| -> f64 {
        let fit = desk.data(&format!("fit session {model} --factors unit"));
        let factors = fit["factors"]["beam"].as_object().unwrap();
        let values = factors.values().map(|factor| factor["value"].number());
        values.map(|value| value.ln().abs()).fold(0.0, f64::max)
    };
    assert!(largest_error("--model model.toml") < 1e-4);
    assert!(largest_error("--mechanism F") > 0.02);
    let text = desk.run("fit session --model model.toml --figures figures");
    let text = text.succeeds().stdout;
    text.must_contain(&["Physics beside the beams, held fixed:\n- joint-compliance at joint A4"]);
    let fit = desk.data("fit session --model model.toml");
    assert_eq!(fit["physics"].list().len(), 3);
    assert!(fit["max_error_percent"].number() < 0.01);
    // The paper's procedure compares means of F/d of the predicted readings, and its reference knows of beams alone.
    desk.run("fit session --model model.toml --method paper --train P1,P3")
        .succeeds();
    let list = desk
        .run("fit paper-experiment --model model.toml")
        .succeeds();
    list.stderr.must_contain(&["10 to 70 N"]);
    desk.run("robot significance --model model.toml --pose P1")
        .succeeds();
    let drawn = desk
        .run("robot compliance --pose P1 --model model.toml --figures figures")
        .succeeds();
    drawn.stderr.must_contain(&["base-compliance"]);
}
