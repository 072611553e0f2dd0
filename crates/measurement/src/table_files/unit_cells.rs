//! Units behind each number, as gauges and people write them: `12.3 N`.

use super::cell::DecimalHint;
use super::columns::{FileColumn, StatedUnit};
use super::find::TableParts;
use super::names::is_unit;
use super::records::TextRecord;
use crate::readings::{TableError, line_of};

/// Leaves the numbers in the fields, and notes their units in the record.
pub(super) fn take_units_off(records: &mut [TextRecord]) {
    for record in records.iter_mut().filter(|record| !record.is_comment) {
        if !record.fields.iter().any(|field| parts_of(field).is_some()) {
            continue;
        }
        let mut units = Vec::new();
        let fields = record.fields.iter().enumerate().map(|(index, field)| {
            let Some((number, unit)) = parts_of(field) else {
                return field.to_owned();
            };
            units.push((index, unit.to_owned()));
            number
        });
        record.fields = fields.collect::<Vec<_>>().into();
        record.units = units;
    }
}

/// A number, without blanks behind its sign, and the unit behind it.
fn parts_of(field: &str) -> Option<(String, &str)> {
    let end = field.rfind(|c: char| c.is_ascii_digit())? + 1;
    let unit = field[end..].trim();
    if unit.is_empty() || !is_unit(unit) {
        return None;
    }
    let number = field[..end].trim();
    let digits = number.trim_start_matches(['+', '-', '−']);
    let sign = &number[..number.len() - digits.len()];
    let number = format!("{sign}{}", digits.trim_start());
    DecimalHint::of(&number).map(|_| (number, unit))
}

/// Gives columns the units of their cells, or those in a column of units behind them.
pub(super) fn name_units_of_cells(
    source: &str,
    columns: &mut [FileColumn],
    records: &[TextRecord],
    parts: &TableParts,
) -> Result<(), TableError> {
    for (row, _) in &parts.rows {
        let record = &records[*row];
        for (index, unit) in &record.units {
            let Some(column) = columns.get_mut(*index) else {
                continue;
            };
            match &column.unit {
                None => {
                    column.unit = Some(unit.clone());
                    column.unit_from = Some(StatedUnit::Cells);
                }
                Some(known) if known == unit => {}
                Some(known) => {
                    return Err(TableError::new(
                        "stiffbench::table::mixed_units",
                        format!(
                            "{}, column `{}`: the unit is {unit}, and {known} before",
                            line_of(source, record.line),
                            column.name
                        ),
                        "write all values of a column in one unit",
                    ));
                }
            }
        }
    }
    take_units_beside(columns, records, parts);
    Ok(())
}

/// A column whose cells all hold the same unit states the unit of the numbers before it.
fn take_units_beside(columns: &mut [FileColumn], records: &[TextRecord], parts: &TableParts) {
    for index in 1..columns.len() {
        if columns[index].is_numeric || !columns[index - 1].is_numeric {
            continue;
        }
        let mut cells = parts
            .rows
            .iter()
            .map(|(row, _)| records[*row].fields.get(index));
        let Some(Some(unit)) = cells.next().filter(|unit| unit.is_some_and(is_unit)) else {
            continue;
        };
        if columns[index - 1].unit.is_none() && cells.all(|cell| cell == Some(unit)) {
            columns[index - 1].unit = Some(unit.to_owned());
            columns[index - 1].unit_from = Some(StatedUnit::Cells);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_with_units() {
        for (cell, number, unit) in [
            ("12.3 N", "12.3", "N"),
            ("+ 12,34 kgf", "+12,34", "kgf"),
            ("-0.5mm", "-0.5", "mm"),
            ("21 °C", "21", "°C"),
        ] {
            assert_eq!(parts_of(cell), Some((number.to_owned(), unit)), "{cell}");
        }
        for cell in ["12.3", "N", "P1", "12 bananas", "", "1.2.3 N"] {
            assert_eq!(parts_of(cell), None, "{cell}");
        }
    }
}
