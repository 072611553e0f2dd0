//! Files as people have them, each to K with its uncertainty in one command, and damaged ones refused with place and remedy.

use std::fmt::Write;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use stiffbench_test_files::desk::{Desk, assert_output_contains};

use super::{desk, misuse};
use crate::support::{Contains, Json};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/imports")
}

/// A desk with the files of `fixtures/imports`.
fn desk_with_files() -> Desk {
    let desk = desk();
    for entry in fs::read_dir(fixtures()).unwrap() {
        let file = entry.unwrap().path();
        let name = file.file_name().unwrap().to_str().unwrap().to_owned();
        fs::copy(&file, desk.path(&name)).unwrap();
    }
    desk
}

/// Pose, direction, stiffness and its expanded uncertainty of each cell, N/um.
fn cells(data: &Value) -> Vec<(String, f64, f64)> {
    let cells = data["cells"].list();
    let of = |cell: &Value| {
        let k = &cell["stiffness_regression"];
        let name = format!("{} {}", cell["pose"].word(), cell["direction"].word());
        (
            name,
            k["value"].number(),
            k["U"].as_f64().unwrap_or_default(),
        )
    };
    cells.iter().map(of).collect()
}

#[test]
fn each_file_gives_its_stiffness_in_one_command() {
    let desk = desk_with_files();
    let expected = fs::read_to_string(fixtures().join("expected.csv")).unwrap();
    let mut files = 0;
    for line in expected.lines().skip(1) {
        let fields: Vec<&str> = line.splitn(3, ',').collect();
        // Options with a comma in them are quoted.
        let (file, rest) = (fields[0], &line[fields[0].len() + 1..]);
        let (options, wanted) = match rest.strip_prefix('"') {
            Some(quoted) => quoted.split_once("\",").unwrap(),
            None => rest.split_once(',').unwrap(),
        };
        let folder = format!("session-of-{file}");
        let ran = desk.run(&format!(
            "import {file} --out {folder} --no-input --json {options}"
        ));
        let data = ran.succeeds().json()["data"].clone();
        let found = cells(&data["stiffness"]);
        let wanted: Vec<&str> = wanted.split("; ").collect();
        assert_eq!(found.len(), wanted.len(), "{file}: {found:?}");
        for ((name, value, uncertainty), wanted) in found.iter().zip(wanted) {
            let (cell, k) = wanted.rsplit_once(' ').unwrap();
            let k: f64 = k.parse().unwrap();
            assert_eq!(name, cell, "{file}");
            assert!(
                (value / k - 1.0).abs() < 0.02,
                "{file}: {value}, expected {k}"
            );
            assert!(
                (value - k).abs() < 2.0 * uncertainty,
                "{file}: {value} ± {uncertainty}, expected {k}"
            );
        }
        assert_eq!(data["runs"], 3 * found.len(), "{file}");
        // A second command opens the folder and gives the same.
        let again = desk.data(&format!("stiffness {folder}"));
        assert_eq!(cells(&again), found, "{file}");
        files += 1;
    }
    assert!(files >= 15);
}

#[test]
fn a_mapping_is_used_again() {
    let desk = desk_with_files();
    desk.run("import two-columns.csv --out monday --direction y --units N,um")
        .succeeds();
    desk.run("import two-columns.csv --out tuesday --mapping monday/mapping.toml")
        .succeeds();
    assert_eq!(
        desk.read("monday/readings.csv")
            .replace("monday", "tuesday"),
        desk.read("tuesday/readings.csv")
    );
    desk.write(
        "wrong.toml",
        "schema = \"stiffbench/mapping/1\"\n[columns]\nkraft = \"F\"\n",
    );
    let error = desk.refusal(
        "import two-columns.csv --out x --mapping wrong.toml",
        11,
        "stiffbench::import::mapping",
    );
    assert_output_contains(&error, &["wrong.toml, line 3", "kraft"]);
}

#[test]
fn columns_are_named_by_name_or_number() {
    let desk = desk();
    desk.write(
        "a.csv",
        "a;b, mm;F (N)\n1;0;0\n2;0.02;10.01\n3;0.04;20.02\n4;0.06;30.03\n",
    );
    let of =
        |map: &str, out: &str| desk.data(&format!("import a.csv --out {out} --direction x {map}"));
    let guessed = cells(&of("", "s1")["stiffness"]);
    let named = cells(&of("--map force=3,displacement=2", "s2")["stiffness"]);
    assert_eq!(guessed, named);
    assert!((guessed[0].1 - 0.5).abs() < 0.01, "{guessed:?}");
    let error = desk.refusal(
        "import a.csv --out s3 --map force=Kraft",
        11,
        "stiffbench::table::unknown_column",
    );
    assert_output_contains(&error, &["a.csv, line 1", "`Kraft`"]);
    desk.refusal(
        "import a.csv --out s3 --map kraft=a",
        2,
        "stiffbench::import::unknown_role",
    );
    misuse(&desk, "import a.csv --out s3 --map force");
}

#[test]
fn a_sign_that_goes_against_the_force_is_said_and_turned() {
    let desk = desk();
    desk.write(
        "a.csv",
        "force_N,displacement_um\n0.1,0\n10.1,-20\n20.1,-40\n30.1,-60\n",
    );
    let ran = desk.run("import a.csv --out s --direction x").succeeds();
    let said = "against the force throughout: its sign was reversed";
    ran.stderr.must_contain(&[said]);
    desk.read("s/mapping.toml")
        .must_contain(&["flip = [\"displacement\"]"]);
    // As if it had been stated, whichever gauge is said to count the other way.
    for (out, stated) in [
        ("t", ""),
        ("u", " --flip displacement"),
        ("v", " --flip force"),
    ] {
        let data = desk.data(&format!("import a.csv --out {out} --direction x{stated}"));
        assert!(
            (cells(&data["stiffness"])[0].1 - 0.5).abs() < 0.01,
            "{stated}"
        );
    }
}

#[test]
fn joint_values_are_the_poses_of_the_robot_in_every_analysis() {
    let desk = desk();
    desk.run(
        "simulate sim --robot serial-arm --noise-free --poses P1,P2 --directions y --repeats 2",
    )
    .succeeds();
    let readings = desk.read("sim/readings.csv");
    let mut rows = csv::Reader::from_reader(readings.as_bytes());
    let names = rows.headers().unwrap().clone();
    let of = |name: &str| names.iter().position(|known| known == name).unwrap();
    let (pose, repeat, force, travel) = (
        of("pose"),
        of("repeat"),
        of("force_N"),
        of("displacement_um"),
    );
    let mut text =
        "THETA1;theta2 (deg);theta3;theta4;Richtung;Lauf;Kraft [N];Weg [um]\n".to_owned();
    for row in rows.records() {
        let row = row.unwrap();
        let angles = if &row[pose] == "P1" {
            "0;70;-30;-60"
        } else {
            "0;25;20;-10"
        };
        writeln!(
            text,
            "{angles};y;{};{};{}",
            &row[repeat], &row[force], &row[travel]
        )
        .unwrap();
    }
    desk.write("angles.csv", &text);
    let imported = desk.data("import angles.csv --out s --robot serial-arm");
    assert_eq!(imported["poses"], serde_json::json!(["Q1", "Q2"]));
    let fit = "--parameter beam.A=fixed --parameter beam.Iz=fixed --parameter beam.J=fixed --json";
    let value = |session: &str| {
        let data = desk.run(&format!("fit {session} {fit}")).succeeds().json()["data"].clone();
        data["factors"]["beam"]["Iy"]["value"]
            .as_f64()
            .unwrap_or_else(|| panic!("{}", data["factors"]))
    };
    assert!((value("s") / value("sim") - 1.0).abs() < 1e-3);
    // A pose that the robot has with other values.
    desk.write(
        "named.csv",
        &text
            .replace("THETA1", "pose;THETA1")
            .replace("\n0;70", "\nP2;0;70")
            .replace("\n0;25", "\nP1;0;25"),
    );
    let error = misuse(&desk, "import named.csv --out t --robot serial-arm");
    assert_output_contains(&error, &["pose of this name with other joint values"]);
}

#[test]
fn damaged_files_are_refused_with_place_and_remedy() {
    let good = "pose;direction;repeat;force [N];travel [mm]\nP1;y;1;0,1;0,001\nP1;y;1;10,2;0,021\nP1;y;1;20,1;0,040\nP1;y;1;30,1;0,061\n";
    let cases: [(&str, String, &str, &[&str]); 9] = [
        (
            "cut",
            good[..good.len() - 8].to_owned(),
            "stiffbench::import::no_value",
            &["line 5", "`travel [mm]`"],
        ),
        (
            "text",
            good.replace("10,2", "1o,2"),
            "stiffbench::table::bad_number",
            &["line 3", "`force [N]`", "1o,2"],
        ),
        (
            "column",
            good.replace("travel [mm]", "colour"),
            "stiffbench::import::missing",
            &["line 1", "displacement", "--map"],
        ),
        (
            "nan",
            good.replace("0,040", "NaN"),
            "stiffbench::import::no_value",
            &["line 4", "NaN", "delete"],
        ),
        (
            "empty",
            String::new(),
            "stiffbench::table::empty",
            &["empty"],
        ),
        (
            "header",
            good.lines().next().unwrap().to_owned(),
            "stiffbench::table::no_numbers",
            &[],
        ),
        (
            "mixed",
            good.replace("20,1", "20.1"),
            "stiffbench::table::mixed_decimals",
            &["line", "20.1"],
        ),
        (
            "twice",
            good.replace("travel [mm]", "force [N]"),
            "stiffbench::table::duplicate_column",
            &["4 and 5", "--map force=4"],
        ),
        (
            "unit",
            good.replace("[mm]", "[V]"),
            "stiffbench::import::missing",
            &["the unit of the displacement", "--displacement-unit"],
        ),
    ];
    let desk = desk();
    for (name, text, code, words) in cases {
        let file = format!("{name}.csv");
        desk.write(&file, &text);
        let ran = desk.run(&format!("import {file} --out out-{name} --no-input --json"));
        let object = ran.json();
        assert_eq!(object["error"]["code"], code, "{name}: {object}");
        assert_output_contains(&object["error"], words);
        assert!(
            !desk.path(&format!("out-{name}")).exists(),
            "{name} left a folder"
        );
    }
    fs::write(
        desk.path("a.png"),
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01",
    )
    .unwrap();
    let ran = desk.run("import a.png --out p --no-input --json");
    assert_output_contains(&ran.json()["error"], &["a.png"]);
    desk.write("zero.csv", "force [N],travel [mm]\n1,0\n2,0\n3,0\n");
    let error = desk.refusal(
        "import zero.csv --out z --direction y",
        11,
        "stiffbench::import::all_zero",
    );
    assert_output_contains(
        &error,
        &["lines 2 to 4", "`travel [mm]`", "--map displacement=COLUMN"],
    );
}

#[test]
fn calibration_can_be_given_to_every_analysis() {
    let desk = desk_with_files();
    desk.run("import two-columns.csv --out s --direction y --units N,um")
        .succeeds();
    let plain = cells(&desk.data("stiffness s"));
    let run = desk
        .run("stiffness s --force-u 1N --displacement-u limit=1um --budget")
        .succeeds();
    run.stdout.must_contain(&[
        "force gauge: U = 1 N, k = 2 (--force-u 1N)",
        "displacement gauge: limits of error ±1 um, rectangular, u = 0.5774 um (--displacement-u limit=1um)",
    ]);
    // The row of the budget has the distribution of the limits; that of the force gauge is normal.
    let row = |gauge: &str| {
        let mut rows = run.stdout.lines();
        let row = rows.rfind(|row| row.contains(gauge));
        row.unwrap_or_default().to_owned()
    };
    let [of_limits, of_force] =
        ["displacement", "force"].map(|name| row(&format!("calibration of the {name} gauge")));
    of_limits.must_contain(&["rectangular"]);
    of_force.must_contain(&["normal"]);
    let with = cells(&desk.data("stiffness s --force-u 1N"));
    assert!((with[0].1 - plain[0].1).abs() < 1e-12);
    // U of the calibration is U/F_max of K, added in squares: 1 N of 50 N is 2 %.
    let added = (with[0].2.powi(2) - plain[0].2.powi(2)).max(0.0).sqrt() / plain[0].1;
    assert!((0.01..0.03).contains(&added), "{added}");
    // A gauge that shows 2 % too much: K is 2 % too large without the table.
    desk.write(
        "force.csv",
        "applied_N,indicated_N,U_N,k\n20,20.4,0.1,2\n40,40.8,0.1,2\n60,61.2,0.1,2\n",
    );
    let ran = desk
        .run("stiffness s --force-calibration force.csv")
        .succeeds();
    ran.stdout
        .must_contain(&["force gauge corrected by --force-calibration force.csv"]);
    let corrected = cells(&desk.data("stiffness s --force-calibration force.csv"));
    assert!(
        (corrected[0].1 * 1.02 / plain[0].1 - 1.0).abs() < 1e-6,
        "{corrected:?} {plain:?}"
    );
    desk.run("compare s s --force-u 1N").succeeds();
    desk.run("stiffness s --instrument-records s/session.toml")
        .succeeds();
    misuse(&desk, "stiffness s --force-u 1mm");
    desk.write("bad.csv", "applied_N,indicated_N\n1,1\n");
    desk.refusal(
        "stiffness s --force-calibration bad.csv",
        11,
        "stiffbench::calibration_table::missing_column",
    );
}

#[test]
fn weights_without_a_zero_begin_a_run_at_the_smallest() {
    let desk = desk();
    let mut table = "load [kg],travel [mm]\n".to_owned();
    for run in 0..3_u32 {
        for weight in 1..6_u32 {
            let travel = f64::from(weight) * 0.0265 + f64::from(run) * 0.0001;
            writeln!(table, "{weight},{travel:.4}").unwrap();
        }
    }
    desk.write("weights.csv", &table);
    desk.run("import weights.csv --out w --direction y")
        .succeeds();
    let readings = desk.read("w/readings.csv");
    assert_eq!(
        readings
            .lines()
            .filter(|line| line.contains(",y,loading,"))
            .count(),
        15,
        "{readings}"
    );
}

#[test]
fn the_page_of_imported_readings_names_their_file() {
    let desk = desk_with_files();
    desk.run("import two-columns.csv --out s --direction y --units N,um")
        .succeeds();
    desk.run("report s").succeeds();
    let page = desk.read("s/report.html");
    let header = desk.read("s/session.toml");
    let (_, hash) = header.split_once("source_sha256 = \"").unwrap();
    assert!(page.contains(&hash[..64]));
    page.must_contain(&["raw/two-columns.csv"]);
    assert!(page.contains("imported by") && !page.contains("recorded by"));
}
