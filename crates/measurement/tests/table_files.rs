//! Files of machines, loggers and spreadsheets: one test in ten layouts has the same numbers in all of them.

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use miette::Diagnostic;
use proptest::prelude::*;
use stiffbench_measurement::specimen::{SpecimenOptions, SpecimenTable, read_specimen};
use stiffbench_measurement::table_files::{MachineTable, TableFileOptions, read_table_file};

fn bytes(name: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../fixtures/tables")
        .join(name);
    fs::read(path).unwrap()
}

fn read(name: &str, [time, travel, force]: [&str; 3], units: [Option<&str>; 3]) -> SpecimenTable {
    let owned = |unit: Option<&str>| unit.map(str::to_owned);
    let options = SpecimenOptions {
        force_column: Some(force.to_owned()),
        displacement_column: travel.to_owned(),
        time_column: Some(time.to_owned()),
        time_unit: owned(units[0]),
        displacement_unit: owned(units[1]),
        force_unit: owned(units[2]),
        ..SpecimenOptions::default()
    };
    read_specimen(&[(name, &bytes(name)[..])], &options)
        .unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The closed form that `generate.py` writes down.
/// The first line that a message names.
fn line_in(message: &str) -> Option<u32> {
    let (_, rest) = message.split_once(", line ")?;
    let digits = rest.split(|c: char| !c.is_ascii_digit()).next()?;
    digits.parse().ok()
}

#[track_caller]
fn assert_is_the_test(table: &SpecimenTable) {
    let name = &table.source;
    assert_eq!(table.readings.len(), 49, "{name}");
    for (index, reading) in table.readings.iter().enumerate() {
        let step = if index % 16 < 8 {
            index % 16
        } else {
            16 - index % 16
        };
        let travel_m = 0.25e-3 * step as f64;
        let near = |a: f64, b: f64, scale: f64| (a - b).abs() < 1e-6 * scale;
        assert!(
            near(reading.displacement, travel_m, 1e-3),
            "{name} {index}: {reading:?}"
        );
        assert!(
            near(reading.force, 1.25e6 * travel_m, 1e3),
            "{name} {index}: {reading:?}"
        );
        let time_s = reading.time_s.unwrap();
        assert!(
            near(time_s, 0.5 * index as f64, 1.0),
            "{name} {index}: {reading:?}"
        );
    }
}

#[test]
fn every_layout_gives_the_same_numbers() {
    let none = [None; 3];
    let mts = read(
        "mts.txt",
        ["Time", "Axial Displacement", "Axial Force"],
        none,
    );
    assert_is_the_test(&mts);
    assert_eq!(mts.force_unit.name, "kN");
    assert_eq!((mts.readings[0].line, mts.readings[17].line), (8, 31));
    let cases = [
        ("instron.csv", ["Time", "Extension", "Load"], none),
        ("labview.lvm", ["X_Value", "Travel", "Force"], none),
        ("labview-multi.lvm", ["X_Value", "Travel", "Force"], none),
        (
            "zwick.txt",
            ["Prüfzeit", "Standardweg", "Standardkraft"],
            none,
        ),
        ("semicolon.csv", ["Zeit", "Weg", "Kraft [N]"], none),
        ("bom.csv", ["Time stamp", "Travel", "Load"], none),
        ("unicode.tsv", ["t_min", "Weg", "Kraft"], none),
        ("sheet.xlsx", ["Time", "Travel", "Load"], none),
        (
            "blanks.txt",
            ["column 1", "column 2", "column 3"],
            [Some("s"), Some("mm"), Some("N")],
        ),
    ];
    for (name, columns, units) in cases {
        assert_is_the_test(&read(name, columns, units));
    }
}

fn layout(name: &str) -> String {
    table(name).layout.to_string()
}

fn table(name: &str) -> MachineTable {
    read_table_file(name, &bytes(name)[..], &TableFileOptions::default()).unwrap()
}

#[test]
fn what_was_taken_for_what_is_stated() {
    for (name, expected) in [
        (
            "mts.txt",
            "table taken as MTS export, UTF-8, delimiter tab, decimal point; names in line 6, units in line 7; 49 rows in lines 8 to 68 in 3 \
             segments (column `segment`); 4 lines above are no part of it; 10 lines from 26 on are no rows of it; `Time` in Sec, \
             `Axial Displacement` in mm, `Axial Force` in kN",
        ),
        (
            "instron.csv",
            "table taken as Instron export, UTF-8, delimiter comma, decimal point; names in line 7, units in line 8; 49 rows in lines 9 to 57; \
             5 lines above are no part of it; `Time` in s, `Extension` in mm, `Load` in N",
        ),
        (
            "zwick.txt",
            "table taken as Zwick export, windows-1252, delimiter semicolon, decimal comma; names in line 4, units in line 5; 49 rows in lines \
             6 to 54; 3 lines above are no part of it; 1 lines from 55 on are no rows of it; `Prüfzeit` in s, `Standardweg` in µm, \
             `Standardkraft` in N",
        ),
        (
            "semicolon.csv",
            "table taken as UTF-8, delimiter semicolon, decimal comma, thousands by `.`; names in line 1; 49 rows in lines 2 to 50; \
             `Kraft [N]` in N, `Weg in mm` in mm",
        ),
        (
            "blanks.txt",
            "table taken as UTF-8, delimiter blanks, decimal point; no names, columns are called `column 1`, `column 2`, …; 49 rows in lines 1 \
             to 49",
        ),
        (
            "sheet.xlsx",
            "table taken as spreadsheet (sheet `Data`); names in row 3, units in row 4; 49 rows in rows 5 to 53; `Time` in s, `Travel` in mm, \
             `Load` in N",
        ),
    ] {
        assert_eq!(layout(name), expected, "{name}");
    }
}

#[test]
fn columns_can_be_taken_without_a_specimen() {
    let table = table("labview.lvm");
    let names: Vec<&str> = table
        .layout
        .columns
        .iter()
        .map(|column| column.name.as_str())
        .collect();
    assert_eq!(names, ["X_Value", "Force", "Travel", "Comment", "segment"]);
    assert_eq!(table.numbers(2).unwrap()[8], Some(2.0));
    assert_eq!(table.numbers(4).unwrap()[19..21], [Some(1.0), Some(2.0)]);
    let stamps = self::table("semicolon.csv");
    assert!(stamps.is_time_stamp(0));
    assert_eq!(stamps.seconds(0).unwrap()[48], Some(24.0));
}

#[track_caller]
fn assert_error(text: &str, options: &TableFileOptions, code: &str, line: Option<u32>, part: &str) {
    let read = read_table_file("t.csv", text.as_bytes(), options);
    let error = match read {
        Ok(table) => {
            let columns = 0..table.layout.columns.len();
            let both = |column| {
                table.numbers(column).err().or(table
                    .seconds(column)
                    .err()
                    .filter(|_| table.is_time_stamp(column)))
            };
            columns
                .into_iter()
                .find_map(|c| {
                    if table.is_time_stamp(c) {
                        table.seconds(c).err()
                    } else {
                        both(c)
                    }
                })
                .unwrap()
        }
        Err(error) => error,
    };
    assert_eq!(
        error.code().unwrap().to_string(),
        format!("stiffbench::table::{code}"),
        "{error}"
    );
    assert_eq!(line_in(&error.to_string()), line, "{error}");
    assert!(error.to_string().contains(part), "{error}");
    assert!(error.help().is_some());
}

#[test]
fn wrong_tables_are_refused_with_place_and_remedy() {
    let plain = TableFileOptions::default();
    assert_error("", &plain, "empty", None, "t.csv");
    assert_error(
        "a,b\nc,d\n",
        &plain,
        "no_numbers",
        None,
        "no row of numbers",
    );
    assert_error(
        "F,d\n1,2\n3,4,5\n",
        &plain,
        "field_count",
        Some(3),
        "3 fields, expected 2",
    );
    assert_error(
        "F;d\n1,5;2\n2.5;3\n",
        &plain,
        "mixed_decimals",
        Some(3),
        "`2.5`",
    );
    assert_error(
        "F;d\n1,234;2\n",
        &plain,
        "either_decimal",
        Some(2),
        "`1,234`",
    );
    assert_error(
        "F,d\n1,2\n2,x\n3,4\n",
        &plain,
        "bad_number",
        Some(3),
        "column `d`: `x`",
    );
    assert_error(
        "F,d\n1,2\n2,1e999\n",
        &plain,
        "not_finite",
        Some(3),
        "`1e999`",
    );
    assert_error(
        "t,d\n1/2/2024 1:00,2\n2/2/2024 1:00,3\n",
        &plain,
        "day_or_month",
        Some(3),
        "`2/2/2024 1:00`",
    );
    assert_error(
        "t,d\n10:00,2\n10:01,3\n25,4\n",
        &plain,
        "bad_time",
        Some(4),
        "`25`",
    );
    let sheet = TableFileOptions {
        sheet: Some("A".into()),
        ..plain.clone()
    };
    assert_error("F,d\n1,2\n", &sheet, "text_has_no_sheets", None, "`A`");
    let told = TableFileOptions {
        decimal: Some(stiffbench_measurement::readings::DecimalSign::Comma),
        ..plain
    };
    let table = read_table_file("t.csv", &b"F;d\n1,234;2\n"[..], &told).unwrap();
    assert_eq!(table.numbers(0).unwrap(), [Some(1.234)]);
}

#[test]
fn sheets_are_named_where_several_would_do_or_none_is_there() {
    let options = TableFileOptions {
        sheet: Some("data".into()),
        ..TableFileOptions::default()
    };
    let error = read_table_file("sheet.xlsx", &bytes("sheet.xlsx")[..], &options).unwrap_err();
    assert_eq!(
        error.to_string(),
        "sheet.xlsx: no sheet `data` among `Notes`, `Data`"
    );
    let torn = &bytes("sheet.xlsx")[..300];
    let error = read_table_file("sheet.xlsx", torn, &TableFileOptions::default()).unwrap_err();
    assert_eq!(error.code, "stiffbench::table::spreadsheet", "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    /// Cut and damaged files give a table or an error, and never more rows than lines.
    #[test]
    fn damaged_files_do_not_panic(
        which in 0_usize..10,
        cut in 0.0_f64..1.0,
        flips in prop::collection::vec((0.0_f64..1.0, any::<u8>()), 0..8),
    ) {
        const NAMES: [&str; 10] = [
            "mts.txt", "instron.csv", "labview.lvm", "labview-multi.lvm", "zwick.txt", "semicolon.csv", "bom.csv", "unicode.tsv", "blanks.txt",
            "sheet.xlsx",
        ];
        let mut bytes = bytes(NAMES[which]);
        for (place, byte) in flips {
            let place = (place * bytes.len() as f64) as usize;
            bytes[place] = byte;
        }
        bytes.truncate((cut * bytes.len() as f64) as usize);
        if let Ok(table) = read_table_file("x", &bytes[..], &TableFileOptions::default()) {
            prop_assert!(table.rows.windows(2).all(|pair| pair[0].line < pair[1].line));
            for column in 0..table.layout.columns.len() {
                let _ = table.numbers(column);
                let _ = table.seconds(column);
            }
        }
    }

    /// Numbers survive any delimiter, decimal sign and thousands separator.
    #[test]
    fn numbers_survive_their_spelling(
        rows in prop::collection::vec((-9_999_999_i64..9_999_999, 0_i64..9_999_999), 2..20),
        form in 0_usize..4,
    ) {
        let (sign, decimal, thousands) = [(';', ',', "."), ('\t', '.', ","), (';', '.', "'"), (';', ',', "\u{a0}")][form];
        let spell = |number: i64| {
            let digits = (number.abs() / 100).to_string();
            let mut grouped = String::new();
            for (index, digit) in digits.chars().enumerate() {
                if index > 0 && (digits.len() - index).is_multiple_of(3) {
                    grouped.push_str(thousands);
                }
                grouped.push(digit);
            }
            format!("{}{grouped}{decimal}{:02}", if number < 0 { "-" } else { "" }, number.abs() % 100)
        };
        let mut text = format!("Kraft [N]{sign}Weg [mm]\n");
        for (force, travel) in &rows {
            writeln!(text, "{}{sign}{}", spell(*force), spell(*travel)).unwrap();
        }
        let table = read_table_file("x", text.as_bytes(), &TableFileOptions::default()).unwrap();
        for (row, (force, travel)) in rows.iter().enumerate() {
            let near = |column: usize, number: i64| (table.numbers(column).unwrap()[row].unwrap() - number as f64 / 100.0).abs() < 1e-6;
            prop_assert!(near(0, *force) && near(1, *travel), "{}", text);
        }
    }
}
