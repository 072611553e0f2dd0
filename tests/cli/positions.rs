//! Absolute positions under own weight through the commands: simulated, fitted, and what is refused with its place.

use super::{Desk, assert_output_contains, desk, misuse, unwrapped};
use crate::support::tables::Table;
use crate::support::{Contains, Json};
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
    head.must_contain(&["joint_second_deg", "position_x_mm"]);
    assert!(!head.contains("force"), "{head}");
    desk.read("a/session.toml")
        .must_contain(&["stiffbench/session/2"]);
    desk.read("a/simulation.toml").must_contain(&["[tracker]"]);

    let fit = desk.data("fit a");
    assert_eq!(
        fit["parameters"].named("joint.J1")["status"],
        "not_identified"
    );
    for (joint, compliance) in SPRINGS
        .split(',')
        .skip(1)
        .map(|one| one.split_once('=').unwrap())
    {
        let one = fit["parameters"].named(joint);
        let truth: f64 = compliance.parse().unwrap();
        let off = (one["value"].number() - truth) / one["se"].number();
        assert!(off.abs() < 4.5, "{joint}: {off} standard errors");
    }
    for (name, place) in [("base", "base_mm"), ("tool", "tool_point_mm")] {
        for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
            let key = match name {
                "base" => format!("base_frame.{letter}"),
                _ => format!("tool_point.{letter}"),
            };
            let error = &fit["frames"]["parameters"].named(&key)["se"];
            let [found, truth] =
                [&fit["frames"], &made["tracker"]].map(|of| of[place][axis].number());
            let off = 1e3 * (found - truth) / error.number();
            assert!(off.abs() < 4.5, "{key}: {off} standard errors");
        }
    }
    let rms = |key: &str| fit["rms"][key].number();
    assert!(rms("rigid_um") > 10.0 * rms("unseen_um"));
    assert_eq!(fit["rms"]["rigid_um"], fit["rms"]["before_um"]);
    let page = unwrapped(&desk.run("fit a").succeeds().stdout);
    page.must_contain(&[
        "base_frame.rx",
        "tool_point.z",
        "Rigid: the robot without the fitted parameters, with its own base frame and tool point",
        "In poses left out",
        "joint.J1: the robot's own weight does not load it",
        "100 N along",
    ]);
    assert!(!page.contains("No force at the tool centre"), "{page}");
}

/// What a fit says of bad positions.
fn warned(desk: &Desk, table: &str) -> Vec<String> {
    let object = desk.run(&format!("fit {table} --robot arm.toml --json"));
    let object = object.succeeds().json();
    let warnings = object["warnings"].list().iter();
    let warnings = warnings.map(|one| one.word().to_owned());
    let found = warnings.filter(|one| one.contains("measure it again"));
    found.collect()
}

/// A table of 40 positions, in one line of which something was added to the values of some columns, with the line and its fields before.
fn with_mistake(desk: &Desk, seed: usize, added: &[(&str, f64)]) -> (usize, Vec<(String, String)>) {
    let folder = format!("good-{seed}");
    desk.data(&simulate(&folder, "").replace("--seed 5", &format!("--seed {seed}")));
    let table = format!("{folder}/readings.csv");
    let good = desk.read(&table);
    assert!(warned(desk, &table).is_empty(), "{seed}");
    let mut lines: Vec<String> = good.lines().map(str::to_owned).collect();
    let head: Vec<String> = lines[0].split(',').map(str::to_owned).collect();
    let line = 3 + 3 * (seed % 10);
    let mut cells: Vec<String> = lines[line - 1].split(',').map(str::to_owned).collect();
    let before = head.iter().cloned().zip(cells.clone()).collect();
    for (name, by) in added {
        let column = head.iter().position(|known| known == name).unwrap();
        let right: f64 = cells[column].parse().unwrap();
        cells[column] = format!("{:.3}", right + by);
    }
    lines[line - 1] = cells.join(",");
    desk.write("bad.csv", &(lines.join("\n") + "\n"));
    (line, before)
}

/// The numbers behind some words.
fn numbers_behind(text: &str, words: &str) -> Vec<f64> {
    let rest = text.split(words).nth(1).unwrap_or_default();
    let numbers = rest.split(|c: char| !(c.is_ascii_digit() || "-.,".contains(c)));
    let numbers = numbers.take_while(|one| !one.is_empty());
    let numbers = numbers.map(|one| one.trim_end_matches(',').parse().unwrap());
    numbers.collect()
}

#[test]
fn a_wrong_coordinate_is_named_with_its_line() {
    let desk = arm();
    for (seed, wrong_mm) in (10..20).zip([100.0, -5.0].into_iter().cycle()) {
        let (line, before) = with_mistake(&desk, seed, &[("position_z_mm", wrong_mm)]);
        let found = warned(&desk, "bad.csv");
        let [one] = &found[..] else {
            panic!("{seed}: {found:?}");
        };
        let begins = format!("line {line}, pose {}: position z is ", before[0].1);
        assert!(one.starts_with(&begins), "{seed}: {one}");
        let right = before.iter().find(|(name, _)| name == "position_z_mm");
        let right: f64 = right.unwrap().1.parse().unwrap();
        let expected = numbers_behind(one, "predicts ");
        // Five times the scatter of a coordinate.
        assert!((expected[0] - right).abs() < 0.1, "{seed}: {one}");
    }
}

#[test]
fn a_wrong_target_is_named_with_all_its_coordinates() {
    let desk = arm();
    let added = [
        ("position_x_mm", 12.0),
        ("position_y_mm", -3.0),
        ("position_z_mm", 5.0),
    ];
    for seed in 20..26 {
        let (line, before) = with_mistake(&desk, seed, &added);
        let found = warned(&desk, "bad.csv");
        let [one] = &found[..] else {
            panic!("{seed}: {found:?}");
        };
        let begins = format!("line {line}, pose {}: position x, y, z is ", before[0].1);
        assert!(one.starts_with(&begins), "{seed}: {one}");
        for (expected, (name, _)) in numbers_behind(one, "predicts ").iter().zip(added) {
            let right = before.iter().find(|(known, _)| known == name);
            let right: f64 = right.unwrap().1.parse().unwrap();
            assert!((expected - right).abs() < 0.1, "{seed}: {one}");
        }
    }
}

#[test]
fn a_wrong_value_of_a_joint_is_named_with_the_right_one() {
    let desk = arm();
    for (seed, joint) in (30..36).zip(["J1", "J2", "J3"].into_iter().cycle()) {
        let column = format!("joint_{joint}_deg");
        let (line, before) = with_mistake(&desk, seed, &[(&column, -1.5)]);
        let found = warned(&desk, "bad.csv");
        let [one] = &found[..] else {
            panic!("{seed}: {found:?}");
        };
        let begins = format!("line {line}, pose {}: position x, y, z is ", before[0].1);
        assert!(one.starts_with(&begins), "{seed}: {one}");
        let right = before.iter().find(|(known, _)| *known == column);
        let right: f64 = right.unwrap().1.parse().unwrap();
        let agrees = numbers_behind(one, &format!("it agrees with {joint} = "));
        // 0.1 mm at 2 m are 0.003 degrees.
        assert!((agrees[0] - right).abs() < 0.01, "{seed}: {one}");
    }
}

/// Three mistakes of one table, one of them of a whole pose: none hides another.
#[test]
fn several_wrong_positions_do_not_hide_each_other() {
    let desk = arm();
    desk.run(&simulate("two", "--repeats 2")).succeeds();
    let mut table = Table::parse(&desk.read("two/readings.csv"));
    let wrong = [
        (6, [650.0, 20.0, -90.0]),
        (7, [3.0, 4.0, 0.0]),
        (19, [0.0, -448.0, 0.0]),
    ];
    for (line, added) in wrong {
        for (axis, by) in ["x", "y", "z"].into_iter().zip(added) {
            let column = format!("position_{axis}_mm");
            let right = table.number(line - 2, &column);
            table.set(line - 2, &column, &format!("{:.3}", right + by));
        }
    }
    desk.write("bad.csv", &table.text());
    let found = warned(&desk, "bad.csv");
    let begins = ["line 6, ", "line 7, ", "line 19, pose 9: position y is"];
    assert_eq!(found.len(), 3, "{found:?}");
    for (one, begins) in found.iter().zip(begins) {
        assert!(one.starts_with(begins), "{one}");
    }
}

/// A law of a joint acts under own weight: found, handed to the fit, and the springs are the true ones again.
#[test]
fn play_that_own_weight_closes_is_found_and_held() {
    let desk = arm();
    let play = "--effect joint-backlash@J3:play=300urad,seat_moment=20N*m";
    desk.run(&simulate("loose", play)).succeeds();
    let found = desk.data("diagnose loose --out found");
    let first = &found["findings"][0];
    assert_eq!(first["physics"], "joint-backlash");
    assert_eq!(first["place"]["joint"], "J3");
    let play = first["parameters"]["play"]["value"].number();
    assert!((play / 300e-6 - 1.0).abs() < 0.1, "{play}");
    let names = found["factors"].list().iter();
    let names: Vec<&str> = names.map(|one| one["name"].word()).collect();
    assert!(
        names.iter().all(|name| name.starts_with("joint.")),
        "{names:?}"
    );
    let fit = desk.data("fit loose --model found/model.toml");
    for (joint, truth) in [("joint.J2", 8e-7), ("joint.J3", 1.1e-6)] {
        let one = fit["parameters"].named(joint);
        let off = (one["value"].number() - truth) / one["se"].number();
        assert!(off.abs() < 4.5, "{joint}: {off} standard errors");
    }
    desk.run("fit loose --effect creep@structure:k=1%/decade,t0=1s")
        .exits_with(2);
    desk.run("fit loose --effect gauge-stand-compliance@y:c=1um/N")
        .exits_with(2);
}

#[test]
fn forces_beside_positions_load_what_weight_does_not() {
    let desk = arm();
    desk.run(&simulate("pulled", "--loads-n 400 --repeats 2"))
        .succeeds();
    let fit = desk.data("fit pulled");
    let first = fit["parameters"].named("joint.J1");
    let off = (first["value"].number() - 1.2e-6) / first["se"].number();
    assert!(off.abs() < 4.5, "{off}");
    assert_eq!(fit["weights"]["basis"], "pooled");
    let sd = fit["displacement_sd_um"].number();
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
    let error = misuse(&desk, &simulate("no", "--directions x"));
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
    desk.run("fit made --next next.csv").exits_with(2);
    assert!(!desk.path("next.csv").exists());
}
