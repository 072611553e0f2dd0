//! The bytes of each reading are found in the traces of the gauges, and `session verify` notices when they are not.

use super::session::{EMULATED, SHORT};
use super::{desk, unwrapped};

#[cfg(unix)]
#[test]
fn a_reading_names_its_bytes_and_verify_finds_them() {
    let desk = desk();
    desk.run(&format!("session run s {SHORT} {EMULATED}"))
        .succeeds();
    let raw = desk.data("session verify s")["raw"].clone();
    assert_eq!(
        (&raw["found"], raw["wrong"].as_array().unwrap().len()),
        (&8.into(), 0)
    );
    let events = desk.data("session log s")["events"].clone();
    let mut readings = events.as_array().unwrap().iter();
    let reading = readings.find(|event| event["kind"] == "reading").unwrap();
    let place = &reading["data"]["raw_bytes"][0];
    assert_eq!(
        (&place["channel"], &place["file"]),
        (&"force".into(), &"force.trace".into())
    );
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
    assert!(
        !found.json()["data"]["raw"]["wrong"]
            .as_array()
            .unwrap()
            .is_empty()
    );
    std::fs::remove_file(desk.path("s/raw/force.trace")).unwrap();
    let gone = desk.run("session verify s");
    assert_eq!(gone.code, 30);
    let gone = unwrapped(&gone.stdout);
    assert!(gone.contains("raw/force.trace cannot be read"), "{gone}");
    // After a power cut the last second may be missing.
    let cut = &trace[..trace.len() / 2];
    desk.write("s/raw/force.trace", cut);
    let raw = desk.data("session verify s")["raw"].clone();
    assert!(!raw["behind"].as_array().unwrap().is_empty(), "{raw}");
}
