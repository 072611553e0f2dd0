//! Six robots of different shape through the commands: what is printed is what programs get, intervals hold their estimates, extremes are
//! extreme, and every result names its robot and its data.

use serde_json::Value;

use super::{Desk, desk};
use crate::support::{Contains, Json};

/// Robots with a pose of theirs: shipped, or in `fixtures/robots`. The end of the SCARA keeps its height, that of the four-bar follows a curve.
const ROBOTS: [(&str, &str); 6] = [
    ("hp-robot", "P1"),
    ("hp-robot-host-dominant", "P2"),
    ("serial-arm", "P1"),
    ("scara", "P1"),
    ("four-bar", "P2"),
    ("six-axis", "P3"),
];

/// A robot's name for `--robot`; one of the fixtures is put on the desk.
fn robot_on(desk: &Desk, name: &str) -> String {
    let fixture = format!("{}/fixtures/robots/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    match std::fs::read_to_string(fixture) {
        Ok(text) => {
            desk.write(&format!("{name}.toml"), &text);
            format!("{name}.toml")
        }
        Err(_) => name.to_owned(),
    }
}

/// The object that a command prints with `--json`: valid, without a word for a number that is none, and naming what it was made of.
fn object(desk: &Desk, arguments: &str) -> Value {
    let object = desk.run(&format!("{arguments} --json")).succeeds().json();
    assert_eq!(object["ok"], true, "{arguments}");
    let kind = object["kind"].word();
    assert!(
        object["schema"]
            .word()
            .starts_with(&format!("stiffbench/{kind}/")),
        "{arguments}"
    );
    let inputs = &object["inputs"];
    let named = inputs["robot"]["name"].is_string() || inputs["data"][0]["name"].is_string();
    assert!(named, "{arguments}: {inputs}");
    object
}

/// Whether a printed number is another one, rounded to its last digit that is not a filling zero.
fn is_rounded(printed: &str, exact: f64) -> bool {
    // A stiffness in doubt is marked.
    let printed = printed.trim_end_matches(" ?");
    let decimals = printed.split_once('.').map(|(_, decimals)| decimals.len());
    let zeros = printed.len() - printed.trim_end_matches('0').len();
    let place = decimals.map_or(zeros as i32, |decimals| -(decimals as i32));
    let value: f64 = printed.parse().unwrap();
    (value - exact).abs() <= 0.5 * 10_f64.powi(place) * (1.0 + 1e-9)
}

#[test]
fn six_robots_go_through_every_command() {
    for (seed, (name, pose)) in ROBOTS.into_iter().enumerate() {
        let desk = desk();
        let robot = robot_on(&desk, name);
        for arguments in [
            format!("robot show {robot}"),
            format!("robot check {robot}"),
            format!("robot show --mobility {robot}"),
            format!("robot compliance {robot} --pose {pose} --figures drawn"),
            format!("robot significance {robot} --pose {pose} --beams-only"),
            format!("simulate s --robot {robot} --seed {seed}"),
            "stiffness s --figures drawn".to_owned(),
            "compare s s".to_owned(),
            "diagnose s --no-figures".to_owned(),
        ] {
            object(&desk, &arguments);
        }
        stiffness_is_the_same_for_people_and_programs(&desk);
        estimates_lie_inside_their_intervals_and_these_inside_the_bounds(&desk);
        figures_show_the_numbers_of_the_fit(&desk);
        refined_extremes_are_extreme(&desk, &robot);
        let refused = desk.run(&format!("robot compliance {robot} --pose NOWHERE --json"));
        let refused = refused.exits_with(10).json();
        assert_eq!(refused["ok"], false);
        assert!(refused["error"]["message"].is_string() && refused["warnings"].is_array());
    }
}

fn stiffness_is_the_same_for_people_and_programs(desk: &Desk) {
    let text = desk.run("stiffness s").succeeds().stdout;
    let data = desk.data("stiffness s");
    let rows: Vec<Vec<&str>> = text
        .lines()
        .map(|line| line.split('|').map(str::trim).collect())
        .filter(|cells: &Vec<&str>| cells.len() > 10 && cells[3].parse::<u32>().is_ok())
        .collect();
    let cells = data["cells"].list();
    assert_eq!(rows.len(), cells.len(), "{text}");
    for (row, cell) in rows.iter().zip(cells) {
        assert_eq!(row[1], cell["pose"].word());
        let regression = &cell["stiffness_regression"];
        for (column, key) in [(4, "value"), (5, "U"), (6, "k")] {
            let exact = regression[key].number();
            assert!(
                is_rounded(row[column], exact),
                "{} is not {exact}",
                row[column]
            );
        }
    }
}

fn estimates_lie_inside_their_intervals_and_these_inside_the_bounds(desk: &Desk) {
    let fit = object(desk, "fit s");
    for (name, factor) in fit["data"]["factors"]["beam"].as_object().unwrap() {
        let [value, start] = ["value", "start"].map(|key| factor[key].number());
        let within = |bounds: [f64; 2]| (bounds[0]..=bounds[1]).contains(&value);
        assert!(within([0.0999 * start, 10.001 * start]), "{name}: {factor}");
        let interval = |ends: &Value| [0, 1].map(|end| ends[end].number());
        if factor["ci95"].is_array() {
            let ends = interval(&factor["ci95"]);
            assert!(within(ends), "{name}: {factor}");
            assert!(
                ends[0] >= 0.0999 * start && ends[1] <= 10.001 * start,
                "{name}: {factor}"
            );
        }
        let islands = factor["islands"].list();
        if !islands.is_empty() {
            assert!(islands.len() > 1, "{name}: {factor}");
            assert!(
                islands.iter().any(|island| within(interval(island))),
                "{name}: {factor}"
            );
        }
    }
}

fn figures_show_the_numbers_of_the_fit(desk: &Desk) {
    let fit = object(desk, "fit s --figures figures");
    let cells = fit["data"]["cells"].list();
    let measured: Vec<f64> = cells
        .iter()
        .map(|cell| cell["measured"]["value"].number())
        .collect();
    // The lower panel shows how a cell is predicted by the others, where it is.
    let ratios: Vec<f64> = cells
        .iter()
        .zip(&measured)
        .map(|(cell, measured)| {
            let judged = cell["predicted_without_its_pose"]["value"].as_f64();
            judged.map_or(cell["ratio_percent"].number(), |k| 100.0 * k / measured)
        })
        .collect();
    let panels = super::drawn::panels(&desk.read("figures/stiffness.svg"));
    let [upper, lower] = &panels[..] else {
        panic!("{panels:?}");
    };
    upper.assert_shows(&measured, f64::ln);
    lower.assert_shows(&ratios, |percent| percent);
}

fn refined_extremes_are_extreme(desk: &Desk, robot: &str) {
    let map = object(
        desk,
        &format!("robot map {robot} --samples 200 --out map --figures map/figures"),
    );
    for mechanism in map["data"]["mechanisms"].list() {
        for column in mechanism["stiffness"].list() {
            let value = |which: &str, how: &str| column[which][how]["value"]["value"].as_f64();
            for (which, sign) in [("smallest", -1.0), ("largest", 1.0)] {
                let (Some(sampled), Some(refined)) =
                    (value(which, "sampled"), value(which, "refined"))
                else {
                    continue;
                };
                assert!(
                    sign * refined >= sign * sampled - 1e-9 * sampled,
                    "{robot}, {}: {which} {sampled}, refined {refined}",
                    column["along"]
                );
            }
        }
    }
}

/// From three runs on, where each cell stands for itself: of fewer the uncertainty is that of all cells together.
#[test]
fn more_runs_give_smaller_uncertainties_on_average() {
    let desk = desk();
    let mut shares = Vec::new();
    for repeats in [3, 5, 9] {
        desk.write(
            "plan.toml",
            &format!("schema = \"stiffbench/procedure/1\"\nname = \"plan\"\nrepeats = {repeats}\n"),
        );
        desk.run(&format!(
            "simulate s{repeats} --procedure plan.toml --seed {repeats}"
        ))
        .succeeds();
        let data = desk.data(&format!("stiffness s{repeats}"));
        let cells = data["cells"].list();
        let share = |cell: &Value| {
            let found = &cell["stiffness_regression"];
            found["U"].number() / found["value"].number()
        };
        shares.push(cells.iter().map(share).sum::<f64>() / cells.len() as f64);
    }
    assert!(shares[0] > shares[1] && shares[1] > shares[2], "{shares:?}");
}

#[test]
fn a_robot_file_is_begun_checked_and_never_written_over() {
    let desk = desk();
    for template in ["serial", "scara", "four-bar", "parallelogram", "gantry"] {
        desk.run(&format!("robot new {template}.toml --template {template}"))
            .succeeds();
        let check = desk.data(&format!("robot check {template}.toml"));
        assert_eq!(check["findings"], serde_json::json!([]), "{template}");
        assert!(check["reach_m"].number() > 0.1, "{template}");
    }
    let before = desk.read("serial.toml");
    let again = desk.run("robot new serial.toml --template scara --json");
    let error = again.exits_with(13).json();
    assert_eq!(error["error"]["code"], "stiffbench::output::exists");
    assert_eq!(desk.read("serial.toml"), before);
    let urdf = format!("{}/fixtures/urdf/panda.urdf", env!("CARGO_MANIFEST_DIR"));
    let error = desk.run(&format!("robot new panda.toml --urdf {urdf} --json"));
    let message = error.exits_with(10).json()["error"]["message"].to_string();
    message.must_contain(&["the robot has 3 ends"]);
    assert!(!desk.path("panda.toml").exists());
    let made = desk.data(&format!(
        "robot new panda.toml --urdf {urdf} --tip panda_hand_tcp"
    ));
    assert_eq!(made["joints"].list().len(), 9);
    let check = desk.run("robot check panda.toml").succeeds().stdout;
    assert!(
        check.contains("joint.panda_joint7") && check.contains("rigid") && !check.contains("yes"),
        "{check}"
    );
    let checked = &desk.data("robot check panda.toml")["checked"][0];
    assert!(checked["plausible"].is_null(), "{checked}");
    desk.write("table.csv", crate::robot_new::TABLE);
    let table = "--dh table.csv --convention modified --check-position";
    let wrong = desk.run(&format!(
        "robot new fanuc.toml {table} 0,0,0,0,0,0=1,2,3 --json"
    ));
    let error = wrong.exits_with(2).json();
    error["error"]["message"].word().must_contain(&["mm away"]);
    assert!(!desk.path("fanuc.toml").exists());
    desk.run(&format!(
        "robot new fanuc.toml {table} 0,0,0,0,0,0=1807,0,1970"
    ))
    .succeeds();
    desk.run("robot new x.toml").exits_with(2);
}

#[test]
fn columns_of_a_table_of_load_cases_are_printed_and_read() {
    let desk = desk();
    let vectors = [
        "force_x_N",
        "force_y_N",
        "force_z_N",
        "displacement_x_um",
        "displacement_y_um",
        "displacement_z_um",
    ];
    let urdf = format!("{}/fixtures/urdf/panda.urdf", env!("CARGO_MANIFEST_DIR"));
    desk.run(&format!(
        "robot new panda.toml --urdf {urdf} --tip panda_hand_tcp"
    ))
    .succeeds();
    desk.run("robot new gantry.toml --template gantry")
        .succeeds();
    // Fingers do not move the tool centre, and sliding joints have a length.
    let panda: Vec<String> = (1..=7)
        .map(|joint| format!("joint_panda_joint{joint}_deg"))
        .collect();
    let gantry = ["joint_X_mm", "joint_Y_mm", "joint_Z_mm"].map(str::to_owned);
    for (robot, joints) in [("panda", panda), ("gantry", gantry.to_vec())] {
        let joints = joints.iter().map(String::as_str);
        let expected: Vec<&str> = ["pose"].into_iter().chain(joints).chain(vectors).collect();
        let check = desk.data(&format!("robot check {robot}.toml"));
        assert_eq!(check["load_case_columns"], serde_json::json!(expected));
        let line = expected.join(",");
        let page = desk
            .run(&format!("robot check {robot}.toml"))
            .succeeds()
            .stdout;
        let words = format!("Columns of a table of load cases for `fit`: {line}\n");
        assert!(page.contains(&words), "{page}");
        // A table with these columns is read.
        let row = |pose: &str, joint: &str| {
            let values = expected.iter().map(|column| match *column {
                "pose" => pose,
                _ if column.starts_with("joint_") => joint,
                _ => "50",
            });
            values.collect::<Vec<_>>().join(",")
        };
        let rows = [("a", "10"), ("b", "30"), ("c", "20"), ("d", "25")];
        let rows = rows.map(|(pose, joint)| row(pose, joint)).join("\n");
        desk.write("table.csv", &format!("{line}\n{rows}\n"));
        let spring = check["free_springs"][0].word();
        let fit = format!("fit table.csv --robot {robot}.toml --parameter {spring}=free --json");
        let fit = desk.run(&fit).succeeds().json();
        assert_eq!(fit["data"]["components"].list().len(), 12);
        assert!(!fit["warnings"].to_string().contains("no joint column"));
    }
}

#[test]
fn springs_that_the_robot_file_frees_are_found_without_an_option() {
    let desk = desk();
    desk.run("simulate arm --robot franka-panda --seed 3")
        .succeeds();
    let fit = desk.data("fit arm");
    let parameters = fit["parameters"].list();
    let of = |status: &str| -> Vec<&Value> {
        let all = parameters.iter();
        all.filter(|one| one["status"] == status).collect()
    };
    // All joints of the file have 7000 N m/rad. Six intervals of 95 % and a margin: the chance that a right program fails is
    // that of a normal value beyond 4 standard errors, six times: 4e-4, and the seed is fixed.
    let found = of("free");
    assert_eq!(found.len(), 6, "{parameters:?}");
    for joint in found {
        let [value, error] = ["value", "se"].map(|key| joint[key].number());
        assert!((value - 1.0 / 7000.0).abs() < 4.0 * error, "{joint}");
    }
    // The load at the flange does not turn the last joint.
    let kept = of("not_identified");
    assert_eq!(kept.len(), 1);
    assert_eq!(kept[0]["name"], "joint.panda_joint7");
    // What is named as free takes the place of what the file frees.
    let one = desk
        .data("fit arm --parameter joint.panda_joint2=free --parameter joint.panda_joint1=fixed");
    let free = one["parameters"].list().iter();
    assert_eq!(free.filter(|one| one["status"] == "free").count(), 1);

    let ran = desk.run("diagnose arm --no-figures --out d").succeeds();
    ran.stdout
        .must_contain(&["No missing physics was detected."]);
    ran.stderr.must_contain(&["joint.panda_joint7 is kept"]);
    let words: Vec<&str> = ran.stdout.split_whitespace().collect();
    let none = "the mechanism has no joint that these loads act on";
    assert!(!words.join(" ").contains(none), "{}", ran.stdout);
}
