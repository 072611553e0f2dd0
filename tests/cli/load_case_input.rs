//! Load cases that cannot be used, and those that are hardly meant: each with its place and a remedy.

use super::load_cases::fanuc;
use super::{Desk, assert_output_contains};
use crate::support::Contains;
use crate::support::tables::Table;
use stiffbench_test_files::text;

/// Tables that do not fit the robot, with exit code, error and words of it.
#[rustfmt::skip]
const REFUSED: [(&str, i32, &str, [&str; 3]); 8] = [
    ("pose,joint_J1_deg,axes,force_x_N,displacement_x_um\na,0,link66,1,2\n", 11, "unknown_axes", ["line 2", "link66", "link6"]),
    ("pose,joint_q1_deg,force_x_N,displacement_x_um\na,0,1,2\n", 11, "unknown_variable", ["joint_q1", "J1", "J2"]),
    ("pose,joint_J1_deg,j2 (deg),force_x_N,displacement_x_um\na,0,30,1,2\n", 11, "bare_variable", ["bad.csv", "`j2 (deg)`", "joint_J2_deg"]),
    ("pose,force_x_N,displacement_x_um\nPX,1,2\n", 11, "unknown_pose", ["line 2", "PX", "joint_J1_deg"]),
    ("pose,joint_J1_deg,force_x_N,displacement_um\na,0,1,2\n", 11, "mixed", ["line 1", "`displacement_um`", "displacement_x_um"]),
    ("pose,joint_J1_deg,axes,force_x_N,displacement_x_um\na,0,base,0,2\n", 11, "no_load", ["line 2", "zero", "rejected"]),
    ("pose,joint_J1_deg,axes,force_x_N,displacement_x_um\na,0,base,1,2\n", 40, "too_few", ["were read: 1", "parameters: 4", "--parameter"]),
    ("pose,joint_J1_mm,force_x_N,displacement_x_um\na,0,1,2\n", 11, "joint_unit", ["joint_J1", "length", "_deg"]),
];

#[test]
fn what_does_not_fit_the_robot_is_refused_with_its_place() {
    let desk = fanuc();
    for (table, exit, code, words) in REFUSED {
        desk.write("bad.csv", table);
        let code = format!("stiffbench::load_cases::{code}");
        let error = desk.refusal("fit bad.csv --robot fanuc.toml", exit, &code);
        assert_output_contains(&error, &words);
    }
    desk.write(
        "limit.csv",
        text("data/load-cases/fanuc-r2000ic/readings.csv")
            .replace("1,-59.991000025", "1,-459.991000025")
            .as_str(),
    );
    let outside = desk
        .run("fit limit.csv --robot fanuc.toml --json")
        .succeeds()
        .json();
    let warnings = outside["warnings"].to_string();
    warnings.must_contain(&["line 3, pose 1: outside the limit J1 >= -185"]);
    desk.refusal("fit cases.csv", 2, "stiffbench::usage::no_robot");
    let argument = "stiffbench::usage::argument";
    for (option, code) in [
        ("--bootstrap 5", argument),
        ("--method paper", argument),
        ("--train 1,99", argument),
        ("--sigma known", "stiffbench::load_cases::no_repeats"),
    ] {
        let run = format!("fit cases.csv --robot fanuc.toml {option}");
        desk.refusal(&run, 2, code);
    }
}

#[test]
fn one_name_for_two_poses_is_a_warning() {
    let desk = fanuc();
    let head =
        "pose,joint_J1_deg,joint_J2_deg,force_x_N,force_y_N,displacement_x_um,displacement_y_um\n";
    let rows = |second_j2: &str| {
        format!(
            "{head}a,0,0,300,100,90,40\na,0,{second_j2},100,300,30,120\nb,40,-20,300,200,80,60\n"
        )
    };
    let warnings = |second_j2: &str| {
        desk.write("named.csv", &rows(second_j2));
        let run = "fit named.csv --robot fanuc.toml --parameter joint.J1,joint.J2=free --json";
        desk.run(run).succeeds().json()["warnings"].to_string()
    };
    let words = "line 3: pose a has other joint values than in line 2: give each pose its own name";
    warnings("10").must_contain(&[words]);
    // A controller repeats a pose to fractions of a degree.
    assert!(!warnings("0.3").contains("other joint values"));
}

#[test]
fn commands_that_need_series_of_loads_say_so() {
    let desk = fanuc();
    for command in ["stiffness cases.csv", "compare cases.csv cases.csv"] {
        let error = desk.refusal(command, 2, "stiffbench::usage::needs_runs");
        assert_output_contains(&error, &["load cases", "stiffbench diagnose"]);
    }
}

/// What a fit of the FANUC's load cases warns of after a change to their text.
fn warnings_of(desk: &Desk, robot: &str, changed: &str) -> String {
    desk.write("changed.csv", changed);
    let run = format!("fit changed.csv --robot {robot} --json");
    desk.run(&run).succeeds().json()["warnings"].to_string()
}

#[test]
fn numbers_that_no_robot_has_are_questioned_with_their_place() {
    let desk = fanuc();
    let table = text("data/load-cases/fanuc-r2000ic/readings.csv");
    let fine = warnings_of(&desk, "fanuc.toml", table);
    for words in [
        "taken for",
        "what is usual",
        "against the force",
        "hardly",
        "N·m/rad",
    ] {
        assert!(!fine.contains(words), "{fine}");
    }
    let soft = warnings_of(&desk, "fanuc.toml", &table.replace("_um", "_mm"));
    soft.must_contain(&[
        "are displacements in µm taken for mm, or forces in kN for N?",
        "line ",
        "displacement_",
    ]);
    let stiff = warnings_of(
        &desk,
        "fanuc.toml",
        &table.replace("_N", "_kN").replace("_um", "_nm"),
    );
    stiff.must_contain(&["are displacements in mm taken for µm, or forces in N for kN?"]);
    // Each quantity alone, in both directions.
    for (unit, other, words) in [
        ("_um", "_mm", "in µm taken for mm"),
        ("_um", "_nm", "in mm taken for µm"),
        ("_N", "_kN", "in N for kN"),
        ("_N", "_mN", "in kN for N"),
    ] {
        let odd = warnings_of(&desk, "fanuc.toml", &table.replace(unit, other));
        assert!(odd.contains(words), "{unit} as {other}: {odd}");
    }
    // One value a thousand times too large.
    let mut slip = Table::parse(table);
    let row = (0..slip.len()).find(|row| slip.word(*row, "pose") == "7");
    let row = row.unwrap();
    slip.change(row, "displacement_y_um", |read| 1e3 * read);
    let slip = warnings_of(&desk, "fanuc.toml", &slip.text());
    let place = format!(
        "line {}, pose 7: displacement_y is, for its force, ",
        row + 2
    );
    assert!(slip.contains(&place), "{slip}");
    // Forces that point the other way.
    let turned = warnings_of(&desk, "fanuc.toml", &with_turned_forces(table));
    turned.must_contain(&[
        "the tool moved against the force",
        "the model explains hardly anything",
    ]);
    // Lengths of the robot a thousand times too large.
    let long = text("data/robots/fanuc-r2000ic.toml").replace("_mm = ", "_m = ");
    desk.write("long.toml", &long);
    let long = warnings_of(&desk, "long.toml", table);
    long.must_contain(&["joint.J1 has ", "N·m/rad"]);
}

/// A table whose forces point the other way.
fn with_turned_forces(table: &str) -> String {
    let mut table = Table::parse(table);
    for row in 0..table.len() {
        for column in ["force_x_N", "force_y_N", "force_z_N"] {
            table.change(row, column, |force| -force);
        }
    }
    table.text()
}

#[test]
fn springs_that_would_have_to_be_negative_explain_nothing() {
    let desk = fanuc();
    let simulate =
        "simulate s --robot fanuc.toml --load-cases 20 --seed 3 --loads-n 800 --run-slope-sd 0";
    desk.run(simulate).succeeds();
    let table = desk.read("s/readings.csv");
    desk.write("turned.csv", &with_turned_forces(&table));
    let verdict = |data: &str| {
        let run = format!("diagnose {data} --robot fanuc.toml --no-figures");
        desk.data(&run)["verdict"].clone()
    };
    assert_eq!(verdict("s"), "insufficient-data");
    assert_eq!(verdict("turned.csv"), "unknown");
}

#[test]
fn a_file_that_is_not_there_is_looked_for_among_those_that_are() {
    let desk = fanuc();
    desk.write("arm.urdf", "<robot name=\"arm\"/>");
    let absent = |run: &str, words: &[&str]| {
        let error = desk.refusal(run, 11, "stiffbench::input::read");
        assert_output_contains(&error, words);
        assert!(
            !error["help"].to_string().contains("permissions"),
            "{error}"
        );
    };
    absent(
        "robot new x.toml --urdf arm.udrf",
        &["did you mean arm.urdf?"],
    );
    absent(
        "robot new x.toml --urdf nothing/arm.urdf",
        &["there is no folder nothing"],
    );
    absent("robot new x.toml --dh table.csv", &["check the name"]);
    std::fs::create_dir(desk.path("folder")).unwrap();
    absent("robot new x.toml --dh folder", &["this is a folder"]);
}

#[test]
fn saved_springs_are_read_again_by_robots_of_both_formats() {
    let desk = fanuc();
    let fit = "fit cases.csv --robot fanuc.toml --parameter joint.J1,joint.J3.y,tool.x=free --save-factors fitted.toml";
    let fitted = desk.data(fit);
    desk.read("fitted.toml").must_contain(&["springs = "]);
    let kept = "fit cases.csv --robot fanuc.toml --factors fitted.toml --parameter joint.J2=free";
    let again = desk.data(kept);
    let value = |data: &serde_json::Value, name: &str| data["factors"]["springs"][name].as_f64();
    assert!(value(&fitted, "joint.J3.y").unwrap() > 0.0);
    for name in ["joint.J3.y", "tool.x"] {
        assert_eq!(value(&again, name), value(&fitted, name));
    }
    let compliance = |robot: &str| {
        let data = desk.data(&format!("robot compliance {robot} --factors soft"));
        data.to_string()
    };
    let set = |springs: &str| {
        format!(
            "\n[factors.soft]\nbeam = {{ A = 1.0, Iy = 1.0, Iz = 1.0, J = 1.0 }}\nlink = {{ A = 1.0, Iy = 1.0, Iz = 1.0, J = 1.0 }}\nsprings = {{ {springs} }}\n"
        )
    };
    for (name, joint) in [("fanuc-r2000ic", "J3"), ("serial-arm", "S3")] {
        let robot = text(&format!("data/robots/{name}.toml"));
        let soft = |compliance: &str| set(&format!("\"joint.{joint}.y\" = {compliance}"));
        desk.write("soft.toml", &format!("{robot}{}", soft("1e-5")));
        desk.write("rigid.toml", &format!("{robot}{}", soft("0.0")));
        assert_ne!(
            compliance("soft.toml --pose P1"),
            compliance("rigid.toml --pose P1"),
            "{name}"
        );
        desk.write(
            "typo.toml",
            &format!("{robot}{}", set("\"joint.S33.y\" = 1e-5")),
        );
        let run = desk
            .run("robot check typo.toml --json")
            .exits_with(10)
            .json();
        let message = run["error"].to_string();
        message.must_contain(&["S33"]);
    }
    let good = desk.read("fitted.toml");
    desk.write("typo.toml", &good.replace("springs = ", "spring = "));
    let error = desk.refusal(
        "fit cases.csv --robot fanuc.toml --factors typo.toml",
        10,
        "stiffbench::robot::factor_file",
    );
    assert_output_contains(&error, &["spring", "is `springs` meant?"]);
}

#[test]
fn simulated_springs_without_a_stiffness_are_named() {
    let desk = fanuc();
    let robot = text("data/robots/fanuc-r2000ic.toml")
        .replace(", compliance_urad_per_Nm = 1.162", "")
        .replace(", compliance_urad_per_Nm = 0.368", "");
    desk.write("begun.toml", &robot);
    let warnings = |folder: &str, more: &str| {
        let run = format!("simulate {folder} --robot begun.toml --load-cases 8 {more} --json");
        desk.run(&run).succeeds().json()["warnings"].to_string()
    };
    let named = warnings("a", "");
    named.must_contain(&["joint.J1, joint.J2 have no stiffness yet"]);
    let given = warnings("b", "--true-factor joint.J1=1e-6,joint.J2=1e-6");
    assert!(!given.contains("no stiffness yet"), "{given}");
}
