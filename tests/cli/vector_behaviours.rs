//! What one gauge along the load and several gauges along the base axes have in common: earlier sessions, several sessions, threads, and axes that are turned.

use std::fmt::Write;

use serde_json::Value;

use super::{Desk, assert_output_contains, desk};
use crate::support::tables::Table;
use crate::support::{Contains, Json};

/// One pose, three gauges or one.
const SHORT: &str = "--mechanism A --poses P1 --directions x,z --loads-n=0,-20,-40,-60 --repeats 4";

const THREE: &str = "--displacement-axes x,y,z";

/// The readings of one gauge along the load, written as vectors.
fn as_vectors(table: &str) -> String {
    let mut text = String::from(
        "seq,t_s,pose,direction,branch,step,target_N,repeat,run,zero_id,axes,force_x_N,force_y_N,force_z_N",
    );
    for axis in ["x", "y", "z"] {
        write!(text, ",displacement_{axis}_um").unwrap();
    }
    text += ",hold_s,temp_degC,status\n";
    let table = Table::parse(table);
    for row in 0..table.len() {
        let of = |name: &str| table.word(row, name);
        let run = format!("{}.{}.{}", of("pose"), of("direction"), of("repeat"));
        let before = "seq t_s pose direction branch step target_N repeat".split(' ');
        let mut cells: Vec<&str> = before.map(of).collect();
        cells.extend([run.as_str(), run.as_str(), "base"]);
        for (name, other) in [("force_N", "0"), ("displacement_um", "")] {
            cells.extend(["x", "y", "z"].map(|axis| {
                let along = axis == of("direction");
                if along { of(name) } else { other }
            }));
        }
        cells.extend(["hold_s", "temp_degC", "status"].map(of));
        text += &cells.join(",");
        text.push('\n');
    }
    text
}

/// The free parameters of a fit that have a standard error: name, value, standard error.
fn free(data: &Value) -> Vec<(String, f64, f64)> {
    let parameters = data["parameters"].list().iter();
    parameters
        .filter(|one| one["status"] == "free")
        .filter_map(|one| {
            let name = one["name"].word().to_owned();
            Some((name, one["value"].as_f64()?, one["se"].as_f64()?))
        })
        .collect()
}

#[test]
fn earlier_sessions_of_three_gauges_contribute_to_the_noise() {
    let desk = desk();
    let simulate = |name: &str, options: &str| {
        desk.run(&format!("simulate {name} {SHORT} {THREE} {options}"))
            .succeeds();
    };
    simulate("now", "--seed 1");
    simulate("before", "--seed 2");
    simulate("worn", "--seed 3 --run-slope-sd 0.03");
    let alone = desk.data("diagnose now --no-figures");
    let object = desk
        .run("diagnose now --earlier before --earlier worn --no-figures --json")
        .succeeds()
        .json();
    let noise = &object["data"]["noise"];
    assert_eq!(noise["source"], "earlier-sessions");
    let used: Vec<&Value> = noise["earlier"]
        .list()
        .iter()
        .map(|one| &one["used"])
        .collect();
    assert_eq!(used, [true, false]);
    let dof = |noise: &Value, of: &str| noise[of]["dof"].number();
    for of in ["reading_sd", "run_slope_sd"] {
        let sum = dof(&alone["noise"], of) + dof(&noise["earlier"][0], of);
        assert!((dof(noise, of) / sum - 1.0).abs() < 0.2, "{of}: {noise}");
    }
    let warnings = object["warnings"].to_string();
    warnings.must_contain(&["simulated-3 has a different scatter than this session"]);
}

#[test]
fn written_as_vectors_sessions_of_one_gauge_and_earlier_ones_get_the_same_answer() {
    let desk = desk();
    for (name, options) in [
        ("now", "--seed 1"),
        ("before", "--seed 2"),
        ("worn", "--seed 3 --run-slope-sd 0.05"),
    ] {
        desk.run(&format!("simulate {name} {SHORT} {options}"))
            .succeeds();
        let table = desk.read(&format!("{name}/readings.csv"));
        // Bare tables both: a session folder states the steps of its gauges, a table does not.
        desk.write(&format!("one/{name}.csv"), &table);
        desk.write(&format!("vectors/{name}.csv"), &as_vectors(&table));
    }
    for earlier in [false, true] {
        let diagnosis = |folder: &str| {
            let mut run = format!(
                "diagnose {folder}/now.csv --robot hp-robot --mechanism A --no-figures --out {folder}/out"
            );
            if earlier {
                write!(
                    run,
                    " --earlier {folder}/before.csv --earlier {folder}/worn.csv"
                )
                .unwrap();
            }
            let text = desk.data(&run).to_string();
            text.replace(&format!("{folder}/"), "")
        };
        let one = diagnosis("one");
        assert_eq!(one.contains("earlier-sessions"), earlier);
        assert_eq!(diagnosis("vectors"), one);
    }
}

/// Two sessions of three gauges and one of a single gauge, which scatters more.
fn sessions() -> Desk {
    let desk = desk();
    let noisy = "--reading-sd-um 8 --displacement-step-um 2";
    for (name, options) in [
        ("first", format!("--poses P1 {THREE} --seed 1")),
        ("second", format!("--poses P1 {THREE} --seed 2 {noisy}")),
        ("single", format!("--poses P1,P2 --seed 3 {noisy}")),
    ] {
        desk.run(&format!(
            "simulate {name} --mechanism A --repeats 4 {options}"
        ))
        .succeeds();
    }
    desk
}

#[test]
fn sessions_of_three_gauges_and_of_one_go_together_each_with_its_noise() {
    let desk = sessions();
    for pair in ["first second", "first single", "single first"] {
        let data = desk.data(&format!("diagnose {pair} --no-figures"));
        assert_eq!(data["verdict"], "nothing-missing", "{pair}");
        let sessions = data["sessions"].list();
        assert_eq!(sessions.len(), 2);
        for (name, one) in pair.split(' ').zip(sessions) {
            assert_eq!(one["data"], name);
            let sd = one["reading_sd_um"].number();
            let expected = if name == "first" { 2.4..4.2 } else { 6.0..10.5 };
            assert!(expected.contains(&sd), "{name}: {sd}");
            let readings = if name == "single" { 216 } else { 324 };
            assert_eq!(one["readings"], readings, "{name}");
        }
    }
    let across = &desk.data("fit first second")["across"];
    let named = [0, 6].map(|place| across[place]["session"].word());
    assert_eq!(named, ["simulated-1", "simulated-2"], "{across}");
    let [first, single, both, other] =
        ["first", "single", "first single", "single first"].map(|names| {
            let data = desk.data(&format!("fit {names}"));
            let of = |name: &str| {
                let all = free(&data).into_iter();
                all.filter(|one| one.0 == name)
                    .map(|one| (one.1, one.2))
                    .next()
                    .unwrap()
            };
            ["beam.A", "beam.Iy"].map(of)
        });
    for factor in 0..2 {
        let weight = |one: [(f64, f64); 2]| one[factor].1.powi(-2);
        let expected = (weight(first) + weight(single)).sqrt().recip();
        assert!((both[factor].1 / expected - 1.0).abs() < 0.1, "{both:?}");
        // Which comes first does not matter.
        assert!((both[factor].0 / other[factor].0 - 1.0).abs() < 1e-6);
    }
    let page = desk.run("fit first single").succeeds().stdout;
    page.must_contain(&[
        "Session simulated-1: 3 cells",
        "Session simulated-3: 6 cells",
        "simulated-3/P2",
        "| load | axis |",
    ]);
}

#[test]
fn a_bad_reading_of_one_of_three_gauges_stays_in_its_session() {
    let desk = sessions();
    let mut table = Table::parse(&desk.read("second/readings.csv"));
    table.change(3, "displacement_x_um", |read| read + 300.0);
    desk.write("second/readings.csv", &table.text());
    let data = desk.data("diagnose first second --no-figures --trust-csv");
    assert_eq!(data["verdict"], "nothing-missing");
    let found = data["data_findings"].list();
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0]["file"], "second");
    assert_eq!(found[0]["lines"][0], 5);
    assert_eq!(found[0]["place"]["reading"]["pose"], "simulated-2/P1");
    assert_eq!(found[0]["place"]["reading"]["direction"], "x");
    let bad = [0, 1].map(|session| data["sessions"][session]["bad_readings"].as_u64().unwrap());
    assert_eq!(bad, [0, 1]);
}

#[test]
fn three_gauges_give_the_same_bytes_on_any_number_of_threads() {
    let desk = sessions();
    let written = |threads: &str| {
        let run = |arguments: &str| {
            let mut command = desk.command(arguments);
            let ran = super::Ran::of(command.env("RAYON_NUM_THREADS", threads));
            ran.succeeds().stdout
        };
        let mut all: Vec<String> = ["first", "first single"]
            .iter()
            .flat_map(|data| {
                [
                    run(&format!("diagnose {data} --no-figures --out found --json")),
                    run(&format!("fit {data} --json")),
                ]
            })
            .collect();
        all.extend(
            ["verdict.txt", "diagnosis.json"].map(|file| desk.read(&format!("found/{file}"))),
        );
        all.push(run("report first --out page.html --json"));
        all.push(desk.read("page.html"));
        std::fs::remove_file(desk.path("page.html")).unwrap();
        all
    };
    let [one, two] = ["1", "2"].map(written);
    for (place, (one, two)) in one.iter().zip(&two).enumerate() {
        assert!(one == two, "output {place} depends on the threads");
    }
}

/// For each axis the one that its components come from, and their sign.
type Turn = [(&'static str, &'static str); 3];

/// Components in turned axes come from these, with a sign: x to y to z to x, and a quarter turn about z.
#[rustfmt::skip]
const TURNED: [(&str, &str, Turn); 2] = [
    ("turn_deg = [90, 0, 90]", "at_mm = [250, 0, 0]", [("z", ""), ("x", ""), ("y", "")]),
    ("turn_deg = [0, 0, 90]", "at_mm = [0, 0, 250]", [("y", "-"), ("x", ""), ("z", "")]),
];

/// A table whose vectors stand in turned axes.
fn turned(table: &str, from: Turn) -> String {
    let head = table.lines().next().unwrap();
    let table = Table::parse(table);
    let named = |row: usize, name: &str| -> String {
        for quantity in ["force_", "displacement_"] {
            for (axis, (source, sign)) in ["x", "y", "z"].into_iter().zip(from) {
                let Some(rest) = name.strip_prefix(&format!("{quantity}{axis}_")) else {
                    continue;
                };
                let value = table.word(row, &format!("{quantity}{source}_{rest}"));
                return match value.parse::<f64>() {
                    Ok(value) if sign == "-" => (-value).to_string(),
                    _ => value.to_owned(),
                };
            }
        }
        if name != "direction" {
            return table.word(row, name).to_owned();
        }
        let direction = table.word(row, name);
        let place = from.iter().position(|(source, _)| *source == direction);
        let place = place.unwrap();
        format!("{}{}", from[place].1, ["x", "y", "z"][place])
    };
    let mut text = format!("{head}\n");
    for row in 0..table.len() {
        let cells: Vec<String> = head.split(',').map(|name| named(row, name)).collect();
        text += &cells.join(",");
        text.push('\n');
    }
    text
}

#[test]
fn turned_with_their_robot_forces_and_displacements_give_the_same_springs() {
    let desk = desk();
    desk.run("robot new arm.toml --template serial").succeeds();
    let arm = desk.read("arm.toml");
    desk.run("simulate cases --robot arm.toml --load-cases 20 --loads-n 300 --seed 6")
        .succeeds();
    let three = format!(
        "--robot arm.toml {THREE} --directions x,y --loads-n=0,-20,-40 --repeats 3 --poses P2,P3,P4 --true-factor joint.J2=3e-6"
    );
    desk.run(&format!("simulate exact {three} --noise-free"))
        .succeeds();
    desk.run(&format!("simulate noisy {three} --seed 5"))
        .succeeds();
    for (name, within) in [("cases", 1e-9), ("exact", 1e-9), ("noisy", 0.2)] {
        let fix = if name == "cases" {
            ""
        } else {
            "--parameter joint.J6=fixed"
        };
        let table = desk.read(&format!("{name}/readings.csv"));
        desk.write("table.csv", &table);
        let expected = free(&desk.data(&format!("fit table.csv --robot arm.toml {fix}")));
        assert!(expected.len() >= 4, "{expected:?}");
        for (turn, at, from) in TURNED {
            let robot = arm.replacen("at_mm = [0, 0, 250]", &format!("{at}, {turn}"), 1);
            desk.write("turned.toml", &robot);
            desk.write("turned.csv", &turned(&table, from));
            let found = free(&desk.data(&format!("fit turned.csv --robot turned.toml {fix}")));
            assert_eq!(found.len(), expected.len());
            for (one, other) in found.iter().zip(&expected) {
                assert_eq!(one.0, other.0);
                // With noise the logarithm of a stiffness along a positive axis and a compliance along a negative one weigh it otherwise: in standard errors.
                let size = if name == "noisy" { other.2 } else { other.1 };
                let off = (one.1 - other.1).abs() / size;
                assert!(off < within, "{name}, {turn}: {one:?} for {other:?}");
            }
        }
    }
}

/// Two joints about z in a plane, 1 m and 0.5 m.
const PLANAR: &str = "schema = \"stiffbench/robot/2\"\nname = \"planar arm\"\nup = \"z\"\n[joints]\n\
    J1 = { axis = \"z\", min_deg = -180, max_deg = 180, spring = \"free\", stiffness_Nm_per_rad = 4e5 }\n\
    J2 = { at_mm = [1000, 0, 0], axis = \"z\", min_deg = -180, max_deg = 180, spring = \"free\", stiffness_Nm_per_rad = 2e5 }\n\
    [tool]\nat_mm = [500, 0, 0]\n[poses]\nP1_deg = [0, 90]\n";

/// Its load cases in some axes, by hand: forces and a moment, displacements and a rotation.
fn planar_cases(axes: &str, compliances: [f64; 2]) -> String {
    let mut text = String::from(
        "pose,joint_J1_deg,joint_J2_deg,repeat,axes,force_x_N,force_y_N,moment_z_Nm,displacement_x_um,displacement_y_um,rotation_z_urad\n",
    );
    let mut case = 0;
    for (first, second) in [(10.0, 40.0), (-30.0, 70.0), (50.0, -60.0), (80.0, 20.0)] {
        let q2 = f64::to_radians(second);
        // Motion of the end per unit rotation of each joint, in the axes of the tool.
        let motions = [[q2.sin(), 0.5 + q2.cos(), 1.0], [0.0, 0.5, 1.0]];
        let angle = match axes {
            "base" => first + second,
            "J1" => second,
            _ => 0.0,
        };
        let (sine, cosine) = f64::to_radians(angle).sin_cos();
        let stand = |x: f64, y: f64| (cosine * x - sine * y, sine * x + cosine * y);
        for load in [[60.0, -40.0, 0.0], [0.0, 0.0, 25.0], [-30.0, 80.0, 10.0]] {
            case += 1;
            let mut moved = [0.0; 3];
            for (motion, compliance) in motions.iter().zip(compliances) {
                let work: f64 = motion.iter().zip(load).map(|(s, w)| s * w).sum();
                for (part, s) in moved.iter_mut().zip(motion) {
                    *part += 1e6 * compliance * s * work;
                }
            }
            let (fx, fy) = stand(load[0], load[1]);
            let (dx, dy) = stand(moved[0], moved[1]);
            for (repeat, sign) in [(1, -1.0), (2, 1.0)] {
                let error = sign * (1.0 + 0.3 * f64::from(case) % 0.7);
                writeln!(
                    text,
                    "{first}.{second},{first},{second},{repeat},{axes},{fx},{fy},{},{},{},{}",
                    load[2],
                    dx + error,
                    dy - error,
                    moved[2] + error
                )
                .unwrap();
            }
        }
    }
    text
}

#[test]
fn load_cases_stand_in_any_axes_with_moments_and_rotations() {
    let desk = desk();
    desk.write("planar.toml", PLANAR);
    for axes in ["base", "tool", "J1"] {
        desk.write("cases.csv", &planar_cases(axes, [3e-6, 7e-6]));
        let data = desk.data("fit cases.csv --robot planar.toml");
        let springs = free(&data);
        assert_eq!(springs.len(), 2);
        for (spring, expected) in springs.iter().zip([3e-6, 7e-6]) {
            assert!(
                (spring.1 / expected - 1.0).abs() < 1e-6,
                "{axes}: {spring:?}"
            );
        }
        // Two displacements and a rotation of each row.
        assert_eq!(data["components"].list().len(), 72);
        let found = desk.data("diagnose cases.csv --robot planar.toml --no-figures");
        assert_eq!(found["verdict"], "nothing-missing", "{axes}");
    }
}

#[test]
fn readings_of_several_gauges_stand_in_base_axes_only() {
    let desk = desk();
    desk.run(&format!("simulate s {SHORT} {THREE} --seed 1"))
        .succeeds();
    let table = desk.read("s/readings.csv").replace(",base,", ",tool,");
    desk.write("tool.csv", &table);
    for command in ["fit", "diagnose"] {
        let run = format!("{command} tool.csv --robot hp-robot --mechanism A");
        let error = desk.refusal(&run, 11, "stiffbench::readings::bad_value");
        assert_output_contains(&error, &["line 2", "`axes`", "`tool`", "`base`"]);
    }
    // A moment that is left out in silence would be a load that never was.
    let with_moments = |moments: [&str; 2]| {
        let table = desk.read("s/readings.csv");
        let lines = table.lines().enumerate().map(|(line, text)| match line {
            0 => format!("{text},moment_x_Nm\n"),
            _ => format!("{text},{}\n", moments[usize::from(line == 3)]),
        });
        desk.write("moments.csv", &lines.collect::<String>());
    };
    let run = "stiffness moments.csv";
    with_moments(["0", "0.0"]);
    desk.run(run).succeeds();
    with_moments(["", "12"]);
    let error = desk.refusal(run, 11, "stiffbench::readings::bad_value");
    assert_output_contains(&error, &["line 4", "`moment_x_Nm`", "table of load cases"]);
}
