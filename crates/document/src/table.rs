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

/// A column of words.
#[must_use]
pub fn words(head: impl Into<String>) -> TableColumn {
    let (head, kind) = (head.into(), ColumnKind::Words);
    TableColumn { head, kind }
}

/// A column of numbers.
#[must_use]
pub fn numbers(head: impl Into<String>) -> TableColumn {
    let (head, kind) = (head.into(), ColumnKind::Numbers);
    TableColumn { head, kind }
}

impl<S: AsRef<str> + ?Sized> From<&S> for TableColumn {
    fn from(head: &S) -> Self {
        words(head.as_ref())
    }
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
    /// A table with these columns.
    #[must_use]
    pub fn new(columns: impl IntoIterator<Item: Into<TableColumn>>) -> Self {
        Self {
            columns: columns.into_iter().map(Into::into).collect(),
            rows: Vec::new(),
        }
    }

    /// A table without columns, with a row for each of these things.
    pub fn of<T>(things: impl IntoIterator<Item = T>) -> TableOf<T> {
        let things: Vec<T> = things.into_iter().collect();
        let (columns, rows) = (Vec::new(), vec![Vec::new(); things.len()]);
        let table = Self { columns, rows };
        TableOf { things, table }
    }

    /// Adds a row.
    pub fn row<C: Into<TableCell>>(&mut self, cells: impl IntoIterator<Item = C>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
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
        self.column(words(head), cell)
    }

    /// Adds a column of numbers.
    #[must_use]
    pub fn numbers<C: Into<TableCell>>(
        self,
        head: impl Into<String>,
        cell: impl Fn(&T) -> C,
    ) -> Self {
        self.column(numbers(head), cell)
    }

    /// Adds columns of numbers whose cells come together.
    #[must_use]
    pub fn numbers_each<C: IntoIterator<Item: Into<TableCell>>>(
        mut self,
        heads: impl IntoIterator<Item: Into<String>>,
        cells: impl Fn(&T) -> C,
    ) -> Self {
        self.table.columns.extend(heads.into_iter().map(numbers));
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

    fn column<C: Into<TableCell>>(mut self, column: TableColumn, cell: impl Fn(&T) -> C) -> Self {
        self.table.columns.push(column);
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
        let mut table = Table::new([words("pose"), numbers("K")]);
        table.row(["P|1".to_owned(), "0.5".to_owned()]);
        insta::assert_snapshot!(table.text(), @r"
        | pose |   K |
        |------|-----|
        | P\|1 | 0.5 |
        ");
    }

    #[test]
    fn columns_of_numbers_are_on_the_right_and_words_on_the_left() {
        let mut table = Table::new([words("pose"), numbers("K"), words("state")]);
        for row in [
            ["P1", "-0.5", "known"],
            ["P2", "-", "21 open"],
            ["P3", "12", "no"],
        ] {
            table.row(row.map(str::to_owned));
        }
        assert_eq!(
            table.text(),
            "| pose |    K | state   |\n|------|------|---------|\n| P1   | -0.5 | known   |\n| P2   |    - | 21 open |\n| P3   |   12 | no      |\n"
        );
    }
}
