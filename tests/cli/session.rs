//! `stiffbench session` on an emulated bench: measured, interrupted, gone on with, damaged and recovered.

use super::{desk, unwrapped};

/// One pose, one direction, four readings.
pub(super) const SHORT: &str =
    "--procedure sweeps --poses P1 --directions x --loads-n 0,-30 --repeats 2";

/// An emulated bench without an operator.
pub(super) const EMULATED: &str = "--emulated --speed 5 --no-input";

#[test]
fn a_plan_lists_every_step_question_and_file() {
    let desk = desk();
    let data = desk.data("session plan --procedure load-hold-unload --poses P1,P3 --directions y");
    assert_eq!(data["readings"], 2 * 5 * 17);
    assert_eq!(data["cells"][1]["pose"], "P3");
    assert_eq!(data["cells"][0]["readings"][8]["hold_s"], 60.0);
    let error = desk.refusal(
        "session plan --poses PP2",
        10,
        "stiffbench::robot::unknown_name",
    );
    assert_eq!(error["help"], "did you mean `P2`?");
    let text = unwrapped(&desk.run(&format!("session plan {SHORT}")).succeeds().stdout);
    for part in [
        "setup.P1.x asks",
        "run 2 0 -30",
        "sign-check",
        "journal.jsonl",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
}

#[cfg(unix)]
#[test]
fn a_session_on_an_emulated_bench_gives_readings_that_are_analysed() {
    let desk = desk();
    let data = desk.data(&format!("session run s {SHORT} {EMULATED}"));
    assert_eq!(data["outcome"], "complete");
    assert_eq!(data["accepted"], 4);
    let cells = desk.data("stiffness s");
    assert_eq!(cells["cells"][0]["n_runs"], 2);
    // The session checked its zero after the loads.
    let budget = desk.run("stiffness s --budget").succeeds().stdout;
    let drift = budget
        .lines()
        .find(|line| line.contains("zero drift"))
        .unwrap();
    assert!(!drift.contains("not stated"), "{budget}");
    let status = desk.data("session status s");
    assert_eq!(status["outcome"], "complete");
    assert!(status["next"].is_null());
    let verified = desk.data("session verify s");
    assert_eq!(verified["whole"], true);
    let log = desk.run("session log s").succeeds().stdout;
    for part in [
        "reading 4: P1 x step 1 repeat 2",
        "zero 2 set",
        "gauge counts",
        "ended: every planned reading is taken or left out",
    ] {
        assert!(log.contains(part), "{part} in {log}");
    }
    // What there is is never written over.
    assert_eq!(
        desk.run(&format!("session run s {SHORT} {EMULATED}")).code,
        13
    );
}

/// A push by hand lasts a moment of the session's time: slower than in other tests, it lies between few samples.
#[cfg(unix)]
#[test]
fn an_emulated_session_at_a_slow_pace_asks_no_question_of_its_own_making() {
    let desk = desk();
    let data = desk.data(
        "session run s --emulated --speed 20 --no-input --procedure paper --poses P1 --directions z --repeats 1 --loads-n=0,-10,-20 --seed 1",
    );
    assert_eq!(data["outcome"], "complete");
}

#[test]
fn a_dry_run_prints_the_plan_and_makes_nothing() {
    let desk = desk();
    let options = "--procedure sweeps --poses P1 --directions x";
    let dry = desk
        .run(&format!("session run s {options} --dry-run"))
        .succeeds();
    let plan = desk.run(&format!("session plan {options}")).succeeds();
    assert!(dry.stdout.contains("readings in 1 cell,"), "{}", dry.stdout);
    assert_eq!(dry.stdout, plan.stdout);
    assert!(!desk.path("s").exists());
}

#[test]
fn a_dry_run_refuses_what_a_run_would_refuse() {
    let desk = desk();
    desk.write("there/file", "");
    desk.write(
        "old.toml",
        "schema = \"stiffbench/session/1\"\n[instruments.force]\ncalibrated = 2020-01-01\ndue = 2021-01-01\n",
    );
    desk.write(
        "wrong.toml",
        "schema = \"stiffbench/session/1\"\n[instruments.force]\nU_N = -3\n",
    );
    for (options, code) in [
        ("s --poses P9", "robot::unknown_name"),
        ("there", "output::exists"),
        ("there/file/s", "output::session_folder"),
        ("s --capture key --no-input", "usage::argument"),
        ("s --answer foo=1", "session::answer_name"),
        ("s --answer temperature=warm", "session::answer_value"),
        ("s --answer temperature=2150", "session::answer_value"),
        ("s --bindings none.toml", "input::not_found"),
        ("s --displacement-port x=/dev/ttyUSB1", "usage::argument"),
        ("s --force-port /dev/no-such-force", "port::absent"),
        (
            "s --instrument-records wrong.toml",
            "session_file::wrong_value",
        ),
        ("s --answer drift=perhaps", "session::answer_value"),
        ("s --instrument-records none.toml", "input::read"),
        (
            "s --instrument-records old.toml --strict",
            "calibration::overdue",
        ),
        ("s --force-instrument nosuch", "instrument::name"),
        ("s --displacement-instrument sauter-fh", "usage::argument"),
        // A gauge without a unit was refused only after the folder had been made.
        (
            "s --displacement-instrument mitutoyo-01a",
            "instrument::unit_needed",
        ),
        (
            "s --effect thermal-drift@clock:rate=1um/s",
            "usage::argument",
        ),
    ] {
        let run = desk.run(&format!("session run {options} --dry-run --json"));
        assert_ne!(run.code, 0, "{options}");
        let error = run.json()["error"]["code"].clone();
        assert_eq!(error, format!("stiffbench::{code}"), "{options}");
    }
    let overdue = desk.run("session run s --instrument-records old.toml --dry-run");
    let notes = overdue.succeeds().stderr;
    assert!(notes.contains("ran out on 2021-01-01"), "{notes}");
    let answers = "--answer setup.P9.x=true --answer setup.P1.x=true --answer unit.force=same";
    let beside = desk.run(&format!("session run s {answers} --poses P1 --dry-run"));
    let notes = beside.succeeds().stderr;
    assert!(
        notes.contains("the answer setup.P9.x is never asked for"),
        "{notes}"
    );
    assert!(
        !notes.contains("setup.P1.x") && !notes.contains("unit.force"),
        "{notes}"
    );
    assert!(!desk.path("s").exists());
}

/// Standard input of a test is empty.
#[cfg(unix)]
#[test]
fn a_question_at_the_end_of_the_input_names_the_option_that_would_have_answered_it() {
    let desk = desk();
    let ran = desk
        .run("session run s --emulated --speed 50 --procedure sweeps --poses P1 --directions x")
        .exits_with(3);
    assert!(
        ran.stderr.contains("--answer temperature=VALUE"),
        "{}",
        ran.stderr
    );
    assert_eq!(desk.data("session status s")["outcome"], "partial");
}

#[cfg(unix)]
#[test]
fn a_damaged_journal_is_found_and_recovered_and_the_session_goes_on() {
    let desk = desk();
    desk.run(&format!("session run s {SHORT} {EMULATED}"))
        .succeeds();
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
    assert_eq!(
        (&data["outcome"], &data["accepted"]),
        (&"complete".into(), &4.into())
    );
    // A line that was being written is no loss.
    let text = desk.read("t/journal.jsonl");
    desk.write("t/journal.jsonl", &text[..text.len() - 7]);
    assert_eq!(desk.data("session verify t")["whole"], true);
}

/// A table in which the value of a column was replaced in the row of a reading (from 1).
#[cfg(unix)]
fn with_value(table: &str, reading: usize, column: &str, value: impl Fn(&str) -> String) -> String {
    let names: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let place = names.iter().position(|name| *name == column).unwrap();
    let mut lines: Vec<String> = table.lines().map(str::to_owned).collect();
    let mut values: Vec<String> = lines[reading].split(',').map(str::to_owned).collect();
    values[place] = value(&values[place]);
    lines[reading] = values.join(",");
    lines.join("\n") + "\n"
}

#[cfg(unix)]
#[test]
fn a_table_that_was_changed_after_the_session_is_refused() {
    let desk = desk();
    desk.run(&format!("session run s {SHORT} {EMULATED}"))
        .succeeds();
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
            let message = error["message"].as_str().unwrap();
            assert!(message.contains(says), "{message}");
        }
        let verified = desk.run("session verify s --json");
        assert_eq!(verified.code, 30);
        assert_eq!(verified.json()["data"]["table"]["state"], "changed");
        assert!(verified.stdout.contains(says));
    }
    let changed = with_value(&table, 2, "displacement_um", one_more);
    desk.write("s/readings.csv", &changed);
    let trusted = desk.run("stiffness s --trust-csv --json").succeeds().json();
    assert!(
        trusted["warnings"]
            .to_string()
            .contains("--trust-csv: s/readings.csv differs")
    );
    // Marks of an analyst are listed and no more.
    desk.write(
        "s/readings.csv",
        &with_value(&table, 2, "note", |_| "door opened".to_owned()),
    );
    let marked = desk.run("stiffness s --json").succeeds().json();
    assert!(
        marked["warnings"]
            .to_string()
            .contains("note of reading 2 is door opened")
    );
    // Another mechanism than the session's, in the header alone.
    desk.write("s/readings.csv", &table);
    let header = desk.read("s/session.toml");
    desk.write(
        "s/session.toml",
        &header.replace("mechanism = \"F\"", "mechanism = \"A\""),
    );
    assert!(
        desk.run("fit s")
            .exits_with(11)
            .stderr
            .contains("mechanism")
    );
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
    let desk = desk();
    desk.run(&format!("session run s {SHORT} {EMULATED}"))
        .succeeds();
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
    assert!(
        behind["warnings"]
            .to_string()
            .contains("its last 1 reading:")
    );
    let within_last_row = shorter.trim_end().rfind('\n').unwrap() + 40;
    desk.write("s/readings.csv", &shorter[..within_last_row]);
    assert_eq!(
        desk.run("session verify s --json").exits_with(30).json()["data"]["table"]["state"],
        "unreadable"
    );
}

#[cfg(unix)]
#[test]
fn a_question_without_an_answer_ends_with_3_and_names_the_flag() {
    let desk = desk();
    let ran = desk.run(&format!(
        "session run s {SHORT} {EMULATED} --answer ready=false --json"
    ));
    assert_eq!(ran.code, 3);
    let error = &ran.json()["error"];
    assert_eq!(error["code"], "stiffbench::input_needed");
    assert!(
        error["help"]
            .as_str()
            .unwrap()
            .contains("--answer ready=VALUE")
    );
    assert_eq!(desk.data("session status s")["outcome"], "partial");
    let unknown = desk.run(&format!(
        "session run t {SHORT} {EMULATED} --answer sing-check=minus"
    ));
    assert_eq!(unknown.code, 10);
    assert!(
        unknown.stderr.contains("did you mean sign-check?"),
        "{}",
        unknown.stderr
    );
    assert!(!desk.path("t").exists());
}

/// The gauge goes on drifting after the interruption, as the mark of the session says.
#[cfg(unix)]
#[test]
fn a_question_at_which_a_session_stopped_is_asked_once_more() {
    let desk = desk();
    // On a busy machine a gauge may seem to stand still.
    let patient = "--answer frozen=again --answer implausible=again";
    let drifts = format!("{patient} --effect thermal-drift@clock:rate=6000um/h");
    for (folder, answer, superseded) in [("kept", "keep", 0), ("redone", "redo", 4 * 3)] {
        desk.run(&format!("session run {folder} {SHORT} {EMULATED} {drifts}"))
            .exits_with(3);
        let status = desk.run(&format!("session status {folder}")).succeeds();
        let repeats = "the question what to do, as the displacement zero moved by";
        let status = unwrapped(&status.stdout);
        assert!(status.contains(repeats), "{status}");
        let resume = format!("session resume {folder} {EMULATED} {patient}");
        desk.run(&resume).exits_with(3);
        let resumed = desk.data(&format!("{resume} --answer drift={answer}"));
        assert_eq!(resumed["outcome"], "complete");
        assert_eq!(resumed["superseded"], superseded, "{answer}");
        // Nothing is begun in a session that is complete.
        let journal = desk.read(&format!("{folder}/journal.jsonl"));
        assert_eq!(desk.data(&resume)["outcome"], "complete");
        assert_eq!(desk.read(&format!("{folder}/journal.jsonl")), journal);
    }
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
    assert!(
        desk.read("s/journal.jsonl")
            .contains("\"kind\":\"calibration-warning\"")
    );
    // The gauge is called what its record calls it.
    assert!(
        desk.read("s/session.toml")
            .contains("model = \"M5-50\"\ndescription = \"mark10-series5\"")
    );
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

#[test]
fn a_gauge_or_port_that_is_not_named_is_asked_for_before_anything_is_made() {
    let desk = desk();
    let ran = desk.run(&format!("session run s {SHORT} --no-input"));
    assert_eq!(ran.code, 2);
    assert!(ran.stderr.contains("--force-instrument"), "{}", ran.stderr);
    let ran = desk.run(&format!(
        "session run s {SHORT} --force-instrument mark10-series5"
    ));
    assert_eq!(ran.code, 2);
    assert!(ran.stderr.contains("--force-port"), "{}", ran.stderr);
    let ports = "--force-instrument mark10-series5 --force-port /dev/no-such-force --displacement-instrument mahr-dk-u1 --displacement-port /dev/no-such-dial";
    let ran = desk.run(&format!("session run s {SHORT} {ports} --no-input"));
    assert_eq!(ran.code, 20);
    assert!(ran.stderr.contains("/dev/no-such-force"), "{}", ran.stderr);
    assert!(!desk.path("s").exists());
    assert_eq!(desk.run("session status nowhere").code, 10);
}
