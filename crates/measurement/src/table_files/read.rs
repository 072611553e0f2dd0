//! From the bytes of a file to a table with named columns.

use std::io::Read;

use csv::StringRecord;

use super::cell::{CellKind, NumberMarks, kind};
use super::columns::{FileColumn, StatedUnit};
use super::decode::decode;
use super::error::{LinePlace, TableFileError};
use super::find::{self, TableParts};
use super::labview::{self, SegmentTags};
use super::layout::{FieldDelimiter, FileLayout, TextEncoding};
use super::marks::{number_marks, refuse_decimal_commas};
use super::names::{in_brackets, name_and_unit};
use super::records::{TextRecord, lines, split};
use super::sheet;
use super::table::{FileRow, MachineTable};
use super::unit_cells::{name_units_of_cells, take_units_off};
use crate::readings::{DecimalSign, is_spreadsheet};

/// What the caller knows of a file; the rest is found from the file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TableFileOptions {
    /// What delimits fields.
    pub delimiter: Option<FieldDelimiter>,
    /// The decimal sign.
    pub decimal: Option<DecimalSign>,
    /// The sheet, of a spreadsheet.
    pub sheet: Option<String>,
    /// Names of columns that the caller needs, as in the file or without their units.
    pub columns: Vec<String>,
    /// What is done about numbers such as `1.010`, where nothing in the file shows what the mark means.
    pub three_digits: ThreeDigits,
    /// Take cells such as `12.3 N`, and columns of units beside their numbers, as numbers with a unit: logs of gauges have them.
    pub units_in_cells: bool,
}

/// What is done about numbers with one mark and three digits behind it, where no other number shows the decimal sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ThreeDigits {
    /// A point is the decimal sign; a comma is refused.
    #[default]
    RefuseComma,
    /// Both are refused.
    Refuse,
    /// The mark is the decimal sign.
    Decimal,
}

/// Name of the column that numbers segments.
const SEGMENT: &str = "segment";

/// Reads a table from a text or a spreadsheet.
///
/// # Arguments
/// - `source`: the name of the input, for messages.
/// - `input`: its bytes.
///
/// # Errors
/// [`TableFileError`] with line, column, value and remedy, for the first thing that is wrong.
pub fn read_table_file(
    source: &str,
    mut input: impl Read,
    options: &TableFileOptions,
) -> Result<MachineTable, TableFileError> {
    let mut bytes = Vec::new();
    input
        .read_to_end(&mut bytes)
        .map_err(|error| TableFileError::Io {
            file: source.to_owned(),
            error,
        })?;
    if is_spreadsheet(&bytes) {
        let (records, name) = sheet::read_sheet(source, &bytes, options.sheet.as_deref())?;
        let told = TextFormat {
            encoding: TextEncoding::Spreadsheet,
            sheet: Some(name),
            delimiter: None,
            decimal: Some(DecimalSign::Point),
            program: None,
        };
        return assemble(source, records, told, options);
    }
    if let Some(sheet) = &options.sheet {
        return Err(TableFileError::NoSpreadsheet {
            file: source.to_owned(),
            sheet: sheet.clone(),
        });
    }
    let (text, encoding) = decode(source, &bytes)?;
    let lines = lines(&text);
    if u32::try_from(lines.len()).is_err() {
        return Err(TableFileError::TooLong {
            file: source.to_owned(),
        });
    }
    let (delimiter, told_line) = delimiter(&lines, options);
    let mut records = split(&lines, delimiter, usize::MAX);
    if options.units_in_cells {
        take_units_off(&mut records);
    }
    if told_line {
        records[0].is_comment = true;
    }
    let (_, of_labview) = labview::stated(&lines);
    let told = TextFormat {
        encoding,
        sheet: None,
        delimiter: Some(delimiter),
        decimal: options.decimal.or(of_labview),
        program: program(&lines),
    };
    assemble(source, records, told, options)
}

/// What is known of a file besides its records.
struct TextFormat {
    encoding: TextEncoding,
    sheet: Option<String>,
    delimiter: Option<FieldDelimiter>,
    decimal: Option<DecimalSign>,
    program: Option<&'static str>,
}

/// The delimiter, and whether the first line is one that states it, as spreadsheets understand it: `sep=;`.
fn delimiter(lines: &[&str], options: &TableFileOptions) -> (FieldDelimiter, bool) {
    let stated = lines.first().and_then(|line| line.strip_prefix("sep="));
    let stated = stated.and_then(|sign| {
        let named = |delimiter: &FieldDelimiter| {
            delimiter
                .sign()
                .is_some_and(|known| sign == known.to_string())
        };
        FieldDelimiter::ALL.into_iter().find(named)
    });
    if let Some(delimiter) = options.delimiter.or(stated) {
        return (delimiter, stated.is_some());
    }
    if let (Some(delimiter), _) = labview::stated(lines) {
        return (delimiter, false);
    }
    let mut best = (i64::MIN, FieldDelimiter::Comma);
    // Then blanks are part of the fields: a date and a time, a number and its unit.
    let mut has_even_sign = false;
    for delimiter in FieldDelimiter::ALL {
        if has_even_sign && delimiter == FieldDelimiter::Blanks {
            continue;
        }
        let mut records = split(lines, delimiter, find::SEARCHED);
        if options.units_in_cells {
            take_units_off(&mut records);
        }
        let score = find::score(&records, &options.columns);
        let is_there = delimiter
            .sign()
            .is_none_or(|sign| lines.iter().any(|line| line.contains(sign)));
        has_even_sign |=
            delimiter.sign().is_some_and(|sign| sign != ',') && find::is_even(&records);
        if is_there && score > best.0 {
            best = (score, delimiter);
        }
    }
    (best.1, false)
}

/// The program that wrote a file, by the marks that it leaves above the table.
fn program(lines: &[&str]) -> Option<&'static str> {
    if labview::is_labview(lines) {
        return Some("LabVIEW measurement file");
    }
    let above = || lines.iter().take(60);
    let has = |marks: &[&str]| above().any(|line| marks.iter().any(|mark| line.contains(mark)));
    if above()
        .next()
        .is_some_and(|line| line.starts_with("MTS793"))
        || has(&["MTS TestSuite", "TestWorks"])
    {
        Some("MTS export")
    } else if has(&["Bluehill", "Results Table", "Instron"]) {
        Some("Instron export")
    } else if has(&["testXpert", "Zwick"]) {
        Some("Zwick export")
    } else {
        None
    }
}

fn assemble(
    source: &str,
    mut records: Vec<TextRecord>,
    told: TextFormat,
    options: &TableFileOptions,
) -> Result<MachineTable, TableFileError> {
    let file = source.to_owned();
    let at = |line| LinePlace::new(source, line);
    if records
        .iter()
        .all(|record| record.is_comment || record.is_blank())
    {
        return Err(TableFileError::Empty { file });
    }
    let Some(parts) = find::find(&records, &options.columns) else {
        return Err(match records.iter().find(|record| record.is_open) {
            Some(record) => TableFileError::UnclosedQuote {
                at: at(record.line),
            },
            None => TableFileError::NoNumbers { file },
        });
    };
    let of_table = parts
        .header
        .into_iter()
        .chain(parts.rows.iter().map(|(index, _)| *index));
    if let Some(open) = of_table
        .map(|index| &records[index])
        .find(|record| record.is_open)
    {
        let at = at(open.line);
        return Err(TableFileError::UnclosedQuote { at });
    }
    if told.delimiter == Some(FieldDelimiter::Comma) {
        refuse_decimal_commas(source, &records, &parts)?;
    }
    let mut columns = columns(&records, &parts);
    for (index, _) in &parts.rows {
        let (found, expected) = (records[*index].len(), columns.len());
        if found > expected {
            return Err(TableFileError::FieldCount {
                at: at(records[*index].line),
                expected,
                found,
            });
        }
    }
    mark_numeric(&mut columns, &records, &parts);
    if options.units_in_cells {
        name_units_of_cells(source, &mut columns, &records, &parts)?;
    }
    let marks = number_marks(source, &columns, &records, &parts, told.decimal, options)?;
    if told.program == Some("LabVIEW measurement file") {
        complete_labview(&mut columns, &mut records, &parts, marks);
    }
    let numbered = parts.segments > 1 && columns.iter().all(|column| column.name != SEGMENT);
    if numbered {
        columns.push(FileColumn {
            is_numeric: true,
            ..FileColumn::named(SEGMENT)
        });
    }
    let table_start = parts.header.unwrap_or(0);
    let listed = |pick: fn(&TextRecord) -> bool| -> Vec<u32> {
        let all = records.iter().enumerate();
        all.filter(|(index, record)| (*index >= table_start || record.is_comment) && pick(record))
            .map(|(_, record)| record.line)
            .collect()
    };
    let blank = listed(|record| !record.is_comment && record.is_blank());
    let comments = listed(|record| record.is_comment);
    let layout = layout(&records, &parts, columns, told, marks);
    let rows = file_rows(&mut records, &parts, layout.columns.len(), numbered);
    Ok(MachineTable {
        source: source.to_owned(),
        rows,
        layout,
        blank,
        comments,
        marks,
    })
}

fn layout(
    records: &[TextRecord],
    parts: &TableParts,
    columns: Vec<FileColumn>,
    told: TextFormat,
    marks: NumberMarks,
) -> FileLayout {
    let first_row = parts.rows.first().map(|row| row.0);
    let first = parts.header.or(first_row).unwrap_or(0);
    let above = records[..first]
        .iter()
        .filter(|record| !record.is_comment && !record.is_blank());
    let line = |index: usize| records[index].line;
    FileLayout {
        program: told.program.map(Into::into),
        encoding: told.encoding,
        sheet: told.sheet,
        delimiter: told.delimiter,
        decimal: marks.sign(),
        thousands: marks.thousands,
        header_line: parts.header.map(line),
        units_line: parts.units.map(line),
        lines_above: above.count() as u32,
        first_line: first_row.map_or(0, line),
        last_line: parts.rows.last().map_or(0, |row| line(row.0)),
        rows: parts.rows.len(),
        segments: parts.segments,
        other_lines: parts.others.iter().map(|index| line(*index)).collect(),
        columns,
    }
}

/// The rows, with the number of their segment as the last cell if it is asked for.
fn file_rows(
    records: &mut [TextRecord],
    parts: &TableParts,
    columns: usize,
    numbered: bool,
) -> Vec<FileRow> {
    let rows = parts.rows.iter().map(|(index, segment)| {
        let record = &mut records[*index];
        let mut cells = std::mem::take(&mut record.fields);
        if numbered {
            while cells.len() + 1 < columns {
                cells.push_field("");
            }
            cells.truncate(columns - 1);
            cells.push_field(&segment.to_string());
        }
        FileRow {
            line: record.line,
            segment: *segment,
            cells,
        }
    });
    rows.collect()
}

/// Names and units.
fn columns(records: &[TextRecord], parts: &TableParts) -> Vec<FileColumn> {
    let Some(header) = parts.header else {
        let widths = parts.rows.iter().map(|(index, _)| records[*index].len());
        let count = widths.max().unwrap_or(0);
        let numbers = 1..=count;
        return numbers
            .map(|number| FileColumn::named(&format!("column {number}")))
            .collect();
    };
    let record = &records[header];
    let names = match &record.wide {
        Some(wide) if parts.wide => wide,
        _ => &record.fields,
    };
    let units = parts.units.map(|units| &records[units].fields);
    let named = names.iter().enumerate().map(|(index, name)| {
        let (stem, in_name) = name_and_unit(name);
        let in_row = units
            .and_then(|units| units.get(index))
            .filter(|unit| !unit.is_empty());
        let in_row = in_row.map(|unit| in_brackets(unit).unwrap_or(unit));
        FileColumn {
            stem: if in_row.is_some() { name } else { stem }.to_owned(),
            unit: in_row.or(in_name).map(str::to_owned),
            unit_from: in_row
                .map(|_| StatedUnit::Row)
                .or(in_name.map(|_| StatedUnit::Name)),
            ..FileColumn::named(name)
        }
    });
    named.collect()
}

/// A column is numeric if more of its cells are numbers or times than words.
fn mark_numeric(columns: &mut [FileColumn], records: &[TextRecord], parts: &TableParts) {
    let mut counts = vec![[0_usize; 2]; columns.len()];
    for (index, _) in &parts.rows {
        for (count, cell) in counts.iter_mut().zip(&records[*index].fields) {
            match kind(cell) {
                CellKind::Numeric => count[0] += 1,
                CellKind::Words => count[1] += 1,
                CellKind::Absent => {}
            }
        }
    }
    for (column, [numbers, words]) in columns.iter_mut().zip(counts) {
        column.is_numeric = numbers > words;
    }
}

/// Units and X columns that a LabVIEW file states above its segments.
fn complete_labview(
    columns: &mut [FileColumn],
    records: &mut [TextRecord],
    parts: &TableParts,
    marks: NumberMarks,
) {
    let Some(header) = parts.header else { return };
    let mut plain = String::new();
    let mut number = |text: &str| {
        marks.plain(text, &mut plain).ok()?;
        plain.parse::<f64>().ok()
    };
    let mut tags = SegmentTags::above(records, header, &mut number);
    tags.name(columns);
    let mut segment = 1;
    let mut sample = 0;
    for (index, of) in &parts.rows {
        if *of != segment {
            (segment, sample) = (*of, 0);
            let names = records[header].fields.clone();
            let start = records[..*index]
                .iter()
                .rposition(|record| record.fields == names);
            tags = SegmentTags::above(records, start.unwrap_or(header), &mut number);
        }
        let fields = &mut records[*index].fields;
        if columns.first().is_some_and(|first| first.name == "X_Value")
            && fields.get(0).is_some_and(str::is_empty)
            && let Some(x) = tags.x(sample)
        {
            let mut cells = StringRecord::new();
            let text = format!("{x:e}");
            cells.push_field(&text.replace('.', marks.sign().encode_utf8(&mut [0; 4])));
            cells.extend(fields.iter().skip(1));
            *fields = cells;
            columns[0].is_numeric = true;
        }
        sample += 1;
    }
}
