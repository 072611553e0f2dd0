//! A table in a text: from bytes to records under named columns, each field with its line, and what was taken for granted on the way.
//!
//! What the columns mean is for those who read readings, logs of gauges and tables of specimens from it.

use std::borrow::Cow;
use std::cell::Cell;
use std::io::Read;

use super::encoding::Encoding;
use super::error::{FileCell, TableError, line_of};
use super::formula::unescape_formula;
use super::number::{Conversion, NumberFault, NumberReader, read_count};
use super::reading::{BRANCH_WORDS, ReadingStatus, STATUS_WORDS, meaning_of};
use super::rows::{FieldDelimiter, Rows, text_of};
use stiffbench_units_and_text::nearest::listed_names;
use stiffbench_units_and_text::test_point::Branch;

/// The error for a field without a value.
pub(super) fn missing_value(cell: &FileCell, expected: &str) -> TableError {
    TableError::new(
        "stiffbench::readings::missing_value",
        format!("{cell}: nothing, expected {expected}"),
        "fill the field, or leave the line out",
    )
}

/// The error for a field with a wrong value.
pub(super) fn bad_value(cell: &FileCell, expected: &str) -> TableError {
    cell.refused(
        "stiffbench::readings::bad_value",
        expected,
        "correct the value; a reading that does not count is marked `rejected` under `status`",
    )
}

/// A table that is read record by record.
pub(crate) struct RecordTable<'a> {
    rows: Rows<'a>,
    /// Line of the column names.
    pub(crate) header_line: u32,
    /// Column names as they stand in the file, without blanks around them.
    pub(crate) names: Vec<String>,
    /// Line on which the current record starts.
    pub(crate) line: u32,
    /// First line with text that is not UTF-8.
    other_encoding: Cell<Option<u32>>,
    pub(crate) numbers: NumberReader,
}

impl<'a> RecordTable<'a> {
    /// Opens a table and takes its first record for the column names.
    pub(crate) fn open(file: &str, input: impl Read + 'a) -> Result<Self, TableError> {
        let mut text = Self {
            rows: Rows::open(file, input)?,
            header_line: 0,
            names: Vec::new(),
            line: 0,
            other_encoding: Cell::new(None),
            numbers: NumberReader::new(None),
        };
        text.header_line = text.rows.next_record()?.ok_or_else(|| text.rows.empty())?;
        let name = |index| text_of(text.rows.field(index)).0.trim().to_owned();
        text.names = (0..text.rows.len()).map(name).collect();
        Ok(text)
    }

    /// The names in the first record of a table; none of a text that is no table.
    pub(crate) fn names_of(bytes: &[u8]) -> Vec<String> {
        RecordTable::open("", bytes).map_or_else(|_| Vec::new(), |text| text.names)
    }

    /// The input, as the caller named it.
    pub(crate) fn file(&self) -> String {
        self.rows.file().to_owned()
    }

    /// A line of the file, for messages.
    pub(crate) fn at(&self, line: u32) -> String {
        line_of(self.rows.file(), line)
    }

    /// The error for a table without a record below the names.
    pub(crate) fn no_readings(&self) -> TableError {
        TableError::new(
            "stiffbench::readings::no_readings",
            format!(
                "{}: no reading follows the header",
                self.at(self.header_line)
            ),
            "one line per reading must follow the column names",
        )
    }

    /// Moves to the next record; whether there is one.
    ///
    /// More fields than names are fine as long as they are empty, as spreadsheets leave them.
    pub(crate) fn next_record(&mut self) -> Result<bool, TableError> {
        let Some(line) = self.rows.next_record()? else {
            return Ok(false);
        };
        self.line = line;
        let (expected, found) = (self.names.len(), self.rows.len());
        if found == expected
            || found > expected && (expected..found).all(|index| self.field(index).is_empty())
        {
            return Ok(true);
        }
        Err(TableError::new(
            "stiffbench::readings::field_count",
            format!(
                "{}: {found} fields, expected {expected} as in the header",
                self.at(line)
            ),
            "if numbers have a decimal comma, the delimiter must be `;` or a tab, or the numbers must be quoted",
        ))
    }

    /// A field of the current record as it stands in the file; empty beyond the last.
    pub(crate) fn raw(&self, index: usize) -> &[u8] {
        self.rows.field(index)
    }

    /// The same without blanks around it.
    pub(crate) fn field(&self, index: usize) -> &[u8] {
        self.raw(index).trim_ascii()
    }

    /// A field as text; one that is not UTF-8 is noted.
    pub(crate) fn text<'t>(&self, field: &'t [u8]) -> Cow<'t, str> {
        let (text, other_encoding) = text_of(field);
        if other_encoding && self.other_encoding.get().is_none() {
            self.other_encoding.set(Some(self.line));
        }
        match text {
            Cow::Borrowed(text) => Cow::Borrowed(unescape_formula(text)),
            Cow::Owned(text) => Cow::Owned(unescape_formula(&text).to_owned()),
        }
    }

    /// The error for columns that must be there and are not.
    pub(crate) fn missing_columns(&self, missing: Vec<String>, advice: String) -> TableError {
        let named = missing.iter().map(|name| format!("`{name}`"));
        let message = format!(
            "{}: no column {} among {}",
            self.at(self.header_line),
            named.collect::<Vec<_>>().join(", "),
            listed_names(self.names.iter().map(String::as_str))
        );
        TableError::new("stiffbench::readings::missing_column", message, advice).about(missing)
    }

    /// The error for two columns that mean the same.
    pub(crate) fn duplicate(
        &self,
        column: &'static str,
        first: usize,
        second: usize,
    ) -> TableError {
        TableError::new(
            "stiffbench::readings::duplicate_column",
            format!(
                "{}: `{}` and `{}` both give {column}",
                self.at(self.header_line),
                self.names[first],
                self.names[second]
            ),
            "remove one of the two columns, or rename it",
        )
    }

    /// The error for a unit in the name of a column.
    pub(crate) fn wrong_unit(
        &self,
        index: usize,
        unit: Option<&str>,
        accepted: &'static str,
    ) -> TableError {
        let unit = unit.map_or("none".to_owned(), |unit| format!("`{unit}`"));
        TableError::new(
            "stiffbench::readings::wrong_unit",
            format!(
                "{}: column `{}` has {unit} for its unit, expected one of {accepted}",
                self.at(self.header_line),
                self.names[index]
            ),
            "write the unit after an underscore: force_N, force_lbf, displacement_mm, temp_degC, force_x_N, joint_J1_deg",
        )
    }

    /// A field of the current record, for messages.
    fn cell(&self, column: &str, value: &[u8]) -> FileCell {
        FileCell {
            file: self.file(),
            line: self.line,
            column: column.to_owned(),
            value: text_of(value).0.into_owned(),
        }
    }

    /// The error for a field of the current record without a value.
    pub(crate) fn missing(&self, column: &str, expected: &'static str) -> TableError {
        missing_value(&self.cell(column, b""), expected)
    }

    /// The error for a field of the current record with a wrong value.
    pub(crate) fn bad(&self, column: &str, value: &[u8], expected: &'static str) -> TableError {
        bad_value(&self.cell(column, value), expected)
    }

    /// A field as a number in SI; `None` without a value.
    pub(crate) fn number(
        &mut self,
        index: usize,
        conversion: Conversion,
    ) -> Result<Option<f64>, TableError> {
        let field = self.rows.field(index).trim_ascii();
        if field.is_empty() {
            return Ok(None);
        }
        let read = self.numbers.read(field, conversion, self.line);
        read.map(Some).map_err(|fault| {
            let (column, field) = (&self.names[index], self.field(index));
            match fault {
                NumberFault::NotANumber => self.bad(column, field, "a number"),
                NumberFault::NotFinite => {
                    let cell = self.cell(column, field);
                    TableError::new(
                        "stiffbench::readings::not_finite",
                        format!("{cell}: `{}` is not a finite number", cell.value),
                        "leave out the line, or the value if the column is optional",
                    )
                }
                NumberFault::OtherDecimalSign(sign, first_line) => {
                    let (cell, sign) = (self.cell(column, field), sign.word());
                    TableError::new(
                        "stiffbench::readings::mixed_decimals",
                        format!(
                            "{cell}: `{}` does not have the decimal {sign} of line {first_line}",
                            cell.value
                        ),
                        "use one decimal sign throughout and no grouping of thousands",
                    )
                }
            }
        })
    }

    /// A whole number from `least`; `None` without a value.
    pub(crate) fn count(&self, index: usize, least: u32) -> Result<Option<u32>, TableError> {
        let field = self.field(index);
        if field.is_empty() {
            return Ok(None);
        }
        let count = read_count(field).filter(|count| *count >= least);
        count.map(Some).ok_or_else(|| {
            let expected = if least == 0 {
                "a whole number from 0"
            } else {
                "a whole number from 1"
            };
            self.bad(&self.names[index], field, expected)
        })
    }

    /// What becomes of a reading; it counts without a value.
    pub(crate) fn status(&self, index: usize) -> Result<ReadingStatus, TableError> {
        let expected = "accepted, superseded or rejected";
        let meaning = self.word(index, &STATUS_WORDS, expected)?;
        Ok(meaning.unwrap_or(ReadingStatus::Accepted))
    }

    /// Whether a load was put on or taken off; put on without a value.
    pub(crate) fn branch(&self, index: usize) -> Result<Branch, TableError> {
        let meaning = self.word(index, &BRANCH_WORDS, "loading or unloading")?;
        Ok(meaning.unwrap_or(Branch::Loading))
    }

    /// A word with a meaning; `None` without a value.
    fn word<T: Copy>(
        &self,
        index: usize,
        known: &[(&str, T)],
        expected: &'static str,
    ) -> Result<Option<T>, TableError> {
        let field = self.field(index);
        if field.is_empty() {
            return Ok(None);
        }
        let meaning = meaning_of(field, known).map(Some);
        meaning.ok_or_else(|| self.bad(&self.names[index], field, expected))
    }

    /// What was taken for granted of the text itself.
    pub(crate) fn assumptions(&self) -> Vec<String> {
        let delimiter = self.rows.delimiter();
        let other_delimiter = delimiter != FieldDelimiter::Comma;
        let encoding = match self.rows.encoding() {
            Encoding::Plain => None,
            Encoding::Utf8Marked => Some("a byte order mark was taken off"),
            Encoding::Utf16 => Some("the text is UTF-16"),
        };
        let line_ends = self.rows.lone_carriage_return();
        let comma = self.numbers.decimal_comma();
        [
            encoding.map(str::to_owned),
            line_ends.then(|| "lines end with a carriage return".to_owned()),
            other_delimiter.then(|| format!("fields are delimited by a {delimiter}")),
            self.other_encoding.get().map(|line| {
                format!("text that is not UTF-8 was taken as ISO 8859-1, first in line {line}")
            }),
            comma.map(|line| format!("numbers have a decimal comma, as in line {line}")),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Lines without a value, and lines of comments.
    pub(crate) fn passed_over(self) -> (Vec<u32>, Vec<u32>) {
        (self.rows.blank, self.rows.comments)
    }
}
