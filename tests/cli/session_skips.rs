//! A planned reading that is missing has a reason, and every result states it.

use stiffbench::session::{Event, SkipCode, Skipped, read_journal, write_line};

use super::session::measured;

#[cfg(unix)]
#[test]
fn skipped_readings_are_named_with_their_reason_in_stiffness_fit_status_and_report() {
    let desk = measured();
    // The last reading was left out instead of taken.
    let read = read_journal(desk.read("s/journal.jsonl").as_bytes());
    let is_fourth = |event: &Event| matches!(event, Event::Reading(taken) if taken.number == 4);
    let mut lines = Vec::new();
    for mut record in read.records {
        if is_fourth(&record.event) {
            record.event = Event::Skipped(Skipped {
                cell: 0,
                index: 3,
                code: Some(SkipCode::Instrument),
                reason: "the cable broke".to_owned(),
                pose: Some("P1".to_owned()),
                direction: Some(stiffbench::test_point::Direction::X.into()),
            });
        }
        lines.extend(write_line(&record).unwrap());
    }
    desk.write("s/journal.jsonl", &String::from_utf8(lines).unwrap());
    desk.run("session recover s --out t").succeeds();
    let expected = "1 planned reading of P1 x left out: instrument: the cable broke";
    for command in ["stiffness t", "fit t --train P1"] {
        let ran = desk.run(&format!("{command} --json"));
        let warnings = ran.json()["warnings"].to_string();
        assert!(warnings.contains(expected), "{command}: {warnings}");
    }
    let status = desk.data("session status t");
    assert_eq!(status["left_out"][0]["code"], "instrument");
    assert_eq!(status["left_out"][0]["readings"], 1);
    desk.run("report t --out t.md --format markdown").succeeds();
    assert!(desk.read("t.md").contains(expected));
}
