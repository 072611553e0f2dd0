//! `stiffbench session undo`: the last decision of a session that has stopped is taken back, and nothing is deleted.

use super::desk;
use super::session::{EMULATED, SHORT};

#[cfg(unix)]
#[test]
fn the_last_reading_of_a_session_that_stopped_is_taken_back_and_taken_again() {
    let desk = desk();
    desk.run(&format!("session run s {SHORT} {EMULATED}"))
        .succeeds();
    let refused = desk.run("session undo s");
    assert_ne!(refused.code, 0);
    assert!(refused.stderr.contains("is complete"), "{}", refused.stderr);
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
    assert_eq!(
        (&undone["accepted"], &undone["planned"]),
        (&1.into(), &4.into())
    );
    let after = desk.read("s/journal.jsonl");
    assert!(after.starts_with(stopped), "nothing is deleted");
    assert_eq!(after.lines().count(), stopped.lines().count() + 1);
    assert_eq!(desk.data("session verify s")["whole"], true);
    assert_eq!(desk.data("session status s")["superseded"], 1);
    // The one before it, then there is no other.
    let text = desk.run("session undo s").succeeds().stdout;
    assert!(text.contains("reading 1 no longer counts"), "{text}");
    assert!(text.contains(": reading 1: P1 x step"), "{text}");
    let none = desk.run("session undo s");
    assert!(
        none.stderr.contains("there is no reading"),
        "{}",
        none.stderr
    );
    let log = desk.run("session log s").succeeds().stdout;
    assert!(log.contains("undone: reading 2"), "{log}");
    let data = desk.data(&format!("session resume s {EMULATED}"));
    assert_eq!(
        (&data["outcome"], &data["accepted"]),
        (&"complete".into(), &4.into())
    );
    assert_eq!(data["superseded"], 2);
}
