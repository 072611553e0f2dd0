//! Absolute positions under own weight through the commands: simulated, fitted, and what is refused with its place.

use super::{Desk, assert_output_contains, desk};
use stiffbench_test_files::text;

const SPRINGS: &str =
    "joint.J1=1.2e-6,joint.J2=8e-7,joint.J3=1.1e-6,joint.J4=3e-6,joint.J5=3.5e-6,joint.J6=6e-6";

/// A desk with the robot `arm.toml`, its masses known.
fn arm() -> Desk {
    let desk = desk();
    desk.write("arm.toml", text("fixtures/elastic-calibration/arm.toml"));
    desk
}

fn simulate(folder: &str, more: &str) -> String {
    format!(
        "simulate {folder} --robot arm.toml --positions 40 --true-factor {SPRINGS} --reading-sd-um 20 --seed 5 {more}"
    )
}

/// The parameters of a fit that are called so.
fn parameter<'j>(list: &'j serde_json::Value, name: &str) -> &'j serde_json::Value {
    let mut parameters = list.as_array().unwrap().iter();
    parameters.find(|one| one["name"] == name).unwrap()
}

#[test]
fn simulated_positions_give_springs_and_frames_back_and_the_same_bytes() {
    let desk = arm();
    let made = desk.data(&simulate("a", ""));
    assert_eq!(made["readings"], 120);
    assert_eq!(made["procedure"], "positions");
    desk.data(&simulate("b", ""));
    assert_eq!(desk.read("a/readings.csv"), desk.read("b/readings.csv"));
    let head = desk.read("a/readings.csv");
    let head = head.lines().next().unwrap();
    assert!(
        head.contains("joint_second_deg") && head.contains("position_x_mm"),
        "{head}"
    );
    assert!(!head.contains("force"), "{head}");
    assert!(desk.read("a/session.toml").contains("stiffbench/session/2"));
    assert!(desk.read("a/simulation.toml").contains("[tracker]"));

    let fit = desk.data("fit a");
    assert_eq!(
        parameter(&fit["parameters"], "joint.J1")["status"],
        "not_identified"
    );
    for (joint, compliance) in SPRINGS
        .split(',')
        .skip(1)
        .map(|one| one.split_once('=').unwrap())
    {
        let one = parameter(&fit["parameters"], joint);
        let truth: f64 = compliance.parse().unwrap();
        let off = (one["value"].as_f64().unwrap() - truth) / one["se"].as_f64().unwrap();
        assert!(off.abs() < 4.5, "{joint}: {off} standard errors");
    }
    for (name, place) in [("base", "base_mm"), ("tool", "tool_point_mm")] {
        for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
            let key = match name {
                "base" => format!("base_frame.{letter}"),
                _ => format!("tool_point.{letter}"),
            };
            let error = &parameter(&fit["frames"]["parameters"], &key)["se"];
            let [found, truth] =
                [&fit["frames"], &made["tracker"]].map(|of| of[place][axis].as_f64().unwrap());
            let off = 1e3 * (found - truth) / error.as_f64().unwrap();
            assert!(off.abs() < 4.5, "{key}: {off} standard errors");
        }
    }
    let rms = |key: &str| fit["rms"][key].as_f64().unwrap();
    assert!(rms("rigid_um") > 10.0 * rms("unseen_um"));
    assert_eq!(fit["rms"]["rigid_um"], fit["rms"]["before_um"]);
    let page = desk.run("fit a").succeeds().stdout;
    for words in [
        "base_frame.rx",
        "tool_point.z",
        "Rigid: the robot without what is fitted, with base frame and tool point of its own",
        "In poses left out",
        "joint.J1: own weight does not load it",
        "100 N along",
    ] {
        assert!(page.contains(words), "`{words}` is not in {page}");
    }
    assert!(!page.contains("No force at the tool centre"), "{page}");
}

#[test]
fn a_wrong_coordinate_is_named_with_its_line() {
    let desk = arm();
    let warned = |folder: &str| -> Vec<String> {
        let object = desk.run(&format!("fit {folder} --robot arm.toml --json"));
        let object = object.succeeds().json();
        let warnings = object["warnings"].as_array().unwrap().iter();
        let warnings = warnings.map(|one| one.as_str().unwrap().to_owned());
        warnings.filter(|one| one.contains("bad value")).collect()
    };
    for (seed, wrong_mm) in (10..20).zip([100.0, -5.0].into_iter().cycle()) {
        let folder = format!("good-{seed}");
        desk.data(&simulate(&folder, "").replace("--seed 5", &format!("--seed {seed}")));
        let table = format!("{folder}/readings.csv");
        let good = desk.read(&table);
        assert!(warned(&table).is_empty(), "{seed}");
        let mut lines: Vec<String> = good.lines().map(str::to_owned).collect();
        let head: Vec<&str> = good.lines().next().unwrap().split(',').collect();
        let column = head.iter().position(|name| *name == "position_z_mm");
        let column = column.unwrap();
        let line = 3 + 3 * (seed as usize - 10);
        let mut cells: Vec<String> = lines[line - 1].split(',').map(str::to_owned).collect();
        let right: f64 = cells[column].parse().unwrap();
        cells[column] = format!("{:.3}", right + wrong_mm);
        lines[line - 1] = cells.join(",");
        desk.write("bad.csv", &(lines.join("\n") + "\n"));
        let found = warned("bad.csv");
        let [one] = &found[..] else {
            panic!("{seed}: {found:?}");
        };
        let begins = format!("line {line}, pose {}: position z is ", cells[0]);
        assert!(one.starts_with(&begins), "{seed}: {one}");
        let expected = one.split("lets expect ").nth(1).unwrap();
        let expected: f64 = expected.split(' ').next().unwrap().parse().unwrap();
        // Four digits, and what the wrong coordinate drew the fit to.
        let allowed = 5e-4 * expected.abs() + 0.03 * 1e3 * f64::abs(wrong_mm);
        assert!((expected - 1e3 * right).abs() < allowed, "{seed}: {one}");
    }
}

#[test]
fn forces_beside_positions_load_what_weight_does_not() {
    let desk = arm();
    desk.run(&simulate("pulled", "--loads-n 400 --repeats 2"))
        .succeeds();
    let fit = desk.data("fit pulled");
    let first = parameter(&fit["parameters"], "joint.J1");
    let off = (first["value"].as_f64().unwrap() - 1.2e-6) / first["se"].as_f64().unwrap();
    assert!(off.abs() < 4.5, "{off}");
    assert_eq!(fit["agreement"]["scatter_from"], "repeats");
    let sd = fit["agreement"]["displacement_sd_um"].as_f64().unwrap();
    assert!((15.0..25.0).contains(&sd), "{sd}");
}

#[test]
fn positions_without_weight_or_beside_something_else_are_refused() {
    let desk = arm();
    let robot = text("fixtures/elastic-calibration/arm.toml");
    let (head, rest) = robot.split_once("[masses]").unwrap();
    let (_, poses) = rest.split_once("[poses]").unwrap();
    let payload = head
        .lines()
        .filter(|line| !line.starts_with("payload"))
        .fold(String::new(), |text, line| text + line + "\n");
    desk.write("light.toml", &format!("{payload}[poses]{poses}"));
    let error = desk.refusal(
        "simulate light --robot light.toml --positions 5",
        10,
        "stiffbench::bench::no_weight",
    );
    assert_output_contains(&error, &["arm with a second arm", "[masses]", "--loads-n"]);
    let error = desk.refusal(
        &simulate("no", "--directions x"),
        2,
        "stiffbench::usage::argument",
    );
    assert_output_contains(&error, &["--directions", "leave out --positions"]);
    for more in [
        "--load-cases 3",
        "--keep-history",
        "--loads-n 0",
        "--repeats 0",
    ] {
        desk.run(&simulate("no", more)).exits_with(2);
        assert!(!desk.path("no").exists(), "{more}");
    }
    desk.run(&simulate("made", "")).succeeds();
    for command in ["fit made --next next.csv", "diagnose made"] {
        desk.run(command).exits_with(2);
    }
    assert!(!desk.path("next.csv").exists());
}

#[test]
fn tables_of_positions_that_cannot_be_fitted_are_refused_with_their_place() {
    let desk = arm();
    let joints = "joint_J1_deg,joint_J2_deg,joint_J3_deg,joint_J4_deg,joint_J5_deg,joint_J6_deg,joint_second_deg";
    let head = format!("{joints},position_x_mm,position_y_mm,position_z_mm\n");
    desk.write(
        "few.csv",
        &format!("{head}0,0,0,0,0,0,0,1,2,3\n10,0,0,0,0,0,0,2,,3\n20,0,0,0,0,0,0,2,3,4\n"),
    );
    let error = desk.refusal(
        "fit few.csv --robot arm.toml --free joint.J2",
        40,
        "stiffbench::load_cases::too_few_positions",
    );
    assert_output_contains(&error, &["2 poses", "4 are needed"]);
    desk.write(
        "both.csv",
        &format!("{joints},position_x_mm,displacement_x_um\n0,0,0,0,0,0,0,1,2\n"),
    );
    let error = desk.refusal(
        "fit both.csv --robot arm.toml",
        11,
        "stiffbench::load_cases::positions_and_displacements",
    );
    assert_output_contains(&error, &["position_x_mm", "displacement_x_um"]);
    desk.write(
        "word.csv",
        &format!("{head}0,0,0,0,0,0,0,1,2,3\n0,0,0,0,0,0,0,1,two,3\n"),
    );
    let error = desk.refusal(
        "fit word.csv --robot arm.toml",
        11,
        "stiffbench::readings::bad_value",
    );
    assert_output_contains(&error, &["line 3", "two"]);
}
