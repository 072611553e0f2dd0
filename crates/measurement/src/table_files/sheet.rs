//! Spreadsheets: XLSX, XLS, XLSB and ODS.

use std::io::{Cursor, Read, Seek};

use calamine::{Data, Range, Reader, Sheets, XlsxError, open_workbook_auto_from_rs};
use csv::StringRecord;

use super::cell::{CellKind, kind};
use super::error::TableFileError;
use super::records::TextRecord;
use super::sheet_size;
use stiffbench_units_and_text::nearest::listed_names;

/// The records of one sheet, and its name.
///
/// # Arguments
/// - `wanted`: the sheet; `None` for the only one with rows of numbers.
pub(super) fn read_sheet(
    file: &str,
    bytes: &[u8],
    wanted: Option<&str>,
) -> Result<(Vec<TextRecord>, String), TableFileError> {
    let wrong = |problem: String| TableFileError::Spreadsheet {
        file: file.to_owned(),
        problem,
    };
    let bytes = sheet_size::of_bounded_size(bytes).map_err(wrong)?;
    let mut book: Sheets<_> =
        open_workbook_auto_from_rs(Cursor::new(bytes)).map_err(|error| wrong(error.to_string()))?;
    let names = book.sheet_names();
    let listed = |names: &[String]| listed_names(names.iter().map(String::as_str));
    if let Some(wanted) = wanted {
        let Some(name) = names.iter().find(|name| *name == wanted) else {
            return Err(TableFileError::NoSheet {
                file: file.to_owned(),
                sheet: wanted.to_owned(),
                found: listed(&names),
            });
        };
        let range = range(&mut book, name).map_err(wrong)?;
        return Ok((records(&range), name.clone()));
    }
    let mut with_numbers = Vec::new();
    for name in names {
        let range = range(&mut book, &name).map_err(wrong)?;
        let records = records(&range);
        if has_a_table(&records) {
            with_numbers.push((records, name));
        }
    }
    match with_numbers.len() {
        0 => Err(TableFileError::NoNumbers {
            file: file.to_owned(),
        }),
        1 => Ok(with_numbers.swap_remove(0)),
        _ => {
            let names: Vec<String> = with_numbers.into_iter().map(|(_, name)| name).collect();
            Err(TableFileError::SeveralSheets {
                file: file.to_owned(),
                found: listed(&names),
            })
        }
    }
}

/// The cells of a sheet; none of one that is no table, such as a chart.
fn range<R: Read + Seek>(book: &mut Sheets<R>, name: &str) -> Result<Range<Data>, String> {
    fn words(error: impl std::error::Error) -> String {
        error.to_string()
    }
    match book {
        Sheets::Xlsx(book) => match book.worksheet_cells_reader(name) {
            Ok(mut cells) => sheet_size::range(|| cells.next_cell().map_err(words)),
            Err(XlsxError::NotAWorksheet(_)) => Ok(Range::default()),
            Err(error) => Err(words(error)),
        },
        Sheets::Xlsb(book) => {
            let mut cells = book.worksheet_cells_reader(name).map_err(words)?;
            sheet_size::range(|| cells.next_cell().map_err(words))
        }
        book => book.worksheet_range(name).map_err(words),
    }
}

/// Whether two rows one below the other have two numbers each.
fn has_a_table(records: &[TextRecord]) -> bool {
    let rows = records.windows(2);
    let numbers = |record: &TextRecord| {
        record
            .fields
            .iter()
            .filter(|f| kind(f) == CellKind::Numeric)
            .count()
    };
    rows.into_iter()
        .any(|pair| pair.iter().all(|record| numbers(record) > 1))
}

fn records(range: &Range<Data>) -> Vec<TextRecord> {
    let first = range.start().map_or(0, |(row, _)| row);
    let rows = range.rows().enumerate();
    rows.map(|(index, row)| {
        let mut fields = StringRecord::new();
        for cell in row {
            fields.push_field(text(cell).trim());
        }
        TextRecord::new(first.saturating_add(index as u32).saturating_add(1), fields)
    })
    .collect()
}

/// A cell as text with a decimal point; dates as ISO 8601.
fn text(cell: &Data) -> String {
    match cell {
        Data::Empty | Data::Error(_) => String::new(),
        Data::String(text) | Data::DateTimeIso(text) | Data::DurationIso(text) => text.clone(),
        Data::Int(number) => number.to_string(),
        Data::Float(number) => number.to_string(),
        Data::Bool(value) => value.to_string(),
        Data::DateTime(time) if time.is_duration() || (0.0..1.0).contains(&time.as_f64()) => {
            clock(time.as_f64())
        }
        Data::DateTime(time) => {
            let (year, month, day, hour, minute, second, milli) = time.to_ymd_hms_milli();
            if time.as_f64().fract() == 0.0 {
                return format!("{year:04}-{month:02}-{day:02}");
            }
            format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{milli:03}")
        }
    }
}

/// Days as hours, minutes and seconds.
fn clock(days: f64) -> String {
    let seconds = days * 86_400.0;
    let minutes = (seconds / 60.0).floor();
    let hours = (minutes / 60.0).floor();
    format!(
        "{hours:.0}:{:02.0}:{:06.3}",
        minutes - hours * 60.0,
        seconds - minutes * 60.0
    )
}
