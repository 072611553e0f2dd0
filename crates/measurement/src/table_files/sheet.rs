//! Spreadsheets: XLSX, XLS, XLSB and ODS.

use std::io::{Cursor, Read, Seek};

use calamine::{Data, Range, Reader, Sheets, XlsxError, open_workbook_auto_from_rs};
use csv::StringRecord;

use super::cell::{CellKind, DecimalHint, NumberMarks, kind};
use super::options::{TableFileOptions, ThreeDigits};
use super::records::TextRecord;
use super::sheet_size;
use super::table::{either_decimal, no_numbers};
use super::unit_cells::take_units_off;
use crate::readings::{DecimalSign, FileCell, TableError};
use stiffbench_units_and_text::nearest::listed_names;

/// The records of sheets with their names: of the one that is asked for, else of all with rows of numbers.
pub(super) fn read_sheets(
    file: &str,
    bytes: &[u8],
    options: &TableFileOptions,
) -> Result<Vec<(Vec<TextRecord>, String)>, TableError> {
    let wrong = |problem: String| {
        TableError::new(
            "stiffbench::table::spreadsheet",
            format!("{file}: the spreadsheet cannot be read: {problem}"),
            "open it in the spreadsheet program and save it as XLSX without a password, or as CSV",
        )
    };
    let bytes = sheet_size::of_bounded_size(bytes).map_err(wrong)?;
    let mut book: Sheets<_> =
        open_workbook_auto_from_rs(Cursor::new(bytes)).map_err(|error| wrong(error.to_string()))?;
    let names = book.sheet_names();
    if let Some(wanted) = &options.sheet {
        let Some(name) = names.iter().find(|name| *name == wanted) else {
            let found = listed_names(names.iter().map(String::as_str));
            return Err(TableError::new(
                "stiffbench::table::no_sheet",
                format!("{file}: no sheet `{wanted}` among {found}"),
                "name one of these with --sheet",
            ));
        };
        let range = range(&mut book, name).map_err(wrong)?;
        return Ok(vec![(records(file, &range, options)?, name.clone())]);
    }
    let mut with_numbers = Vec::new();
    for name in names {
        let range = range(&mut book, &name).map_err(wrong)?;
        let records = records(file, &range, options)?;
        if has_a_table(&records) {
            with_numbers.push((records, name));
        }
    }
    if with_numbers.is_empty() {
        return Err(no_numbers(file));
    }
    Ok(with_numbers)
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

fn records(
    file: &str,
    range: &Range<Data>,
    options: &TableFileOptions,
) -> Result<Vec<TextRecord>, TableError> {
    let first = range.start().map_or(0, |(row, _)| row);
    let line = |index: usize| first.saturating_add(index as u32).saturating_add(1);
    let marks = marks_of_texts(file, range, line, options)?;
    let rows = range.rows().enumerate();
    let mut plain = String::new();
    let records = rows.map(|(index, row)| {
        let mut fields = StringRecord::new();
        for cell in row {
            let text = text(cell);
            let is_number =
                matches!(cell, Data::String(_)) && marks.plain(&text, &mut plain).is_ok();
            fields.push_field(if is_number { &plain } else { text.trim() });
        }
        TextRecord::new(line(index), fields)
    });
    let mut records: Vec<TextRecord> = records.collect();
    if options.units_in_cells {
        take_units_off(&mut records);
    }
    Ok(records)
}

/// The decimal sign of numbers that stand as text in cells: a program took them for words, as of another country.
fn marks_of_texts(
    file: &str,
    range: &Range<Data>,
    line: impl Fn(usize) -> u32,
    options: &TableFileOptions,
) -> Result<NumberMarks, TableError> {
    let cells = range.rows().enumerate().flat_map(|(row, cells)| {
        let texts = cells.iter().enumerate();
        texts.filter_map(move |(column, cell)| match cell {
            Data::String(text) => Some((row, column, text.trim())),
            _ => None,
        })
    });
    let mut either = None;
    let mut decimal = options.decimal;
    for (row, column, text) in cells {
        match DecimalHint::of(text) {
            Some(DecimalHint::Sign(sign)) => decimal = decimal.or(Some(sign)),
            Some(DecimalHint::Either(DecimalSign::Comma)) => {
                either.get_or_insert((row, column, text));
            }
            _ => {}
        }
    }
    if let (None, Some((row, column, text)), false) = (
        decimal,
        either,
        options.three_digits == ThreeDigits::Decimal,
    ) {
        let cell = FileCell {
            file: file.to_owned(),
            line: line(row),
            column: format!("column {}", column + 1),
            value: text.to_owned(),
        };
        return Err(either_decimal(&cell));
    }
    let of_either = either.map(|_| DecimalSign::Comma);
    Ok(NumberMarks {
        decimal: decimal.or(of_either).unwrap_or(DecimalSign::Point),
        thousands: None,
    })
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
