//! Session folders and tables in `fixtures/sessions` read as their README says; a wrong header is shown in place.

use std::fs;

use jiff::civil::date;
use miette::Diagnostic;
use stiffbench_measurement::readings::{
    Column, LoadOrder, ReadSession, ReadingStatus, ReadingTable, RepeatOrder, SessionFileError,
    SessionHeader, ZeroScope, read_readings, write_readings,
};
use stiffbench_units_and_text::test_point::Branch;

fn fixture(name: &str) -> Vec<u8> {
    let path = stiffbench_test_files::repository()
        .join("fixtures/sessions")
        .join(name);
    fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn table(name: &str) -> ReadingTable {
    read_readings(name, &fixture(name)[..]).expect("the fixture is a table")
}

fn header(name: &str) -> ReadSession {
    let text = String::from_utf8(fixture(name)).expect("the fixture is UTF-8");
    SessionHeader::from_toml(name, &text).expect("the fixture is a header")
}

fn wrong(text: &str) -> SessionFileError {
    let text = format!("schema = \"stiffbench/session/1\"\n{text}");
    let error = SessionHeader::from_toml("session.toml", &text).expect_err("the header is wrong");
    assert!(error.code().is_some() && error.help().is_some());
    error
}

#[test]
fn three_spellings_of_the_same_readings() {
    let five = table("five-columns.csv");
    let values = |table: &ReadingTable| -> Vec<_> {
        let value = |r: &stiffbench_measurement::readings::Reading| {
            (
                r.pose.clone(),
                r.direction,
                r.branch,
                r.step,
                r.repeat,
                r.target_n,
                r.force_n,
                r.displacement_m,
            )
        };
        table.readings.iter().map(value).collect()
    };
    for name in ["spreadsheet.csv", "other-names.csv", "short/readings.csv"] {
        assert_eq!(values(&table(name)), values(&five), "{name}");
    }
    assert_eq!(five.readings[3].target_n, -30.0);
    assert_eq!(five.readings[4].branch, Branch::Unloading);
    assert_eq!(five.runs.len(), 2);
    let spreadsheet = table("spreadsheet.csv");
    for expected in [
        "a byte order mark was taken off",
        "numbers have a decimal comma, as in line 3",
    ] {
        let mut assumed = spreadsheet.assumptions.iter();
        assert!(assumed.any(|one| one == expected), "{expected}");
    }
    let other = table("other-names.csv");
    assert!(
        other
            .assumptions
            .contains(&"fields are delimited by a tab".to_owned())
    );
    assert!(
        other
            .notes
            .contains(&"column `disp_sd_mm` is not used".to_owned())
    );
    assert_eq!(
        (other.excluded.comments, other.excluded.blank),
        (vec![1], vec![3])
    );
}

#[test]
fn a_full_table_is_read_and_written_as_it_was() {
    let table = table("full/readings.csv");
    assert_eq!(table.session.as_deref(), Some("2026-03-02-bench"));
    let measured = Column::ALL.into_iter();
    let measured: Vec<Column> = measured
        .filter(|column| *column != Column::Origin)
        .collect();
    assert_eq!(table.columns, measured);
    assert_eq!(table.origin, None);
    assert!(table.assumptions.is_empty(), "{:?}", table.assumptions);
    assert_eq!(table.excluded.superseded, [3]);
    // The note above it has two lines.
    assert_eq!(table.readings[4].line, 6 + 1);
    assert_eq!(table.excluded.rejected, [10]);
    let rejected = &table.readings[7];
    assert_eq!(rejected.status, ReadingStatus::Rejected);
    assert_eq!(
        &*rejected.text.as_ref().unwrap().flag,
        "outlier: 0.7 mm off"
    );
    let text = table.readings[3].text.as_ref().unwrap();
    assert_eq!(&*text.note, "the \"new\" stand\nagain");
    assert_eq!(&*text.force_raw, "-20.2 N");
    assert_eq!(table.readings[5].hold_s, Some(60.2));
    assert_eq!(table.readings[5].time_s, Some(160.5));
    assert_eq!(table.runs[0].to_string(), "P1 x first");
    let mut written = Vec::new();
    write_readings(&table, &mut written).unwrap();
    assert_eq!(
        String::from_utf8(written),
        String::from_utf8(fixture("full/readings.csv"))
    );
}

#[test]
fn a_full_header_is_read_and_written_as_it_was() {
    let ReadSession {
        header,
        unknown_keys,
    } = header("full/session.toml");
    assert!(unknown_keys.is_empty(), "{unknown_keys:?}");
    let force = header.instruments.force.as_ref().unwrap();
    assert_eq!(force.range, Some(100.0));
    assert_eq!(force.standard_uncertainty(), Some(0.075));
    assert_eq!(force.due, Some(date(2026, 3, 2)));
    let dial = header.instruments.displacement.as_ref().unwrap();
    assert_eq!(dial.resolution, Some(1e-6));
    assert_eq!(dial.range, Some(0.0127));
    let procedure = header.procedure.as_ref().unwrap();
    assert_eq!(procedure.loads_n, [0.0, -10.0, -20.0, -30.0]);
    assert_eq!(procedure.repeat_order, Some(RepeatOrder::Sweep));
    assert_eq!(procedure.load_order, Some(LoadOrder::Shuffled));
    assert_eq!(procedure.zero, Some(ZeroScope::Run));
    assert_eq!(procedure.settle.slope_m_per_s, Some(5e-7));
    let text = String::from_utf8(fixture("full/session.toml")).unwrap();
    assert_eq!(header.to_toml(), text);
}

#[test]
fn a_short_header_is_enough() {
    let ReadSession {
        header,
        unknown_keys,
    } = header("short/session.toml");
    assert!(unknown_keys.is_empty(), "{unknown_keys:?}");
    let procedure = header.procedure.as_ref().unwrap();
    assert_eq!(procedure.settle.force_tolerance_n, Some(0.5));
    assert_eq!(procedure.repeats, Some(2));
    assert!(
        header
            .instruments
            .force
            .as_ref()
            .unwrap()
            .expanded_uncertainty
            .is_none()
    );
    let again = SessionHeader::from_toml("again", &header.to_toml()).unwrap();
    assert_eq!(again.header, header);
    let least = SessionHeader::from_toml("s", "schema = \"stiffbench/session/1\"").unwrap();
    assert_eq!(least.header, SessionHeader::default());
}

#[test]
fn calibrations_run_out_after_their_last_day() {
    let mut instruments = header("full/session.toml").header.instruments;
    assert_eq!(instruments.overdue(date(2026, 3, 2)), []);
    let overdue = instruments.overdue(date(2026, 3, 3));
    assert_eq!(overdue.len(), 1);
    assert_eq!(overdue[0].to_string(), "force gauge (due 2026-03-02)");
    // A record that names no last day does not run out.
    instruments.force.as_mut().unwrap().due = None;
    assert_eq!(instruments.overdue(date(2026, 3, 3)), []);
}

#[test]
fn unknown_keys_are_listed_with_their_lines() {
    let text = "schema = \"stiffbench/session/1\"\ncolour = \"red\"\n[procedure.settle]\ndwel_s = 2\n\
                [instruments.force]\nserial = 3791204\ndue = \"2027-03-02\"\n[instruments.third]\nk = 2\n";
    let read = SessionHeader::from_toml("session.toml", text).unwrap();
    let expected = [
        ("colour", 2),
        ("procedure.settle.dwel_s", 4),
        ("instruments.third", 8),
    ];
    let unknown = read.unknown_keys.iter();
    let unknown: Vec<_> = unknown.map(|key| (key.key.as_str(), key.line)).collect();
    assert_eq!(unknown, expected);
    let meant: Vec<_> = read
        .unknown_keys
        .iter()
        .map(|key| key.meant.as_deref())
        .collect();
    assert_eq!(meant, [None, Some("procedure.settle.dwell_s"), None]);
    // A number for a serial and a date in quotes are what people write.
    let force = read.header.instruments.force.unwrap();
    assert_eq!(force.serial.as_deref(), Some("3791204"));
    assert_eq!(force.due, Some(date(2027, 3, 2)));
}

#[test]
fn other_units_are_converted() {
    let text = "schema = \"stiffbench/session/1\"\n[instruments.force]\nrange_lbf = 20\n\
                [instruments.displacement]\nresolution_mm = 0.001\n";
    let read = SessionHeader::from_toml("session.toml", text).unwrap();
    assert!(read.unknown_keys.is_empty());
    // NIST SP 811 (2008), B.8: 1 lbf = 4.448 222 N.
    let range = read.header.instruments.force.unwrap().range.unwrap();
    assert!((range - 20.0 * 4.448_222).abs() < 1e-4);
    let dial = read.header.instruments.displacement.unwrap();
    assert_eq!(dial.resolution, Some(1e-6));
}

#[test]
fn a_newer_or_another_schema_is_refused() {
    let newer = SessionHeader::from_toml("s", "schema = \"stiffbench/session/3\"\n").unwrap_err();
    assert_eq!((newer.line, newer.problem.0.word()), (1, "newer_schema"));
    assert!(newer.help().unwrap().to_string().contains("newer version"));
    let other = SessionHeader::from_toml("s", "schema = \"planar-linkage-robot/1\"\n").unwrap_err();
    assert_eq!(other.problem.0.word(), "other_schema");
    let none = SessionHeader::from_toml("s", "id = \"a\"\n").unwrap_err();
    assert_eq!(none.problem.0.word(), "no_schema");
    let procedure = wrong("[procedure]\nschema = \"stiffbench/procedure/9\"\n");
    let found = (procedure.line, procedure.problem.0.word());
    assert_eq!(found, (3, "newer_schema"));
}

#[test]
fn wrong_values_are_shown_in_place() {
    let cases = [
        (
            "id = 1.5",
            "session.toml:2: `id` is `1.5`, expected a text in quotes",
        ),
        (
            "[instruments.force]\nrange_N = \"100\"",
            "session.toml:3: `instruments.force.range_N` is the text `100`, expected a number",
        ),
        (
            "[instruments.force]\nk = inf",
            "session.toml:3: `instruments.force.k` is `inf`, expected a finite number",
        ),
        (
            "[instruments.force]\ndue = 2026-02-30T00:00:00",
            "session.toml:3:",
        ),
        (
            "[instruments.displacement]\ndue = \"soon\"",
            "session.toml:3: `instruments.displacement.due` is the text `soon`, expected a date like 2026-03-02",
        ),
        (
            "[procedure]\nrepeats = -1",
            "session.toml:3: `procedure.repeats` is `-1`, expected a whole number from 0",
        ),
        (
            "[procedure]\nzero = \"never\"",
            "session.toml:3: `procedure.zero` is the text `never`, expected \"cell\" or \"run\"",
        ),
        (
            "[procedure]\ndirections = [\"x\",\n\"w\"]",
            "session.toml:4: `procedure.directions` is the text `w`, expected \"x\", \"y\", \"z\", \"-x\", \"-y\", \"-z\", a name of [load_directions], or a unit vector like [0, 0.6, 0.8]",
        ),
        (
            "[procedure]\nposes = \"P1\"",
            "session.toml:3: `procedure.poses` is the text `P1`, expected an array",
        ),
        (
            "instruments = 3",
            "session.toml:2: `instruments` is `3`, expected a table",
        ),
        (
            "[instruments.force]\nresolution_um = 1",
            "session.toml:3: `instruments.force.resolution_um` has the unit `um`, expected one of N, mN, uN, nN, daN, kN, MN, gf, kgf, kp, tf, lbf, klbf, kip, ozf",
        ),
    ];
    for (text, expected) in cases {
        let message = wrong(text).to_string();
        let (place, problem) = expected.split_once(": ").unwrap_or((expected, ""));
        assert!(message.starts_with(place), "{message}");
        assert!(message.contains(problem), "{message}");
    }
    let syntax = wrong("id = ");
    assert_eq!((syntax.line, syntax.problem.0.word()), (2, "syntax"));
}

#[test]
fn the_place_is_marked_in_the_text() {
    let error = wrong("[instruments.force]\nresolution_um = 1\n");
    let label = error.labels().unwrap().next().unwrap();
    let text = "schema = \"stiffbench/session/1\"\n[instruments.force]\nresolution_um = 1\n";
    assert_eq!(
        &text[label.offset()..label.offset() + label.len()],
        "resolution_um"
    );
}

proptest::proptest! {
    #[test]
    fn any_text_is_answered(text in "(schema = \"stiffbench/session/1\"\n)?[ -~\n]{0,80}") {
        // An answer of either kind will do; what must not happen is a panic.
        if let Err(error) = SessionHeader::from_toml("s", &text) {
            proptest::prop_assert!(error.line >= 1 && error.column >= 1);
        }
    }
}
