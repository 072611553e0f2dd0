//! Sessions with displacement gauges along the base axes on an emulated bench, loads in any direction, and the table of ISO 9283.

use super::{assert_output_contains, desk, misuse};
use crate::support::{Contains, Json};
use serde_json::Value;

/// Three gauges, two loads of the test of ISO 9283 against and along a direction each.
const SHORT: &str = "--procedure iso-9283-static-compliance --poses P1 --directions -y,0,0.6,0.8 --loads-n 20,40,60 --repeats 3";

/// An emulated bench without an operator. On a busy machine one of four lines may lag behind the others for half a second, which is ten of the
/// bench: such a reading is taken again.
const EMULATED: &str = "--emulated --speed 12 --no-input --answer temperature=21 --answer frozen=again --answer implausible=again";

/// Rows of the compliance of the robot's end in a pose, µm/N.
fn compliance(data: &Value) -> [[f64; 3]; 3] {
    let entry = |i: usize, j: usize| data["compliance"][i][j].number() * 1e6;
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

#[test]
fn three_gauges_measure_the_compliance_that_the_robot_has() {
    let desk = desk();
    let data = desk.data(&format!("session run s {SHORT} {EMULATED}"));
    assert_eq!(data["outcome"], "complete");
    assert_eq!(data["accepted"], 18);
    let header = desk.read("s/session.toml");
    header.must_contain(&[
        "schema = \"stiffbench/session/2\"",
        "displacement_axes = [\"x\", \"y\", \"z\"]",
        "[instruments.displacement_z]",
    ]);
    for trace in [
        "force",
        "displacement-x",
        "displacement-y",
        "displacement-z",
    ] {
        assert!(
            desk.path(&format!("s/raw/{trace}.trace")).is_file(),
            "{trace}"
        );
    }
    assert_eq!(
        desk.data("session verify s")["table"]["state"],
        "as-recorded"
    );
    // What is measured, against the beam model by another way.
    let matrix = compliance(&desk.data("robot compliance --pose P1"));
    let measured = desk.data("stiffness s");
    for (cell, unit) in [[0.0, -1.0, 0.0], [0.0, 0.6, 0.8]].into_iter().enumerate() {
        let found = &measured["cells"][cell];
        let mut along = 0.0;
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let expected: f64 = (0..3).map(|i| matrix[axis][i] * unit[i]).sum();
            along += unit[axis] * expected;
            let value = &found["compliance"][name];
            let error = (value["value"].number() - expected).abs();
            let allowed = 2.0 * value["U"].number() + 0.05;
            assert!(error < allowed, "{name}: {value} for {expected}");
        }
        let stiffness = found["stiffness"]["value"].number();
        assert!(
            (stiffness * along - 1.0).abs() < 0.1,
            "{stiffness} for {along}"
        );
        let row = &measured["static_compliance"][cell];
        assert!((row["force_N"].number() - 60.0).abs() < 0.5);
        let mm_per_n = row["compliance"]["y"]["value"].number();
        let expected: f64 = (0..3).map(|i| matrix[1][i] * unit[i]).sum();
        assert!(
            (mm_per_n * 1e3 - expected).abs() < 0.1,
            "{mm_per_n} for {expected}"
        );
    }
    let text = desk.run("stiffness s").succeeds().stdout;
    text.must_contain(&["(0,0.6,0.8)", "Static compliance (ISO 9283), mm/N", "-y"]);
    let log = desk.run("session log s").succeeds().stdout;
    log.must_contain(&[
        "displacement-z gauge counts along",
        "direction -y",
        "x ",
        "displacement-y gauge,",
    ]);
    // A report has both directions, the compliance along each axis and a decision.
    let details = "decision_rule = \"guard-band\"\n[[requirement]]\npose = \"P1\"\ndirection = \"-y\"\nat_least_N_per_um = 0.02\n";
    desk.write("report.toml", details);
    let report = desk.data("report s --details report.toml --out s.html");
    assert_eq!(report["conformity"]["requirements"][0]["decision"], "pass");
    desk.read("s.html")
        .must_contain(&["Static compliance (ISO 9283)", "(0,0.6,0.8)"]);
    desk.run("report verify s.html s").succeeds();
    // What reads one displacement gauge says so.
    let error = desk.refusal("compare s s", 11, "stiffbench::input::vectors");
    assert_output_contains(&error, &["stiffbench stiffness"]);
}

/// True springs of the emulated serial arm, rad/(N·m).
const SPRINGS: [(&str, f64); 4] = [("S1", 5e-6), ("S2", 8e-6), ("S3", 6e-6), ("S4", 1e-5)];

#[test]
fn springs_are_fitted_from_a_guided_session_and_from_the_one_it_plans() {
    let desk = desk();
    let effects =
        SPRINGS.map(|(joint, c)| format!("--effect joint-compliance@{joint}:c={c}rad/(N*m)"));
    let arm = format!(
        "--robot serial-arm {} {EMULATED} --answer sign-differs=use",
        effects.join(" ")
    );
    desk.run(&format!("session run s --procedure iso-9283-static-compliance --poses P1 --directions -y,0,0.6,0.8 --loads-n 20,40,60 --repeats 3 {arm}"))
        .succeeds();
    desk.read("s/readings.csv")
        .must_contain(&[",joint_theta1_deg,joint_theta2_deg,"]);
    desk.read("s/session.toml")
        .must_contain(&["[procedure.joint_values"]);
    let springs = "--parameter beam.A,beam.Iy,beam.Iz,beam.J=fixed --parameter joint.S1,joint.S2,joint.S3,joint.S4=free";
    let first = desk.data(&format!("fit s {springs} --next next.toml"));
    // One pose with its arm in the plane of all loads cannot turn the post.
    assert_eq!(
        first["parameters"].named("joint.S1")["status"],
        "not_identified"
    );
    let error = misuse(&desk, &format!("fit s {springs} --next next.txt"));
    assert_output_contains(&error, &[".toml", ".csv"]);
    desk.read("next.toml").must_contain(&[" min"]);
    desk.run(&format!("session run t --procedure next.toml {arm}"))
        .succeeds();
    let both = desk.data(&format!("fit s t {springs}"));
    for (joint, expected) in SPRINGS {
        let one = both["parameters"].named(&format!("joint.{joint}"));
        let off = (one["value"].number() - expected) / one["se"].number();
        assert!(off.abs() < 4.0, "{joint}: {off} standard errors");
        assert_eq!(one["status"], "free", "{joint}");
    }
    // Kept rigid, the springs are missed.
    assert_ne!(desk.data("diagnose s")["verdict"], "nothing-missing");
    // Poses that are not those of the robot are named.
    let next = desk.read("next.toml");
    desk.write("other.toml", &next.replacen("theta1_deg", "theta9_deg", 1));
    let error = desk
        .run("session plan --robot serial-arm --procedure other.toml --json")
        .json();
    assert_output_contains(
        &error["error"],
        &["joint_values.", "no variable theta9", "theta1"],
    );
    desk.write("unit.toml", &next.replacen("theta1_deg", "theta1_mm", 1));
    let error = desk
        .run("session plan --robot serial-arm --procedure unit.toml --json")
        .json();
    assert_output_contains(&error["error"], &["theta1 is an angle", "_deg"]);
}

#[test]
fn the_poses_that_determine_springs_best_are_planned_and_measured() {
    let desk = desk();
    let plan =
        "session plan --robot serial-arm --directions x,y,z --loads-n=0,-20,-40 --best-poses";
    let data = desk.data(&format!("{plan} 3 --save-procedure three.toml"));
    assert_eq!(data["determines"].list().len(), 4);
    let further = desk.data(&format!("{plan} 6"));
    for (three, six) in data["determines"]
        .list()
        .iter()
        .zip(further["determines"].list())
    {
        // Twice the poses: about a half of the variance.
        let ratio = six["se"].number() / three["se"].number();
        assert!((0.4..1.0).contains(&ratio), "{ratio}");
    }
    let simulated = desk.data("simulate a --robot serial-arm --procedure three.toml");
    assert_eq!(simulated["readings"], 3 * 3 * 5 * 3);
    desk.run("stiffness a").succeeds();
    // Effects may name the poses of the plan.
    let planned = desk.read("three.toml");
    let named = planned.split("poses = [\"").nth(1).unwrap();
    let pose = named.split('"').next().unwrap();
    let slip = format!("--effect slip@{pose}.y.2.1:jump=20um");
    let warned = desk
        .run(&format!(
            "simulate b --robot serial-arm --procedure three.toml {slip}"
        ))
        .succeeds();
    assert!(!warned.stderr.contains("does not act"), "{}", warned.stderr);
    misuse(&desk, &format!("{plan} 0"));
}

#[test]
fn a_simulated_session_of_three_gauges_is_one_that_a_bench_makes() {
    let desk = desk();
    let data = desk.data(&format!("simulate s {SHORT} --noise-free"));
    assert_eq!(data["readings"], 18);
    let [header, table] =
        ["session.toml", "readings.csv"].map(|file| desk.read(&format!("s/{file}")));
    header.must_contain(&[
        "schema = \"stiffbench/session/2\"",
        "[instruments.displacement_z]",
        "[procedure.joint_values.P1]",
    ]);
    assert!(!header.contains("[instruments.displacement]"), "{header}");
    table.must_contain(&[",joint_theta1_deg,", ",origin\n"]);
    let matrix = compliance(&desk.data("robot compliance --pose P1"));
    let measured = desk.data("stiffness s");
    for (cell, unit) in [[0.0, -1.0, 0.0], [0.0, 0.6, 0.8]].into_iter().enumerate() {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let expected: f64 = (0..3).map(|i| matrix[axis][i] * unit[i]).sum();
            let value = &measured["cells"][cell]["compliance"][name]["value"];
            let error = value.number() - expected;
            // Of the ten digits of a compliance nine are left in the slope.
            let allowed = 1e-9 * expected.abs().max(1.0);
            assert!(
                error.abs() < 5.0 * allowed,
                "{name}: {value} for {expected}"
            );
        }
    }
    // What does not act is said, whichever gauge it is of.
    let two = "simulate t --directions x,0,0.6,0.8 --displacement-axes x,z --poses P1";
    let slip = |place: &str| {
        let effect = format!("--effect slip@P1.{place}:jump=20um");
        desk.run(&format!("{two} {effect}")).succeeds().stderr
    };
    let stderr = slip("(0,0.6,0.8).2.3/y");
    stderr.must_contain(&["the effect does not act"]);
    std::fs::remove_dir_all(desk.path("t")).unwrap();
    let stderr = slip("(0,0.6,0.8).2.3/z");
    assert!(!stderr.contains("does not act"), "{stderr}");
    desk.run("fit s --parameter beam.A,beam.J=fixed").succeeds();
}

#[test]
fn cut_in_the_middle_and_resumed_the_readings_are_the_same() {
    let desk = desk();
    desk.run(&format!("session run s {SHORT} {EMULATED}"))
        .succeeds();
    let whole = desk.read("s/journal.jsonl");
    let third = whole
        .match_indices("\"kind\":\"reading\"")
        .nth(4)
        .unwrap()
        .0;
    desk.write("s/journal.jsonl", &whole[..third + 40]);
    let status = desk.data("session status s");
    assert_eq!(status["accepted"], 4);
    assert_eq!(
        status["next"]["direction"],
        serde_json::json!([0.0, -1.0, 0.0])
    );
    let data = desk.data(&format!("session resume s {EMULATED}"));
    assert_eq!(data["outcome"], "complete");
    assert_eq!(data["accepted"], 18);
    // A changed number is found, whichever gauge it is of.
    let table = desk.read("s/readings.csv");
    let line = table.lines().nth(5).unwrap();
    let raw = line
        .split(',')
        .find(|field| field.ends_with("mm") || field.contains("mm "))
        .unwrap();
    desk.write("s/readings.csv", &table.replacen(raw, "+9.999 mm", 1));
    desk.refusal("stiffness s", 11, "stiffbench::input::changed");
    assert_eq!(desk.run("session verify s").code, 30);
    let recovered = desk.run("session recover s --out t").succeeds();
    recovered.stdout.must_contain(&["18 readings"]);
    desk.run("stiffness t").succeeds();
}
