//! The bytes of each reading are found in the traces of the gauges, and `session verify` notices when they are not.

use super::session::measured;
use super::unwrapped;
use crate::support::{Contains, Json};

#[cfg(unix)]
#[test]
fn a_reading_names_its_bytes_and_verify_finds_them() {
    let desk = measured();
    let raw = desk.data("session verify s")["raw"].clone();
    assert_eq!((&raw["found"], raw["wrong"].list().len()), (&8.into(), 0));
    let events = desk.data("session log s")["events"].clone();
    let mut readings = events.list().iter();
    let reading = readings.find(|event| event["kind"] == "reading").unwrap();
    let place = &reading["data"]["raw_bytes"][0];
    assert_eq!(place["channel"], "force");
    assert_eq!(place["file"], "force.trace");
    assert!(place["from"].as_u64().unwrap() < place["to"].as_u64().unwrap());
    // A received packet less: all behind it are elsewhere.
    let trace = desk.read("s/raw/force.trace");
    let first = trace.lines().find(|line| line.contains(" < ")).unwrap();
    desk.write(
        "s/raw/force.trace",
        &trace.replacen(&format!("{first}\n"), "", 1),
    );
    let found = desk.run("session verify s --json");
    assert_eq!(found.code, 30, "{}", found.stdout);
    assert!(!found.json()["data"]["raw"]["wrong"].list().is_empty());
    std::fs::remove_file(desk.path("s/raw/force.trace")).unwrap();
    let gone = desk.run("session verify s");
    assert_eq!(gone.code, 30);
    let gone = unwrapped(&gone.stdout);
    gone.must_contain(&["raw/force.trace cannot be read"]);
    // After a power cut the last second may be missing.
    let cut = &trace[..trace.len() / 2];
    desk.write("s/raw/force.trace", cut);
    let raw = desk.data("session verify s")["raw"].clone();
    assert!(!raw["behind"].list().is_empty(), "{raw}");
}
