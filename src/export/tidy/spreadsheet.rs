//! Tidy tables as one XLSX file: a sheet a table, and a sheet that states where they come from.

use jiff::Timestamp;
use jiff::tz::TimeZone;
use rust_xlsxwriter::{DocProperties, ExcelDateTime, Format, Workbook, Worksheet, XlsxError};

use super::package::TableProvenance;
use super::table::{FieldKind, TidyTable};

/// Tables that do not fit into a spreadsheet.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("the tables do not fit into a spreadsheet")]
#[diagnostic(
    code(stiffbench::output::spreadsheet),
    help("a sheet holds 1 048 576 rows and 32 767 characters a cell; write --format csv instead")
)]
pub struct SpreadsheetError {
    /// What the writer reports.
    #[from]
    pub source: XlsxError,
}

/// Width of a column, in characters.
const WIDTHS: std::ops::RangeInclusive<usize> = 8..=40;

/// The tables as XLSX. The same tables give the same bytes: the date of creation is that of the last reading.
///
/// # Errors
/// [`SpreadsheetError`] for a table with too many rows or a text that is too long.
pub fn xlsx(about: &TableProvenance, tables: &[TidyTable]) -> Result<Vec<u8>, SpreadsheetError> {
    let mut workbook = Workbook::new();
    let created = created(about.measured_until.as_deref())?;
    let properties = DocProperties::new()
        .set_title(&about.title)
        .set_creation_datetime(&created);
    workbook.set_properties(&properties);
    for table in tables {
        write_table(workbook.add_worksheet(), table)?;
    }
    write_about(workbook.add_worksheet(), about, tables)?;
    Ok(workbook.save_to_buffer()?)
}

/// The date of creation; without times of readings the first day of 2000.
fn created(time: Option<&str>) -> Result<ExcelDateTime, XlsxError> {
    let time = time.and_then(|time| time.parse::<Timestamp>().ok());
    let Some(time) = time.map(|time| time.to_zoned(TimeZone::UTC).datetime()) else {
        return ExcelDateTime::from_ymd(2000, 1, 1);
    };
    let part = |number: i8| number.unsigned_abs();
    let year = time.year().clamp(1900, 9999).unsigned_abs();
    ExcelDateTime::from_ymd(year, part(time.month()), part(time.day()))?.and_hms(
        u16::from(part(time.hour())),
        part(time.minute()),
        f64::from(part(time.second())),
    )
}

fn write_table(sheet: &mut Worksheet, table: &TidyTable) -> Result<(), XlsxError> {
    let bold = Format::new().set_bold();
    sheet.set_name(table.name)?;
    for (place, column) in table.columns.iter().enumerate() {
        let place = place as u16;
        sheet.write_string_with_format(0, place, &column.name, &bold)?;
        let width = column.name.len().clamp(*WIDTHS.start(), *WIDTHS.end());
        sheet.set_column_width(place, width as f64 + 2.0)?;
    }
    for (row, fields) in (1..).zip(&table.rows) {
        for (place, (field, column)) in (0..).zip(fields.iter().zip(&table.columns)) {
            if field.is_empty() {
                continue;
            }
            match (column.kind, field.parse::<f64>()) {
                (FieldKind::Integer | FieldKind::Number, Ok(number)) => {
                    sheet.write_number(row, place, number)?;
                }
                _ => {
                    sheet.write_string(row, place, field)?;
                }
            }
        }
    }
    let last = (
        table.rows.len() as u32,
        (table.columns.len() as u16).saturating_sub(1),
    );
    sheet.autofilter(0, 0, last.0, last.1)?;
    sheet.set_freeze_panes(1, 0)?;
    Ok(())
}

/// Facts, notes, and what each column means.
fn write_about(
    sheet: &mut Worksheet,
    about: &TableProvenance,
    tables: &[TidyTable],
) -> Result<(), XlsxError> {
    sheet.set_name("about")?;
    for (place, width) in [(0, 24.0), (1, 32.0), (2, 10.0), (3, 80.0)] {
        sheet.set_column_width(place, width)?;
    }
    let bold = Format::new().set_bold();
    let mut row = 0;
    let facts = about.facts.iter().map(|(name, fact)| (name.as_str(), fact));
    let notes = about.notes.iter().map(|note| ("note", note));
    for (name, fact) in facts.chain(notes) {
        sheet.write_string(row, 0, name)?;
        sheet.write_string(row, 1, fact)?;
        row += 1;
    }
    row += 1;
    for (place, head) in (0..).zip(["sheet", "column", "unit", "meaning"]) {
        sheet.write_string_with_format(row, place, head, &bold)?;
    }
    for table in tables {
        for column in &table.columns {
            row += 1;
            let words = [table.name, &column.name, &column.unit, &column.meaning];
            for (place, word) in (0..).zip(words) {
                sheet.write_string(row, place, word)?;
            }
        }
    }
    Ok(())
}
