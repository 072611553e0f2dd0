//! Tables, which a terminal prints as Markdown.

use std::fmt::Display;

use comfy_table::CellAlignment;
use comfy_table::presets::ASCII_MARKDOWN;
use schemars::JsonSchema;
use serde::Serialize;

/// A table of text cells.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Table {
    /// Its columns.
    columns: Vec<TableColumn>,
    /// Its rows.
    rows: Vec<Vec<TableCell>>,
}

/// A column of a table. A head alone is a column of words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct TableColumn {
    /// What stands above it, with the unit of its numbers.
    pub head: String,
    /// What stands in it.
    pub kind: ColumnKind,
}

/// What stands in a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ColumnKind {
    /// Words, which begin on the left.
    Words,
    /// Numbers, which end on the right.
    Numbers,
}

/// A cell of a table.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum TableCell {
    /// A text.
    Plain(String),
    /// A text that stands out: a decision, or something that is missing.
    Marked {
        /// The text.
        marked: String,
    },
}

impl TableCell {
    /// A text that stands out.
    #[must_use]
    pub fn marked(text: impl Into<String>) -> Self {
        let marked = text.into();
        Self::Marked { marked }
    }

    fn text(&self) -> &str {
        match self {
            Self::Plain(text) | Self::Marked { marked: text } => text,
        }
    }
}

impl<D: Display> From<D> for TableCell {
    fn from(text: D) -> Self {
        Self::Plain(text.to_string())
    }
}

impl Table {
    /// A table without columns, with a row for each of these things.
    pub fn of<T>(things: impl IntoIterator<Item = T>) -> TableOf<T> {
        let things: Vec<T> = things.into_iter().collect();
        let (columns, rows) = (Vec::new(), vec![Vec::new(); things.len()]);
        let table = Self { columns, rows };
        TableOf { things, table }
    }

    /// As a terminal shows it, each line ended.
    #[must_use]
    pub fn text(&self) -> String {
        let mut table = comfy_table::Table::new();
        table.load_style(ASCII_MARKDOWN);
        table.set_header(self.columns.iter().map(|column| in_one_cell(&column.head)));
        for (shown, column) in table.column_iter_mut().zip(&self.columns) {
            shown.set_cell_alignment(match column.kind {
                ColumnKind::Numbers => CellAlignment::Right,
                ColumnKind::Words => CellAlignment::Left,
            });
        }
        for row in &self.rows {
            table.add_row(row.iter().map(|cell| in_one_cell(cell.text())));
        }
        format!("{table}\n")
    }
}

/// A table that is made column by column from things, each of which has a row.
#[derive(Debug)]
pub struct TableOf<T> {
    things: Vec<T>,
    table: Table,
}

impl<T> TableOf<T> {
    /// Adds a column of words.
    #[must_use]
    pub fn words<C: Into<TableCell>>(
        self,
        head: impl Into<String>,
        cell: impl Fn(&T) -> C,
    ) -> Self {
        self.column(head, ColumnKind::Words, cell)
    }

    /// Adds a column of numbers.
    #[must_use]
    pub fn numbers<C: Into<TableCell>>(
        self,
        head: impl Into<String>,
        cell: impl Fn(&T) -> C,
    ) -> Self {
        self.column(head, ColumnKind::Numbers, cell)
    }

    /// Adds columns of numbers whose cells come together.
    #[must_use]
    pub fn numbers_each<C: IntoIterator<Item: Into<TableCell>>>(
        mut self,
        heads: impl IntoIterator<Item: Into<String>>,
        cells: impl Fn(&T) -> C,
    ) -> Self {
        let heads = heads.into_iter().map(Into::into);
        let kind = ColumnKind::Numbers;
        let columns = heads.map(|head| TableColumn { head, kind });
        self.table.columns.extend(columns);
        for (row, thing) in self.table.rows.iter_mut().zip(&self.things) {
            row.extend(cells(thing).into_iter().map(Into::into));
        }
        self
    }

    /// Adds columns if a condition holds.
    #[must_use]
    pub fn when(self, holds: bool, add: impl FnOnce(Self) -> Self) -> Self {
        if holds { add(self) } else { self }
    }

    /// As text.
    #[must_use]
    pub fn text(&self) -> String {
        self.table.text()
    }

    fn column<C: Into<TableCell>>(
        mut self,
        head: impl Into<String>,
        kind: ColumnKind,
        cell: impl Fn(&T) -> C,
    ) -> Self {
        let head = head.into();
        self.table.columns.push(TableColumn { head, kind });
        for (row, thing) in self.table.rows.iter_mut().zip(&self.things) {
            row.push(cell(thing).into());
        }
        self
    }
}

impl<T> From<TableOf<T>> for Table {
    fn from(made: TableOf<T>) -> Self {
        made.table
    }
}

/// A text as a cell: no bar in it ends the cell, and no line the row.
fn in_one_cell(text: &str) -> String {
    text.replace('|', "\\|").replace(['\n', '\r'], " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_markdown() {
        let table = Table::of(["P|1"])
            .words("pose", |pose| *pose)
            .numbers("K", |_| 0.5);
        insta::assert_snapshot!(table.text(), @r"
        | pose |   K |
        |------|-----|
        | P\|1 | 0.5 |
        ");
    }

    #[test]
    fn columns_of_numbers_are_on_the_right_and_words_on_the_left() {
        let rows = [
            ["P1", "-0.5", "known"],
            ["P2", "-", "21 open"],
            ["P3", "12", "no"],
        ];
        let table = Table::of(rows)
            .words("pose", |row| row[0])
            .numbers("K", |row| row[1])
            .words("state", |row| row[2]);
        assert_eq!(
            table.text(),
            "| pose |    K | state   |\n|------|------|---------|\n| P1   | -0.5 | known   |\n| P2   |    - | 21 open |\n| P3   |   12 | no      |\n"
        );
    }
}
