//! Sessions with displacement gauges along the base axes on an emulated bench, loads in any direction, and the table of ISO 9283.

use super::{assert_output_contains, desk};
use serde_json::Value;

/// Three gauges, two loads of the test of ISO 9283 against and along a direction each.
const SHORT: &str = "--procedure iso-9283-static-compliance --poses P1 --directions -y,0,0.6,0.8 --loads-n 20,40,60 --repeats 3";

/// An emulated bench without an operator.
const EMULATED: &str = "--emulated --speed 20 --no-input --answer temperature=21";

/// Rows of the compliance of the robot's end in a pose, µm/N.
fn compliance(data: &Value) -> [[f64; 3]; 3] {
    let entry = |i: usize, j: usize| data["compliance"][i][j].as_f64().unwrap() * 1e6;
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

#[test]
fn three_gauges_measure_the_compliance_that_the_robot_has() {
    let desk = desk();
    let data = desk.data(&format!("session run s {SHORT} {EMULATED}"));
    assert_eq!(
        (&data["outcome"], &data["accepted"]),
        (&"complete".into(), &18.into())
    );
    let header = desk.read("s/session.toml");
    for part in [
        "schema = \"stiffbench/session/2\"",
        "displacement_axes = [\"x\", \"y\", \"z\"]",
        "[instruments.displacement_z]",
    ] {
        assert!(header.contains(part), "{part} in {header}");
    }
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
            let error = (value["value"].as_f64().unwrap() - expected).abs();
            let allowed = 2.0 * value["U"].as_f64().unwrap() + 0.05;
            assert!(error < allowed, "{name}: {value} for {expected}");
        }
        let stiffness = found["stiffness"]["value"].as_f64().unwrap();
        assert!(
            (stiffness * along - 1.0).abs() < 0.1,
            "{stiffness} for {along}"
        );
        let row = &measured["static_compliance"][cell];
        assert!((row["force_N"].as_f64().unwrap() - 60.0).abs() < 0.5);
        let mm_per_n = row["compliance"]["y"]["value"].as_f64().unwrap();
        let expected: f64 = (0..3).map(|i| matrix[1][i] * unit[i]).sum();
        assert!(
            (mm_per_n * 1e3 - expected).abs() < 0.1,
            "{mm_per_n} for {expected}"
        );
    }
    let text = desk.run("stiffness s").succeeds().stdout;
    for part in ["(0,0.6,0.8)", "Static compliance (ISO 9283), mm/N", "-y"] {
        assert!(text.contains(part), "{part} in {text}");
    }
    let log = desk.run("session log s").succeeds().stdout;
    for part in [
        "displacement-z gauge counts along",
        "direction -y",
        "x ",
        "displacement-y gauge,",
    ] {
        assert!(log.contains(part), "{part} in {log}");
    }
    // What reads one displacement gauge says so.
    for command in ["fit s --train P1", "diagnose s", "compare s s"] {
        let error = desk.refusal(command, 11, "stiffbench::input::vectors");
        assert_output_contains(&error, &["stiffbench stiffness"]);
    }
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
    assert_eq!(
        (&data["outcome"], &data["accepted"]),
        (&"complete".into(), &18.into())
    );
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
    assert!(
        recovered.stdout.contains("18 readings"),
        "{}",
        recovered.stdout
    );
    desk.run("stiffness t").succeeds();
}

#[test]
fn directions_and_axes_that_cannot_be_are_refused_by_name() {
    let desk = desk();
    desk.write(
        "long.toml",
        "schema = \"stiffbench/procedure/1\"\ndirections = [\"d\"]\ndisplacement_axes = [\"x\"]\n[load_directions]\nd = [0, 3, 4]\n",
    );
    let error = desk.run("session plan --procedure long.toml --json").json();
    assert_output_contains(
        &error["error"],
        &["long.toml", "length 5.0000", "unit vector"],
    );
    let plan = desk
        .run("session plan --directions x,0,0.6,0.8 --json")
        .json();
    assert_output_contains(&plan["error"], &["(0,0.6,0.8)", "displacement_axes"]);
    let error = desk
        .run("simulate t --procedure iso-9283-static-compliance --json")
        .json();
    assert_output_contains(&error["error"], &["displacement_axes", "guided sessions"]);
    let error = desk.run("session run s --displacement-port x=/dev/null --force-port /dev/null --force-instrument mark10-series5 --json").json();
    assert_output_contains(&error["error"], &["x=/dev/null", "--displacement-axes"]);
    let bad = desk.run("session plan --directions x,w");
    assert_eq!(bad.code, 2);
    assert!(
        bad.stderr.contains("`w` is not a direction"),
        "{}",
        bad.stderr
    );
    let data =
        desk.data("session plan --directions -x,0,0.7,0.7 --displacement-axes z,x --poses P1");
    assert_eq!(
        data["cells"][0]["direction"],
        serde_json::json!([-1.0, 0.0, 0.0])
    );
    desk.write(
        "names.toml",
        "schema = \"stiffbench/procedure/1\"\ndirections = [\"diagonal\"]\ndisplacement_axes = [\"y\"]\n[load_directions]\ndiagonal = [0.6, 0.8, 0]\nother = [0, 0, 1]\n",
    );
    let plan = desk.run("session plan --procedure names.toml --poses P1");
    assert!(plan.stdout.contains("setup.P1.diagonal"), "{}", plan.stdout);
    assert!(
        plan.stderr.contains("load_directions.other"),
        "{}",
        plan.stderr
    );
}
