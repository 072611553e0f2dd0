//! One record of a table to one row, with the texts that name its run and configuration.

use std::io::Read;

use super::assumption::{Incomplete, SpecimenAssumption};
use super::columns::{Columns, Measured, Place};
use super::error::SpecimenError;
use crate::readings::{
    NumberFault, NumberReader, ReadingsError, Rows, number_error, read_count, text_of,
};
use stiffbench_units_and_text::test_point::Branch;

/// A record that has all it must have.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
    pub(super) line: u32,
    pub(super) configuration: String,
    pub(super) run: String,
    pub(super) order: Option<u32>,
    pub(super) branch: Option<Branch>,
    pub(super) force: f64,
    pub(super) displacement: f64,
    pub(super) time_s: Option<f64>,
    pub(super) hold_s: Option<f64>,
    pub(super) temperature_deg_c: Option<f64>,
}

/// How often, and where first, an optional column has no value.
#[derive(Debug, Clone, Copy, Default)]
struct Absences {
    rows: u32,
    line: u32,
}

/// Turns records into rows.
pub(super) struct RowReader<'a> {
    file: &'a str,
    columns: &'a Columns,
    pub(super) numbers: NumberReader,
    pub(super) rows: Vec<Row>,
    pub(super) incomplete: Vec<Incomplete>,
    pub(super) other_encoding: Option<u32>,
    absences: [Absences; 3],
}

/// A value that a row must have is not there.
enum Fault {
    Absent(String),
    Wrong(SpecimenError),
}

impl From<SpecimenError> for Fault {
    fn from(error: SpecimenError) -> Self {
        Self::Wrong(error)
    }
}

impl<'a> RowReader<'a> {
    pub(super) fn new(file: &'a str, columns: &'a Columns, numbers: NumberReader) -> Self {
        Self {
            file,
            columns,
            numbers,
            rows: Vec::new(),
            incomplete: Vec::new(),
            other_encoding: None,
            absences: [Absences::default(); 3],
        }
    }

    /// Adds the current record, to the rows or to those that lack a value.
    pub(super) fn take<R: Read>(&mut self, rows: &Rows<R>, line: u32) -> Result<(), SpecimenError> {
        self.check_width(rows, line)?;
        match self.row(rows, line) {
            Ok(row) => self.rows.push(row),
            Err(Fault::Absent(column)) => self.incomplete.push(Incomplete { line, column }),
            Err(Fault::Wrong(error)) => return Err(error),
        }
        Ok(())
    }

    /// More fields than names are fine as long as they are empty, as spreadsheets leave them.
    fn check_width<R: Read>(&self, rows: &Rows<R>, line: u32) -> Result<(), SpecimenError> {
        let (expected, found) = (self.columns.width, rows.len());
        let empty = |index: usize| rows.field(index).trim_ascii().is_empty();
        if found == expected || found > expected && (expected..found).all(empty) {
            return Ok(());
        }
        let file = self.file.to_owned();
        Err(SpecimenError::Text(ReadingsError::FieldCount {
            file,
            line,
            expected,
            found,
        }))
    }

    fn row<R: Read>(&mut self, rows: &Rows<R>, line: u32) -> Result<Row, Fault> {
        let columns = self.columns;
        let force = match &columns.force {
            Some(force) => self.required(rows, line, force)?,
            None => 0.0,
        };
        let displacement = self.required(rows, line, &columns.displacement)?;
        let configuration = self.label(rows, line, &columns.configuration)?;
        let run = self.label(rows, line, &columns.run)?;
        let order = columns
            .order
            .as_ref()
            .map(|place| self.order(rows, line, place))
            .transpose()?;
        let branch = columns
            .branch
            .as_ref()
            .map(|place| self.branch(rows, line, place))
            .transpose()?;
        let mut optional = [None; 3];
        for (index, column) in columns.optional().into_iter().enumerate() {
            let Some(column) = column else { continue };
            optional[index] = self.number(rows, line, column)?;
            if optional[index].is_none() {
                let absences = &mut self.absences[index];
                absences.rows += 1;
                if absences.line == 0 {
                    absences.line = line;
                }
            }
        }
        let [time_s, hold_s, temperature_deg_c] = optional;
        Ok(Row {
            line,
            configuration,
            run,
            order,
            branch,
            force,
            displacement,
            time_s,
            hold_s,
            temperature_deg_c,
        })
    }

    fn required<R: Read>(
        &mut self,
        rows: &Rows<R>,
        line: u32,
        column: &Measured,
    ) -> Result<f64, Fault> {
        self.number(rows, line, column)?
            .ok_or_else(|| Fault::Absent(column.place.name.clone()))
    }

    fn number<R: Read>(
        &mut self,
        rows: &Rows<R>,
        line: u32,
        column: &Measured,
    ) -> Result<Option<f64>, SpecimenError> {
        let Some(field) = present(rows, &column.place) else {
            return Ok(None);
        };
        match self.numbers.read(field, column.conversion, line) {
            Ok(number) => Ok(Some(number)),
            Err(NumberFault::NotANumber) => Err(self.bad(line, &column.place, field, "a number")),
            Err(fault) => {
                let name = column.place.name.clone();
                Err(number_error(self.file, line, name, field, fault).into())
            }
        }
    }

    /// The texts of columns that together name something.
    fn label<R: Read>(
        &mut self,
        rows: &Rows<R>,
        line: u32,
        places: &[Place],
    ) -> Result<String, Fault> {
        let mut label = String::new();
        for place in places {
            let field = present(rows, place).ok_or_else(|| Fault::Absent(place.name.clone()))?;
            let (text, other_encoding) = text_of(field);
            if other_encoding {
                self.other_encoding.get_or_insert(line);
            }
            if !label.is_empty() {
                label.push_str(" / ");
            }
            label.push_str(&text);
        }
        Ok(label)
    }

    fn order<R: Read>(&self, rows: &Rows<R>, line: u32, place: &Place) -> Result<u32, Fault> {
        let field = present(rows, place).ok_or_else(|| Fault::Absent(place.name.clone()))?;
        let count = read_count(field);
        Ok(count.ok_or_else(|| self.bad(line, place, field, "a whole number from 0"))?)
    }

    fn branch<R: Read>(&self, rows: &Rows<R>, line: u32, place: &Place) -> Result<Branch, Fault> {
        let field = present(rows, place).ok_or_else(|| Fault::Absent(place.name.clone()))?;
        let is = |words: [&str; 2]| {
            words
                .iter()
                .any(|word| field.eq_ignore_ascii_case(word.as_bytes()))
        };
        if is(["loading", "load"]) {
            Ok(Branch::Loading)
        } else if is(["unloading", "unload"]) {
            Ok(Branch::Unloading)
        } else {
            Err(self.bad(line, place, field, "loading or unloading").into())
        }
    }

    fn bad(&self, line: u32, place: &Place, value: &[u8], expected: &'static str) -> SpecimenError {
        SpecimenError::BadValue {
            file: self.file.to_owned(),
            line,
            column: place.name.clone(),
            value: text_of(value).0.into_owned(),
            expected,
        }
    }

    /// Optional columns that have no value in some rows.
    pub(super) fn absent(&self) -> Vec<SpecimenAssumption> {
        let columns = self.columns.optional().into_iter().zip(self.absences);
        columns
            .filter(|(_, absences)| absences.rows > 0)
            .filter_map(|(column, Absences { rows, line })| {
                let column = column?.place.name.clone();
                Some(SpecimenAssumption::ValuesAbsent { column, rows, line })
            })
            .collect()
    }
}

/// The field without blanks around it; `None` if it says that there is no value.
fn present<'r, R: Read>(rows: &'r Rows<R>, place: &Place) -> Option<&'r [u8]> {
    const ABSENT: [&str; 5] = ["", "NA", "N/A", "NaN", "null"];
    let field = rows.field(place.index).trim_ascii();
    let absent = ABSENT
        .iter()
        .any(|word| field.eq_ignore_ascii_case(word.as_bytes()));
    (!absent).then_some(field)
}
