//! The log of a session folder: options, gauges, questions, answers, events and the end; readings only where they are wanted.

use stiffbench_test_files::desk::Desk;

use super::desk;
use crate::support::{Contains, Json};

const RUN: &str = "session run s --emulated --speed 50 --no-input --procedure sweeps --poses P1 --directions x --repeats 1 --seed 2 --answer temperature=21";

/// The lines as time, level and message.
fn lines(desk: &Desk) -> Vec<(String, String, String)> {
    let parts = |line: &str| {
        let line: serde_json::Value = serde_json::from_str(line).unwrap();
        let [time, level, message] =
            ["utc", "level", "message"].map(|key| line[key].word().to_owned());
        (time, level, message)
    };
    desk.read("s/session.log").lines().map(parts).collect()
}

/// As a session that crashed is: without its end.
fn cut_off_the_end(desk: &Desk) {
    let journal = desk.read("s/journal.jsonl");
    let (before, _) = journal.trim_end().rsplit_once('\n').unwrap();
    desk.write("s/journal.jsonl", &format!("{before}\n"));
}

#[test]
fn the_log_holds_what_happened_but_no_readings_and_goes_on() {
    let desk = desk();
    let ran = desk.run(RUN).succeeds();
    assert!(!ran.stderr.contains(" INFO "), "{}", ran.stderr);
    let log = lines(&desk);
    for (time, level, _) in &log {
        assert_eq!(time.len(), "2026-11-25T00:31:07.412Z".len(), "{time}");
        assert!(
            ["INFO", "WARN", "ERROR"].contains(&level.as_str()),
            "{level}"
        );
    }
    let is_there = |words: &str| log.iter().any(|(.., message)| message.contains(words));
    for words in [
        "options: session run s --emulated",
        "force gauge: ",
        "displacement gauge: ",
        "event 1: session s-",
        "ended: ",
    ] {
        assert!(is_there(words), "{words}: {log:?}");
    }
    assert!(!is_there("reading 1:"), "{log:?}");
    let count = log.len();
    cut_off_the_end(&desk);
    desk.run("session resume s --emulated --speed 50 --no-input --verbose --answer temperature=21")
        .succeeds();
    let log = lines(&desk);
    assert!(log.len() > count);
    assert!(
        log[count..]
            .iter()
            .any(|(.., message)| message.starts_with("options: session resume s"))
    );
}

#[test]
fn a_verbose_session_prints_its_log_and_at_the_second_level_every_reading() {
    for (option, with_readings) in [("-v", false), ("-vv", true)] {
        let desk = desk();
        let ran = desk.run(&format!("{RUN} {option}")).succeeds();
        let log = desk.read("s/session.log");
        let readings = log
            .lines()
            .filter(|line| line.contains("\"DEBUG\"") && line.contains(": reading "))
            .count();
        let taken = desk.read("s/readings.csv").lines().count() - 1;
        assert_eq!(readings, if with_readings { taken } else { 0 }, "{option}");
        for (time, level, message) in lines(&desk) {
            let line = format!("{time} {level:<5} {message}");
            assert!(ran.stderr.contains(&line), "{option}: {line}");
        }
    }
}

#[test]
fn a_log_that_cannot_be_written_stops_no_session() {
    let desk = desk();
    desk.run(RUN).succeeds();
    std::fs::remove_file(desk.path("s/session.log")).unwrap();
    std::fs::create_dir(desk.path("s/session.log")).unwrap();
    cut_off_the_end(&desk);
    let ran = desk
        .run("session resume s --emulated --speed 50 --no-input --answer temperature=21")
        .succeeds();
    ran.stderr.must_contain(&["session.log cannot be written"]);
    // Nothing depends on it.
    desk.run("session verify s").succeeds();
    desk.run("stiffness s").succeeds();
}
