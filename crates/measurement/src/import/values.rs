//! Cells to what they mean, each with its place where it means nothing.

use super::columns::ColumnRole;
use super::draft::ImportDraft;
use crate::readings::{FileCell, TableError};
use crate::table_files::keywords::plain;
use stiffbench_units_and_text::test_point::{Branch, Direction};

/// An error about a cell without a value.
pub(super) fn no_value(draft: &ImportDraft, row: usize, column: usize) -> TableError {
    let cell = draft.table.cell(row, column);
    let found = match cell.value.as_str() {
        "" => String::new(),
        text => format!(": `{text}`"),
    };
    TableError::new(
        "stiffbench::import::no_value",
        format!("{cell}: no value{found}"),
        "complete the row, or delete it: rows without any value are left out, incomplete rows are refused",
    )
}

/// An error about a cell that holds something else.
pub(super) fn bad_value(cell: &FileCell, expected: &str) -> TableError {
    cell.refused(
        "stiffbench::import::bad_value",
        expected,
        "correct the cell, or name another column with --map",
    )
}

/// The texts of a column that every row must have; `None` without such a column.
pub(super) fn texts(
    draft: &ImportDraft,
    role: &ColumnRole,
    rows: &[usize],
) -> Result<Option<Vec<String>>, TableError> {
    let Some(column) = draft.found.place(role) else {
        return Ok(None);
    };
    let text = |row: &usize| {
        let found = draft.table.present(*row, column).map(str::to_owned);
        found.ok_or_else(|| no_value(draft, *row, column))
    };
    rows.iter().map(text).collect::<Result<_, _>>().map(Some)
}

/// What the texts of a column mean that every row must have; `None` without such a column.
pub(super) fn meanings<T>(
    draft: &ImportDraft,
    role: &ColumnRole,
    rows: &[usize],
    meaning: fn(&str) -> Option<T>,
    expected: &'static str,
) -> Result<Option<Vec<T>>, TableError> {
    let (Some(texts), Some(column)) = (texts(draft, role, rows)?, draft.found.place(role)) else {
        return Ok(None);
    };
    let of = |(row, text): (&usize, &String)| {
        meaning(text).ok_or_else(|| bad_value(&draft.table.cell(*row, column), expected))
    };
    let found = rows.iter().zip(&texts).map(of);
    found.collect::<Result<_, _>>().map(Some)
}

/// A direction and whether it has a minus sign: `y`, `-Y`, `z-Richtung`, `vertical`.
pub(super) fn direction(text: &str) -> Option<(Direction, bool)> {
    let text = plain(text);
    let is_negative = text.starts_with(['-', '−']);
    let word = text.trim_start_matches(['-', '−', '+']);
    let first = word.split(|c: char| !c.is_alphanumeric()).next()?;
    let axis = match first {
        "x" | "lateral" | "seitlich" => Direction::X,
        "y" | "vertical" | "vertikal" | "verticale" => Direction::Y,
        "z" | "radial" | "radiale" => Direction::Z,
        _ => return None,
    };
    Some((axis, is_negative))
}

/// Loading or unloading, in the words of five languages.
pub(super) fn branch(text: &str) -> Option<Branch> {
    const LOADING: [&str; 11] = [
        "loading",
        "load",
        "up",
        "belastung",
        "belasten",
        "auf",
        "hin",
        "charge",
        "carico",
        "carga",
        "l",
    ];
    const UNLOADING: [&str; 12] = [
        "unloading",
        "unload",
        "down",
        "entlastung",
        "entlasten",
        "ab",
        "ruck",
        "decharge",
        "scarico",
        "descarga",
        "zuruck",
        "u",
    ];
    let word = plain(text);
    if LOADING.contains(&word.as_str()) {
        Some(Branch::Loading)
    } else if UNLOADING.contains(&word.as_str()) {
        Some(Branch::Unloading)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_and_branches() {
        assert_eq!(direction("-Y"), Some((Direction::Y, true)));
        assert_eq!(direction("z-Richtung"), Some((Direction::Z, false)));
        assert_eq!(direction("up"), None);
        assert_eq!(branch("Entlastung"), Some(Branch::Unloading));
        assert_eq!(branch("Rück"), Some(Branch::Unloading));
        assert_eq!(branch("carga"), Some(Branch::Loading));
        assert_eq!(branch("?"), None);
    }
}
