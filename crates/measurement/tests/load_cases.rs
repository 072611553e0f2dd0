//! Tables of load cases: what is read, what is refused with its place, and that what is written is read back.

use stiffbench_measurement::load_cases::{
    LoadAxes, LoadCaseTable, is_load_case_table, read_load_cases, write_load_cases,
};
use stiffbench_measurement::readings::TableError;

fn read(text: &str) -> Result<LoadCaseTable, TableError> {
    read_load_cases("cases.csv", text.as_bytes())
}

fn error(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

const TWO: &str = "pose,joint_p1_deg,joint_p2_rad,axes,force_x_N,force_z_kN,moment_y_Nm,displacement_x_um,displacement_z_mm,rotation_y_urad\n\
    a,90,1.5,base,100,-0.2,5,-12.5,,30\n\
    b,-45,0,tool,0,1,0,,2,\n";

#[test]
fn vectors_are_read_in_si_and_an_empty_field_was_not_read() {
    let table = read(TWO).unwrap();
    let names: Vec<&str> = table.joints.iter().map(|j| j.variable.as_str()).collect();
    assert_eq!(names, ["p1", "p2"]);
    let [a, b] = &table.cases[..] else {
        panic!("{:?}", table.cases);
    };
    assert_eq!((a.line, a.pose.as_str(), a.repeat), (2, "a", 1));
    assert_eq!(a.joints, [90.0_f64.to_radians(), 1.5]);
    assert_eq!((&a.axes, &b.axes), (&LoadAxes::Base, &LoadAxes::Tool));
    assert_eq!(a.force_n, [100.0, 0.0, -200.0]);
    assert_eq!(a.moment_nm, [0.0, 5.0, 0.0]);
    assert_eq!(a.displacement_m, [Some(-12.5e-6), None, None]);
    assert_eq!(a.rotation_rad, [None, Some(30e-6), None]);
    assert_eq!(b.displacement_m, [None, None, Some(2e-3)]);
    assert_eq!(table.component_count(), 3);
}

#[test]
fn a_table_comes_back_from_what_was_written() {
    let mut table = read(TWO).unwrap();
    table.origin = Some("simulated; seed 3, no noise".to_owned());
    let text = write_load_cases(&table);
    let again = read(&text).unwrap();
    assert_eq!(again.origin, table.origin);
    assert_eq!(again.joints, table.joints);
    for (found, expected) in again.cases.iter().zip(&table.cases) {
        for (a, b) in found.joints.iter().zip(&expected.joints) {
            assert!((a - b).abs() <= 4e-15, "{a} {b}");
        }
        assert_eq!(found.force_n, expected.force_n);
        assert_eq!(found.moment_nm, expected.moment_nm);
        assert_eq!(found.displacement_m, expected.displacement_m);
        assert_eq!(found.rotation_rad, expected.rotation_rad);
        assert_eq!(found.axes, expected.axes);
    }
}

#[test]
fn a_table_without_names_of_poses_numbers_them_by_their_joint_values() {
    let table = read("joint_p1_deg,force_x_N,displacement_x_um\n10,5,1\n20,5,2\n10,6,3\n").unwrap();
    let poses: Vec<&str> = table.cases.iter().map(|case| case.pose.as_str()).collect();
    assert_eq!(poses, ["1", "2", "1"]);
    let notes: Vec<String> = table.notes.iter().map(ToString::to_string).collect();
    assert!(notes.iter().any(|note| note.contains("no column `pose`")));
    assert!(notes.iter().any(|note| note.contains("no column `axes`")));
}

#[test]
fn forms_are_told_by_their_columns() {
    assert!(is_load_case_table(TWO.as_bytes()));
    assert!(is_load_case_table(
        b"# a comment\n\npose;Force X [N];disp_x_mm\n"
    ));
    assert!(!is_load_case_table(
        b"pose,direction,repeat,force_N,displacement_um\n"
    ));
    assert!(!is_load_case_table(b""));
    let mixed = error("pose,direction,force_x_N,displacement_x_um\na,x,1,2\n");
    assert!(mixed.contains("mixes two forms"), "{mixed}");
}

#[test]
fn what_is_wrong_has_its_line_column_and_remedy() {
    let head = "pose,force_x_N,displacement_x_um";
    let cases = [
        (
            format!("{head}\na,0,5\n"),
            "line 2: force and moment are zero",
        ),
        (
            format!("{head}\na,1,\n"),
            "line 2: no component of displacement",
        ),
        (
            format!("{head}\na,1,2\nb,,2\n"),
            "line 3, column `force_x_N`: nothing",
        ),
        (
            format!("{head}\na,1,NaN\n"),
            "line 2, column `displacement_x_um`: `NaN` is not a finite number",
        ),
        (
            format!("{head}\na,1,1 um\n"),
            "line 2, column `displacement_x_um`: `1 um`, expected a number",
        ),
        (format!("{head}\n,1,2\n"), "line 2, column `pose`: nothing"),
        (
            "pose,force_x,displacement_x_um\na,1,2\n".to_owned(),
            "column `force_x` has none for its unit",
        ),
        (
            "pose,force_x_mm,displacement_x_um\na,1,2\n".to_owned(),
            "column `force_x_mm` has `mm` for its unit",
        ),
        (
            "joint_J1_N,force_x_N,displacement_x_um\n1,1,2\n".to_owned(),
            "column `joint_J1_N` has `N` for its unit",
        ),
        (
            "pose,displacement_x_um\na,2\n".to_owned(),
            "no column of a load",
        ),
        (
            "pose,force_x_N\na,2\n".to_owned(),
            "no column of a displacement",
        ),
        (
            "force_x_N,displacement_x_um\n1,2\n".to_owned(),
            "no column of a pose or a joint",
        ),
        (
            "pose,force_x_N,force_x_kN,displacement_x_um\na,1,2,3\n".to_owned(),
            "both give force",
        ),
        (
            format!("{head},repeat\na,1,2,0\n"),
            "column `repeat`: `0`, expected a whole number from 1",
        ),
        (
            format!("{head},status\na,1,2,perhaps\n"),
            "column `status`: `perhaps`",
        ),
        (format!("{head}\n"), "no reading follows the header"),
    ];
    for (text, expected) in cases {
        let found = error(&text);
        assert!(found.contains(expected), "{found}\n expected {expected}");
    }
    let empty = read("").unwrap_err();
    assert_eq!(empty.code, "stiffbench::readings::empty");
}

#[test]
fn rejected_rows_are_left_out_and_listed_and_repeated_ones_noted() {
    let table =
        read("pose,force_x_N,displacement_x_um,status\na,1,2,\nb,0,,rejected\na,1,2,\n").unwrap();
    assert_eq!(table.cases.len(), 2);
    let notes: Vec<String> = table.notes.iter().map(ToString::to_string).collect();
    assert!(
        notes.iter().any(|note| note.contains("line 3")),
        "{notes:?}"
    );
    assert!(
        notes
            .iter()
            .any(|note| note.contains("line 4 repeats line 2")),
        "{notes:?}"
    );
}

const POSITIONS: &str =
    "joint_J1_deg,position_x_mm,position_y_m,position_z_mm\n10,1234.5,2,\n20,1,,3\n";

#[test]
fn positions_need_no_load_and_come_back_from_what_was_written() {
    let mut table = read(POSITIONS).unwrap();
    assert!(table.has_positions());
    assert_eq!(table.cases[0].position_m, [Some(1.2345), Some(2.0), None]);
    assert_eq!(table.cases[0].force_n, [0.0; 3]);
    assert_eq!(table.component_count(), 4);
    let notes: Vec<String> = table.notes.iter().map(ToString::to_string).collect();
    assert!(!notes.iter().any(|note| note.contains("axes")), "{notes:?}");
    table.cases[1].force_n = [0.0, -120.0, 0.0];
    let text = write_load_cases(&table);
    assert!(
        text.starts_with("pose,joint_J1_deg,repeat,axes,force_x_N"),
        "{text}"
    );
    assert!(!text.contains("displacement"), "{text}");
    let again = read(&text).unwrap();
    for (found, expected) in again.cases.iter().zip(&table.cases) {
        assert_eq!(found.position_m, expected.position_m);
        assert_eq!(found.force_n, expected.force_n);
    }
}

#[test]
fn positions_beside_displacements_and_rows_without_any_are_refused() {
    let mixed = error("pose,force_x_N,position_x_mm,displacement_x_um\na,1,2,3\n");
    for words in ["line 1", "position_x_mm", "displacement_x_um", "two tables"] {
        assert!(mixed.contains(words), "{mixed}");
    }
    let empty = error("joint_J1_deg,position_x_mm\n10,5\n20,\n");
    assert!(
        empty.contains("line 3") && empty.contains("position"),
        "{empty}"
    );
    let unit = error("joint_J1_deg,position_x_N\n10,5\n");
    assert!(unit.contains("position_x_N"), "{unit}");
}
