//! One record of a table to one row, with the texts that name its run and configuration.

use super::columns::{ColumnPosition, MeasuredColumn, SpecimenColumns};
use super::excluded::Incomplete;
use super::table::SpecimenReading;
use crate::readings::{BRANCH_WORDS, TableError, meaning_of, read_count};
use crate::table_files::MachineTable;
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::test_point::Branch;

/// A record that has all it must have.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpecimenRow {
    pub(super) configuration: String,
    pub(super) run: String,
    pub(super) order: Option<u32>,
    /// The reading, before its configuration, its run and its place in the order are numbered.
    pub(super) reading: SpecimenReading,
}

/// How often, and where first, an optional column has no value.
#[derive(Debug, Clone, Copy, Default)]
struct Absences {
    rows: u32,
    line: u32,
}

/// Turns rows of a file into rows of a specimen.
pub(super) struct SpecimenRowReader<'a> {
    table: &'a MachineTable,
    columns: &'a SpecimenColumns,
    pub(super) rows: Vec<SpecimenRow>,
    pub(super) incomplete: Vec<Incomplete>,
    absences: [Absences; 3],
}

/// A value that a row must have is not there.
enum MissingValue {
    Absent(String),
    Wrong(TableError),
}

impl From<TableError> for MissingValue {
    fn from(error: TableError) -> Self {
        Self::Wrong(error)
    }
}

impl<'a> SpecimenRowReader<'a> {
    pub(super) fn new(table: &'a MachineTable, columns: &'a SpecimenColumns) -> Self {
        Self {
            table,
            columns,
            rows: Vec::new(),
            incomplete: Vec::new(),
            absences: [Absences::default(); 3],
        }
    }

    /// Adds a row, to the rows or to those that lack a value.
    pub(super) fn take(&mut self, number: usize) -> Result<(), TableError> {
        match self.row(number) {
            Ok(row) => self.rows.push(row),
            Err(MissingValue::Absent(column)) => {
                let line = self.table.rows[number].line;
                self.incomplete.push(Incomplete { line, column });
            }
            Err(MissingValue::Wrong(error)) => return Err(error),
        }
        Ok(())
    }

    fn row(&mut self, number: usize) -> Result<SpecimenRow, MissingValue> {
        let columns = self.columns;
        let force = match &columns.force {
            Some(force) => self.required(number, force)?,
            None => 0.0,
        };
        let displacement = match &columns.displacement {
            Some(displacement) => self.required(number, displacement)?,
            None => 0.0,
        };
        let configuration = self.label(number, &columns.configuration)?;
        let run = self.label(number, &columns.run)?;
        let order = columns.order.as_ref();
        let order =
            order.map(|place| self.parsed(number, place, read_count, "a whole number from 0"));
        let order = order.transpose()?;
        let branch = columns.branch.as_ref();
        let branch = branch.map(|place| {
            self.parsed(
                number,
                place,
                |text| meaning_of(text, &BRANCH_WORDS),
                "loading or unloading",
            )
        });
        let branch = branch.transpose()?.unwrap_or(Branch::Loading);
        let line = self.table.rows[number].line;
        let mut optional = [None; 3];
        for (index, column) in columns.optional().into_iter().enumerate() {
            let Some(column) = column else { continue };
            optional[index] = self.number(number, column)?;
            if optional[index].is_none() {
                let absences = &mut self.absences[index];
                absences.rows += 1;
                if absences.line == 0 {
                    absences.line = line;
                }
            }
        }
        let [time_s, hold_s, temperature_deg_c] = optional;
        Ok(SpecimenRow {
            configuration,
            run,
            order,
            reading: SpecimenReading {
                line,
                configuration: 0,
                run: 0,
                order: 0,
                branch,
                force,
                displacement,
                time_s,
                hold_s,
                temperature_deg_c,
            },
        })
    }

    fn required(&self, number: usize, column: &MeasuredColumn) -> Result<f64, MissingValue> {
        self.number(number, column)?
            .ok_or_else(|| MissingValue::Absent(column.place.name.clone()))
    }

    fn number(&self, number: usize, column: &MeasuredColumn) -> Result<Option<f64>, TableError> {
        if let Some(seconds) = &column.seconds {
            return Ok(seconds[number]);
        }
        self.table
            .number(number, column.place.index, column.conversion)
    }

    fn present(&self, row: usize, place: &ColumnPosition) -> Result<&str, MissingValue> {
        let found = self.table.present(row, place.index);
        found.ok_or_else(|| MissingValue::Absent(place.name.clone()))
    }

    /// The texts of columns that together name something.
    fn label(&self, row: usize, places: &[ColumnPosition]) -> Result<String, MissingValue> {
        let texts = places.iter().map(|place| self.present(row, place));
        Ok(texts.collect::<Result<Vec<_>, _>>()?.join(" / "))
    }

    /// What the text of a cell means.
    fn parsed<T>(
        &self,
        row: usize,
        place: &ColumnPosition,
        meaning: impl Fn(&[u8]) -> Option<T>,
        expected: &'static str,
    ) -> Result<T, MissingValue> {
        let found = meaning(self.present(row, place)?.as_bytes());
        Ok(found.ok_or_else(|| {
            self.table.cell(row, place.index).refused(
                "stiffbench::specimen::bad_value",
                expected,
                "correct the value, or leave the field empty: the row is then left out and listed",
            )
        })?)
    }

    /// Optional columns that have no value in some rows.
    pub(super) fn absent(&self) -> Vec<String> {
        let columns = self.columns.optional().into_iter().zip(self.absences);
        columns
            .filter(|(_, absences)| absences.rows > 0)
            .filter_map(|(column, Absences { rows, line })| {
                let (column, rows) = (&column?.place.name, counted(rows, "row"));
                Some(format!(
                    "no value of `{column}` in {rows}, first in line {line}; kept without it"
                ))
            })
            .collect()
    }
}
