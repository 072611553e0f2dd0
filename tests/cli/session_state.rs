//! `stiffbench session status` tells a session that runs from one that crashed, and states by whom one was ended.

use super::desk;
use super::session::{EMULATED, SHORT};
use crate::support::Contains;

#[cfg(unix)]
#[test]
fn running_crashed_and_ended_sessions_are_told_apart() {
    let desk = desk();
    desk.run(&format!(
        "session run s {SHORT} {EMULATED} --operator Jones --answer humidity=40"
    ))
    .succeeds();
    let status = desk.data("session status s");
    assert_eq!(status["outcome"], "complete");
    assert_eq!(status["ended_by"], "program");
    let log = desk.run("session log s").succeeds().stdout;
    log.must_contain(&["40 % relative humidity at the start"]);
    // As after a power cut behind the first reading.
    let journal = desk.read("s/journal.jsonl");
    let first = journal.find("\"kind\":\"reading\"").unwrap();
    let end = first + journal[first..].find('\n').unwrap() + 1;
    desk.write("s/journal.jsonl", &journal[..end]);
    let status = desk.data("session status s");
    assert_eq!(status["outcome"], "crashed");
    let repeats = status["repeats"].to_string();
    repeats.must_contain(&["the check of zero 1", "the loads 0 N, not recorded"]);
    let lock = std::fs::File::open(desk.path("s/journal.jsonl")).unwrap();
    lock.lock().unwrap();
    assert_eq!(desk.data("session status s")["outcome"], "running");
    let text = desk.run("session status s").succeeds().stdout;
    text.must_contain(&["running, process "]);
    lock.unlock().unwrap();
}
