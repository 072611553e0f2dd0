//! What a wrong or odd table of readings gives: the exact error with its place, or the stated assumption. Nothing is lost.

use std::fmt::Write as _;

use crate::specimen_tables::line_in;
use miette::Diagnostic;
use stiffbench_measurement::readings::{ReadingTable, TableError, check_poses, read_readings};
use stiffbench_units_and_text::test_point::{Branch, PoseId};

const FIVE: &str = "pose,direction,repeat,force_N,displacement_um";

fn read(text: &str) -> Result<ReadingTable, TableError> {
    read_readings("bench.csv", text.as_bytes())
}

/// The five columns with these rows.
fn five(rows: &[&str]) -> Result<ReadingTable, TableError> {
    read(&format!("{FIVE}\n{}\n", rows.join("\n")))
}

/// Code, line and message of the error.
fn error(result: Result<ReadingTable, TableError>) -> (String, Option<u32>, String) {
    let error = result.expect_err("the table should not have been accepted");
    let code = error.code().expect("every error has a code").to_string();
    assert!(error.help().is_some(), "every error says what to do");
    (code, line_in(&error.to_string()), error.to_string())
}

#[track_caller]
fn assert_error(result: Result<ReadingTable, TableError>, code: &str, line: u32, parts: &[&str]) {
    let (found, at, message) = error(result);
    assert_eq!(found, format!("stiffbench::readings::{code}"), "{message}");
    assert_eq!(at, Some(line), "{message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

#[test]
fn missing_column() {
    let result = read("pose,dirction,repeat,force_N,displacement_um\nP1,x,1,0,0\n");
    let advice = result.as_ref().unwrap_err().help().unwrap().to_string();
    assert!(advice.starts_with("is `dirction` meant? Name it `direction`;"));
    assert!(advice.contains("stiffbench import bench.csv"));
    let parts = ["bench.csv, line 1", "`direction`", "`dirction`, `repeat`"];
    assert_error(result, "missing_column", 1, &parts);
}

#[test]
fn wrong_unit() {
    let result = read("pose,direction,repeat,force_mm,displacement_um\nP1,x,1,0,0\n");
    assert_error(
        result,
        "wrong_unit",
        1,
        &["`force_mm`", "`mm`", "N, mN, uN"],
    );
    let result = read("# bench 2\npose,direction,repeat,force,displacement_um\nP1,x,1,0,0\n");
    assert_error(result, "wrong_unit", 2, &["`force`", "none"]);
    let result = read("pose,direction,repeat,force_N,displacement_furlong\nP1,x,1,0,0\n");
    assert_error(
        result,
        "wrong_unit",
        1,
        &["`displacement_furlong`", "um, mm"],
    );
}

#[test]
fn decimal_comma_is_read_and_said() {
    let text =
        "pose;direction;repeat;force_N;displacement_um\nP1;x;1;-9,9;-1276\nP1;x;1;-20,4;-2649,5\n";
    let table = read(text).unwrap();
    assert_eq!(table.readings[0].force_n, -9.9);
    assert_eq!(table.readings[1].displacement_m, -0.002_649_5);
    assert!(
        table
            .assumptions
            .contains(&"numbers have a decimal comma, as in line 2".to_owned())
    );
    let said: Vec<String> = table.assumptions.iter().map(ToString::to_string).collect();
    assert!(said.contains(&"fields are delimited by a semicolon".to_owned()));
    assert!(said.contains(&"numbers have a decimal comma, as in line 2".to_owned()));
}

#[test]
fn decimal_comma_between_commas_is_an_error() {
    assert_error(
        five(&["P1,x,1,-9,9,-1276"]),
        "field_count",
        2,
        &["6 fields, expected 5"],
    );
    // In quotes it is clear what is meant.
    assert_eq!(
        five(&["P1,x,1,\"-9,9\",-1276"]).unwrap().readings[0].force_n,
        -9.9
    );
}

#[test]
fn two_decimal_signs_are_an_error() {
    let text =
        "pose;direction;repeat;force_N;displacement_um\nP1;x;1;-9,9;-1276\nP1;x;1;-20.4;-2649\n";
    let parts = ["column `force_N`", "`-20.4`", "comma of line 2"];
    assert_error(read(text), "mixed_decimals", 3, &parts);
}

#[test]
fn text_in_a_number() {
    let rows = ["P1,x,1,0,0", "P1,x,1,ten,4"];
    let parts = ["column `force_N`", "`ten`", "expected a number"];
    assert_error(five(&rows), "bad_value", 3, &parts);
    assert_error(
        five(&["P1,x,1,0,4 um"]),
        "bad_value",
        2,
        &["`displacement_um`", "`4 um`"],
    );
}

#[test]
fn not_a_number_and_infinity() {
    assert_error(
        five(&["P1,x,1,0,0", "P1,x,1,NaN,4"]),
        "not_finite",
        3,
        &["`NaN`", "`force_N`"],
    );
    assert_error(
        five(&["P1,x,1,0,-inf"]),
        "not_finite",
        2,
        &["`-inf`", "`displacement_um`"],
    );
    assert_error(five(&["P1,x,1,1e999,0"]), "not_finite", 2, &["`1e999`"]);
}

#[test]
fn nothing_where_a_number_belongs() {
    let parts = ["column `force_N`", "nothing, expected a number"];
    assert_error(five(&["P1,x,1,,0"]), "missing_value", 2, &parts);
    assert_error(five(&[",x,1,0,0"]), "missing_value", 2, &["column `pose`"]);
}

#[test]
fn wrong_words_and_counts() {
    assert_error(
        five(&["P1,w,1,0,0"]),
        "bad_value",
        2,
        &["`direction`", "`w`", "x, y or z"],
    );
    assert_error(
        five(&["P1,x,-1,0,0"]),
        "bad_value",
        2,
        &["`repeat`", "`-1`", "from 1"],
    );
    assert_error(five(&["P1,x,0,0,0"]), "bad_value", 2, &["`repeat`", "`0`"]);
    let with = |column: &str, value: &str| read(&format!("{FIVE},{column}\nP1,x,1,0,0,{value}\n"));
    assert_error(
        with("branch", "up"),
        "bad_value",
        2,
        &["`up`", "loading or unloading"],
    );
    assert_error(
        with("status", "ok"),
        "bad_value",
        2,
        &["accepted, superseded or rejected"],
    );
    assert_error(with("step", "1.5"), "bad_value", 2, &["`step`", "from 0"]);
    assert_error(
        with("attempt", "0"),
        "bad_value",
        2,
        &["`attempt`", "from 1"],
    );
}

#[test]
fn wrong_field_count() {
    assert_error(
        five(&["P1,x,1,0,0", "P1,x,1,0"]),
        "field_count",
        3,
        &["4 fields, expected 5"],
    );
    // Empty fields that a spreadsheet leaves behind are nothing.
    assert_eq!(five(&["P1,x,1,0,0,,"]).unwrap().readings.len(), 1);
}

#[test]
fn zero_force_is_a_reading() {
    let table = five(&["P1,x,1,0.0,2", "P1,x,1,-10,-40", "P1,x,2,0,1"]).unwrap();
    assert_eq!(table.readings[0].target_n, 0.0);
    assert_eq!(table.accepted().count(), 3);
    let all_zero = five(&["P1,x,1,0,2", "P1,x,2,0,1"]).unwrap();
    let notes: Vec<String> = all_zero.notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        ["P1 x has no force other than zero, so it has no stiffness"]
    );
    let missed = read(&format!(
        "{FIVE},target_N\nP1,x,1,0,0,0\nP1,x,1,0,1,-10\nP1,x,2,-10,1,-10\n"
    ));
    assert_eq!(
        missed.unwrap().notes,
        ["zero force at a target load other than zero: 1 reading, first in line 3"]
    );
}

#[test]
fn one_repeat_is_said() {
    let table = five(&[
        "P1,x,1,0,0",
        "P1,x,1,-10,-40",
        "P2,y,1,-10,-4",
        "P2,y,2,-10,-5",
    ])
    .unwrap();
    let notes: Vec<String> = table.notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        ["P1 x has one repeat: the scatter between repeats is unknown"]
    );
}

#[test]
fn duplicated_reading() {
    let rows = "P1,x,1,0,0,0\nP1,x,1,-10,-40,1\nP1,x,1,-10,-40,1\n";
    assert_error(
        read(&format!("{FIVE},step\n{rows}")),
        "duplicate_reading",
        4,
        &[
            "the same reading as line 3",
            "P1 x, loading, step 1, repeat 1",
        ],
    );
    // Without a step it may be a second reading that agrees: kept, and said.
    let table = five(&["P1,x,1,0,0", "P1,x,1,-10,-40", "P1,x,1,-10,-40"]).unwrap();
    assert_eq!(table.readings.len(), 3);
    let said = "line 4 repeats line 3 word for word; both are kept as separate readings";
    assert!(table.assumptions.iter().any(|one| one == said));
}

#[test]
fn several_sessions() {
    let text = format!("session,{FIVE}\na1,P1,x,1,0,0\nb2,P1,x,1,0,0\n");
    assert_error(
        read(&text),
        "several_sessions",
        3,
        &["`b2`", "line 2 has session `a1`"],
    );
}

#[test]
fn unknown_pose() {
    let table = five(&["P1,x,1,0,0", "reach_out,x,1,0,0"]).unwrap();
    let known = [PoseId::new("P1"), PoseId::new("reach-out")];
    let error = check_poses(&table, &known).unwrap_err();
    assert_eq!(line_in(&error.to_string()), Some(3));
    assert_eq!(
        error.to_string(),
        "bench.csv, line 3, column `pose`: `reach_out` is not one of the known poses `P1`, `reach-out`"
    );
    assert_eq!(error.help().unwrap().to_string(), "is `reach-out` meant?");
    assert!(check_poses(&table, &[known[0].clone(), PoseId::new("reach_out")]).is_ok());
}

#[test]
fn empty_file_and_header_only() {
    for text in ["", "\n\n", "# a comment\n", "\u{feff}"] {
        let (code, line, _) = error(read(text));
        assert_eq!((code.as_str(), line), ("stiffbench::readings::empty", None));
    }
    assert_error(read(&format!("{FIVE}\n")), "no_readings", 1, &["bench.csv"]);
    assert_error(
        read(&format!("{FIVE}\n,,,,\n")),
        "no_readings",
        1,
        &["bench.csv"],
    );
}

#[test]
fn lines_are_right_after_quoted_line_breaks() {
    let text = format!("{FIVE},note\r\nP1,x,1,0,0,\"the gauge\r\nslipped\"\r\n\r\nP1,x,1,x,0,\r\n");
    assert_error(read(&text), "bad_value", 5, &["`force_N`"]);
}

#[test]
fn an_open_quote() {
    let text = format!("{FIVE},note\nP1,x,1,0,0,\"the gauge\nP1,x,1,-10,-4,\n");
    assert_error(read(&text), "unclosed_quote", 2, &["never ends"]);
}

#[test]
fn what_does_not_count_is_listed() {
    let text = format!(
        "{FIVE},status,colour\n# first try\nP1,x,1,0,0,superseded,red\n\nP1,x,1,0,1,,red\nP1,x,1,-10,9,Rejected,\n"
    );
    let table = read(&text).unwrap();
    assert_eq!(table.excluded.superseded, [3]);
    assert_eq!(table.excluded.rejected, [6]);
    assert_eq!(table.excluded.blank, [4]);
    assert_eq!(table.excluded.comments, [2]);
    assert_eq!(
        table.excluded.to_string(),
        "superseded: 1 (first in line 3); rejected: 1 (first in line 6); blank: 1 (first in line 4); comments: 1 (first in line 2)"
    );
    assert!(
        table
            .notes
            .contains(&"column `colour` is not used".to_owned())
    );
}

#[test]
fn defaults_are_said() {
    let table = five(&["P1,X,1,0,0", "P1,x,1,-10,-40", "P1,x,1,-0.1,-1"]).unwrap();
    let said: Vec<String> = table.assumptions.iter().map(ToString::to_string).collect();
    for part in [
        "`branch`",
        "`step`",
        "`target_N`",
        "`zero_id`",
        "creep cannot be tested",
    ] {
        assert!(
            said.iter().any(|text| text.contains(part)),
            "{part}: {said:?}"
        );
    }
    assert!(said.contains(
        &"loads that go down again are taken as unloading: 1 reading, first in line 4".to_owned()
    ));
    assert_eq!(table.readings[2].branch, Branch::Unloading);
}

#[test]
fn a_million_rows() {
    const ROWS: usize = 1_000_000;
    let mut text = String::with_capacity(ROWS * 24);
    writeln!(text, "{FIVE}").unwrap();
    for row in 0..ROWS {
        let (run, step) = (row / 8, row % 8);
        let pose = run / 15 % 40;
        let direction = ["x", "y", "z"][run / 5 % 3];
        let repeat = run / 600 * 5 + run % 5 + 1;
        writeln!(
            text,
            "P{pose},{direction},{repeat},-{step}0.{},-{step}7{row}",
            row % 5
        )
        .unwrap();
    }
    let table = read(&text).unwrap();
    assert_eq!(table.readings.len(), ROWS);
    assert_eq!(table.runs.len(), ROWS / 8);
    assert_eq!(table.cells().len(), 120);
    assert_eq!(table.readings[ROWS - 1].line as usize, ROWS + 1);
    assert_eq!(table.readings[ROWS - 1].target_n, -70.0);
}
