//! What `import` prints of tables that people have: equal runs, one flaw in many rows, lines as gauges send them.

use std::fmt::Write;

use stiffbench_test_files::desk::assert_output_contains;

use super::{desk, misuse};
use crate::support::{Contains, Json};

#[test]
fn equal_runs_have_no_endless_digits() {
    let desk = desk();
    for (name, loads) in [("few", 4), ("many", 8)] {
        let mut text = "force [N],travel [mm],run\n".to_owned();
        for run in 1..=3 {
            for load in 0..loads {
                let travel = 201 * load + i32::from(load % 2 == 1);
                writeln!(text, "{}.1,0.{travel:05},{run}", 10 * load).unwrap();
            }
        }
        desk.write(&format!("{name}.csv"), &text);
        let ran = desk
            .run(&format!("import {name}.csv --out {name} --direction y"))
            .succeeds();
        let row = ran.stdout.lines().find(|line| line.contains("| P1 "));
        let longest = row.unwrap().split('|').map(|cell| cell.trim().len()).max();
        assert!(longest.unwrap() < 12, "{}", ran.stdout);
        // Eight different readings show the step of the display, four do not.
        assert_eq!(
            ran.stdout.contains("the readings do not scatter (3 runs)"),
            name == "few",
            "{}",
            ran.stdout
        );
    }
}

#[test]
fn one_flaw_in_many_rows_is_one_line() {
    let desk = desk();
    let mut text = "force [N],travel [mm],run\n".to_owned();
    for run in 1..=5 {
        for load in 0..40 {
            let turned = if load % 4 == 1 { "-" } else { "" };
            let noise = (7 * load + 3 * run) % 5;
            writeln!(
                text,
                "{},{turned}0.{:05},{run}",
                2 * load,
                100 * load + noise
            )
            .unwrap();
        }
    }
    desk.write("a.csv", &text);
    let ran = desk.run("import a.csv --out s --direction y").succeeds();
    let of = |words: &str| {
        ran.stdout
            .lines()
            .filter(|line| line.contains(words))
            .count()
    };
    assert_eq!(
        of("opposite signs, F/δ has no meaning"),
        1,
        "{}",
        ran.stdout
    );
    let flag = "flag, P1 y: 10 of displacement-sign, first: at 2 N";
    assert!(ran.stdout.contains(flag), "{}", ran.stdout);
}

/// Times, loads in N and displacements in mm of three runs up and down: 2 N/um.
fn steps() -> Vec<(f64, f64, f64)> {
    let loads = [0, 10, 20, 30, 40, 50, 40, 30, 20, 10, 0];
    let of_run = |run: u32| {
        loads.iter().zip(0_u32..).map(move |(load, step)| {
            let noise = f64::from((7 * step + 3 * run) % 5) * 1e-5;
            let time = 60.0 * f64::from(run) + 2.0 * f64::from(step);
            (time, f64::from(*load), f64::from(*load) / 2000.0 + noise)
        })
    };
    (0..3).flat_map(of_run).collect()
}

#[test]
fn lines_as_gauges_send_them_are_decoded_by_their_descriptions() {
    let desk = desk();
    let clock = |time: f64| format!("10:{:02}:{:04.1}", (time / 60.0) as u32, time % 60.0);
    let mut force = String::new();
    let mut travel = "time;travel [mm]\n".to_owned();
    let mut packets = String::new();
    for (time, load, mm) in steps() {
        writeln!(force, "{} {load:.1} N", clock(time)).unwrap();
        writeln!(travel, "{};{mm:.5}", clock(time)).unwrap();
        writeln!(packets, "{};01A+{mm:08.3}", clock(time)).unwrap();
    }
    // An answer that is no value, in line 2.
    let force = force.replacen('\n', "\n10:00:01.0 *10\n", 1);
    desk.write("force.txt", &force);
    desk.write("travel.csv", &travel);
    desk.write("packets.txt", &packets);
    for (name, options) in [
        ("table", "--displacement-log travel.csv"),
        (
            "packets",
            "--displacement-log packets.txt --displacement-instrument mitutoyo-01a --displacement-unit mm",
        ),
    ] {
        let ran = desk
            .run(&format!(
                "import force.txt --instrument mark10-series5 {options} --out {name} --direction x --json"
            ))
            .succeeds();
        let object = ran.json();
        let k = &object["data"]["stiffness"]["cells"][0]["stiffness_regression"];
        assert!((k["value"].number() - 2.0).abs() < 0.02, "{name}: {k}");
        assert_eq!(object["data"]["readings"], 33, "{name}");
        let warnings = object["warnings"].to_string();
        warnings.must_contain(&[
            "left out as no value of mark10-series5: 1 line, the first is line",
            "line 2",
        ]);
        // The bytes as they came, and the digits as they were sent.
        assert_eq!(desk.read(&format!("{name}/raw/force.txt")), force);
        desk.read(&format!("{name}/readings.csv"))
            .must_contain(&[",50.0,"]);
    }
    let error = desk.refusal(
        "import travel.csv --instrument mark10-series5 --out x --direction x",
        11,
        "stiffbench::import::no_packets",
    );
    assert_output_contains(&error, &["travel.csv, line 1", "mark10-series5"]);
    let error = misuse(
        &desk,
        "import force.txt --instrument mitutoyo-01a --out x --direction x",
    );
    assert_output_contains(&error, &["measures displacement"]);
}
