//! Several tables as one: files or sheets with the same columns, and columns that repeat one another.

use std::fmt::Write;

use super::columns::FileColumn;
use super::table::{FileRow, MachineTable, no_numbers};
use crate::readings::TableError;
use stiffbench_units_and_text::nearest::listed_names;

impl MachineTable {
    /// Tables with the same columns below each other; of several, a column names the table of each row.
    ///
    /// # Arguments
    /// - `tables`: at least one, with their names.
    /// - `column`: the name of that column.
    ///
    /// # Errors
    /// [`TableError`] for the first whose columns are not those of the first.
    pub(super) fn joined(tables: Vec<(String, Self)>, column: &str) -> Result<Self, TableError> {
        let is_alone = tables.len() == 1;
        let mut tables = tables.into_iter();
        let Some((name, mut all)) = tables.next() else {
            return Err(no_numbers(""));
        };
        if is_alone {
            return Ok(all);
        }
        let known = all.layout.columns.clone();
        all.add_texts(column, &name);
        let mut sheets: Vec<String> = all.layout.sheet.take().into_iter().collect();
        for (name, mut next) in tables {
            let alike = |a: &FileColumn, b: &FileColumn| a.name == b.name && a.unit == b.unit;
            let columns = &next.layout.columns;
            let are_alike = columns.len() == known.len()
                && columns.iter().zip(&known).all(|(a, b)| alike(a, b));
            if !are_alike {
                let expected = listed_names(known.iter().map(|column| column.name.as_str()));
                return Err(TableError::new(
                    "stiffbench::table::other_columns",
                    format!(
                        "{}: the columns are {}, and those of {} {expected}",
                        next.header(),
                        listed_names(next.names()),
                        all.source
                    ),
                    "several files are the repeats of one table: read files with other columns by themselves",
                ));
            }
            next.add_texts(column, &name);
            for (column, of_next) in all.layout.columns.iter_mut().zip(&next.layout.columns) {
                column.is_numeric |= of_next.is_numeric;
            }
            sheets.extend(next.layout.sheet.take());
            let (parts, segments) = (all.parts.len(), all.layout.segments);
            all.layout.segments += next.layout.segments;
            all.layout.rows += next.layout.rows;
            all.layout.last_line = next.layout.last_line;
            all.parts.append(&mut next.parts);
            all.rows.extend(next.rows.into_iter().map(|row| FileRow {
                part: row.part + parts,
                segment: row.segment + segments,
                ..row
            }));
        }
        all.layout.sheet = (!sheets.is_empty()).then(|| sheets.join("`, `"));
        Ok(all)
    }

    /// The same with a row for each of some columns, which stand below each other as the first of them; a column names the one of each row.
    pub(crate) fn stacked(&self, columns: &[usize], name: &str) -> Self {
        let Some(first) = columns.first() else {
            return self.clone();
        };
        let mut all = self.clone();
        all.rows.clear();
        // Columns may have one name.
        let is_alike = |column: usize| {
            let mut others = columns.iter().filter(|other| **other != column);
            others.any(|other| self.name(*other) == self.name(column))
        };
        for column in columns {
            let mut label = self.name(*column).to_owned();
            if is_alike(*column) {
                let _ = write!(label, " ({})", column + 1);
            }
            all.rows.extend(self.rows.iter().map(|row| {
                let cell = |index| {
                    let from = if index == *first { *column } else { index };
                    row.cells.get(from).unwrap_or("")
                };
                let cells = (0..self.layout.columns.len()).map(cell);
                let cells = cells.chain([label.as_str()]).collect();
                FileRow {
                    cells,
                    ..row.clone()
                }
            }));
        }
        all.layout.columns.push(FileColumn::named(name));
        all
    }

    /// Adds a column with the same text in every row; none where there is one of its name.
    fn add_texts(&mut self, column: &str, text: &str) {
        if self.names().any(|name| name == column) {
            return;
        }
        let width = self.layout.columns.len();
        for row in &mut self.rows {
            while row.cells.len() < width {
                row.cells.push_field("");
            }
            row.cells.truncate(width);
            row.cells.push_field(text);
        }
        self.layout.columns.push(FileColumn::named(column));
    }
}
