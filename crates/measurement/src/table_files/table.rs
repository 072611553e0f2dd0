//! A table with named columns, and how its cells are taken.

use csv::StringRecord;

use super::cell::{CellFault, DecimalHint, NumberMarks, is_absent};
use super::columns::FileColumn;
use super::keywords::plain;
use super::layout::FileLayout;
use super::times::{StampFault, StampKind, TimeStamp, seconds_since_first};
use crate::readings::{
    Conversion, DecimalSign, FileCell, NumberFault, NumberReader, TableError, line_of,
    unescape_formula,
};
use stiffbench_units_and_text::nearest::{listed_names, nearest};

/// A row of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct FileRow {
    /// Its line in the file, or its row in the sheet, from 1.
    pub line: u32,
    /// The file or sheet that it is of, of several from 0.
    pub(super) part: usize,
    /// The segment it is in, from 1.
    pub segment: u32,
    pub(super) cells: StringRecord,
}

/// A file or sheet whose rows are in a table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TablePart {
    pub(super) source: String,
    pub(super) marks: NumberMarks,
}

/// A table with named columns.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineTable {
    /// The input, as the caller named it.
    pub source: String,
    /// What was taken for what.
    pub layout: FileLayout,
    /// The rows, in the order of the file.
    pub rows: Vec<FileRow>,
    /// Lines without any value.
    pub blank: Vec<u32>,
    /// Lines that start with `#`.
    pub comments: Vec<u32>,
    pub(super) parts: Vec<TablePart>,
}

/// The error for a file without a row that has a number in it.
pub(super) fn no_numbers(source: &str) -> TableError {
    TableError::new(
        "stiffbench::table::no_numbers",
        format!("{source}: no row of numbers was found"),
        "export the measured values as text, CSV or XLSX, one reading a row; a delimiter other than tab, semicolon, comma and blanks is not known",
    )
}

/// The error for a cell that should hold a number.
fn bad_number(cell: &FileCell) -> TableError {
    cell.refused("stiffbench::table::bad_number", "a number", CORRECT_VALUE)
}

/// The error for a number that is not finite, or an instrument's mark for none.
fn not_finite(cell: &FileCell) -> TableError {
    TableError::new(
        "stiffbench::table::not_finite",
        format!(
            "{cell}: `{}` is no value: it is not finite, or the mark of an instrument for a value beyond its range",
            cell.value
        ),
        CORRECT_VALUE,
    )
}

/// The error for a cell among times that is none.
fn bad_time(cell: &FileCell) -> TableError {
    cell.refused(
        "stiffbench::table::bad_time",
        "a time like the others",
        "known are 2024-01-31T10:05:00.25, 31.01.2024 10:05:00, 1/31/2024 10:05:00 AM and 10:05:00.25; or leave the field empty",
    )
}

/// The error for a number with another decimal sign than that of an earlier line.
pub(super) fn mixed_decimals(cell: &FileCell, first_line: u32) -> TableError {
    TableError::new(
        "stiffbench::table::mixed_decimals",
        format!(
            "{cell}: `{}` has another decimal sign than line {first_line}",
            cell.value
        ),
        "write all numbers with the same decimal sign",
    )
}

/// The error for a number whose mark may be that of decimals or of thousands.
pub(super) fn either_decimal(cell: &FileCell) -> TableError {
    TableError::new(
        "stiffbench::table::either_decimal",
        format!(
            "{cell}: the mark in `{}` may be a decimal sign or stand between thousands",
            cell.value
        ),
        "state it with --decimal comma or --decimal point; stiffbench import takes --thousands too",
    )
}

const CORRECT_VALUE: &str = "correct the value, or take the row out of a copy of the file";

/// From here on a number marks a value beyond the range of an instrument (9.9E37) or none at all (9.91E37): SCPI 1999, volume 1, 7.2.1.
const OVER_RANGE: f64 = 9.9e37;

impl MachineTable {
    /// The cell of a row, both counted from 0, without blanks around it; empty beyond the last.
    #[must_use]
    pub fn text(&self, row: usize, column: usize) -> &str {
        let row = self.rows.get(row);
        unescape_formula(row.and_then(|row| row.cells.get(column)).unwrap_or(""))
    }

    /// The cell, `None` if it states that there is no value.
    #[must_use]
    pub fn present(&self, row: usize, column: usize) -> Option<&str> {
        Some(self.text(row, column)).filter(|text| !is_absent(text))
    }

    /// The cells of a column, `None` for those that state that there is no value.
    fn all_present(&self, column: usize) -> impl Iterator<Item = Option<&str>> {
        (0..self.rows.len()).map(move |row| self.present(row, column))
    }

    /// Whether the first value of a column is a time or a date rather than a number.
    #[must_use]
    pub fn is_time_stamp(&self, column: usize) -> bool {
        self.stamp_kind(column).is_some()
    }

    /// What the first value of a column states of a time; `None` of a number and of words.
    #[must_use]
    pub fn stamp_kind(&self, column: usize) -> Option<StampKind> {
        let first = self.all_present(column).flatten().next();
        let first = first.filter(|text| DecimalHint::of(text).is_none())?;
        TimeStamp::parse(first).map(TimeStamp::kind)
    }

    /// Puts dates before the times of day of another column. A row without a date has that of the row above.
    pub(crate) fn join_dates(&mut self, dates: usize, times: usize) {
        let mut date = String::new();
        for row in &mut self.rows {
            let text = row.cells.get(dates).unwrap_or("");
            if !is_absent(text) {
                text.clone_into(&mut date);
            }
            let joined = row.cells.iter().enumerate().map(|(column, cell)| {
                if column == times && !is_absent(cell) {
                    format!("{date} {cell}")
                } else {
                    cell.to_owned()
                }
            });
            row.cells = joined.collect::<Vec<_>>().into();
        }
    }

    /// The cell as a number after a change of unit; `None` if there is none.
    ///
    /// # Errors
    /// [`TableError`] for what is no number.
    pub(crate) fn number(
        &self,
        row: usize,
        column: usize,
        conversion: Conversion,
    ) -> Result<Option<f64>, TableError> {
        let Some(text) = self.present(row, column) else {
            return Ok(None);
        };
        let cell = || self.cell(row, column);
        let mut plain = String::new();
        let part = &self.parts[self.rows[row].part];
        let marks = part.marks.plain(text, &mut plain);
        marks.map_err(|fault| match fault {
            CellFault::OtherDecimalSign => mixed_decimals(&cell(), self.layout.first_line),
            CellFault::NotANumber => bad_number(&cell()),
        })?;
        // Read before the unit is changed.
        if plain
            .parse()
            .is_ok_and(|value: f64| value.abs() >= OVER_RANGE)
        {
            return Err(not_finite(&cell()));
        }
        let mut reader = NumberReader::new(Some(DecimalSign::Point));
        let read = reader.read(plain.as_bytes(), conversion, self.rows[row].line);
        read.map(Some).map_err(|fault| match fault {
            NumberFault::NotFinite => not_finite(&cell()),
            _ => bad_number(&cell()),
        })
    }

    /// A column as numbers in the unit of the file, one for each row; `None` where a row has none.
    ///
    /// # Errors
    /// [`TableError`] for a cell that is no number.
    pub fn numbers(&self, column: usize) -> Result<Vec<Option<f64>>, TableError> {
        self.numbers_in(column, Conversion::NONE)
    }

    /// The same after a change of unit.
    ///
    /// # Errors
    /// As [`MachineTable::numbers`].
    pub(crate) fn numbers_in(
        &self,
        column: usize,
        conversion: Conversion,
    ) -> Result<Vec<Option<f64>>, TableError> {
        let rows = 0..self.rows.len();
        rows.map(|row| self.number(row, column, conversion))
            .collect()
    }

    /// Times and dates of a column as seconds since the first, one for each row.
    ///
    /// # Errors
    /// [`TableError`] for a cell that is no time, or whose day and month cannot be distinguished.
    pub fn seconds(&self, column: usize) -> Result<Vec<Option<f64>>, TableError> {
        seconds_since_first(self.all_present(column)).map_err(|fault| match fault {
            StampFault::NotATime(row) => bad_time(&self.cell(row, column)),
            StampFault::DayOrMonth(row) => {
                let cell = self.cell(row, column);
                TableError::new(
                    "stiffbench::table::day_or_month",
                    format!(
                        "{cell}: is `{}` a day and a month, or a month and a day?",
                        cell.value
                    ),
                    "write dates as 2024-01-31",
                )
            }
        })
    }

    /// The same of a column of each of two tables, both since the first time of this one.
    ///
    /// # Errors
    /// As [`MachineTable::seconds`].
    pub(crate) fn seconds_with(
        &self,
        column: usize,
        other: &Self,
        of_other: usize,
    ) -> Result<[Vec<Option<f64>>; 2], TableError> {
        let cells = self.all_present(column).chain(other.all_present(of_other));
        let Ok(mut first) = seconds_since_first(cells) else {
            // The table that is wrong states its own line; a form that differs is stated with the other.
            self.seconds(column)?;
            other.seconds(of_other)?;
            return Err(bad_time(&other.cell(0, of_other)));
        };
        let second = first.split_off(self.rows.len());
        Ok([first, second])
    }

    /// The line of the column names, for messages; the first without such a line.
    pub(crate) fn header(&self) -> String {
        line_of(&self.source, self.layout.header_line.unwrap_or(1))
    }

    /// The names of the columns.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        let columns = self.layout.columns.iter();
        columns.map(|column| column.name.as_str())
    }

    /// Whether all rows are of one file or sheet, whose lines they count.
    pub(crate) fn is_of_one_file(&self) -> bool {
        self.parts.len() == 1
    }

    /// A number as it stands in the file, with a decimal point and no marks between thousands; empty without one.
    pub(crate) fn plain_number(&self, row: usize, column: usize) -> String {
        let mut plain = String::new();
        let marks = self.parts[self.rows[row].part].marks;
        match self.present(row, column) {
            Some(text) if marks.plain(text, &mut plain).is_ok() => plain,
            _ => String::new(),
        }
    }

    /// The first values of a column, as they stand in the file.
    pub(crate) fn first_values(&self, column: usize) -> Vec<String> {
        const SHOWN: usize = 3;
        let rows = 0..self.rows.len().min(SHOWN);
        rows.map(|row| self.text(row, column).to_owned()).collect()
    }

    /// The column of a name: as it stands in the file, without its unit, in other capitals or without accents; else a number from 1.
    ///
    /// # Errors
    /// For no such column, and for two of them.
    pub(crate) fn column(&self, wanted: &str, role: &str) -> Result<usize, TableError> {
        let wanted = wanted.trim();
        let small = plain(wanted);
        let columns = &self.layout.columns;
        let called = |is: &dyn Fn(&FileColumn) -> bool| -> Vec<usize> {
            let places = 0..columns.len();
            places.filter(|index| is(&columns[*index])).collect()
        };
        let ways: [&dyn Fn(&FileColumn) -> bool; 3] = [
            &|column| column.name == wanted,
            &|column| column.stem == wanted,
            &|column| plain(&column.name) == small || plain(&column.stem) == small,
        ];
        let found = ways.into_iter().map(called).find(|found| !found.is_empty());
        match found.as_deref() {
            Some([one]) => return Ok(*one),
            Some([first, second, ..]) => {
                return Err(self.duplicate(wanted, role, [*first, *second]));
            }
            _ => {}
        }
        let number = wanted.parse::<usize>().ok();
        let index = number.and_then(|number| number.checked_sub(1));
        if let Some(index) = index.filter(|index| *index < columns.len()) {
            return Ok(index);
        }
        let advice = match nearest(wanted, self.names().filter(|name| !name.is_empty())) {
            Some(near) => format!("is `{near}` meant? --map {role}={near}"),
            None => format!("name one of these, or its number from 1: --map {role}=COLUMN"),
        };
        let (at, found) = (self.header(), listed_names(self.names()));
        let unknown = TableError::new(
            "stiffbench::table::unknown_column",
            format!("{at}: no column `{wanted}` for the {role}; the columns are {found}"),
            advice,
        );
        Err(unknown.about(vec![wanted.to_owned()]))
    }

    /// An error about one column for two things.
    pub(crate) fn same_column(&self, column: &str, first: &str, second: &str) -> TableError {
        TableError::new(
            "stiffbench::table::same_column",
            format!(
                "{}: column `{column}` is named for the {first} and for the {second}",
                self.source
            ),
            format!("name another column with --map {second}=COLUMN"),
        )
    }

    /// An error about two columns of one name, at places that count from 0.
    pub(crate) fn duplicate(&self, column: &str, role: &str, places: [usize; 2]) -> TableError {
        let [first, second] = places.map(|place| place + 1);
        TableError::new(
            "stiffbench::table::duplicate_column",
            format!(
                "{}: columns {first} and {second} are both called `{column}`",
                self.header()
            ),
            format!("name the intended column by its number: --map {role}={first}"),
        )
    }

    /// A cell, for messages.
    pub(crate) fn cell(&self, row: usize, column: usize) -> FileCell {
        FileCell {
            file: self.parts[self.rows[row].part].source.clone(),
            line: self.rows[row].line,
            column: self.name(column).to_owned(),
            value: self.text(row, column).to_owned(),
        }
    }

    /// The name of a column; empty beyond the last.
    pub(crate) fn name(&self, column: usize) -> &str {
        self.layout
            .columns
            .get(column)
            .map_or("", |column| &column.name)
    }
}
