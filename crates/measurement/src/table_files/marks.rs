//! Which mark is the decimal sign.

use super::cell::{DecimalHint, NumberForm, NumberMarks};
use super::columns::FileColumn;
use super::error::TableFileError;
use super::find::TableParts;
use super::read::{TableFileOptions, ThreeDigits};
use super::records::TextRecord;
use crate::readings::DecimalSign;

/// The decimal sign and that between thousands, from all numbers of the table.
pub(super) fn number_marks(
    source: &str,
    columns: &[FileColumn],
    records: &[TextRecord],
    parts: &TableParts,
    told: Option<DecimalSign>,
    options: &TableFileOptions,
) -> Result<NumberMarks, TableFileError> {
    // Where each decimal sign, and a mark that may be either, was first seen: line, column, cell.
    let mut seen: [Option<(u32, usize, &str)>; 4] = [None; 4];
    let cells = || {
        parts.rows.iter().flat_map(|(index, _)| {
            let record = &records[*index];
            let numeric = record
                .fields
                .iter()
                .enumerate()
                .filter(|(c, _)| columns.get(*c).is_some_and(|c| c.is_numeric));
            numeric.map(|(column, cell)| (record.line, column, cell))
        })
    };
    for (line, column, cell) in cells() {
        let place = match NumberForm::of(cell).map(|form| form.hint) {
            Some(DecimalHint::Sign(DecimalSign::Point)) => 0,
            Some(DecimalHint::Sign(DecimalSign::Comma)) => 1,
            Some(DecimalHint::Either(DecimalSign::Comma)) => 2,
            Some(DecimalHint::Either(DecimalSign::Point)) => 3,
            _ => continue,
        };
        seen[place].get_or_insert((line, column, cell));
    }
    let decimal = match (told, seen) {
        (Some(told), _) => told,
        (None, [Some(point), Some(comma), ..]) => {
            let (later, first) = if point.0 > comma.0 {
                (point, comma)
            } else {
                (comma, point)
            };
            return Err(TableFileError::MixedDecimals {
                file: source.to_owned(),
                line: later.0,
                column: columns[later.1].name.clone(),
                value: later.2.to_owned(),
                first_line: first.0,
            });
        }
        (None, [_, Some(_), ..]) => DecimalSign::Comma,
        (None, [None, None, comma, point]) => {
            let refused = match options.three_digits {
                ThreeDigits::RefuseComma => comma,
                ThreeDigits::Refuse => comma.or(point),
                ThreeDigits::Decimal => None,
            };
            if let Some((line, column, value)) = refused {
                return Err(TableFileError::EitherDecimal {
                    file: source.to_owned(),
                    line,
                    column: columns[column].name.clone(),
                    value: value.to_owned(),
                });
            }
            match (comma, point) {
                (Some(_), None) => DecimalSign::Comma,
                _ => DecimalSign::Point,
            }
        }
        _ => DecimalSign::Point,
    };
    let mut marks = NumberMarks {
        decimal,
        thousands: None,
    };
    marks.thousands = cells()
        .filter(|(_, _, cell)| NumberForm::of(cell).is_some())
        .find_map(|(_, _, cell)| marks.thousands_of(cell));
    Ok(marks)
}
