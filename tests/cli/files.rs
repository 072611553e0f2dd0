//! The files that the program writes: complete, readable, and the same bytes for the same seed.

use super::{Desk, desk, desk_with_session};
use crate::support::{Contains, Json};

/// An SVG that parses, with something drawn in it.
fn assert_svg(desk: &Desk, name: &str) {
    let options = resvg::usvg::Options::default();
    let tree = resvg::usvg::Tree::from_str(&desk.read(name), &options)
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(tree.root().has_children(), "{name} is empty");
}

fn assert_png(desk: &Desk, name: &str) {
    let bytes = std::fs::read(desk.path(name)).unwrap();
    assert!(
        bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.len() > 1000,
        "{name}"
    );
}

const FIGURES: [&str; 6] = [
    "load-displacement",
    "stiffness",
    "factors",
    "correlation",
    "residuals",
    "robot",
];

#[test]
fn the_demonstration_writes_all_it_lists() {
    let desk = desk();
    // Another demonstration stays as it is, and what its user has changed there.
    desk.write("here/demo/tables.txt", "mine");
    let data = desk.data("demo --out here/demo");
    assert_eq!(desk.read("here/demo/tables.txt"), "mine");
    let files: Vec<&str> = data["files"].list().iter().map(Json::word).collect();
    for file in &files {
        assert!(desk.path(file).is_file(), "{file}");
    }
    for figure in FIGURES {
        let name = format!("here/demo-2/figures/{figure}");
        assert!(files.contains(&format!("{name}.svg").as_str()), "{name}");
        assert_svg(&desk, &format!("{name}.svg"));
        assert_png(&desk, &format!("{name}.png"));
    }
    desk.read("here/demo-2/tables.txt")
        .must_contain(&["95 % interval"]);
    // The session it leaves can be used as it stands.
    let fit = desk.data("fit here/demo-2/session --train P1,P3");
    assert_eq!(fit["factors"], data["fit"]["factors"]);
}

#[test]
fn commands_draw_the_figures_of_their_results() {
    let desk = desk_with_session();
    for command in [
        "fit session --save-factors fit/factors.toml",
        "stiffness session",
        "robot compliance --pose P1",
    ] {
        desk.run(&format!("{command} --figures figures")).succeeds();
    }
    for figure in FIGURES {
        assert_svg(&desk, &format!("figures/{figure}.svg"));
        assert_png(&desk, &format!("figures/{figure}.png"));
    }
    desk.run("compare session session --figures compared")
        .succeeds();
    assert_svg(&desk, "compared/load-displacement.svg");
}

#[test]
fn a_session_freezes_the_procedure_it_followed() {
    let desk = desk();
    desk.write(
        "mine.toml",
        "schema = \"stiffbench/procedure/1\"\nloads_N = [0, -10, -20, 10, 20]\nbranches = [\"loading\", \"unloading\"]\n\
         repeats = 3\nholds_s = [30]\nhold_s = 5\n",
    );
    let ran = desk
        .run("simulate s --procedure mine.toml --poses P3 --directions y,z --noise-distribution skewed")
        .succeeds();
    ran.stdout.must_contain(&["procedure mine"]);
    ran.stderr
        .must_contain(&["mine.toml:6:1: key `hold_s` is not known"]);
    // 0, -10, -20 held, -10, 0, 10, 20 held, 10, 0: 11 readings a run.
    ran.stdout.must_contain(&["66 readings"]);
    let header: toml::Table = desk.read("s/session.toml").parse().unwrap();
    let procedure = header["procedure"].as_table().unwrap();
    for (key, value) in [
        ("schema", "\"stiffbench/procedure/1\""),
        ("name", "\"mine\""),
        ("poses", "[\"P3\"]"),
        ("directions", "[\"y\", \"z\"]"),
        ("loads_N", "[0.0, -10.0, -20.0, 10.0, 20.0]"),
        ("branches", "[\"loading\", \"unloading\"]"),
        ("repeats", "3"),
        ("repeat_order", "\"sweep\""),
        ("load_order", "\"ascending\""),
        ("zero", "\"run\""),
        ("preload_N", "-1.0"),
        ("holds_s", "[30.0]"),
    ] {
        assert_eq!(procedure[key].to_string(), value, "{key}");
    }
    assert_eq!(procedure["settle"].as_table().unwrap().len(), 4);
    desk.read("s/simulation.toml")
        .must_contain(&["shape = \"skewed\""]);
    let readings = desk.read("s/readings.csv");
    let rows: Vec<Vec<&str>> = readings
        .lines()
        .map(|line| line.split(',').collect())
        .collect();
    let column = |name: &str| rows[0].iter().position(|known| *known == name).unwrap();
    let first_run: Vec<(&str, &str, &str)> = rows[1..12]
        .iter()
        .map(|row| {
            (
                row[column("step")],
                row[column("target_N")],
                row[column("branch")],
            )
        })
        .collect();
    assert_eq!(
        first_run,
        [
            ("0", "0", "loading"),
            ("1", "-10", "loading"),
            ("2", "-20", "loading"),
            ("2", "-20", "loading"),
            ("3", "-10", "unloading"),
            ("4", "0", "unloading"),
            ("5", "10", "loading"),
            ("6", "20", "loading"),
            ("6", "20", "loading"),
            ("7", "10", "unloading"),
            ("8", "0", "unloading"),
        ]
    );
    assert!(
        rows[1..]
            .iter()
            .all(|row| !row[column("temp_degC")].is_empty())
    );
    desk.run("stiffness s --branches both").succeeds();
}
