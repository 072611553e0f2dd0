//! The header of a table: which column stands where, in which unit.

use super::column::{Column, NamedColumn, understand};
use super::error::TableError;
use super::number::Conversion;
use super::text_table::RecordTable;
use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::quantity::Kind;

/// Where the columns of a file are.
#[derive(Debug)]
pub(super) struct ColumnHeader {
    /// Names as they stand in the file.
    names: Vec<String>,
    places: [Option<(usize, Conversion)>; Column::ALL.len()],
    /// Columns that mean nothing here, by place.
    pub(super) unused: Vec<usize>,
}

impl ColumnHeader {
    /// The header of a table that has all columns of readings along the load.
    pub(super) fn read(text: &RecordTable<'_>) -> Result<Self, TableError> {
        let (header, without_unit) = Self::find(text)?;
        header.check_required(text, &without_unit)?;
        Ok(header)
    }

    /// The columns that a table has, and those that lack a unit.
    pub(super) fn find(text: &RecordTable<'_>) -> Result<(Self, Vec<(Column, usize)>), TableError> {
        let mut header = Self {
            places: [None; Column::ALL.len()],
            unused: Vec::new(),
            names: text.names.clone(),
        };
        let mut without_unit = Vec::new();
        for index in 0..header.names.len() {
            match understand(&header.names[index]) {
                NamedColumn::Column(column, conversion) => {
                    if let Some((first, _)) = header.places[column as usize] {
                        return Err(text.duplicate(column.name(), first, index));
                    }
                    header.places[column as usize] = Some((index, conversion));
                }
                NamedColumn::WrongUnit(column, unit) => {
                    return Err(wrong_unit(text, index, Some(unit), column));
                }
                NamedColumn::NoUnit(column) => {
                    without_unit.push((column, index));
                    header.unused.push(index);
                }
                NamedColumn::Unknown => header.unused.push(index),
            }
        }
        Ok((header, without_unit))
    }

    fn check_required(
        &self,
        text: &RecordTable<'_>,
        without_unit: &[(Column, usize)],
    ) -> Result<(), TableError> {
        let absent = |column: &Column| !self.has(*column);
        // `force` where `force_N` is needed: the unit is missing rather than the column, and no unit is guessed.
        let named = |column: &Column| without_unit.iter().find(|(found, _)| found == column);
        let (no_unit, missing): (Vec<Column>, Vec<Column>) = Column::REQUIRED
            .into_iter()
            .filter(absent)
            .partition(|column| named(column).is_some());
        match (missing.as_slice(), no_unit.as_slice()) {
            ([], []) => Ok(()),
            ([], [column, ..]) => {
                let index = named(column).map_or(0, |(_, index)| *index);
                Err(wrong_unit(text, index, None, *column))
            }
            ([first, others @ ..], no_unit) => Err(self.missing(text, *first, others, no_unit)),
        }
    }

    /// All that is missing, at once.
    fn missing(
        &self,
        text: &RecordTable<'_>,
        first: Column,
        others: &[Column],
        no_unit: &[Column],
    ) -> TableError {
        let unused = || self.unused.iter().map(|index| self.names[*index].as_str());
        let near = std::iter::once(&first).chain(others).filter_map(|column| {
            let near = nearest(column.name(), unused())?;
            Some(format!("is `{near}` meant? Name it `{column}`"))
        });
        let units = no_unit
            .iter()
            .map(|column| format!("`{column}` needs a unit behind its name"));
        let mut advice: Vec<String> = near.chain(units).collect();
        if advice.is_empty() {
            advice.push(
                "the smallest table has the columns pose,direction,repeat,force_N,displacement_um"
                    .to_owned(),
            );
        }
        let file = text.file();
        let file = file.as_str();
        let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
        // Standard input, and a name with a blank, cannot be copied as they are.
        let (named, stem) = if file.contains(' ') {
            ("FILE", "my")
        } else {
            (file, stem)
        };
        advice.push(format!(
            "columns of other names are read where --direction, --pose or --map state what is missing, and by stiffbench import {named} --out {stem}-session"
        ));
        let missing = std::iter::once(&first).chain(others);
        let missing: Vec<String> = missing.map(ToString::to_string).collect();
        text.missing_columns(missing, advice.join("; "))
    }

    pub(super) fn has(&self, column: Column) -> bool {
        self.places[column as usize].is_some()
    }

    /// Place and unit of a column.
    pub(super) fn place(&self, column: Column) -> Option<(usize, Conversion)> {
        self.places[column as usize]
    }

    /// The column's name in the file, for messages.
    pub(super) fn name(&self, column: Column) -> String {
        match self.places[column as usize] {
            Some((index, _)) => self.names[index].clone(),
            None => column.name().to_owned(),
        }
    }

    /// The name of a column by its place; one without a name is called by its number.
    pub(super) fn name_at(&self, index: usize) -> String {
        match self.names[index].as_str() {
            "" => format!("column {} (no name)", index + 1),
            name => name.to_owned(),
        }
    }

    /// The unit conversions in use.
    pub(super) fn conversions(&self) -> Vec<String> {
        let written = |column: Column| {
            let kind = column.kind()?;
            Conversion::from_unit(kind, column.unit())
        };
        Column::ALL
            .into_iter()
            .filter_map(|column| {
                let (_, conversion) = self.place(column)?;
                (written(column)? != conversion).then(|| {
                    let found = self.name(column);
                    format!("column `{found}` was converted to {}", column.unit())
                })
            })
            .collect()
    }
}

fn wrong_unit(
    text: &RecordTable<'_>,
    index: usize,
    unit: Option<&str>,
    column: Column,
) -> TableError {
    text.wrong_unit(index, unit, column.kind().map_or("", Kind::units))
}

#[cfg(test)]
mod tests {
    use super::*;
    use miette::Diagnostic;

    fn header(names: &str) -> Result<ColumnHeader, TableError> {
        let text = RecordTable::open("t.csv", names.as_bytes())?;
        ColumnHeader::read(&text)
    }

    #[test]
    fn the_five_columns_are_enough() {
        let header = header("displacement_um,force_N,repeat,direction,pose").unwrap();
        assert_eq!(header.place(Column::Pose), Some((4, Conversion::NONE)));
        assert!(header.conversions().is_empty());
        assert!(!header.has(Column::Step));
    }

    #[test]
    fn a_missing_column_names_the_nearest() {
        let error = header("pose,directoin,repeat,force_N,displacement_um").unwrap_err();
        assert_eq!(error.missing, ["direction"]);
        let advice = error.help().unwrap().to_string();
        assert!(advice.contains("`directoin`"), "{advice}");
        assert!(error.to_string().contains("`displacement_um`"), "{error}");
    }

    #[test]
    fn all_missing_columns_are_named_at_once() {
        let error = header("Pose,Richtung,Wiederholung,force,Weg").unwrap_err();
        let text = error.to_string();
        assert!(
            text.contains("no column `direction`, `repeat`, `displacement_um` among"),
            "{text}"
        );
        let advice = error.help().unwrap().to_string();
        assert!(advice.contains("`force_N` needs a unit"), "{advice}");
    }

    #[test]
    fn a_unit_is_required() {
        let error = header("pose,direction,repeat,force,displacement_um").unwrap_err();
        let expected = "t.csv, line 1: column `force` has none for its unit, expected one of N, ";
        assert!(error.to_string().starts_with(expected), "{error}");
    }

    #[test]
    fn two_names_for_one_column_are_refused() {
        let error = header("pose,direction,repeat,force_N,load_lbf,displacement_um").unwrap_err();
        assert_eq!(
            error.to_string(),
            "t.csv, line 1: `force_N` and `load_lbf` both give force_N"
        );
    }

    #[test]
    fn conversions_and_unused_columns_are_listed() {
        let header = header("pose,direction,repeat,force_kN,disp_mm,disp_sd_mm,").unwrap();
        assert_eq!(
            header.conversions(),
            [
                "column `force_kN` was converted to N",
                "column `disp_mm` was converted to um"
            ]
        );
        let unused: Vec<String> = header.unused.iter().map(|i| header.name_at(*i)).collect();
        assert_eq!(unused, ["disp_sd_mm", "column 7 (no name)"]);
    }
}
