//! Every result states what it was made of, marks readings that nobody measured, and doubts numbers that are hardly meant.

use super::{desk, desk_with_session, five_columns};
use crate::support::{Contains, Json};

#[test]
fn every_result_begins_with_its_data_and_its_robot() {
    let desk = desk_with_session();
    for (arguments, data, robot) in [
        ("stiffness session", 1, false),
        ("compare session session", 2, false),
        ("fit session", 1, true),
        ("fit paper-experiment", 1, true),
        ("diagnose session --no-figures", 1, true),
        ("robot map --samples 40 --mechanisms F", 0, true),
        (
            "robot map --samples 40 --mechanisms F --load=0,0,-50",
            0,
            true,
        ),
        ("robot compliance --pose P1", 0, true),
        ("robot show hp-robot", 0, true),
        ("robot check hp-robot", 0, true),
        ("robot show --mobility hp-robot", 0, true),
        ("robot significance --beams-only", 0, true),
        ("session plan --procedure sweeps --design", 0, true),
        ("simulate again", 0, true),
    ] {
        let text = desk.run(arguments).succeeds().stdout;
        let first = if data > 0 { "Data: " } else { "Robot: " };
        assert!(text.starts_with(first), "{arguments}:\n{text}");
        let arguments = arguments.replace("again", "once-more");
        let object = desk.run(&format!("{arguments} --json")).succeeds().json();
        let inputs = &object["inputs"];
        let listed = inputs["data"].list();
        assert_eq!(listed.len(), data, "{arguments}: {inputs}");
        for entry in listed {
            assert_eq!(entry["sha256"].word().len(), 64, "{arguments}");
        }
        assert_eq!(inputs["robot"]["sha256"].is_string(), robot, "{arguments}");
    }
    desk.run("fit session --figures figures").succeeds();
    desk.read("figures/residuals.svg")
        .must_contain(&["mechanism"]);
    assert!(
        desk.read("session/diagnosis/verdict.txt")
            .starts_with("Data: ")
    );
}

#[cfg(unix)]
#[test]
fn emulated_readings_bear_their_mark_and_are_not_mixed_with_measured_ones() {
    let desk = desk();
    desk.run(
        "session run e --emulated --speed 50 --no-input --procedure sweeps --poses P1 --seed 2",
    )
    .succeeds();
    let mark = "emulated gauges; seed 2";
    for file in ["session.toml", "journal.jsonl", "readings.csv"] {
        assert!(desk.read(&format!("e/{file}")).contains(mark), "{file}");
    }
    let text = desk.run("stiffness e").succeeds().stdout;
    text.must_contain(&["NOT MEASURED: emulated gauges"]);
    // A mark that was taken away is missed.
    let header = desk.read("e/session.toml");
    let kept = header.lines().filter(|line| !line.starts_with("origin"));
    let without: Vec<&str> = kept.collect();
    desk.write("e/session.toml", &without.join("\n"));
    desk.run("stiffness e").exits_with(11);
    desk.run("session resume e --emulated --no-input")
        .exits_with(2);
}

#[test]
fn implausible_numbers_are_questioned() {
    let desk = desk();
    let table = five_columns(&["P1", "P2"], 3);
    desk.write("good.csv", &table);
    let warnings = |file: &str| desk.run(&format!("stiffness {file}")).succeeds().stderr;
    let good = warnings("good.csv");
    for words in ["exchanged", "expected", "twice", "opposite"] {
        assert!(!good.contains(words), "{good}");
    }
    desk.write(
        "swapped.csv",
        &table.replace("force_N,displacement_um", "displacement_um,force_N"),
    );
    warnings("swapped.csv").must_contain(&["are the two columns exchanged?"]);
    desk.write(
        "mm.csv",
        &table.replace("displacement_um", "displacement_mm"),
    );
    warnings("mm.csv")
        .must_contain(&["are displacements in µm taken for mm, or forces in kN for N?"]);
    let turned: Vec<String> = table
        .lines()
        .map(|line| match line.rsplit_once(",-") {
            Some((before, displacement)) => format!("{before},{displacement}"),
            None => line.to_owned(),
        })
        .collect();
    desk.write("turned.csv", &turned.join("\n"));
    warnings("turned.csv").must_contain(&["opposite signs"]);
    let rows: Vec<&str> = table.lines().collect();
    let twice = [rows.as_slice(), &rows[1..9]].concat();
    desk.write("twice.csv", &twice.join("\n"));
    warnings("twice.csv").must_contain(&["was part of the file pasted twice?"]);

    let fixture = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/robots/scara.toml");
    let file = std::fs::read_to_string(fixture).unwrap();
    let with = |text: String| {
        assert_ne!(text, file);
        desk.write("robot.toml", &text);
        desk.run("robot check robot.toml").succeeds().stderr
    };
    let moduli = |from: &str, to: &str| file.replace(from, to);
    with(moduli("e9", "e3")).must_contain(&["is it in MPa or GPa?"]);
    let in_mm = file
        .replace("h = 0.40", "h = 400.0")
        .replace("l1 = 0.30", "l1 = 300.0")
        .replace("l2 = 0.25", "l2 = 250.0");
    with(in_mm).must_contain(&["are lengths in mm?"]);
}
