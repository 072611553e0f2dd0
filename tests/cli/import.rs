//! Files as people have them, each to K with its uncertainty in one command, and damaged ones refused with place and remedy.

use std::fmt::Write;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use stiffbench_test_files::desk::{Desk, assert_output_contains};

use super::desk;

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
    let cells = data["cells"].as_array().unwrap();
    let of = |cell: &Value| {
        let k = &cell["stiffness_regression"];
        let name = format!(
            "{} {}",
            cell["pose"].as_str().unwrap(),
            cell["direction"].as_str().unwrap()
        );
        (
            name,
            k["value"].as_f64().unwrap(),
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
fn a_folder_holds_source_mapping_and_mark() {
    let desk = desk_with_files();
    desk.run("import german-excel.csv --out s").succeeds();
    assert_eq!(
        fs::read(desk.path("s/raw/german-excel.csv")).unwrap(),
        fs::read(desk.path("german-excel.csv")).unwrap()
    );
    let header = desk.read("s/session.toml");
    for words in [
        "software = \"stiffbench ",
        "source_sha256 = ",
        "mapping_sha256 = ",
    ] {
        assert!(header.contains(words), "{header}");
    }
    let ran = desk.run("stiffness s").succeeds();
    assert!(
        ran.stdout.contains("imported from raw/german-excel.csv"),
        "{}",
        ran.stdout
    );
    assert!(ran.stdout.contains("not protected"), "{}", ran.stdout);
    let readings = desk.read("s/readings.csv");
    assert!(
        readings.contains("\"9,99\"") || readings.contains("\"10,0"),
        "the texts of the file are kept"
    );
    // The folder of before is left alone.
    let error = desk.refusal(
        "import french.csv --out s",
        13,
        "stiffbench::output::exists",
    );
    assert_output_contains(&error, &["s exists already"]);
    assert_eq!(desk.read("s/session.toml"), header);
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
fn all_that_is_missing_is_named_at_once_with_the_line_to_use() {
    let desk = desk();
    desk.write("a.csv", "a,b\n1,2\n2,4\n");
    let error = desk.refusal(
        "import a.csv --out s --no-input",
        3,
        "stiffbench::import::missing",
    );
    assert_output_contains(
        &error,
        &[
            "a.csv, line 1",
            "the column of the force",
            "the column of the displacement",
            "the direction",
            "`a`, `b`",
            "stiffbench import a.csv --out s --map force=COLUMN --force-unit UNIT --map displacement=COLUMN --displacement-unit UNIT --direction y",
        ],
    );
    let error = desk.refusal(
        "stiffness a.csv",
        11,
        "stiffbench::readings::missing_column",
    );
    assert_output_contains(
        &error,
        &[
            "`pose`",
            "`repeat`",
            "stiffbench import a.csv --out a-session",
        ],
    );
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
        "stiffbench::import::unknown_column",
    );
    assert_output_contains(&error, &["a.csv, line 1", "`Kraft`"]);
    desk.refusal(
        "import a.csv --out s3 --map kraft=a",
        2,
        "stiffbench::import::unknown_role",
    );
    desk.refusal(
        "import a.csv --out s3 --map force",
        2,
        "stiffbench::usage::argument",
    );
}

#[test]
fn a_sign_that_goes_against_the_force_is_said_and_turned() {
    let desk = desk();
    desk.write(
        "a.csv",
        "force_N,displacement_um\n0.1,0\n10.1,-20\n20.1,-40\n30.1,-60\n",
    );
    let ran = desk.run("import a.csv --out s --direction x").succeeds();
    assert!(ran.stderr.contains("--flip displacement"), "{}", ran.stderr);
    let data = desk.data("import a.csv --out t --direction x --flip displacement");
    assert!((cells(&data["stiffness"])[0].1 - 0.5).abs() < 0.01);
}

#[test]
fn implausible_numbers_are_said() {
    let desk = desk();
    desk.write(
        "a.csv",
        "force [N],travel [um]\n0.1,0\n10.1,0.002\n20.1,0.004\n30.1,0.006\n",
    );
    let ran = desk.run("import a.csv --out s --direction x").succeeds();
    assert!(ran.stderr.contains("um"), "{}", ran.stderr);
    assert!(
        ran.stderr.contains("robots have 0.001 to 10"),
        "{}",
        ran.stderr
    );
}

#[test]
fn joint_values_are_kept_and_become_poses_of_the_robot() {
    let desk = desk_with_files();
    desk.run("import joint-angles.csv --out s").succeeds();
    let header = desk.read("s/session.toml");
    assert!(header.contains("q1_deg = 45"), "{header}");
    assert!(header.contains("q2_deg = 60"), "{header}");
}

#[test]
fn numbered_joint_columns_are_the_joints_of_the_robot() {
    let desk = desk();
    let names = |word: &str, n: usize| {
        let names = (1..=n).map(|k| format!("{word}{k} [deg]"));
        names.collect::<Vec<_>>().join(";")
    };
    let table = |joints: &str, values: &str| {
        format!(
            "Stellung;{joints};Richtung;Lauf;Kraft [N];Weg [mm]\nA;{values};y;1;0,1;0,001\nA;{values};y;1;10,2;0,021\n"
        )
    };
    // The variables of this arm are theta1 to theta4.
    for (place, word) in ["q", "Achse ", "axis_", "joint "].into_iter().enumerate() {
        desk.write("arm.csv", &table(&names(word, 4), "0;70;-30;-60"));
        let run = format!("import arm.csv --out s{place} --robot serial-arm");
        let note = desk.run(&run).succeeds().stderr;
        let words = format!(
            "joint columns `{word}1 [deg]` to `{word}4 [deg]` are taken as theta1 to theta4"
        );
        assert!(note.contains(&words), "{note}");
        let header = desk.read(&format!("s{place}/session.toml"));
        assert!(header.contains("theta2_deg = 70"), "{header}");
    }
    // Three columns, and names without numbers, are not guessed.
    desk.write("three.csv", &table(&names("q", 3), "0;70;-30"));
    let run = "import three.csv --out t --robot serial-arm";
    let error = desk.refusal(run, 2, "stiffbench::usage::argument");
    let place = "three.csv, line 1, column `q1 [deg]`";
    let remedy = "joint.theta1=q1 [deg],...";
    assert_output_contains(&error, &[place, "has no variable q1", remedy]);
    assert!(!desk.path("t").exists());
}

#[test]
fn repeats_at_one_load_are_loading_and_give_no_slope() {
    let desk = desk();
    // 0.8 N/um, read three times at about 50 N; the noise of the force rises, falls, or neither.
    for (place, order) in [[0, 1, 2], [2, 1, 0], [1, 2, 0]].into_iter().enumerate() {
        let rows = [("50.01", "62.4"), ("50.05", "62.1"), ("50.11", "62.7")];
        let rows = order.map(|row| format!("{},{}\n", rows[row].0, rows[row].1));
        desk.write(
            "one.csv",
            &format!("Force [N],Displacement [um]\n{}", rows.concat()),
        );
        let ran = desk
            .run(&format!("import one.csv --out s{place} --direction y"))
            .succeeds();
        for word in ["unloading", "begin at the largest"] {
            assert!(!ran.stderr.contains(word), "{}", ran.stderr);
        }
        assert!(ran.stdout.contains("are at one load"), "{}", ran.stdout);
        let data = desk.data(&format!("stiffness s{place}"));
        let slope = &data["cells"][0]["stiffness_regression"];
        assert!(slope["value"].is_null(), "{slope}");
        assert!(
            slope["reason"].to_string().contains("at one load"),
            "{slope}"
        );
        let readings = desk.read(&format!("s{place}/readings.csv"));
        assert_eq!(readings.matches(",loading,").count(), 3, "{readings}");
        assert!(ran.stdout.contains("0.802"), "{}", ran.stdout);
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
    let fit = "--fix beam.A --fix beam.Iz --fix beam.J --json";
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
    let error = desk.refusal(
        "import named.csv --out t --robot serial-arm",
        2,
        "stiffbench::usage::argument",
    );
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
            "stiffbench::import::duplicate_column",
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
fn a_mark_that_may_be_either_is_settled_by_an_option() {
    let desk = desk();
    desk.write(
        "a.csv",
        "force [N];travel [um]\n1.010;2.020\n2.020;4.040\n3.030;6.060\n4.040;8.080\n",
    );
    let error = desk.refusal(
        "import a.csv --out s --direction y",
        11,
        "stiffbench::table::either_decimal",
    );
    assert_output_contains(&error, &["line 2", "`1.010`", "--decimal", "--thousands"]);
    for (options, largest) in [
        ("--decimal point", "4.04"),
        ("--decimal ,", "4040"),
        ("--thousands none", "4.04"),
        ("--thousands point", "4040"),
        ("--decimal comma", "4040"),
    ] {
        let out = options.replace([' ', '-'], "");
        desk.run(&format!("import a.csv --out {out} --direction y {options}"))
            .succeeds();
        let readings = desk.read(&format!("{out}/readings.csv"));
        assert!(
            readings.contains(&format!(",{largest},4.040,")),
            "{options}: {readings}"
        );
    }
}

#[test]
fn the_delimiter_can_be_stated_and_is_remembered() {
    let desk = desk();
    desk.write(
        "a.csv",
        "force [N];travel [um]\n1;2,5\n2;5,0\n3;7,5\n4;10,0\n",
    );
    for (option, word) in [
        ("--delimiter semicolon", "semicolon"),
        ("--delimiter ;", "semicolon"),
    ] {
        let out = option.replace([' ', '-', ';'], "") + &option.len().to_string();
        desk.run(&format!("import a.csv --out {out} --direction y {option}"))
            .succeeds();
        let mapping = desk.read(&format!("{out}/mapping.toml"));
        assert!(
            mapping.contains(&format!("delimiter = \"{word}\"")),
            "{mapping}"
        );
        let readings = desk.read(&format!("{out}/readings.csv"));
        assert_eq!(readings.lines().count(), 5, "{readings}");
    }
    // What is stated counts, not what is found.
    let code = "stiffbench::table::no_numbers";
    desk.refusal(
        "import a.csv --out t --direction y --delimiter tab",
        11,
        code,
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
    for words in [
        "force gauge: U = 1 N, k = 2 (--force-u 1N)",
        "displacement gauge: limits of error ±1 um, rectangular, u = 0.5774 um (--displacement-u limit=1um)",
    ] {
        assert!(run.stdout.contains(words), "{}", run.stdout);
    }
    // The row of the budget has the distribution of the limits; that of the force gauge is normal.
    let row = |gauge: &str| {
        let mut rows = run.stdout.lines();
        let row = rows.rfind(|row| row.contains(gauge));
        row.unwrap_or_default().to_owned()
    };
    let [of_limits, of_force] =
        ["displacement", "force"].map(|name| row(&format!("calibration of the {name} gauge")));
    assert!(of_limits.contains("rectangular"), "{of_limits}");
    assert!(of_force.contains("normal"), "{of_force}");
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
    assert!(
        ran.stdout
            .contains("force gauge corrected by --force-calibration force.csv"),
        "{}",
        ran.stdout
    );
    let corrected = cells(&desk.data("stiffness s --force-calibration force.csv"));
    assert!(
        (corrected[0].1 * 1.02 / plain[0].1 - 1.0).abs() < 1e-6,
        "{corrected:?} {plain:?}"
    );
    desk.run("compare s s --force-u 1N").succeeds();
    desk.run("stiffness s --instrument-records s/session.toml")
        .succeeds();
    desk.refusal(
        "stiffness s --force-u 1mm",
        2,
        "stiffbench::usage::argument",
    );
    desk.write("bad.csv", "applied_N,indicated_N\n1,1\n");
    desk.refusal(
        "stiffness s --force-calibration bad.csv",
        11,
        "stiffbench::calibration_table::missing_column",
    );
}

/// The notes of an import of a table, which must succeed.
fn notes_of(desk: &Desk, name: &str, table: &str, options: &str) -> (Value, String) {
    desk.write(name, table);
    let ran = desk.run(&format!(
        "import {name} --out of-{name} --no-input --json {options}"
    ));
    let object = ran.succeeds().json();
    (object["data"].clone(), object["warnings"].to_string())
}

#[test]
fn dates_and_times_in_two_columns_are_one_time() {
    let desk = desk();
    // Around midnight: the times of day alone would go back.
    let force = "Date;Time;Force [N]\n2026-11-24;23:59:58;0\n2026-11-24;23:59:59;10\n2026-11-25;00:00:00;20\n2026-11-25;00:00:01;30\n";
    let travel = "Date;Time;Travel [um]\n2026-11-24;23:59:58;0\n2026-11-25;00:00:01;60\n";
    desk.write("travel.csv", travel);
    let (data, notes) = notes_of(
        &desk,
        "force.csv",
        force,
        "--displacement-log travel.csv --direction y",
    );
    let roles = data["columns"].as_array().unwrap().iter();
    let roles: Vec<&Value> = roles.map(|column| &column["role"]).collect();
    assert_eq!(roles, ["date", "time", "force"], "{notes}");
    assert_eq!(data["readings"], 4);
    let k = &data["stiffness"]["cells"][0]["stiffness_regression"]["value"];
    assert!((k.as_f64().unwrap() - 0.5).abs() < 1e-9, "{k}");
    let readings = desk.read("of-force.csv/readings.csv");
    assert!(
        readings.lines().last().unwrap().contains(",3"),
        "{readings}"
    );
}

#[test]
fn a_unit_that_is_not_known_is_named_with_those_that_are() {
    let desk = desk();
    desk.write("t.csv", "Kraft [Zentner];Weg [mm]\n1;0,1\n2;0,2\n");
    let error = desk.refusal(
        "import t.csv --out o --no-input --pose Q7 --direction y",
        3,
        "stiffbench::import::missing",
    );
    assert_output_contains(
        &error,
        &[
            "unit `Zentner` is not known for a force",
            "daN",
            "kp",
            "--force-unit UNIT",
            "--direction y",
        ],
    );
    for (unit, newtons) in [
        ("daN", 10.0),
        ("kp", 9.806_65),
        ("kip", 4_448.221_615_260_5),
    ] {
        let table = format!("Force [{unit}],Travel [um]\n0,0\n1,10\n2,20\n3,30\n");
        let name = format!("{unit}.csv");
        let (data, _) = notes_of(&desk, &name, &table, "--direction y");
        let k = data["stiffness"]["cells"][0]["stiffness_regression"]["value"]
            .as_f64()
            .unwrap();
        assert!((k / (newtons / 10.0) - 1.0).abs() < 1e-9, "{unit}: {k}");
    }
}

#[test]
fn what_puts_an_import_in_doubt_is_noted_and_counts_under_strict() {
    let desk = desk();
    let steps = |loads: &[f64], offset: f64| -> String {
        let rows = loads
            .iter()
            .map(|load| format!("{load},{}\n", 20.0 * load + offset));
        format!("Force [N],Travel [um]\n{}", rows.collect::<String>())
    };
    for (name, loads, offset, options, words) in [
        (
            "zero.csv",
            vec![0.0, 10.0, 0.0, 20.0, 0.0, 30.0, 0.0, 40.0],
            0.0,
            "",
            "goes up and down more than once",
        ),
        (
            "down.csv",
            vec![40.0, 30.0, 20.0, 10.0, 40.0, 30.0, 20.0, 10.0],
            0.0,
            "",
            "begin at the largest",
        ),
        (
            "preload.csv",
            vec![0.0, 25.0, 0.0, 20.0, 40.0, 0.0, 20.0, 40.0],
            0.0,
            "",
            "do not reach the same load",
        ),
        (
            "unit.csv",
            vec![0.0, 10.0, 20.0, 0.0, 10.0, 20.0],
            0.0,
            "--units kN,mm",
            "the file states N for column",
        ),
        (
            "tare.csv",
            vec![1.0, 10.0, 20.0, 1.0, 10.0, 20.0],
            300.0,
            "",
            "mean of F/d and the slope differ",
        ),
    ] {
        let (_, notes) = notes_of(
            &desk,
            name,
            &steps(&loads, offset),
            &format!("--direction y {options}"),
        );
        assert!(notes.contains(words), "{name}: {notes}");
        desk.run(&format!(
            "import {name} --out strict-{name} --no-input --direction y --strict {options}"
        ))
        .exits_with(1);
    }
    // Up, a little below zero at the start of each run, and nothing to doubt.
    let (data, notes) = notes_of(
        &desk,
        "good.csv",
        &steps(&[-0.2, 10.0, 20.0, -0.2, 10.0, 20.0], 0.0),
        "--direction y",
    );
    assert!(
        !notes.contains("uncertain") && !notes.contains("unloading"),
        "{notes}"
    );
    assert_eq!(data["runs"], 2);
    desk.run("import good.csv --out strict-good --no-input --direction y --strict")
        .succeeds();
}

#[test]
fn poses_that_are_not_recognised_are_not_mixed_without_a_word() {
    let desk = desk();
    let mut table = String::from("Ort;Lauf;Last [kg];Messuhr [mm]\n");
    for (place, compliance) in [("vorn", 0.05), ("hinten", 0.02)] {
        for run in 1..=3 {
            for load in 0..=5 {
                let travel = f64::from(load) * compliance + 0.001 * f64::from((load * run) % 3);
                writeln!(table, "{place};{run};{load};{travel:.3}").unwrap();
            }
        }
    }
    let table = table.replace('.', ",");
    let (_, notes) = notes_of(&desk, "ort.csv", &table, "--direction z");
    for words in [
        "column `Ort` is not used and has the words vorn, hinten",
        "the runs of column `Lauf` are uncertain",
    ] {
        assert!(notes.contains(words), "{notes}");
    }
    let (data, notes) = notes_of(&desk, "mapped.csv", &table, "--direction z --map pose=Ort");
    assert!(
        !notes.contains("uncertain") && !notes.contains("not used"),
        "{notes}"
    );
    assert_eq!(data["poses"], serde_json::json!(["vorn", "hinten"]));
    let (data, _) = notes_of(
        &desk,
        "pos.csv",
        &table.replace("Ort", "Pos"),
        "--direction z",
    );
    assert_eq!(data["poses"], serde_json::json!(["vorn", "hinten"]));
}

#[test]
fn weights_are_no_step_of_a_display() {
    let desk = desk();
    let mut table = "mass [kg];travel [um]\n".to_owned();
    // 0.37 N/um, and a scatter of a tenth of a micrometre.
    for run in 0..5_u32 {
        for weight in 0..6_u32 {
            let noise = f64::from((run * 7 + weight * 3) % 5) * 0.05;
            let travel = f64::from(weight) * 9.80665 / 0.37 + noise;
            writeln!(table, "{weight};{travel:.2}").unwrap();
        }
    }
    desk.write("weights.csv", &table);
    desk.run("import weights.csv --out w --direction y --map force=1,displacement=2 --units kg,um")
        .succeeds();
    let ran = desk.run("stiffness w --json").succeeds();
    assert!(
        !ran.stdout.contains("whole multiples of 9.8"),
        "{}",
        ran.stdout
    );
    let data: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    let text = data["data"].to_string();
    assert!(text.contains("P1"), "{text}");
    let printed = desk.run("stiffness w").succeeds().stdout;
    assert!(printed.contains("0.370"), "{printed}");
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
fn a_date_and_a_time_with_a_blank_between_them_are_one_field_between_tabs() {
    for stamp in ["24.11.2026 10:00:0", "2026-11-24 10:00:0"] {
        let desk = desk();
        let mut table = "Zeit\tKraftaufnehmer (N)\tMessuhr (mm)\n".to_owned();
        for (second, load) in [0, 10, 20, 30, 0, 10, 20, 30].iter().enumerate() {
            writeln!(table, "{stamp}{second},250\t{load},05\t0,{:03}", load * 3).unwrap();
        }
        desk.write("t.txt", &table);
        desk.run("import t.txt --out t --direction x").succeeds();
        assert_eq!(desk.read("t/readings.csv").lines().count(), 9);
    }
}

#[test]
fn a_column_is_mapped_once() {
    let desk = desk_with_files();
    desk.refusal(
        "import two-columns.csv --out s --direction y --map force=1,force=2",
        2,
        "stiffbench::usage::argument",
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
    assert!(page.contains("raw/two-columns.csv"));
    assert!(page.contains("imported by") && !page.contains("recorded by"));
}
