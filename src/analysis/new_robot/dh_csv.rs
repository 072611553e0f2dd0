//! A Denavit-Hartenberg table in CSV.

use std::fmt::Write as _;

use crate::source_text::SourceText;
use crate::toml_text::quoted;

use super::draft::key;
use super::{ImportError, ImportProblem};

/// What the columns begin with, before a unit: the keys of [`super::dh::DhRow`].
const COLUMNS: [&str; 9] = [
    "joint", "kind", "alpha", "a", "theta", "d", "angle", "min", "max",
];

/// Signs between two fields.
const DELIMITERS: [char; 3] = [',', ';', '\t'];

/// The table as TOML whose rows stand in the same lines.
pub(super) fn csv_as_toml(source: &SourceText) -> Result<SourceText, ImportError> {
    let text = source.text.trim_start_matches('\u{feff}');
    let delimiter = delimiter(text);
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter as u8)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let refused = |error: &csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        let before = source
            .text
            .split_inclusive('\n')
            .take(line.saturating_sub(1) as usize);
        let at = before.map(str::len).sum::<usize>().min(source.text.len());
        let problem = ImportProblem::new(
            format!("this row does not fit: {error}"),
            "each row has as many cells as the first line",
        );
        ImportError::new(source, at..at, problem)
    };
    let headers = reader.headers().map_err(|error| refused(&error))?.clone();
    let columns: Vec<DhColumn> = headers.iter().map(DhColumn::of).collect();
    let unknown = columns
        .iter()
        .position(|column| !column.name.is_empty() && !COLUMNS.contains(&column.name.as_str()));
    if let Some(unknown) = unknown.map(|place| &headers[place]) {
        let at = source.text.find(unknown).unwrap_or(0);
        let problem = ImportProblem::new(
            format!("a Denavit-Hartenberg table has no column `{unknown}`"),
            "the columns are joint, kind, alpha_deg, a_mm, theta_deg, d_mm, angle, min_deg, max_deg, or the same with other units",
        );
        return Err(ImportError::new(source, at..at + unknown.len(), problem));
    }
    let mut text = String::from("rows = [ ");
    let mut line = 1;
    for record in reader.records() {
        let record = record.map_err(|error| refused(&error))?;
        let own = record.position().map_or(line, csv::Position::line);
        while line < own {
            text.push('\n');
            line += 1;
        }
        let cells = columns
            .iter()
            .zip(&record)
            .filter(|(_, cell)| !cell.is_empty());
        let cells = cells.map(|(column, cell)| {
            let value = match column.name.as_str() {
                "angle" => terms(cell, delimiter),
                "joint" | "kind" => quoted(cell),
                _ => number(cell, delimiter),
            };
            format!("{} = {value}", key(&column.key))
        });
        let cells: Vec<String> = cells.collect();
        let _ = write!(text, "{{ {} }}, ", cells.join(", "));
    }
    text.push_str("]\n");
    Ok(SourceText::new(source.name.clone(), text))
}

/// The sign that stands most often in the first line.
fn delimiter(text: &str) -> char {
    let mut lines = text.lines();
    let header = lines.find(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let count = |sign: &char| header.unwrap_or_default().matches(*sign).count();
    // The last maximum wins in max_by_key, hence the reversal: of equals the comma is taken.
    DELIMITERS
        .into_iter()
        .rev()
        .max_by_key(count)
        .unwrap_or(',')
}

/// What a header says.
struct DhColumn {
    /// Without a unit.
    name: String,
    /// As the key of a TOML table: the name, an underscore and the unit.
    key: String,
}

impl DhColumn {
    /// `a_mm`, `a [mm]` and `A (mm)` are the same.
    fn of(header: &str) -> Self {
        let (name, unit) = header.split_once(['_', '[', '(']).unwrap_or((header, ""));
        let name = match name.trim().to_lowercase().as_str() {
            "α" => "alpha".to_owned(),
            "θ" => "theta".to_owned(),
            name => name.to_owned(),
        };
        let key = match unit.trim_end_matches([']', ')']).trim() {
            "" => name.clone(),
            "°" => format!("{name}_deg"),
            unit => format!("{name}_{unit}"),
        };
        Self { name, key }
    }
}

/// The cell of an angle as TOML value.
fn terms(cell: &str, delimiter: char) -> String {
    let terms = cell.split([' ', ';']).filter(|term| !term.is_empty());
    let terms = terms.map(|term| match term.split_once('=') {
        Some((name, coefficient)) => {
            format!("{} = {}", key(name.trim()), number(coefficient, delimiter))
        }
        None => format!("{} = {}", key(term), quoted(term)),
    });
    format!("{{ {} }}", terms.collect::<Vec<_>>().join(", "))
}

/// A cell as TOML number; what is none is passed on as text, which the reader of the table refuses in its place.
fn number(cell: &str, delimiter: char) -> String {
    let plain = cell.trim();
    let plain = if delimiter == ',' {
        plain.to_owned()
    } else {
        plain.replace(',', ".")
    };
    match plain.parse::<f64>() {
        Ok(number) if number.is_finite() => format!("{number:?}"),
        _ => quoted(cell),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::new_robot::dh::DhRow;

    #[test]
    fn the_columns_are_the_keys_of_a_row() {
        let error = serde_json::from_str::<DhRow>(r#"{ "none": 0 }"#).unwrap_err();
        let keys = COLUMNS.map(|column| format!("`{column}`")).join(", ");
        assert!(
            error
                .to_string()
                .contains(&format!("expected one of {keys} ")),
            "{error}"
        );
    }
}
