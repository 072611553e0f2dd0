//! Reads the log a force gauge's own program writes: load over travel, without pose, direction or repeat.
//!
//! The layout is that of the MESUR programs of one gauge maker: a local time of day, lines `Units: N` and `Travel Unit: mm`, then a
//! table with tabs, `Reading`, `Load`, `Travel`, `Time`. A newer one writes the units behind the names, `Load [N]`, `Distance [mm]`.
//! Neither is described by its maker as far as we could find, and no log from the programs themselves was at hand: what is known here
//! comes from reading public programs that write the first kind and read both. A log that differs is refused rather than guessed at.

use std::io::Read;

use super::assumption::Assumption;
use super::column::Column;
use super::error::ReadingsError;
use super::log_columns::{GaugeLogOptions, LoadSign, LogColumns, Preamble};
use super::rows::Delimiter;
use super::table::{ReadingTable, RunKey};
use super::targets::{are_one_load, fill_targets};
use super::text_table::{ReadOptions, RecordTable};
use stiffbench_units_and_text::test_point::{Branch, Cell};

/// Readings from a force gauge's own log.
///
/// Readings up to the largest load are loading, those after it unloading. Load and travel are turned so that both have the sign of
/// `options.sign` at the largest load: stiffness is positive. Times are kept as seconds since the log began; the time of day above the
/// table has no zone and is only noted.
///
/// # Errors
/// [`ReadingsError::NotAGaugeLog`] without the line of column names, [`ReadingsError::WrongUnit`] for a load or travel without a known
/// unit, and the errors of a table for its rows.
pub fn read_gauge_log(
    source: &str,
    input: impl Read,
    options: &GaugeLogOptions,
) -> Result<ReadingTable, ReadingsError> {
    let told = ReadOptions {
        delimiter: options.text.delimiter.or(Some(Delimiter::Tab)),
        ..options.text
    };
    let mut text = RecordTable::open(source, input, told)?;
    let preamble = Preamble::read(&mut text)?;
    let columns = LogColumns::find(&text, &preamble)?;
    let mut readings = Vec::new();
    while text.next_record()? {
        let seq = readings.len() as u32 + 1;
        readings.push(columns.reading(&mut text, options, seq)?);
    }
    if readings.is_empty() {
        return Err(ReadingsError::NoReadings {
            file: source.to_owned(),
            line: text.header_line,
        });
    }
    let mut table = ReadingTable {
        source: source.to_owned(),
        readings,
        columns: columns.present(),
        assumptions: text.assumptions(),
        notes: preamble.notes,
        ..ReadingTable::default()
    };
    (table.excluded.blank, table.excluded.comments) = text.passed_over();
    table.assumptions.extend(columns.assumptions());
    place_in_cell(&mut table, options);
    turn_and_split(&mut table, options.sign);
    fill_targets(&mut table);
    table.take_stock();
    Ok(table)
}

fn place_in_cell(table: &mut ReadingTable, options: &GaugeLogOptions) {
    let run = RunKey::of_repeat(options.pose.clone(), options.direction, options.repeat);
    table.runs = vec![run.clone()];
    table.zeros = vec![run];
    table.assumptions.push(Assumption::CellGiven {
        cell: Cell::new(options.pose.clone(), options.direction),
        repeat: options.repeat,
    });
    let absent = Assumption::MISSED
        .into_iter()
        .filter(|column| !table.columns.contains(column))
        .map(Assumption::ColumnAbsent);
    table.assumptions.extend(absent);
}

/// Gives load and travel the sign of the load, and makes unloading of what follows the largest one.
fn turn_and_split(table: &mut ReadingTable, sign: LoadSign) {
    let larger = |best: usize, index: usize| {
        if table.readings[index].force_n.abs() > table.readings[best].force_n.abs() {
            index
        } else {
            best
        }
    };
    let largest = (0..table.readings.len()).fold(0, larger);
    let peak = table.readings[largest].clone();
    if peak.force_n == 0.0 {
        return;
    }
    let wrong = |value: f64| match sign {
        LoadSign::Positive => value < 0.0,
        LoadSign::Negative => value > 0.0,
    };
    let is_one_load = are_one_load(table.readings.iter().map(|reading| reading.force_n));
    let (turn_force, turn_travel) = (wrong(peak.force_n), wrong(peak.displacement_m));
    for (index, reading) in table.readings.iter_mut().enumerate() {
        if turn_force {
            reading.force_n = -reading.force_n;
        }
        if turn_travel {
            reading.displacement_m = -reading.displacement_m;
        }
        if index > largest && !is_one_load {
            reading.branch = Branch::Unloading;
        }
    }
    for (turned, column) in [
        (turn_force, Column::Force),
        (turn_travel, Column::Displacement),
    ] {
        if turned {
            table.assumptions.push(Assumption::SignTurned(column));
        }
    }
    if largest + 1 < table.readings.len() && !is_one_load {
        let line = peak.line;
        table
            .assumptions
            .push(Assumption::SplitAtLargestLoad { line });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::AssumptionNote;
    use stiffbench_units_and_text::test_point::{Direction, PoseId};

    const LOG: &str = "3/2/2026  9:30 AM\r\nUnits: N\r\nReadings: Continuous\r\nX-Axis: Travel\r\nTravel Unit: mm\r\n\
        Reading\tLoad\tTravel\tTime\r\n1\t0.02\t0.000\t0.000\r\n2\t10.10\t-0.610\t0.181\r\n3\t20.00\t-1.213\t0.360\r\n4\t9.90\t-0.605\t0.540\r\n";

    fn options(sign: LoadSign) -> GaugeLogOptions {
        GaugeLogOptions {
            pose: PoseId::new("P1"),
            direction: Direction::X,
            repeat: 2,
            sign,
            text: ReadOptions::default(),
        }
    }

    fn read(text: &str) -> Result<ReadingTable, ReadingsError> {
        read_gauge_log("run.log", text.as_bytes(), &options(LoadSign::Negative))
    }

    #[test]
    fn a_log_becomes_one_run() {
        let table = read(LOG).unwrap();
        let forces: Vec<f64> = table.readings.iter().map(|r| r.force_n).collect();
        assert_eq!(forces, [-0.02, -10.1, -20.0, -9.9]);
        let travel: Vec<f64> = table.readings.iter().map(|r| r.displacement_m).collect();
        assert_eq!(travel, [0.0, -610e-6, -1213e-6, -605e-6]);
        assert_eq!(table.readings[3].time_s, Some(0.54));
        assert_eq!(table.readings[3].branch, Branch::Unloading);
        assert_eq!(table.readings[2].branch, Branch::Loading);
        assert_eq!(table.readings[1].target_n, -10.0);
        assert_eq!(table.readings[1].line, 8);
        assert_eq!(
            &*table.readings[1].text.as_ref().unwrap().force_raw,
            "10.10"
        );
        assert_eq!(table.runs[0].to_string(), "P1 x 2");
    }

    #[test]
    fn repeats_at_one_load_are_loading() {
        let one = LOG
            .replace("10.10", "20.05")
            .replace("9.90", "19.95")
            .replace("0.02", "20.10");
        let table = read(&one).unwrap();
        assert!(table.readings.iter().all(|r| r.branch == Branch::Loading));
        let is_split = |one: &Assumption| matches!(one, Assumption::SplitAtLargestLoad { .. });
        assert!(!table.assumptions.iter().any(is_split));
    }

    #[test]
    fn everything_decided_is_said() {
        let table = read(LOG).unwrap();
        for expected in [
            Assumption::SignTurned(Column::Force),
            Assumption::SplitAtLargestLoad { line: 9 },
            Assumption::TimeInSeconds,
            Assumption::UnitConverted {
                column: Column::Displacement,
                found: "Travel".to_owned(),
            },
        ] {
            assert!(table.assumptions.contains(&expected), "{expected}");
        }
        assert!(
            !table
                .assumptions
                .contains(&Assumption::SignTurned(Column::Displacement))
        );
        assert!(
            table
                .notes
                .contains(&AssumptionNote::LocalTime("3/2/2026  9:30 AM".to_owned()))
        );
        assert!(
            table
                .notes
                .contains(&AssumptionNote::LogLine("X-Axis: Travel".to_owned()))
        );
    }

    #[test]
    fn units_may_stand_in_the_names() {
        let text = "Test: pull\nReading\tLoad [lbF]\tDistance [in]\tTime [s]\n1\t1,0\t-0,5\t0\n";
        let table =
            read_gauge_log("run.log", text.as_bytes(), &options(LoadSign::Positive)).unwrap();
        // NIST SP 811 (2008), B.8: 1 lbf = 4.448 222 N, 1 in = 25.4 mm.
        assert!((table.readings[0].force_n - 4.448_222).abs() < 1e-6);
        assert!((table.readings[0].displacement_m - 0.0127).abs() < 1e-15);
        assert!(
            table
                .assumptions
                .contains(&Assumption::DecimalComma { line: 3 })
        );
        assert!(!table.assumptions.contains(&Assumption::TimeInSeconds));
    }

    #[test]
    fn an_incomplete_log_is_rejected() {
        let no_unit = LOG.replace("Travel Unit: mm\r\n", "");
        let error = read(&no_unit).unwrap_err();
        assert!(
            matches!(error, ReadingsError::WrongUnit { line: 5, ref column, .. } if column == "Travel")
        );
        let other_unit = LOG.replace("Units: N", "Units: mm");
        let error = read(&other_unit).unwrap_err();
        assert!(matches!(error, ReadingsError::WrongUnit { ref unit, .. } if unit == "`mm`"));
        let no_travel = LOG.replace("\tTravel", "\tAngle");
        let error = read(&no_travel).unwrap_err();
        assert!(matches!(
            error,
            ReadingsError::MissingColumn {
                line: 6,
                column: "displacement_um",
                ..
            }
        ));
        let error = read("pose,direction\nP1,x\n").unwrap_err();
        assert!(matches!(error, ReadingsError::NotAGaugeLog { .. }));
        let error = read("Units: N\nTravel Unit: mm\nReading\tLoad\tTravel\tTime\n").unwrap_err();
        assert!(matches!(error, ReadingsError::NoReadings { line: 3, .. }));
        let torn = LOG.replace("3\t20.00\t-1.213\t0.360", "3\t20.00\t-1.2");
        let error = read(&torn).unwrap_err();
        assert!(matches!(
            error,
            ReadingsError::FieldCount {
                line: 9,
                found: 3,
                ..
            }
        ));
    }
}
