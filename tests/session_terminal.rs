//! Guided sessions of the released program in a real terminal: keys in, screen out; and the same in plain lines, with an answers file.
//!
//! With `STIFFBENCH_PICTURE=FILE` the first test keeps its screen as an SVG, which is how `docs/session.svg` is made.

#![cfg(unix)]
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::Contains;
use crate::support::screen_picture;
use crate::support::tables::Table;
use crate::support::terminal::Terminal;

/// A bench of one pose and direction, three loads, two runs.
const PLAN: [&str; 12] = [
    "--procedure",
    "sweeps",
    "--poses",
    "P2",
    "--directions",
    "y",
    "--loads-n",
    "0,-20,-40",
    "--repeats",
    "3",
    "--seed",
    "5",
];

fn arguments<'a>(command: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [command, &PLAN, &["--emulated"], more].concat()
}

/// Accepted readings: force and displacement by step and repeat.
fn readings(session: &Path) -> Vec<[String; 4]> {
    let table = Table::parse(&fs::read_to_string(session.join("readings.csv")).unwrap());
    let accepted = (0..table.len()).filter(|row| table.word(*row, "status") == "accepted");
    let wanted = ["step", "repeat", "force_N", "displacement_um"];
    accepted
        .map(|row| wanted.map(|column| table.word(row, column).to_owned()))
        .collect()
}

#[test]
fn a_session_is_guided_on_the_whole_of_a_terminal() {
    let desk = tempfile::tempdir().unwrap();
    // Slow enough to press keys between two readings.
    let command = arguments(&["session", "run", "s"], &["--speed", "2"]);
    let mut terminal = Terminal::start(desk.path(), &command, (34, 100));
    terminal.wait_for("Question");
    // A hand at an emulated bench says for itself that all is ready; how warm it is only a person knows.
    terminal.press("215\r");
    terminal.wait_for("is expected");
    terminal.press("\x7f\r");
    terminal.wait_for("repeat 1 of 3");
    terminal.wait_for("Turn the jack to -20.0 N");
    terminal.wait_until("a bar with its band", |screen| {
        screen.contains('░') || screen.contains('▒')
    });
    // A note, asked for and typed.
    terminal.press("n");
    terminal.wait_for("> ");
    terminal.press("the lamp was switched on\r");
    terminal.wait_for("repeat 2 of 3");
    terminal.wait_for("K =");
    if let Some(file) = std::env::var_os("STIFFBENCH_PICTURE") {
        terminal.wait_until("a load under way", |screen| {
            screen.contains("Turn the jack to -40.0 N") && screen.contains("settling [=")
        });
        fs::write(file, screen_picture::svg(&terminal.screen())).unwrap();
    }
    // Once more what was taken last; then to the end.
    terminal.press("r");
    terminal.wait_for("try 2");
    assert_eq!(terminal.exit_code(), Some(0));
    let session = desk.path().join("s");
    assert_eq!(readings(&session).len(), 9);
    let table = fs::read_to_string(session.join("readings.csv")).unwrap();
    assert_eq!(table.matches(",superseded,").count(), 1);
    let journal = fs::read_to_string(session.join("journal.jsonl")).unwrap();
    journal.must_contain(&["the lamp was switched on"]);
}

#[test]
fn control_c_once_ends_at_the_next_safe_point_and_resume_goes_on() {
    let desk = tempfile::tempdir().unwrap();
    let command = arguments(
        &["session", "run", "s"],
        &["--speed", "4", "--answer", "temperature=21"],
    );
    let mut terminal = Terminal::start(desk.path(), &command, (24, 80));
    terminal.wait_for("2 of 9 readings");
    terminal.press("\x03");
    assert_eq!(terminal.exit_code(), Some(130));
    let session = desk.path().join("s");
    let before = readings(&session);
    assert!((2..9).contains(&before.len()), "{before:?}");
    let resume = [
        "session",
        "resume",
        "s",
        "--emulated",
        "--seed",
        "5",
        "--speed",
        "20",
    ];
    let mut terminal = Terminal::start(desk.path(), &resume, (24, 80));
    terminal.wait_until("the question or the end", |screen| {
        screen.contains("Question") || screen.contains("complete")
    });
    terminal.press("21\r");
    assert_eq!(terminal.exit_code(), Some(0));
    let after = readings(&session);
    assert_eq!(after.len(), 9);
    assert_eq!(after[..before.len()], before);
}

#[test]
fn lines_and_an_answers_file_give_the_readings_of_the_screen() {
    let desk = tempfile::tempdir().unwrap();
    fs::write(
        desk.path().join("answers.toml"),
        "schema = \"stiffbench/answers/1\"\nready = true\ntemperature = 21.0\nsetup = true\nsign-check = \"minus\"\ndrift = \"keep\"\n",
    )
    .unwrap();
    let run = |name: &str, more: &[&str]| {
        let command = arguments(&["session", "run", name], more);
        let output = Command::new(env!("CARGO_BIN_EXE_stiffbench"))
            .args(command)
            .current_dir(&desk)
            .stdin(std::process::Stdio::null())
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        (readings(&desk.path().join(name)), said)
    };
    let file = [
        "--answer-file",
        "answers.toml",
        "--no-input",
        "--speed",
        "20",
    ];
    let (by_file, said) = run("by-file", &file);
    said.must_contain(&["reading 9:"]);
    let faster = [
        "--answer",
        "temperature=21",
        "--line",
        "--no-input",
        "--speed",
        "40",
    ];
    let (by_line, _) = run("by-line", &faster);
    assert_eq!(by_file, by_line);
}

#[test]
fn three_gauges_stand_on_the_screen_with_their_axes_and_their_readings_in_one_row() {
    let desk = tempfile::tempdir().unwrap();
    let plan = [
        "session",
        "run",
        "s",
        "--procedure",
        "iso-9283-static-compliance",
        "--poses",
        "P2",
        "--directions",
        "-y,0,0.6,0.8",
        "--loads-n",
        "20,40",
        "--repeats",
        "2",
        "--emulated",
        "--speed",
        "4",
        "--answer",
        "temperature=21",
    ];
    let terminal = Terminal::start(desk.path(), &plan, (34, 100));
    terminal.wait_for("Displacement along the base axes");
    terminal.wait_for("beside the force gauge");
    terminal.wait_for("Turn the jack to 20.0 N");
    terminal.wait_until("a value of each gauge", |screen| {
        ["x", "y", "z"].iter().all(|axis| {
            let line = |line: &&str| line.contains(&format!(" {axis} ")) && line.contains(" um");
            screen.lines().any(|of| line(&of))
        })
    });
    assert_eq!(terminal.exit_code(), Some(0));
    let table = fs::read_to_string(desk.path().join("s").join("readings.csv")).unwrap();
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    for axis in ["x", "y", "z"] {
        assert!(names.contains(&format!("displacement_{axis}_um").as_str()));
    }
    assert_eq!(lines.count(), 8);
}
