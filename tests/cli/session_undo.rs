//! `stiffbench session undo`: the last decision of a session that has stopped is taken back, and nothing is deleted.

use super::session::{EMULATED, measured};
use crate::support::Contains;

#[cfg(unix)]
#[test]
fn the_last_reading_of_a_session_that_stopped_is_taken_back_and_taken_again() {
    let desk = measured();
    let refused = desk.run("session undo s");
    assert_ne!(refused.code, 0);
    refused.stderr.must_contain(&["is complete"]);
    // As after a power cut behind the second reading.
    let journal = desk.read("s/journal.jsonl");
    let second = journal
        .match_indices("\"kind\":\"reading\"")
        .nth(1)
        .unwrap()
        .0;
    let end = second + journal[second..].find('\n').unwrap() + 1;
    let stopped = &journal[..end];
    desk.write("s/journal.jsonl", stopped);
    // The log would show what followed.
    std::fs::remove_file(desk.path("s/session.log")).unwrap();
    // Another process has it.
    let lock = std::fs::File::open(desk.path("s/journal.jsonl")).unwrap();
    lock.lock().unwrap();
    assert_eq!(desk.run("session undo s").code, 21);
    assert_eq!(desk.read("s/journal.jsonl"), stopped);
    lock.unlock().unwrap();
    let undone = desk.data("session undo s");
    assert_eq!(undone["undone"]["action"]["reading"]["number"], 2);
    assert_eq!(undone["accepted"], 1);
    assert_eq!(undone["planned"], 4);
    let after = desk.read("s/journal.jsonl");
    assert!(after.starts_with(stopped), "nothing is deleted");
    assert_eq!(after.lines().count(), stopped.lines().count() + 1);
    assert_eq!(desk.data("session verify s")["whole"], true);
    assert_eq!(desk.data("session status s")["superseded"], 1);
    // The one before it, then there is no other.
    let text = desk.run("session undo s").succeeds().stdout;
    text.must_contain(&["reading 1 no longer counts", ": reading 1: P1 x step"]);
    let none = desk.run("session undo s");
    none.stderr.must_contain(&["there is no reading"]);
    let log = desk.run("session log s").succeeds().stdout;
    log.must_contain(&["undone: reading 2"]);
    let data = desk.data(&format!("session resume s {EMULATED}"));
    assert_eq!(data["outcome"], "complete");
    assert_eq!(data["accepted"], 4);
    assert_eq!(data["superseded"], 2);
}
