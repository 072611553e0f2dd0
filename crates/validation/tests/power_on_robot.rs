//! Power of a diagnosis on a robot that the user names, its springs free in the baseline.

use std::process::Command;

use serde_json::Value as Json;

fn power(arguments: &[&str]) -> (Option<i32>, Json) {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_stiffbench-validate"))
        .args(["prove", "--only", "power", "--json", "--out"])
        .arg(folder.path().join("power"))
        .args(arguments)
        .output()
        .unwrap();
    let printed = serde_json::from_slice(&output.stdout).unwrap();
    (output.status.code(), printed)
}

#[test]
fn laws_on_an_arm_with_free_springs_are_named() {
    let laws = "joint-friction,setting-in,joint-compliance";
    let (code, printed) = power(&[
        "--robot",
        "fanuc-r2000ic",
        "--laws",
        laws,
        "--sizes",
        "8",
        "--trials",
        "1",
    ]);
    assert_eq!(code, Some(0), "{printed}");
    let cases = printed["data"]["parts"]["power"]["cases"]
        .as_array()
        .unwrap();
    let names: Vec<&str> = cases
        .iter()
        .map(|case| case["laws"][0].as_str().unwrap())
        .collect();
    // The springs of all joints are free: their compliance is no law to be found.
    assert_eq!(names, ["joint-friction", "setting-in"]);
    for case in cases {
        assert!(case["bench"].as_str().unwrap().contains("FANUC"), "{case}");
        let point = &case["points"][0];
        let hits = |what: &str| point[what]["hits"].as_u64().unwrap();
        assert_eq!(point["found"]["trials"], 6, "{point}");
        assert!(hits("found") >= 5 && hits("right") >= 3, "{point}");
    }
}

#[test]
fn a_robot_that_is_not_there_is_named() {
    let (code, printed) = power(&["--robot", "no-such-robot", "--trials", "1"]);
    assert_eq!(code, Some(2), "{printed}");
    let message = printed["error"]["message"].as_str().unwrap();
    assert!(message.contains("no-such-robot"), "{message}");
}
