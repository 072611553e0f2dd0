//! Tables of a specimen: what is read, what is decided and said, and the exact error of what is wrong.

use std::fmt::Write as _;

use miette::Diagnostic;
use proptest::prelude::*;
use stiffbench_measurement::readings::TableError;
use stiffbench_measurement::specimen::{
    Incomplete, ResponseVariable, SpecimenOptions, SpecimenTable, read_specimen,
};
use stiffbench_units_and_text::test_point::Branch;

/// Columns `F_N` and `d_um`.
fn options() -> SpecimenOptions {
    SpecimenOptions {
        force_column: Some("F_N".to_owned()),
        displacement_column: "d_um".to_owned(),
        ..SpecimenOptions::default()
    }
}

fn read_with(table: &str, options: &SpecimenOptions) -> Result<SpecimenTable, TableError> {
    read_specimen(&[("pull.csv", table.as_bytes())], options)
}

fn read(table: &str) -> Result<SpecimenTable, TableError> {
    read_with(table, &options())
}

const LOADS_WERE_SET: &str =
    "loads were set and displacements measured: the table does not show which";

/// Whether a table was read on an assumption that begins so.
fn assumes(table: &SpecimenTable, start: &str) -> bool {
    table.assumptions.iter().any(|one| one.starts_with(start))
}

/// The first line that a message names.
pub(crate) fn line_in(message: &str) -> Option<u32> {
    let (_, rest) = message.split_once(", line ")?;
    let digits = rest.split(|c: char| !c.is_ascii_digit()).next()?;
    digits.parse().ok()
}

#[track_caller]
fn assert_error(error: &TableError, code: &str, line: Option<u32>, parts: &[&str]) {
    let message = error.to_string();
    assert_eq!(
        error.code().expect("every error has a code").to_string(),
        format!("stiffbench::{code}")
    );
    assert!(
        error.help().is_some(),
        "every error says what to do: {message}"
    );
    assert_eq!(line_in(&message), line, "{message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

#[test]
fn a_plain_table_becomes_si() {
    let table = read("F_N,d_um,note\n0,0,a\n10,4,b\n20,8.5,c\n").unwrap();
    assert_eq!(
        (table.force_unit.si, table.displacement_unit.si),
        ("N", "m")
    );
    assert_eq!(table.readings[2].displacement, 8.5e-6);
    assert_eq!(table.readings[2].line, 4);
    assert_eq!(table.readings[2].order, 3);
    assert_eq!(table.configurations, ["specimen"]);
    assert_eq!(table.runs[0].label, "specimen");
    assert_eq!(table.unused_columns, ["note"]);
    for expected in [
        "all readings are of one specimen",
        "all readings of a specimen are one run, with one zero",
        "column `d_um` is in um, by its name",
    ] {
        assert!(assumes(&table, expected), "{expected}");
    }
}

#[test]
fn units_given_come_before_those_in_names() {
    let with = |force: &str, displacement: &str| SpecimenOptions {
        force_unit: Some(force.to_owned()),
        displacement_unit: Some(displacement.to_owned()),
        ..options()
    };
    let rows = "F_N,d_um\n2,3\n";
    // NIST SP 811 (2008), appendix B.8, for pound-force and kilogram-force.
    for (unit, newton) in [
        ("kN", 2e3),
        ("mN", 2e-3),
        ("nN", 2e-9),
        ("lbf", 8.896_443_230_521),
        ("kgf", 19.6133),
        ("1", 2.0),
    ] {
        let table = read_with(rows, &with(unit, "m")).unwrap();
        assert!(
            (table.readings[0].force / newton - 1.0).abs() < 1e-13,
            "{unit}"
        );
    }
    for (unit, metre) in [
        ("m", 3.0),
        ("mm", 3e-3),
        ("um", 3e-6),
        ("nm", 3e-9),
        ("in", 0.0762),
        ("1", 3.0),
    ] {
        let table = read_with(rows, &with("N", unit)).unwrap();
        assert!(
            (table.readings[0].displacement / metre - 1.0).abs() < 1e-13,
            "{unit}"
        );
    }
    let table = read_with(rows, &with("1", "1")).unwrap();
    assert_eq!(
        (table.force_unit.si, table.displacement_unit.si),
        ("1", "1")
    );
}

#[test]
fn times_holds_and_temperatures_are_read() {
    let options = SpecimenOptions {
        time_column: Some("clock".to_owned()),
        time_unit: Some("min".to_owned()),
        hold_column: Some("hold".to_owned()),
        temperature_column: Some("air_K".to_owned()),
        ..options()
    };
    let table = read_with(
        "F_N,d_um,clock,hold,air_K\n1,1,0.5,1,293.15\n2,2,2,,\n",
        &options,
    )
    .unwrap();
    assert_eq!(table.readings[0].time_s, Some(30.0));
    assert_eq!(table.readings[0].hold_s, Some(60.0));
    assert!((table.readings[0].temperature_deg_c.unwrap() - 20.0).abs() < 1e-12);
    assert_eq!(table.readings[1].hold_s, None);
    let absent = "no value of `hold` in 1 row, first in line 3; kept without it";
    assert!(assumes(&table, absent));
    let bare = SpecimenOptions {
        temperature_column: Some("hold".to_owned()),
        ..self::options()
    };
    let table = read_with("F_N,d_um,hold\n1,1,20\n", &bare).unwrap();
    assert_eq!(table.readings[0].temperature_deg_c, Some(20.0));
    assert!(assumes(&table, "temperatures without a unit are °C"));
    let hours = SpecimenOptions {
        time_column: Some("t_h".to_owned()),
        ..self::options()
    };
    let table = read_with("F_N,d_um,t_h\n1,1,0.5\n", &hours).unwrap();
    assert_eq!(table.readings[0].time_s, Some(1800.0));
}

#[test]
fn runs_and_configurations_may_have_several_columns() {
    let options = SpecimenOptions {
        run_column: vec!["day".to_owned(), "sweep".to_owned()],
        configuration_column: vec!["bar".to_owned()],
        ..options()
    };
    let table = read_with(
        "bar,day,sweep,F_N,d_um\nA,1,1,0,0\nA,1,2,0,0\nB,1,1,0,0\nA,1,1,5,2\n",
        &options,
    )
    .unwrap();
    assert_eq!(table.configurations, ["A", "B"]);
    let runs: Vec<_> = table
        .runs
        .iter()
        .map(|run| (run.label.as_str(), run.configuration))
        .collect();
    assert_eq!(runs, [("1 / 1", 0), ("1 / 2", 0), ("1 / 1", 1)]);
    assert_eq!(table.readings[3].run, 0);
}

#[test]
fn incomplete_rows_are_listed() {
    let options = SpecimenOptions {
        run_column: vec!["run".to_owned()],
        ..options()
    };
    let table = read_with(
        "run,F_N,d_um\n1,0,0\n1,10,\n,20,8\n1,NA,3\n\n# pause\n1,nan,3\n1,30,12\n",
        &options,
    )
    .unwrap();
    assert_eq!(table.readings.len(), 2);
    let listed: Vec<(u32, &str)> = table
        .excluded
        .incomplete
        .iter()
        .map(|Incomplete { line, column }| (*line, column.as_str()))
        .collect();
    assert_eq!(listed, [(3, "d_um"), (4, "run"), (5, "F_N"), (8, "F_N")]);
    assert_eq!(
        (&table.excluded.blank[..], &table.excluded.comments[..]),
        (&[6][..], &[7][..])
    );
    assert_eq!(
        table.excluded.to_string(),
        "incomplete: 4 (first in line 3); blank: 1 (first in line 6); comments: 1 (first in line 7)"
    );
}

#[test]
fn foreign_tables_are_understood_and_it_is_said() {
    let layout_of = |table: &SpecimenTable| table.assumptions[0].clone();
    let table = read("\u{feff}F_N;d_um\n0,5;1,25\n").unwrap();
    assert_eq!(table.readings[0].displacement, 1.25e-6);
    assert_eq!(
        layout_of(&table),
        "table taken as UTF-8 with byte order mark, delimiter semicolon, decimal comma; names in line 1; 1 rows in lines 2 to 2; \
         `F_N` in N, `d_um` in um"
    );
    let table = read("F_N\td_um\n1\t2\n").unwrap();
    assert_eq!(table.readings.len(), 1);
    let runs = SpecimenOptions {
        run_column: vec!["run".to_owned()],
        ..options()
    };
    let latin = read_specimen(&[("pull.csv", &b"run,F_N,d_um\n\xb5,1,2\n"[..])], &runs).unwrap();
    assert_eq!(latin.runs[0].label, "µ");
    assert!(layout_of(&latin).contains("windows-1252"));
}

#[test]
fn the_order_column_is_followed_where_it_can_be() {
    let ordered = SpecimenOptions {
        order_column: Some("n".to_owned()),
        run_column: vec!["run".to_owned()],
        ..options()
    };
    let lines = |table: &SpecimenTable| table.readings.iter().map(|r| r.line).collect::<Vec<_>>();
    let table = read_with("run,n,F_N,d_um\na,7,0,0\na,3,1,1\nb,5,2,2\n", &ordered).unwrap();
    assert_eq!(lines(&table), [3, 4, 2]);
    assert_eq!(table.readings[0].order, 3);
    assert!(assumes(&table, "rows were sorted by the order column"));
    let table = read_with("run,n,F_N,d_um\na,2,0,0\nb,1,1,1\na,1,2,2\n", &ordered).unwrap();
    assert_eq!(lines(&table), [4, 2, 3]);
    let said = "the order column starts again in each run: rows were sorted within their runs";
    assert!(assumes(&table, said));
    let table = read_with("run,n,F_N,d_um\na,1,0,0\nb,1,1,1\nb,2,2,2\n", &ordered).unwrap();
    assert_eq!(lines(&table), [2, 3, 4], "in order already");
    let table = read_with("run,n,F_N,d_um\na,2,0,0\na,1,1,1\na,2,2,2\n", &ordered).unwrap();
    assert_eq!(lines(&table), [2, 3, 4]);
    assert_eq!(table.readings[2].order, 3);
    let said = "the number in the order column of line 4 occurs before";
    assert!(assumes(&table, said));
}

#[test]
fn time_that_goes_back_is_noted() {
    let options = SpecimenOptions {
        time_column: Some("t_s".to_owned()),
        ..options()
    };
    let table = read_with("F_N,d_um,t_s\n0,0,0\n1,1,5\n2,2,\n3,3,4\n", &options).unwrap();
    assert!(assumes(&table, "in 1 run time goes back, first in line 5"));
    let table = read_with("F_N,d_um,t_s\n0,0,0\n1,1,5\n", &options).unwrap();
    assert!(
        !table
            .assumptions
            .iter()
            .any(|one| one.contains("time goes back"))
    );
}

#[test]
fn branches_come_from_a_column_or_from_the_path() {
    let unloading = |table: &SpecimenTable| {
        let of = table
            .readings
            .iter()
            .filter(|r| r.branch == Branch::Unloading);
        of.map(|r| r.line).collect::<Vec<_>>()
    };
    let rows = "way,F_N,d_um\nload,0,0\nUnload,10,1\nloading,20,2\nunloading,10,1\nload,0,0\n";
    let table = read(rows).unwrap();
    assert_eq!(unloading(&table), [5, 6]);
    let said = "branches are derived from the path: 1 cycle and 1 turn, where a turn is a return by more than 5 % of the run's range";
    assert!(assumes(&table, said));
    let named = SpecimenOptions {
        branch_column: Some("way".to_owned()),
        ..options()
    };
    assert_eq!(unloading(&read_with(rows, &named).unwrap()), [3, 5]);
    // The displacement is set: it turns where the force does not.
    let set = SpecimenOptions {
        response: Some(ResponseVariable::Force),
        ..options()
    };
    let rows = "F_N,d_um\n0,5\n1,6\n2,7\n2,6\n2,5\n";
    let table = read_with(rows, &set).unwrap();
    assert_eq!(unloading(&table), [5, 6]);
    assert_eq!(
        (
            table.driver(&table.readings[1]),
            table.answer(&table.readings[1])
        ),
        (6e-6, 1.0)
    );
    assert_eq!(unloading(&read(rows).unwrap()), [] as [u32; 0]);
}

#[test]
fn without_a_force_the_load_is_constant() {
    let options = SpecimenOptions {
        force_column: None,
        displacement_column: "reading".to_owned(),
        displacement_unit: Some("1".to_owned()),
        ..SpecimenOptions::default()
    };
    let table = read_with("reading\n2.0018\n2.0017\n", &options).unwrap();
    let said = "no force column: the load is the same throughout";
    assert!(assumes(&table, said));
    assert!(!assumes(&table, "branches are derived from the path"));
    assert_eq!(table.readings[1].force, 0.0);
}

#[test]
fn options_that_cannot_be() {
    let same = SpecimenOptions {
        displacement_column: "F_N".to_owned(),
        ..options()
    };
    let error = read_with("F_N,d_um\n1,2\n", &same).unwrap_err();
    assert_error(&error, "table::same_column", None, &["`F_N`"]);
    for share in [0.0, 1.0, -0.1, f64::NAN] {
        let wrong = SpecimenOptions {
            turn_share: Some(share),
            ..options()
        };
        let error = read_with("F_N,d_um\n1,2\n", &wrong).unwrap_err();
        assert_error(
            &error,
            "specimen::bad_turn_share",
            None,
            &["between 0 and 1"],
        );
    }
    for (force_unit, displacement_unit, option) in [
        ("mm", "um", "--force-unit"),
        ("N", "N", "--displacement-unit"),
        ("mn", "um", "--force-unit"),
    ] {
        let wrong = SpecimenOptions {
            force_unit: Some(force_unit.to_owned()),
            displacement_unit: Some(displacement_unit.to_owned()),
            ..options()
        };
        let error = read_with("F_N,d_um\n1,2\n", &wrong).unwrap_err();
        assert_error(
            &error,
            "specimen::wrong_unit",
            None,
            &[option, "expected one of"],
        );
    }
    let wrong = SpecimenOptions {
        time_column: Some("t".to_owned()),
        time_unit: Some("1".to_owned()),
        ..options()
    };
    let error = read_with("F_N,d_um,t\n1,2,3\n", &wrong).unwrap_err();
    assert_error(
        &error,
        "specimen::wrong_unit",
        None,
        &["`1`", "--time-unit"],
    );
}

#[test]
fn headers_that_do_not_fit() {
    let error = read("F_N,dd_um\n1,2\n").unwrap_err();
    assert_error(
        &error,
        "table::unknown_column",
        Some(1),
        &["pull.csv, line 1", "`d_um`", "`F_N`, `dd_um`"],
    );
    let help = error.help().unwrap().to_string();
    assert_eq!(help, "is `dd_um` meant? --map displacement=dd_um");
    let error = read("0,0\n1,2\n").unwrap_err();
    assert!(
        error
            .help()
            .unwrap()
            .to_string()
            .contains("its number from 1")
    );
    let error = read("# rig 3\nF_N,d_um,d_um\n1,2,3\n").unwrap_err();
    assert_error(
        &error,
        "table::duplicate_column",
        Some(2),
        &["`d_um`", "columns 2 and 3"],
    );
    for name in ["d", "strain_um_m", "d_per_m"] {
        let bare = SpecimenOptions {
            displacement_column: name.to_owned(),
            ..options()
        };
        let error = read_with(&format!("F_N,{name}\n1,2\n"), &bare).unwrap_err();
        assert_error(
            &error,
            "specimen::no_unit",
            Some(1),
            &[name, "um, mm, m, nm, cm, in"],
        );
        assert!(
            error
                .help()
                .unwrap()
                .to_string()
                .contains("--displacement-unit 1")
        );
    }
}

#[test]
fn values_that_do_not_fit() {
    let error = read("F_N,d_um\n1,2\n2,x3\n").unwrap_err();
    assert_error(
        &error,
        "table::bad_number",
        Some(3),
        &["line 3, column `d_um`: `x3`, expected a number"],
    );
    let named = SpecimenOptions {
        branch_column: Some("way".to_owned()),
        ..options()
    };
    let error = read_with("way,F_N,d_um\nup,1,2\n", &named).unwrap_err();
    assert_error(
        &error,
        "specimen::bad_value",
        Some(2),
        &["`way`: `up`, expected loading or unloading"],
    );
    let ordered = SpecimenOptions {
        order_column: Some("n".to_owned()),
        ..options()
    };
    let error = read_with("n,F_N,d_um\n1.5,1,2\n", &ordered).unwrap_err();
    assert_error(
        &error,
        "specimen::bad_value",
        Some(2),
        &["`1.5`, expected a whole number from 0"],
    );
}

#[test]
fn texts_that_are_no_tables() {
    for empty in ["", "\n\n# nothing\n", ",,\n"] {
        assert_error(
            &read(empty).unwrap_err(),
            "table::empty",
            None,
            &["pull.csv"],
        );
    }
    assert_error(
        &read("F_N,d_um\n").unwrap_err(),
        "specimen::no_readings",
        Some(1),
        &["0 rows"],
    );
    let error = read("F_N,d_um\n1,\n,2\n").unwrap_err();
    assert_error(
        &error,
        "specimen::no_readings",
        Some(1),
        &["2 rows without a value"],
    );
    let error = read("F_N,d_um\n1,2,3\n").unwrap_err();
    assert_error(
        &error,
        "table::field_count",
        Some(2),
        &["3 fields, expected 2"],
    );
    let error = read("F_N;d_um\n1.5;2\n2,5;3\n").unwrap_err();
    assert_error(
        &error,
        "table::mixed_decimals",
        Some(3),
        &["`2,5`", "line 2"],
    );
    let error = read("F_N,d_um\n1,inf\n").unwrap_err();
    assert_error(&error, "table::not_finite", Some(2), &["`inf`"]);
    let error = read("F_N,d_um\n1,\"2\n").unwrap_err();
    assert_error(&error, "table::unclosed_quote", Some(2), &["never ends"]);
    let error = read_specimen(&[("pull.csv", &b"F_N\0,d_um\n"[..])], &options()).unwrap_err();
    assert_error(&error, "table::not_text", Some(1), &["not text"]);
}

#[test]
fn options_of_files_have_the_names_of_flags() {
    let options: SpecimenOptions = toml::from_str("displacement-column = \"d\"\nforce-column = \"F\"\nresponse = \"force\"\nrun-column = [\"a\"]").unwrap();
    assert_eq!(
        (options.response, options.run_column.len()),
        (Some(ResponseVariable::Force), 1)
    );
    assert!(toml::from_str::<SpecimenOptions>("force-column = \"F\"").is_err());
    assert!(
        toml::from_str::<SpecimenOptions>("displacement-column = \"d\"\nforce-colum = \"F\"")
            .is_err()
    );
}

fn everything() -> SpecimenOptions {
    SpecimenOptions {
        time_column: Some("t_s".to_owned()),
        run_column: vec!["run".to_owned()],
        configuration_column: vec!["bar".to_owned()],
        temperature_column: Some("temp_C".to_owned()),
        hold_column: Some("hold_s".to_owned()),
        order_column: Some("n".to_owned()),
        ..options()
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    /// What is written is read, in the stated order, and every line is accounted for.
    #[test]
    fn every_row_is_a_reading_or_is_listed(
        rows in prop::collection::vec((0_u32..3, prop::option::of(-1000_i32..1000), prop::option::of(-1000_i32..1000), prop::option::of(0_u32..100)), 1..40),
        semicolon in any::<bool>(),
    ) {
        let sign = if semicolon { ';' } else { ',' };
        let mut table = format!("run{sign}F_N{sign}d_um{sign}t_s\n");
        for (run, force, displacement, time) in &rows {
            let number = |n: Option<i32>| n.map_or(String::new(), |n| n.to_string());
            let time = time.map_or(String::new(), |t| t.to_string());
            writeln!(table, "{run}{sign}{}{sign}{}{sign}{time}", number(*force), number(*displacement)).unwrap();
        }
        let options = SpecimenOptions { run_column: vec!["run".to_owned()], time_column: Some("t_s".to_owned()), ..options() };
        let complete: Vec<_> = rows.iter().filter_map(|(run, f, d, t)| Some((*run, (*f)?, (*d)?, *t))).collect();
        match read_with(&table, &options) {
            Err(error) => {
                prop_assert!(complete.is_empty());
                let rows = if rows.len() == 1 { "1 row".to_owned() } else { format!("{} rows", rows.len()) };
                let incomplete = format!("({rows} without a value)");
                prop_assert!(error.to_string().ends_with(&incomplete), "{}", error);
            }
            Ok(read) => {
                prop_assert_eq!(read.readings.len(), complete.len());
                prop_assert_eq!(read.excluded.incomplete.len(), rows.len() - complete.len());
                for (reading, (run, force, displacement, time)) in read.readings.iter().zip(&complete) {
                    prop_assert_eq!(&read.runs[reading.run as usize].label, &run.to_string());
                    prop_assert_eq!(reading.force, f64::from(*force));
                    prop_assert_eq!(reading.displacement, format!("{displacement}e-6").parse::<f64>().unwrap());
                    prop_assert_eq!(reading.time_s, time.map(f64::from));
                }
            }
        }
    }

    /// Branches do not change when loads are pushed instead of pulled, or given in another unit.
    #[test]
    fn branches_do_not_depend_on_sign_and_unit(forces in prop::collection::vec(-70_i32..70, 1..30)) {
        let branches = |scale: i32| {
            let mut table = "F_N,d_um\n".to_owned();
            for force in &forces {
                writeln!(table, "{},0", force * scale).unwrap();
            }
            read(&table).unwrap().readings.iter().map(|r| r.branch).collect::<Vec<_>>()
        };
        prop_assert_eq!(branches(1), branches(-1));
        prop_assert_eq!(branches(1), branches(1024));
    }

    /// No bytes make the reader panic.
    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = read_specimen(&[("x", &bytes[..])], &options());
        let mut table = b"bar,run,n,F_N,d_um,t_s,hold_s,temp_C\n".to_vec();
        table.extend(bytes);
        let _ = read_specimen(&[("x", &table[..])], &everything());
    }

    /// Nor does text that nearly is a table.
    #[test]
    fn no_text_panics(rows in "([-+0-9eE.,;aN/A\"\t #\u{b5}]{0,12},){0,8}\n?([0-9.,\"\n-]{0,60})") {
        let table = format!("bar,run,n,F_N,d_um,t_s,hold_s,temp_C\n{rows}");
        let _ = read_with(&table, &everything());
        let set = SpecimenOptions { response: Some(ResponseVariable::Force), order_column: None, ..everything() };
        let _ = read_with(&table, &set);
    }
}

/// A test at 10 readings a second, of what is set as a share of its range, and what answers: `t_s,F_N,d_um`, with the noise that gauges have.
fn of_a_machine(
    set: impl Fn(f64) -> f64,
    answer: impl Fn(f64, bool) -> f64,
    response: ResponseVariable,
) -> String {
    let mut table = "t_s,F_N,d_um\n".to_owned();
    let mut rising = true;
    for step in 0..400 {
        let time = 0.1 * f64::from(step);
        let now = set(time);
        rising = set(time + 0.05) > now || (set(time + 0.05) - now == 0.0 && rising);
        let noise = 1e-3 * (f64::from(step) * 2.4).sin();
        let (set, answer) = (50.0 * now, 80.0 * (answer(now, rising) + noise));
        let (force, displacement) = match response {
            ResponseVariable::Displacement => (set, answer),
            ResponseVariable::Force => (answer, set),
        };
        writeln!(table, "{time:.1},{force:.4},{displacement:.4}").unwrap();
    }
    table
}

#[test]
fn what_a_machine_sets_is_known_by_its_ramps_and_sines() {
    let triangle = |time: f64| {
        let phase = (time / 10.0).fract();
        if phase < 0.5 {
            2.0 * phase
        } else {
            2.0 - 2.0 * phase
        }
    };
    let sine = |time: f64| (0.2 * std::f64::consts::PI * time).sin();
    let curved = |set: f64, _: bool| set - 0.3 * set * set;
    let loop_ = |set: f64, rising: bool| set + if rising { 0.05 } else { -0.05 };
    let line = |set: f64, _: bool| set;
    let with_time = SpecimenOptions {
        time_column: Some("t_s".to_owned()),
        ..options()
    };
    for response in [ResponseVariable::Displacement, ResponseVariable::Force] {
        for table in [
            of_a_machine(triangle, curved, response),
            of_a_machine(triangle, loop_, response),
            of_a_machine(sine, curved, response),
            of_a_machine(sine, loop_, response),
            of_a_machine(triangle, line, response),
        ] {
            let found = read_with(&table, &with_time).unwrap();
            assert_eq!(found.response, response);
            let [set, _] = response.set_and_answer();
            let said = format!("the {set} is a ramp or a sine of time");
            assert!(assumes(&found, &said), "{:?}", found.assumptions);
            // Whoever states the contrary is told; without times the order of the readings is the clock.
            for (stated, doubt) in [
                (response, false),
                (
                    ResponseVariable::Displacement,
                    response != ResponseVariable::Displacement,
                ),
                (ResponseVariable::Force, response != ResponseVariable::Force),
            ] {
                let stated = SpecimenOptions {
                    response: Some(stated),
                    ..with_time.clone()
                };
                let read = read_with(&table, &stated).unwrap();
                assert_eq!(read.response_doubt.is_some(), doubt);
            }
            assert_eq!(read(&table).unwrap().response, response);
        }
    }
}

#[test]
fn loads_by_hand_show_no_machine() {
    // Weights at times of a person, who is not even: a line and a curve.
    let times = [0, 9, 21, 28, 41, 49, 63, 70, 79, 92];
    for bow in [0.0, 0.2] {
        let mut table = "t_s,F_N,d_um\n".to_owned();
        for (step, time) in times.into_iter().enumerate() {
            let load = step as f64 / 9.0;
            let travel = 80.0 * (load + bow * load * load) + 0.05 * (step as f64 * 2.4).sin();
            writeln!(table, "{time},{:.2},{travel:.2}", 50.0 * load).unwrap();
        }
        let with_time = SpecimenOptions {
            time_column: Some("t_s".to_owned()),
            ..options()
        };
        let read = read_with(&table, &with_time).unwrap();
        assert_eq!(read.response, ResponseVariable::Displacement);
        assert!(assumes(&read, LOADS_WERE_SET));
        assert!(!read.is_one_sweep);
    }
}

#[test]
fn where_the_clock_shows_nothing_the_noisier_quantity_is_the_response() {
    // By a fixed sequence, of standard deviation 1.
    let noise = |step: i32, seed: f64| (f64::from(step) * 2.4 + seed).sin() * 2_f64.sqrt();
    // Beyond its preload the part is four times softer, and the travel was set in steps four times as long.
    let soft = |step: i32| 20.0 * f64::from(step.min(30) + 4 * (step - 30).max(0));
    // Twelve readings at each of five levels: between levels both quantities jump.
    let held = |step: i32| f64::from(step / 12);
    // Every other reading another load: what neighbours differ by is no scatter.
    let shuffled = |step: i32| f64::from((step * 37) % 60);
    let of = |set: &dyn Fn(i32) -> [f64; 2], noise_of: [f64; 2]| {
        let mut table = "F_N,d_um\n".to_owned();
        for step in 0..60 {
            let [force, travel] = set(step);
            let force = force + noise_of[0] * noise(step, 0.0);
            let travel = travel + noise_of[1] * noise(step, 1.0);
            writeln!(table, "{force:.4},{travel:.4}").unwrap();
        }
        read(&table).unwrap()
    };
    let force = "the force scatters more than the displacement, so it is taken for the response";
    let displacement =
        "the displacement scatters more than the force, so it is taken for the response";
    for (set, noise_of, said) in [
        (
            &(|step| [f64::from(step), soft(step)]) as &dyn Fn(i32) -> [f64; 2],
            [0.2, 0.0],
            force,
        ),
        (&|step| [held(step), 20.0 * held(step)], [0.02, 0.1], force),
        (
            &|step| [held(step), 20.0 * held(step)],
            [0.005, 0.4],
            displacement,
        ),
        (
            &|step| [held(step), 20.0 * held(step)],
            [0.02, 0.4],
            LOADS_WERE_SET,
        ),
        (
            &|step| [shuffled(step), 20.0 * shuffled(step)],
            [0.2, 0.0],
            LOADS_WERE_SET,
        ),
    ] {
        let found = of(set, noise_of);
        assert!(assumes(&found, said), "{said}: {:?}", found.assumptions);
    }
}

#[test]
fn one_sweep_goes_one_way_at_one_rate() {
    let table = |rates: [f64; 2], turn: usize| {
        let mut table = "r,F_N,d_um\n".to_owned();
        for (run, rate) in rates.into_iter().enumerate() {
            for step in 0..20 {
                let load = rate * (if step > turn { 2 * turn - step } else { step }) as f64;
                writeln!(table, "{run},{load},{}", load * load).unwrap();
            }
        }
        let options = SpecimenOptions {
            run_column: vec!["r".to_owned()],
            ..options()
        };
        read_with(&table, &options).unwrap()
    };
    assert!(table([1.0, 1.0], 20).is_one_sweep);
    assert!(!table([1.0, 2.0], 20).is_one_sweep);
    assert!(!table([1.0, 1.0], 15).is_one_sweep);
}

#[test]
fn files_and_columns_of_repeats_are_runs() {
    let long = read_with(
        "r,F_N,d_um\na,0,0\na,5,1\na,9,2\nb,0,3\nb,5,4\nb,9,5\n",
        &SpecimenOptions {
            run_column: vec!["r".to_owned()],
            ..options()
        },
    );
    let files: [(&str, &[u8]); 2] = [
        ("a", b"F_N,d_um\n0,0\n5,1\n9,2\n"),
        ("b", b"F_N,d_um\n0,3\n5,4\n9,5\n"),
    ];
    let files = read_specimen(&files, &options());
    let wide = read_with(
        "F_N,a_um,b_um\n0,0,3\n5,1,4\n9,2,5\n",
        &SpecimenOptions {
            displacement_column: "a_um".to_owned(),
            repeat_columns: vec!["b_um".to_owned()],
            ..options()
        },
    );
    let [long, files, wide] = [long, files, wide].map(Result::unwrap);
    let values = |table: &SpecimenTable| -> Vec<(u32, f64, f64)> {
        let readings = table.readings.iter();
        readings
            .map(|one| (one.run, one.force, one.displacement))
            .collect()
    };
    assert_eq!(values(&files), values(&long));
    assert_eq!(values(&wide), values(&long));
    assert_eq!(files.runs[1].label, "b");
    assert_eq!(wide.runs[1].label, "b_um");
    for (table, column) in [(&files, "file"), (&wide, "series")] {
        let said = format!("each {column} is a run, with a zero of its own");
        assert!(assumes(table, &said));
    }
}
