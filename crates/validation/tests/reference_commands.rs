//! The reference of solids from the command line: what is written, run, compared and refused.

use std::process::Command;

use stiffbench_test_files::desk::{Desk, assert_output_contains};

/// A folder of its own to run the program in.
fn desk() -> Desk {
    Desk::new(env!("CARGO_BIN_EXE_stiffbench-validate"))
}

#[test]
fn a_model_is_written_with_its_cases_and_differences() {
    let desk = desk();
    let ran = desk
        .run("reference export --robot serial-arm --load=-50,-100 --size 40 --pose P1,P2 --out solids")
        .succeeds();
    assert!(
        ran.stdout.contains("J and shear are those of the prism"),
        "{}",
        ran.stdout
    );
    let model: serde_json::Value = serde_json::from_str(&desk.read("solids/model.json")).unwrap();
    assert_eq!(model["schema"], "stiffbench/reference-model/1");
    assert_eq!(model["beams"], 7);
    assert_eq!(model["factors"], "unit");
    for pose in ["P1", "P2"] {
        for case in ["x-50N", "x-100N", "y-50N", "y-100N", "z-50N", "z-100N"] {
            let text = desk.read(&format!("solids/{pose}_{case}.inp"));
            assert!(
                text.contains(&format!("*INCLUDE, INPUT={pose}.inp")),
                "{text}"
            );
        }
        assert!(
            desk.read(&format!("solids/{pose}.inp"))
                .contains("** Units: mm, N, MPa.")
        );
    }
    // A model is never written over.
    let error = desk.refusal(
        "reference export --out solids",
        2,
        "stiffbench::usage::argument",
    );
    assert_output_contains(&error, &["not an empty folder"]);
}

#[test]
fn what_cannot_be_exported_is_refused_before_anything_is_written() {
    let desk = desk();
    for (arguments, exit, code) in [
        ("--load 0", 2, "stiffbench::usage::argument"),
        ("--load=-50,-50", 2, "stiffbench::usage::argument"),
        ("--pose P1,P1", 2, "stiffbench::usage::argument"),
        ("--size 0", 2, "stiffbench::reference::size"),
        ("--size -5", 2, "stiffbench::reference::size"),
        ("--size 0.01", 2, "stiffbench::reference::size"),
        ("--pose P9", 10, "stiffbench::robot::unknown_name"),
        ("--robot nowhere", 2, "stiffbench::usage::argument"),
    ] {
        desk.refusal(
            &format!("reference export {arguments} --out solids"),
            exit,
            code,
        );
        assert!(!desk.path("solids").exists(), "{arguments}");
    }
}

#[test]
fn without_calculix_the_message_names_the_remedy() {
    let desk = desk();
    desk.refusal("reference run nowhere", 11, "stiffbench::input::not_found");
    desk.run("reference export --robot serial-arm --size 40 --out solids")
        .succeeds();
    let error = desk.refusal(
        "reference run solids --ccx no-such-program",
        10,
        "stiffbench::reference::no_calculix",
    );
    assert_output_contains(
        &error,
        &["apt-get install calculix-ccx", "reference compare"],
    );
    desk.refusal(
        "reference run solids --ccx true",
        10,
        "stiffbench::reference::no_calculix",
    );
    desk.refusal(
        "reference compare solids",
        11,
        "stiffbench::input::not_found",
    );
    desk.write("solids/reference.json", "{}");
    let error = desk.refusal(
        "reference compare solids",
        11,
        "stiffbench::reference::record",
    );
    assert_output_contains(&error, &["missing field"]);
}

/// A program that answers as CalculiX does, notes its cases, and stops at the second one while there is a file `stop`.
const STAND_IN: &str = r#"#!/bin/sh
if [ "$1" = -v ]; then echo "This is Version 0.0"; exit; fi
echo "$1" >> cases.txt
if [ -e stop ] && [ "$1" = P1_y-50N ]; then exit 1; fi
echo " displacements (vx,vy,vz) for set ENDNODE and time  0.1000000E+01" > "$1.dat"
echo " 7 -1.0E-01 -2.0E-01 -3.0E-01" >> "$1.dat"
"#;

#[cfg(unix)]
#[test]
fn a_stopped_run_is_reported_and_resumes() {
    let desk = desk();
    desk.run("reference export --robot serial-arm --size 40 --out solids")
        .succeeds();
    desk.write("stand-in.sh", STAND_IN);
    desk.install("stand-in.sh", "ccx");
    let program = desk.path("ccx");
    let run = format!("reference run solids --ccx {}", program.display());
    desk.write("solids/stop", "");
    desk.refusal(&run, 11, "stiffbench::reference::answer");
    let error = desk.refusal(
        "reference compare solids",
        11,
        "stiffbench::reference::unfinished",
    );
    assert_output_contains(
        &error,
        &[
            "stopped after 1 of 3 cases",
            "P1 y -50 N is the first",
            "reference run",
        ],
    );
    for file in ["solids/stop", "solids/cases.txt"] {
        std::fs::remove_file(desk.path(file)).unwrap();
    }
    let text = desk.run(&run).succeeds().stdout;
    assert!(
        text.contains("1 of them are of a run that was stopped"),
        "{text}"
    );
    assert_eq!(desk.read("solids/cases.txt"), "P1_y-50N\nP1_z-50N\n");
    desk.run("reference compare solids").succeeds();
    // One that came to its end is run again from the first case on.
    desk.run(&run).succeeds();
    assert_eq!(desk.read("solids/cases.txt").lines().count(), 2 + 3);
    // A case that somebody took out of the middle is run, and no other.
    let file = "solids/reference.json";
    let mut record: serde_json::Value = serde_json::from_str(&desk.read(file)).unwrap();
    record["cells"].as_array_mut().unwrap().remove(1);
    desk.write(file, &record.to_string());
    std::fs::remove_file(desk.path("solids/cases.txt")).unwrap();
    desk.run(&run).succeeds();
    assert_eq!(desk.read("solids/cases.txt"), "P1_y-50N\n");
    desk.run("reference compare solids").succeeds();
}

#[test]
fn the_recorded_reference_repeats_table_iv() {
    let desk = desk();
    let text = desk.run("reference compare").succeeds().stdout;
    assert!(
        text.contains("Table IV in short") && text.contains("1261386"),
        "{text}"
    );
    let data = desk.data("reference compare");
    assert_eq!(data["run"]["program"], "CalculiX ccx 2.20");
    let pose = &data["poses"][0];
    assert_eq!(pose["beams"], 36);
    let rows = pose["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 12);
    // The factors are fitted at -50 N: there the trials reach 1e-4, and at 500 N 46 mm of displacement stiffen the robot by less than 1 %.
    for row in rows {
        let allowed = if row["force_N"] == -50.0 { 0.02 } else { 1.0 };
        assert!(
            row["difference_percent"].as_f64().unwrap().abs() < allowed,
            "{row}"
        );
    }
    let largest = pose["largest_difference_percent"].as_f64().unwrap();
    assert!(
        largest > 0.05,
        "large displacements must be seen at 500 N: {largest}"
    );
}

#[test]
fn calculix_runs_and_its_answer_is_fitted() {
    if Command::new("ccx").arg("-v").output().is_err() {
        eprintln!("skipped: CalculiX is not installed (apt-get install calculix-ccx)");
        return;
    }
    let desk = desk();
    desk.run("reference export --robot serial-arm --size 40 --out solids")
        .succeeds();
    desk.run("reference run solids").succeeds();
    let data = desk.data("reference compare solids");
    let pose = &data["poses"][0];
    assert_eq!(pose["rows"].as_array().unwrap().len(), 3);
    for row in pose["rows"].as_array().unwrap() {
        let solids = row["reference_um"].as_f64().unwrap();
        let prisms = row["prisms_um"].as_f64().unwrap();
        // Seven short tubes: Bredt's torsion constant is up to 5 % low, and contraction held at the joints is not in the beams.
        assert!((prisms / solids - 1.0).abs() < 0.06, "{row}");
    }
    let list = desk.read("solids/reference.csv");
    assert!(
        list.starts_with("pose,direction,force_N,displacement_um\nP1,x,-50,"),
        "{list}"
    );
    // A broken model: CalculiX stops, and an answer of before is not taken for its own.
    desk.write("solids/P1.inp", "*NODE\n");
    let error = desk.refusal("reference run solids", 11, "stiffbench::reference::answer");
    assert_output_contains(&error, &["P1_x-50N.dat", ".log"]);
}
