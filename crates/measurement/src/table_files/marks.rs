//! Which mark is the decimal sign.

use super::cell::{DecimalHint, NumberMarks};
use super::columns::FileColumn;
use super::find::TableParts;
use super::options::{TableFileOptions, ThreeDigits};
use super::records::TextRecord;
use super::table::{either_decimal, mixed_decimals};
use crate::readings::{DecimalSign, FileCell, TableError, line_of};

/// The decimal sign and that between thousands, from all numbers of the table.
pub(super) fn number_marks(
    source: &str,
    columns: &[FileColumn],
    records: &[TextRecord],
    parts: &TableParts,
    told: Option<DecimalSign>,
    options: &TableFileOptions,
) -> Result<NumberMarks, TableError> {
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
    let named = |(line, column, value): (u32, usize, &str)| FileCell {
        file: source.to_owned(),
        line,
        column: columns[column].name.clone(),
        value: value.to_owned(),
    };
    for (line, column, cell) in cells() {
        let place = match DecimalHint::of(cell) {
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
            return Err(mixed_decimals(&named(later), first.0));
        }
        (None, [_, Some(_), ..]) => DecimalSign::Comma,
        (None, [None, None, comma, point]) => {
            let refused = match options.three_digits {
                ThreeDigits::RefuseComma => comma,
                ThreeDigits::Refuse => comma.or(point),
                ThreeDigits::Decimal => None,
            };
            if let Some(refused) = refused {
                return Err(either_decimal(&named(refused)));
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
        .filter(|(_, _, cell)| DecimalHint::of(cell).is_some())
        .find_map(|(_, _, cell)| marks.thousands_of(cell));
    Ok(marks)
}

/// Refuses a table without names, delimited by commas, whose commas may be decimal signs: whole numbers alone, four fields or another even
/// number, or rows of different length, or a line of fewer names right above.
pub(super) fn refuse_decimal_commas(
    source: &str,
    records: &[TextRecord],
    parts: &TableParts,
) -> Result<(), TableError> {
    let rows = || parts.rows.iter().map(|(index, _)| &records[*index]);
    let is_whole = |cell: &str| {
        let digits = cell.strip_prefix(['+', '-', '−']).unwrap_or(cell);
        !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())
    };
    let are_whole = |record: &TextRecord| record.fields.iter().all(is_whole);
    let Some(first) = rows().next().filter(|_| parts.header.is_none()) else {
        return Ok(());
    };
    let width = first.len();
    let in_pairs = width > 2 && width % 2 == 0;
    let uneven = rows().any(|row| row.len() != width);
    let above = records
        .iter()
        .rfind(|record| record.line < first.line && !record.is_blank());
    let fewer_names = above.is_some_and(|above| (2..width).contains(&above.len()));
    if !(in_pairs || uneven || fewer_names) || !rows().all(are_whole) {
        return Ok(());
    }
    let row = first.fields.iter().collect::<Vec<_>>().join(",");
    Err(TableError::new(
        "stiffbench::table::comma_or_decimal",
        format!(
            "{}: the commas in `{row}` may delimit fields or be decimal signs, and nothing shows which",
            line_of(source, first.line)
        ),
        "export with semicolons or tabs between the fields, or with decimal points, or put each number in quotes. If the numbers are whole, give every column a name",
    ))
}
