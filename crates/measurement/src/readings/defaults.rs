//! What a smaller table leaves open: branch, step, target, time.

use super::assumption::{absent, absent_columns, first_in_line};
use super::column::Column;
use super::error::{FileCell, TableError};
use super::header::ColumnHeader;
use super::order::{note_repeated_rows, put_in_order, refuse_duplicates};
use super::reading::Reading;
use super::row::FirstMissing;
use super::table::ReadingTable;
use super::targets::{REVERSAL_SHARE, fill_targets};
use super::text_table::{bad_value, missing_value};
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::test_point::Branch;

/// Puts readings in order, fills what their file left open, and states what was assumed.
///
/// # Errors
/// A required value that is missing in part of a column, a reading that occurs twice, or a `utc` that is no time.
pub(super) fn fill_defaults(
    table: &mut ReadingTable,
    header: &ColumnHeader,
    first_missing: &FirstMissing,
) -> Result<(), TableError> {
    check_half_empty(table, header, first_missing)?;
    put_in_order(table);
    table.assumptions.extend(absent_columns(table));
    if !table.has(Column::Time) && table.has(Column::Utc) {
        fill_times(table)?;
    }
    if !table.has(Column::Branch) {
        fill_branches(table);
    }
    if !table.has(Column::Target) {
        fill_targets(table);
    }
    if table.has(Column::Step) {
        refuse_duplicates(table)
    } else {
        fill_steps(table);
        note_repeated_rows(table);
        Ok(())
    }
}

/// A column that orders or groups readings is filled throughout or not at all: half a default would mix two numberings.
fn check_half_empty(
    table: &ReadingTable,
    header: &ColumnHeader,
    first_missing: &FirstMissing,
) -> Result<(), TableError> {
    for column in [Column::Seq, Column::Step, Column::Target] {
        if let (true, Some(line)) = (table.has(column), first_missing[column as usize]) {
            let cell = FileCell {
                file: table.source.clone(),
                line,
                column: header.name(column),
                value: String::new(),
            };
            return Err(missing_value(&cell, "a number, as in the other lines"));
        }
    }
    Ok(())
}

const TIME_FROM_UTC: &str = "times are seconds since the first `utc`";

fn fill_times(table: &mut ReadingTable) -> Result<(), TableError> {
    let mut first: Option<jiff::Timestamp> = None;
    for reading in &mut table.readings {
        let Some(text) = reading.text.as_deref().filter(|text| !text.utc.is_empty()) else {
            continue;
        };
        let cell = || FileCell {
            file: table.source.clone(),
            line: reading.line,
            column: Column::Utc.name().to_owned(),
            value: text.utc.to_string(),
        };
        let time = text.utc.parse::<jiff::Timestamp>();
        let time = time.map_err(|_| bad_value(&cell(), "a time like 2026-03-02T09:30:00Z"))?;
        let since = time.duration_since(*first.get_or_insert(time));
        reading.time_s = Some(since.as_secs_f64());
    }
    let no_times = absent(Column::Time);
    for assumption in &mut table.assumptions {
        if *assumption == no_times {
            TIME_FROM_UTC.clone_into(assumption);
        }
    }
    Ok(())
}

/// Where the load of a run stands.
#[derive(Clone, Copy, Default)]
struct RunLoad {
    largest_n: f64,
    /// The furthest the load went on its present branch.
    level_n: f64,
    branch: Branch,
    reversals: u32,
}

impl RunLoad {
    /// The branch on which a load of this size (N, from 0) is applied.
    fn follow(&mut self, size_n: f64) -> Branch {
        let tolerance_n = REVERSAL_SHARE * self.largest_n;
        let (further, back) = match self.branch {
            Branch::Loading => (size_n > self.level_n, size_n < self.level_n - tolerance_n),
            Branch::Unloading => (size_n < self.level_n, size_n > self.level_n + tolerance_n),
        };
        if back {
            self.reversals += 1;
            self.branch = match self.branch {
                Branch::Loading => Branch::Unloading,
                Branch::Unloading => Branch::Loading,
            };
        }
        if further || back {
            self.level_n = size_n;
        }
        self.branch
    }
}

/// Takes loads that go down again within their run as unloading. Readings that do not count do not turn the branch.
fn fill_branches(table: &mut ReadingTable) {
    let by_target = table.has(Column::Target);
    let size = |reading: &Reading| {
        let load = if by_target {
            reading.target_n
        } else {
            reading.force_n
        };
        load.abs()
    };
    let mut loads = vec![RunLoad::default(); table.runs.len()];
    for reading in table.accepted() {
        let load = &mut loads[reading.run as usize];
        load.largest_n = load.largest_n.max(size(reading));
    }
    let mut unloading = Vec::new();
    for reading in &mut table.readings {
        let load = &mut loads[reading.run as usize];
        reading.branch = if reading.is_accepted() {
            load.follow(size(reading))
        } else {
            load.branch
        };
        if reading.branch == Branch::Unloading {
            unloading.push(reading.line);
        }
    }
    let what = "loads that go down again are taken as unloading";
    table.assumptions.extend(first_in_line(what, &unloading));
    let runs = loads.iter().filter(|load| load.reversals > 1).count() as u32;
    if runs > 0 {
        table.assumptions.push(format!(
            "in {} the load goes up again after it went down: if the loads were shuffled, add a column `branch`",
            counted(runs, "run")
        ));
    }
}

/// Numbers readings within their run. A reading that does not count stays on the step of the one that replaces it, and so do longer
/// holds under one target.
fn fill_steps(table: &mut ReadingTable) {
    #[derive(Clone, Copy)]
    struct SequencePosition {
        next: u32,
        last: Option<(f64, Branch, f64)>,
    }
    let targets_given = table.has(Column::Target);
    let mut places = vec![
        SequencePosition {
            next: 0,
            last: None
        };
        table.runs.len()
    ];
    for reading in &mut table.readings {
        let place = &mut places[reading.run as usize];
        let hold = reading.hold_s.filter(|_| targets_given);
        let longer_hold = match (place.last, hold) {
            (Some((target, branch, held)), Some(hold)) => {
                target == reading.target_n && branch == reading.branch && hold > held
            }
            _ => false,
        };
        if longer_hold {
            reading.step = place.next - 1;
        } else {
            reading.step = place.next;
            place.next += u32::from(reading.is_accepted());
        }
        if reading.is_accepted() {
            place.last = hold.map(|hold| (reading.target_n, reading.branch, hold));
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::fmt::Write as _;

    use super::*;
    use crate::readings::read_readings;

    pub(in crate::readings) fn read(text: &str) -> ReadingTable {
        read_readings("t.csv", text.as_bytes()).unwrap()
    }

    /// One run of these forces, in a table of five columns.
    pub(in crate::readings) fn five_columns(forces_n: &[f64]) -> ReadingTable {
        let mut text = String::from("pose,direction,repeat,force_N,displacement_um\n");
        for (index, force) in forces_n.iter().enumerate() {
            writeln!(text, "P1,x,1,{force},{}", index + 1).unwrap();
        }
        read(&text)
    }

    /// Whether a table was read on an assumption.
    pub(in crate::readings) fn assumes(table: &ReadingTable, wanted: &str) -> bool {
        table.assumptions.iter().any(|said| said == wanted)
    }

    fn branches(table: &ReadingTable) -> String {
        let letter = |reading: &Reading| match reading.branch {
            Branch::Loading => 'l',
            Branch::Unloading => 'u',
        };
        table.readings.iter().map(letter).collect()
    }

    #[test]
    fn loads_that_go_down_again_are_unloading() {
        let table = five_columns(&[0.0, -9.9, -20.3, -29.8, -20.1, -10.2, 0.0]);
        assert_eq!(branches(&table), "lllluuu");
        assert!(assumes(
            &table,
            "loads that go down again are taken as unloading: 3 readings, first in line 6"
        ));
        assert!(assumes(
            &table,
            "target loads are the multiples of 10 N nearest to the forces"
        ));
        let steps: Vec<u32> = table.readings.iter().map(|reading| reading.step).collect();
        assert_eq!(steps, [0, 1, 2, 3, 4, 5, 6]);
        let targets: Vec<f64> = table
            .readings
            .iter()
            .map(|reading| reading.target_n)
            .collect();
        assert_eq!(targets, [0.0, -10.0, -20.0, -30.0, -20.0, -10.0, 0.0]);
    }

    #[test]
    fn the_scatter_of_a_held_load_is_no_unloading() {
        assert_eq!(
            branches(&five_columns(&[0.0, 50.0, 70.3, 69.8, 70.1])),
            "lllll"
        );
        // 5 % of 70 N is 3.5 N.
        assert_eq!(branches(&five_columns(&[0.0, 70.0, 66.4])), "llu");
        assert_eq!(branches(&five_columns(&[0.0, 70.0, 66.6])), "lll");
        // Small steps down add up.
        assert_eq!(
            branches(&five_columns(&[70.0, 68.0, 66.0, 64.0, 62.0])),
            "lluuu"
        );
        assert_eq!(branches(&five_columns(&[0.0, 0.0, 0.0])), "lll");
    }

    #[test]
    fn a_load_that_goes_up_again_is_said() {
        let table = five_columns(&[10.0, 40.0, 20.0, 60.0, 30.0]);
        assert_eq!(branches(&table), "llulu");
        assert!(assumes(
            &table,
            "in 1 run the load goes up again after it went down: if the loads were shuffled, add a column `branch`"
        ));
    }

    #[test]
    fn rejected_readings_do_not_turn_the_branch() {
        let table = read(
            "pose,direction,repeat,force_N,displacement_um,status\n\
             P1,x,1,10,1,accepted\nP1,x,1,900,2,rejected\nP1,x,1,20,2,accepted\nP1,x,1,30,3,accepted\n",
        );
        assert_eq!(branches(&table), "llll");
        let steps: Vec<u32> = table.readings.iter().map(|reading| reading.step).collect();
        assert_eq!(steps, [0, 1, 1, 2]);
        assert_eq!(table.excluded.rejected, [3]);
    }

    #[test]
    fn longer_holds_stay_on_their_step() {
        let table = read(
            "pose,direction,repeat,force_N,displacement_um,target_N,hold_s\n\
             P1,x,1,60,1,60,5\nP1,x,1,70,2,70,5\nP1,x,1,70,3,70,60\nP1,x,1,60,4,60,5\n",
        );
        let steps: Vec<u32> = table.readings.iter().map(|reading| reading.step).collect();
        assert_eq!(steps, [0, 1, 1, 2]);
    }

    #[test]
    fn times_come_from_utc() {
        let table = read(
            "pose,direction,repeat,force_N,displacement_um,utc\n\
             P1,x,1,0,0,2026-03-02T09:30:00+01:00\nP1,x,1,10,1,\nP1,x,1,20,2,2026-03-02T08:30:12.5Z\n",
        );
        let times: Vec<Option<f64>> = table
            .readings
            .iter()
            .map(|reading| reading.time_s)
            .collect();
        assert_eq!(times, [Some(0.0), None, Some(12.5)]);
        assert!(assumes(&table, TIME_FROM_UTC));
        assert!(!assumes(&table, &absent(Column::Time)));
        let local =
            "pose,direction,repeat,force_N,displacement_um,utc\nP1,x,1,0,0,8/14/2026 10:46 AM\n";
        let error = read_readings("t.csv", local.as_bytes()).unwrap_err();
        assert_eq!(error.code, "stiffbench::readings::bad_value");
        let expected = "t.csv, line 2, column `utc`: `8/14/2026 10:46 AM`, expected a time";
        assert!(error.to_string().starts_with(expected), "{error}");
    }

    #[test]
    fn half_a_column_is_an_error() {
        let text =
            "pose,direction,repeat,force_N,displacement_um,step\nP1,x,1,0,0,0\nP1,x,1,10,1,\n";
        let error = read_readings("t.csv", text.as_bytes()).unwrap_err();
        assert_eq!(error.code, "stiffbench::readings::missing_value");
        let expected = "t.csv, line 3, column `step`: nothing, expected a number";
        assert!(error.to_string().starts_with(expected), "{error}");
        // A column without any value is as good as none.
        let text = "pose,direction,repeat,force_N,displacement_um,step\nP1,x,1,0,0,\n";
        let table = read(text);
        assert!(assumes(&table, &absent(Column::Step)));
    }
}
