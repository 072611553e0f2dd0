//! `stiffbench session` on an emulated bench: measured, interrupted, gone on with, damaged and recovered.

use super::{Desk, desk};
#[cfg(unix)]
use crate::support::tables::Table;
use crate::support::{Contains, Json};

/// One pose, one direction, four readings.
pub(super) const SHORT: &str =
    "--procedure sweeps --poses P1 --directions x --loads-n 0,-30 --repeats 2";

/// An emulated bench without an operator.
pub(super) const EMULATED: &str = "--emulated --speed 5 --no-input";

/// A desk with the session `s` of such a bench.
#[cfg(unix)]
pub(super) fn measured() -> Desk {
    let desk = desk();
    desk.run(&format!("session run s {SHORT} {EMULATED}"))
        .succeeds();
    desk
}

#[cfg(unix)]
#[test]
fn a_damaged_journal_is_found_and_recovered_and_the_session_goes_on() {
    let desk = measured();
    let journal = desk.read("s/journal.jsonl");
    let third = journal
        .match_indices("\"kind\":\"reading\"")
        .nth(2)
        .unwrap()
        .0;
    let mut damaged = journal.clone().into_bytes();
    damaged[third + 8] ^= 0x01;
    std::fs::write(desk.path("s/journal.jsonl"), &damaged).unwrap();
    assert_eq!(desk.run("session verify s").code, 30);
    assert_eq!(desk.run(&format!("session resume s {EMULATED}")).code, 30);
    let recovered = desk.run("session recover s --out t --json");
    assert_eq!(recovered.code, 30);
    assert_eq!(recovered.json()["data"]["readings"], 3);
    assert_eq!(
        std::fs::read(desk.path("s/journal.jsonl")).unwrap(),
        damaged
    );
    let data = desk.data(&format!("session resume t {EMULATED}"));
    assert_eq!(data["outcome"], "complete");
    assert_eq!(data["accepted"], 4);
    // A line that was being written is no loss, unless the log names its event; nor does a journal without an end pass as complete.
    let text = desk.read("t/journal.jsonl");
    desk.write("t/journal.jsonl", &text[..text.len() - 7]);
    let verified = desk.run("session verify t");
    verified
        .exits_with(30)
        .stdout
        .must_contain(&["the journal was cut behind event"]);
    std::fs::remove_file(desk.path("t/session.log")).unwrap();
    assert_eq!(desk.data("session verify t")["whole"], true);
    let verified = desk.run("session verify t");
    verified
        .succeeds()
        .stdout
        .must_contain(&["no end of the session"]);
}

/// A table in which the value of a column was replaced in the row of a reading (from 1).
#[cfg(unix)]
fn with_value(table: &str, reading: usize, column: &str, value: impl Fn(&str) -> String) -> String {
    let mut table = Table::parse(table);
    table.set(reading - 1, column, &value(table.word(reading - 1, column)));
    table.text()
}

#[cfg(unix)]
#[test]
fn a_table_that_was_changed_after_the_session_is_refused() {
    let desk = measured();
    let table = desk.read("s/readings.csv");
    desk.run("stiffness s").succeeds();
    let verified = desk.data("session verify s");
    assert_eq!(verified["table"]["state"], "as-recorded");
    let one_more = |value: &str| (value.parse::<f64>().unwrap() + 1.0).to_string();
    let other_names = table.replace("displacement_um", "displacement_mm");
    let cases = [
        (
            with_value(&table, 2, "displacement_um", one_more),
            "readings.csv:3: displacement_um of reading 2 is",
        ),
        (
            with_value(&table, 2, "force_N", one_more),
            "force_N of reading 2",
        ),
        (
            with_value(&table, 3, "pose", |_| "P2".to_owned()),
            "pose of reading 3 is P2",
        ),
        (
            with_value(&table, 1, "repeat", |_| "2".to_owned()),
            "repeat of reading 1 is 2",
        ),
        (other_names, "displacement_um of reading 1"),
        (
            table.lines().take(3).collect::<Vec<_>>().join("\n") + "\n",
            "reading 3 is missing",
        ),
    ];
    for (changed, says) in cases {
        desk.write("s/readings.csv", &changed);
        for command in ["stiffness s", "stiffness s/readings.csv", "fit s"] {
            let refused = desk.run(&format!("{command} --json"));
            assert_eq!(refused.code, 11, "{}", refused.stdout);
            let error = &refused.json()["error"];
            assert_eq!(error["code"], "stiffbench::input::changed");
            let message = error["message"].word();
            message.must_contain(&[says]);
        }
        let verified = desk.run("session verify s --json");
        assert_eq!(verified.code, 30);
        assert_eq!(verified.json()["data"]["table"]["state"], "changed");
        verified.stdout.must_contain(&[says]);
    }
    let changed = with_value(&table, 2, "displacement_um", one_more);
    desk.write("s/readings.csv", &changed);
    let trusted = desk.run("stiffness s --trust-csv --json").succeeds().json();
    trusted["warnings"]
        .to_string()
        .must_contain(&["--trust-csv: s/readings.csv differs"]);
    // Marks of an analyst are listed and no more.
    desk.write(
        "s/readings.csv",
        &with_value(&table, 2, "note", |_| "door opened".to_owned()),
    );
    let marked = desk.run("stiffness s --json").succeeds().json();
    marked["warnings"]
        .to_string()
        .must_contain(&["note of reading 2 is door opened"]);
    // Another mechanism than the session's, in the header alone.
    desk.write("s/readings.csv", &table);
    let header = desk.read("s/session.toml");
    desk.write(
        "s/session.toml",
        &header.replace("mechanism = \"F\"", "mechanism = \"A\""),
    );
    desk.run("fit s")
        .exits_with(11)
        .stderr
        .must_contain(&["mechanism"]);
    // Without a journal nothing can be compared.
    desk.write("s/session.toml", &header);
    std::fs::remove_file(desk.path("s/journal.jsonl")).unwrap();
    desk.run("stiffness s").succeeds();
    let verified = desk.data("session verify s");
    assert_eq!(verified["table"]["state"], "not-protected");
}

#[cfg(unix)]
#[test]
fn a_table_that_lags_behind_the_journal_was_not_changed() {
    let desk = measured();
    let table = desk.read("s/readings.csv");
    // A session that was killed between journal and table is behind and not changed; one that ended is not.
    let journal = desk.read("s/journal.jsonl");
    let ended = journal.find("\"kind\":\"ended\"").unwrap();
    let running = &journal[..=journal[..ended].rfind('\n').unwrap()];
    let shorter = table.lines().take(4).collect::<Vec<_>>().join("\n") + "\n";
    desk.write("s/readings.csv", &shorter);
    desk.run("stiffness s").exits_with(11);
    desk.write("s/journal.jsonl", running);
    let behind = desk.run("stiffness s --json").succeeds().json();
    behind["warnings"]
        .to_string()
        .must_contain(&["its last 1 reading:"]);
    let within_last_row = shorter.trim_end().rfind('\n').unwrap() + 40;
    desk.write("s/readings.csv", &shorter[..within_last_row]);
    assert_eq!(
        desk.run("session verify s --json").exits_with(30).json()["data"]["table"]["state"],
        "unreadable"
    );
}

#[cfg(unix)]
#[test]
fn an_overdue_calibration_is_said_and_refused_under_strict() {
    let desk = desk();
    let records = "schema = \"stiffbench/session/1\"\n[instruments.force]\nmodel = \"M5-50\"\nserial = \"7\"\ndue = 2020-01-31\n";
    desk.write("records.toml", records);
    let command = format!("session run s {SHORT} {EMULATED} --instrument-records records.toml");
    assert_eq!(desk.run(&format!("{command} --strict")).code, 12);
    let ran = desk.run(&command).succeeds();
    let said = "calibration of the force gauge ran out on 2020-01-31";
    // Before the first reading, and once more at the end.
    let (before, _) = ran.stderr.split_once("reading 1:").unwrap();
    assert!(before.contains(said), "{}", ran.stderr);
    assert_eq!(ran.stderr.matches(said).count(), 2, "{}", ran.stderr);
    desk.read("s/journal.jsonl")
        .must_contain(&["\"kind\":\"calibration-warning\""]);
    // The gauge is called what its record calls it.
    desk.read("s/session.toml")
        .must_contain(&["model = \"M5-50\"\ndescription = \"mark10-series5\""]);
    for command in ["status s", "log s", "verify s", "recover s --out t"] {
        let command = format!("session {command}");
        desk.run(&format!("{command} --strict")).exits_with(12);
        let ran = desk.run(&command).succeeds();
        assert!(ran.stderr.contains(said), "{command}: {}", ran.stderr);
    }
    desk.run("report s --out s.html").succeeds();
    for command in ["report verify s.html", "report verify s.html s"] {
        desk.run(&format!("{command} --strict")).exits_with(12);
        let ran = desk.run(command).succeeds();
        assert!(ran.stderr.contains("calibration overdue"), "{command}");
    }
    let running = desk.read("s/journal.jsonl");
    let begun = running.lines().next().unwrap();
    desk.write("s/journal.jsonl", &format!("x{}\n", &begun[1..]));
    desk.run("session verify s --strict").exits_with(31);
}
