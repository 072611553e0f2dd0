//! Tables, which a terminal prints as Markdown.

use comfy_table::CellAlignment;
use comfy_table::presets::ASCII_MARKDOWN;
use schemars::JsonSchema;
use serde::Serialize;

/// A table of text cells; columns with numbers are right-aligned, but for the first.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Table {
    /// Its column heads.
    head: Vec<String>,
    /// What stands in each column.
    columns: Vec<ColumnKind>,
    /// Its rows.
    rows: Vec<Vec<TableCell>>,
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

impl From<String> for TableCell {
    fn from(text: String) -> Self {
        Self::Plain(text)
    }
}

impl Table {
    /// A table with these column heads.
    #[must_use]
    pub fn new(heads: &[&str]) -> Self {
        Self {
            head: heads.iter().map(|&head| head.to_owned()).collect(),
            columns: vec![ColumnKind::Words; heads.len()],
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn row<C: Into<TableCell>>(&mut self, cells: impl IntoIterator<Item = C>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }

    /// With the kinds of its columns.
    pub(crate) fn with_kinds(self) -> Self {
        Self {
            columns: self.kinds(),
            ..self
        }
    }

    /// The kinds of the columns, from their cells; the first names the rows.
    fn kinds(&self) -> Vec<ColumnKind> {
        let kind = |place| {
            if place > 0 && self.is_of_numbers(place) {
                ColumnKind::Numbers
            } else {
                ColumnKind::Words
            }
        };
        (0..self.head.len()).map(kind).collect()
    }

    /// As a terminal shows it, each line ended.
    #[must_use]
    pub fn text(&self) -> String {
        let mut table = comfy_table::Table::new();
        table.load_style(ASCII_MARKDOWN);
        table.set_header(self.head.iter().map(|head| in_one_cell(head)));
        for (column, kind) in table.column_iter_mut().zip(self.kinds()) {
            column.set_cell_alignment(match kind {
                ColumnKind::Numbers => CellAlignment::Right,
                ColumnKind::Words => CellAlignment::Left,
            });
        }
        for row in &self.rows {
            table.add_row(row.iter().map(|cell| in_one_cell(cell.text())));
        }
        format!("{table}\n")
    }

    /// Whether a column is of numbers: as many cells begin with one as do not, or all others are a single word in the place of one, such as
    /// `never`. A dash stands for either.
    fn is_of_numbers(&self, place: usize) -> bool {
        let cells = self.rows.iter().filter_map(|row| row.get(place));
        let cells = cells.map(TableCell::text);
        let cells = cells.map(|cell| cell.trim_start_matches(['-', '+', '<', ' ']));
        let cells: Vec<&str> = cells.filter(|cell| !cell.is_empty()).collect();
        let begin = cells.iter().filter(|cell| begins_with_number(cell)).count();
        let is_filled = |cell: &&str| is_number(cell) || !cell.contains(' ');
        2 * begin >= cells.len()
            || cells.iter().any(|cell| is_number(cell)) && cells.iter().all(is_filled)
    }
}

fn begins_with_number(cell: &str) -> bool {
    cell.starts_with(|first: char| first.is_ascii_digit() || first == '∞')
}

/// Whether a cell holds digits, and no letters but those of powers of ten and of an interval.
fn is_number(cell: &str) -> bool {
    begins_with_number(cell) && !cell.contains(|c: char| c.is_alphabetic() && !"eto".contains(c))
}

/// A column of a table: its head, and what it shows of a row.
pub type TextColumn<'a, T> = (&'a str, &'a dyn Fn(&T) -> String);

/// A table of rows.
pub fn table_of<T>(rows: impl IntoIterator<Item = T>, columns: &[TextColumn<'_, T>]) -> Table {
    let heads: Vec<&str> = columns.iter().map(|(head, _)| *head).collect();
    let mut table = Table::new(&heads);
    for row in rows {
        table.row(columns.iter().map(|(_, cell)| cell(&row)));
    }
    table
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
        let mut table = Table::new(&["pose", "K"]);
        table.row(["P|1".to_owned(), "0.5".to_owned()]);
        insta::assert_snapshot!(table.text(), @r"
        | pose |   K |
        |------|-----|
        | P\|1 | 0.5 |
        ");
    }

    #[test]
    fn columns_of_numbers_are_on_the_right_and_words_on_the_left() {
        let mut table = Table::new(&["pose", "K", "state"]);
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
