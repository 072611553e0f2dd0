//! One record of a table to one row, with the texts that name its run and configuration.

use super::assumption::{Incomplete, SpecimenAssumption};
use super::columns::{ColumnPosition, MeasuredColumn, SpecimenColumns};
use super::error::SpecimenError;
use crate::readings::{NumberFault, RecordTable, read_count};
use stiffbench_units_and_text::test_point::Branch;

/// A record that has all it must have.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpecimenRow {
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
pub(super) struct SpecimenRowReader<'a> {
    columns: &'a SpecimenColumns,
    pub(super) rows: Vec<SpecimenRow>,
    pub(super) incomplete: Vec<Incomplete>,
    absences: [Absences; 3],
}

/// A value that a row must have is not there.
enum MissingValue {
    Absent(String),
    Wrong(SpecimenError),
}

impl From<SpecimenError> for MissingValue {
    fn from(error: SpecimenError) -> Self {
        Self::Wrong(error)
    }
}

impl<'a> SpecimenRowReader<'a> {
    pub(super) fn new(columns: &'a SpecimenColumns) -> Self {
        Self {
            columns,
            rows: Vec::new(),
            incomplete: Vec::new(),
            absences: [Absences::default(); 3],
        }
    }

    /// Adds the current record, to the rows or to those that lack a value.
    pub(super) fn take(&mut self, text: &mut RecordTable<'_>) -> Result<(), SpecimenError> {
        match self.row(text) {
            Ok(row) => self.rows.push(row),
            Err(MissingValue::Absent(column)) => {
                let line = text.line;
                self.incomplete.push(Incomplete { line, column });
            }
            Err(MissingValue::Wrong(error)) => return Err(error),
        }
        Ok(())
    }

    fn row(&mut self, text: &mut RecordTable<'_>) -> Result<SpecimenRow, MissingValue> {
        let columns = self.columns;
        let force = match &columns.force {
            Some(force) => Self::required(text, force)?,
            None => 0.0,
        };
        let displacement = Self::required(text, &columns.displacement)?;
        let configuration = Self::label(text, &columns.configuration)?;
        let run = Self::label(text, &columns.run)?;
        let order = columns
            .order
            .as_ref()
            .map(|place| Self::order(text, place))
            .transpose()?;
        let branch = columns
            .branch
            .as_ref()
            .map(|place| Self::branch(text, place))
            .transpose()?;
        let mut optional = [None; 3];
        for (index, column) in columns.optional().into_iter().enumerate() {
            let Some(column) = column else { continue };
            optional[index] = Self::number(text, column)?;
            if optional[index].is_none() {
                let absences = &mut self.absences[index];
                absences.rows += 1;
                if absences.line == 0 {
                    absences.line = text.line;
                }
            }
        }
        let [time_s, hold_s, temperature_deg_c] = optional;
        Ok(SpecimenRow {
            line: text.line,
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

    fn required(text: &mut RecordTable<'_>, column: &MeasuredColumn) -> Result<f64, MissingValue> {
        Self::number(text, column)?.ok_or_else(|| MissingValue::Absent(column.place.name.clone()))
    }

    fn number(
        text: &mut RecordTable<'_>,
        column: &MeasuredColumn,
    ) -> Result<Option<f64>, SpecimenError> {
        let MeasuredColumn {
            place, conversion, ..
        } = column;
        if present(text, place).is_none() {
            return Ok(None);
        }
        match text.number(place.index, *conversion) {
            Ok(number) => Ok(Some(number)),
            Err(NumberFault::NotANumber) => {
                Err(Self::bad(text, place, text.field(place.index), "a number"))
            }
            Err(fault) => Err(text
                .number_error(place.index, place.name.clone(), fault)
                .into()),
        }
    }

    /// The texts of columns that together name something.
    fn label(text: &RecordTable<'_>, places: &[ColumnPosition]) -> Result<String, MissingValue> {
        let mut label = String::new();
        for place in places {
            let field =
                present(text, place).ok_or_else(|| MissingValue::Absent(place.name.clone()))?;
            if !label.is_empty() {
                label.push_str(" / ");
            }
            label.push_str(&text.text(field));
        }
        Ok(label)
    }

    fn order(text: &RecordTable<'_>, place: &ColumnPosition) -> Result<u32, MissingValue> {
        let field = present(text, place).ok_or_else(|| MissingValue::Absent(place.name.clone()))?;
        let count = read_count(field);
        Ok(count.ok_or_else(|| Self::bad(text, place, field, "a whole number from 0"))?)
    }

    fn branch(text: &RecordTable<'_>, place: &ColumnPosition) -> Result<Branch, MissingValue> {
        let field = present(text, place).ok_or_else(|| MissingValue::Absent(place.name.clone()))?;
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
            Err(Self::bad(text, place, field, "loading or unloading").into())
        }
    }

    fn bad(
        text: &RecordTable<'_>,
        place: &ColumnPosition,
        value: &[u8],
        expected: &'static str,
    ) -> SpecimenError {
        SpecimenError::BadValue {
            file: text.file(),
            line: text.line,
            column: place.name.clone(),
            value: text.text(value).into_owned(),
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

/// The field without blanks around it; `None` if it states that there is no value.
fn present<'r>(text: &'r RecordTable<'_>, place: &ColumnPosition) -> Option<&'r [u8]> {
    const ABSENT: [&str; 5] = ["", "NA", "N/A", "NaN", "null"];
    let field = text.field(place.index);
    let absent = ABSENT
        .iter()
        .any(|word| field.eq_ignore_ascii_case(word.as_bytes()));
    (!absent).then_some(field)
}
