//! What is written is read back as it was; spellings of one table read alike; no bytes make the reader panic.

use crate::specimen_tables::line_in;
use proptest::prelude::*;
use stiffbench_measurement::readings::{
    Column, Reading, ReadingStatus, ReadingTable, ReadingText, RunNumbers, TableError,
    read_readings, write_readings,
};
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

/// A number as a gauge gives it: up to seven digits, up to four of them behind the point.
fn gauge_number() -> impl Strategy<Value = f64> {
    (-9_999_999_i32..=9_999_999, 0_u32..=4).prop_map(|(digits, places)| {
        let text = format!("{digits}e-{places}");
        text.parse().expect("digits are a number")
    })
}

/// The same in µm, to m by the nearest number.
fn gauge_metres() -> impl Strategy<Value = f64> {
    (-9_999_999_i32..=9_999_999, 6_u32..=8).prop_map(|(digits, places)| {
        format!("{digits}e-{places}")
            .parse()
            .expect("digits are a number")
    })
}

/// Text with everything that needs quotes.
fn awkward_text() -> impl Strategy<Value = Box<str>> {
    prop_oneof![
        Just(Box::from("")),
        "[ -~µ°;,\"\n\r\t]{0,12}".prop_map(String::into_boxed_str),
    ]
}

fn reading_text() -> impl Strategy<Value = Option<Box<ReadingText>>> {
    let utc = prop_oneof![Just(""), Just("2026-03-02T09:30:00Z")];
    let texts = (
        utc,
        awkward_text(),
        awkward_text(),
        awkward_text(),
        awkward_text(),
        [
            proptest::option::of(-80..80_i32),
            proptest::option::of(-80..80_i32),
        ],
    );
    texts.prop_map(|(utc, force_raw, displacement_raw, flag, note, zeros)| {
        let text = ReadingText {
            utc: utc.into(),
            force_raw,
            displacement_raw,
            zero_si: [
                zeros[0].map(|eighths| f64::from(eighths) / 8.0),
                zeros[1].map(|micrometres| f64::from(micrometres) / 1e6),
            ],
            flag,
            note,
        };
        (text != ReadingText::default()).then(|| Box::new(text))
    })
}

/// A pose from a handful of names, one of which looks like a comment.
fn pose() -> impl Strategy<Value = PoseId> {
    prop_oneof![Just("P1"), Just("#2"), Just("reach, \"far\""), Just("höhe")].prop_map(PoseId::new)
}

fn label() -> impl Strategy<Value = Option<&'static str>> {
    prop_oneof![Just(None), Just(Some("a")), Just(Some("1"))]
}

type Parts = (
    (PoseId, Direction, Branch, ReadingStatus),
    (u32, u32, u32),
    (f64, f64, f64),
    (Option<f64>, Option<f64>, Option<f64>),
    (Option<&'static str>, Option<&'static str>),
    Option<Box<ReadingText>>,
);

fn parts() -> impl Strategy<Value = Parts> {
    let direction = prop_oneof![Just(Direction::X), Just(Direction::Y), Just(Direction::Z)];
    let branch = prop_oneof![Just(Branch::Loading), Just(Branch::Unloading)];
    let status = prop_oneof![
        Just(ReadingStatus::Accepted),
        Just(ReadingStatus::Superseded),
        Just(ReadingStatus::Rejected)
    ];
    (
        (pose(), direction, branch, status),
        (0_u32..20, 1_u32..6, 1_u32..4),
        (gauge_number(), gauge_number(), gauge_metres()),
        (
            proptest::option::of(gauge_number()),
            proptest::option::of(gauge_number()),
            proptest::option::of(gauge_number()),
        ),
        (label(), label()),
        reading_text(),
    )
}

fn table() -> impl Strategy<Value = ReadingTable> {
    let session = prop_oneof![Just(None), Just(Some("2026-03-02, bench".to_owned()))];
    (session, proptest::collection::vec(parts(), 1..40)).prop_map(|(session, rows)| {
        let (mut runs, mut zeros) = (RunNumbers::default(), RunNumbers::default());
        let mut readings = Vec::new();
        for (index, row) in rows.into_iter().enumerate() {
            let (
                (pose, direction, branch, status),
                (step, repeat, attempt),
                loads,
                times,
                labels,
                text,
            ) = row;
            readings.push(Reading {
                line: 0,
                seq: 10 * index as u32,
                run: runs.number(&pose, direction, repeat, labels.0),
                zero: zeros.number(&pose, direction, repeat, labels.1),
                pose,
                direction,
                load: None,
                branch,
                step,
                repeat,
                // Keeps test points apart: what is given twice is refused.
                attempt: 4 * index as u32 + attempt,
                status,
                target_n: loads.0,
                force_n: loads.1,
                displacement_m: loads.2,
                // Where no reading has a time but `utc` is there, times are computed from that.
                time_s: times.0.or(text.as_ref().map(|_| 0.0)),
                hold_s: times.1,
                temperature_deg_c: times.2,
                text,
            });
        }
        ReadingTable {
            source: "t.csv".to_owned(),
            session,
            readings,
            runs: runs.into_keys(),
            zeros: zeros.into_keys(),
            ..ReadingTable::default()
        }
    })
}

fn written(table: &ReadingTable) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_readings(table, &mut bytes).expect("the numbers are finite");
    bytes
}

fn read(bytes: &[u8]) -> Result<ReadingTable, TableError> {
    read_readings("t.csv", bytes)
}

/// Readings without the lines they stand on.
fn without_lines(table: &ReadingTable) -> Vec<Reading> {
    let strip = |reading: &Reading| Reading {
        line: 0,
        ..reading.clone()
    };
    table.readings.iter().map(strip).collect()
}

/// The five columns in a spelling of their own.
fn spelled(rows: &[(i32, i32)], delimiter: char, decimal: char, end: &str) -> String {
    let names = ["pose", "direction", "repeat", "force_N", "displacement_um"];
    let mut text = names.join(&delimiter.to_string()) + end;
    for (force, displacement) in rows {
        let number = |tenths: i32| {
            let sign = if tenths < 0 { "-" } else { "" };
            format!(
                "{sign}{}{decimal}{}",
                (tenths / 10).abs(),
                (tenths % 10).abs()
            )
        };
        let fields = ["P1", "x", "1", &number(*force), &number(*displacement)].map(str::to_owned);
        text += &(fields.join(&delimiter.to_string()) + end);
    }
    text
}

/// Bytes that look like a table more often than chance would have it.
fn nearly_a_table() -> impl Strategy<Value = Vec<u8>> {
    let piece = prop_oneof![
        Just(&b"pose,direction,repeat,force_N,displacement_um\n"[..]),
        Just(&b"pose;direction;repeat;force_N;displacement_um;step;seq\n"[..]),
        Just(&b"P1,x,1,0,0\n"[..]),
        Just(&b"P1;y;2;-9,9;1e3;1;4\n"[..]),
        Just(&b"Units: N\nTravel Unit: mm\nReading\tLoad\tTravel\tTime\n"[..]),
        Just(&b"1\t0.02\t0.000\t0.000\n"[..]),
        Just(&b"\xEF\xBB\xBF"[..]),
        Just(&b"\xFF\xFE"[..]),
        Just(&b"\""[..]),
        Just(&b"\r"[..]),
        Just(&b"\n"[..]),
        Just(&b"#"[..]),
        Just(&b",;\t"[..]),
        Just(&b"NaN,1e999,--,\xB5m"[..]),
    ];
    proptest::collection::vec(piece, 0..12).prop_map(|pieces| pieces.concat())
}

/// Parsed, or an error that states where; only what concerns no line has none.
fn assert_answered(result: Result<ReadingTable, TableError>) {
    match result {
        Ok(table) => assert!(!table.readings.is_empty()),
        Err(error) if error.code == "stiffbench::readings::empty" => {}
        Err(error) => assert!(line_in(&error.to_string()).is_some(), "{error}"),
    }
}

proptest! {
    #[test]
    fn written_tables_come_back(table in table()) {
        let bytes = written(&table);
        let again = read(&bytes).unwrap();
        prop_assert_eq!(without_lines(&again), without_lines(&table));
        prop_assert_eq!(&again.runs, &table.runs);
        prop_assert_eq!(&again.zeros, &table.zeros);
        prop_assert_eq!(&again.session, &table.session);
        prop_assert_eq!(written(&again), bytes);
    }

    #[test]
    fn spellings_of_one_table_read_alike(
        rows in proptest::collection::vec((-9999_i32..9999, -99_999_i32..99_999), 1..30)
    ) {
        let plain = read(spelled(&rows, ',', '.', "\n").as_bytes()).unwrap();
        for (delimiter, decimal, end) in [
            (';', '.', "\n"),
            ('\t', '.', "\r\n"),
            (';', ',', "\r\n"),
            ('\t', ',', "\n"),
            (';', ',', "\r"),
        ] {
            let text = spelled(&rows, delimiter, decimal, end);
            let other = read(text.as_bytes()).unwrap();
            prop_assert_eq!(&other.readings, &plain.readings);
            let marked = [&b"\xEF\xBB\xBF"[..], text.as_bytes()].concat();
            prop_assert_eq!(&read(&marked).unwrap().readings, &plain.readings);
            let wide: Vec<u8> = std::iter::once(0xFEFF)
                .chain(text.encode_utf16())
                .flat_map(u16::to_le_bytes)
                .collect();
            prop_assert_eq!(&read(&wide).unwrap().readings, &plain.readings);
        }
    }

    #[test]
    fn any_bytes_are_answered(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        assert_answered(read(&bytes));
    }

    #[test]
    fn pieces_of_tables_are_answered(bytes in nearly_a_table()) {
        assert_answered(read(&bytes));
    }
}

#[test]
fn the_written_header_is_the_contract() {
    let table = ReadingTable::default();
    let expected = "session,seq,utc,t_s,pose,direction,branch,step,target_N,repeat,attempt,run,zero_id,force_N,force_raw,force_zero_N,\
                    displacement_um,displacement_raw,displacement_zero_um,hold_s,temp_degC,status,flag,note\n";
    assert_eq!(String::from_utf8(written(&table)).unwrap(), expected);
    // Readings that nobody measured have one column more.
    assert_eq!(Column::ALL.len(), expected.split(',').count() + 1);
    let marked = ReadingTable {
        origin: Some("simulated".to_owned()),
        ..table
    };
    let header = expected.replace("note\n", "note,origin\n");
    assert_eq!(String::from_utf8(written(&marked)).unwrap(), header);
}

#[test]
fn a_number_that_is_not_finite_is_not_written() {
    let text = "pose,direction,repeat,force_N,displacement_um\nP1,x,1,0,0\n";
    let mut table = read(text.as_bytes()).unwrap();
    table.readings[0].hold_s = Some(f64::INFINITY);
    let error = write_readings(&table, Vec::new()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "reading 1: hold_s is inf, which a table cannot hold"
    );
}
