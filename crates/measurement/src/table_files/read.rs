//! From the bytes of a file to a table with named columns.

use csv::StringRecord;

use super::cell::NumberMarks;
use super::columns::{FileColumn, StatedUnit};
use super::decode::decode;
use super::find::{self, TableParts};
use super::keywords;
use super::labview::{self, SegmentTags};
use super::layout::{FileLayout, TextEncoding};
use super::marks::{number_marks, refuse_decimal_commas};
use super::names::{in_brackets, is_unit, name_and_unit};
use super::options::TableFileOptions;
use super::records::{TextRecord, lines, split};
use super::sheet;
use super::table::{FileRow, MachineTable, TablePart, no_numbers};
use super::unit_cells::{name_units_of_cells, take_units_off};
use crate::readings::FieldDelimiter;
use crate::readings::{Conversion, DecimalSign, TableError, is_spreadsheet, line_of};
use stiffbench_units_and_text::nearest::listed_names;
use stiffbench_units_and_text::quantity::Kind;

/// Name of the column that numbers segments.
const SEGMENT: &str = "segment";

/// Reads a table from a text or a spreadsheet.
///
/// # Arguments
/// - `source`: the name of the input, for messages.
/// - `bytes`: what it holds.
///
/// # Errors
/// [`TableError`] with line, column, value and remedy, for the first thing that is wrong.
pub fn read_table_file(
    source: &str,
    bytes: &[u8],
    options: &TableFileOptions,
) -> Result<MachineTable, TableError> {
    if is_spreadsheet(bytes) {
        return read_workbook(source, bytes, options);
    }
    if let Some(sheet) = &options.sheet {
        return Err(TableError::new(
            "stiffbench::table::text_has_no_sheets",
            format!("{source}: the file is text and has no sheet `{sheet}`"),
            "leave out --sheet",
        ));
    }
    let (text, encoding) = decode(source, bytes, options.encoding)?;
    let lines = lines(&text);
    if u32::try_from(lines.len()).is_err() {
        return Err(TableError::new(
            "stiffbench::table::too_long",
            format!("{source}: more than four thousand million lines"),
            "divide the file",
        ));
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

/// The table of a sheet, or of all sheets with the same columns.
fn read_workbook(
    source: &str,
    bytes: &[u8],
    options: &TableFileOptions,
) -> Result<MachineTable, TableError> {
    let sheets = sheet::read_sheets(source, bytes, options)?;
    let names: Vec<String> = sheets.iter().map(|(_, name)| name.clone()).collect();
    let table = |(records, name): (Vec<TextRecord>, String)| {
        let of_sheet = if names.len() > 1 {
            format!("{source}, sheet `{name}`")
        } else {
            source.to_owned()
        };
        let told = TextFormat {
            encoding: TextEncoding::Spreadsheet,
            sheet: Some(name.clone()),
            delimiter: None,
            decimal: Some(DecimalSign::Point),
            program: None,
        };
        Ok((name, assemble(&of_sheet, records, told, options)?))
    };
    let tables = sheets.into_iter().map(table).collect::<Result<_, _>>()?;
    MachineTable::joined(tables, "sheet").map_err(|_| {
        let found = listed_names(names.iter().map(String::as_str));
        TableError::new(
            "stiffbench::table::several_sheets",
            format!("{source}: several sheets hold rows of numbers in other columns: {found}"),
            "name one of these with --sheet",
        )
    })
}

/// Reads the tables of files with the same columns as one; a column `file` names the file of each row.
///
/// # Arguments
/// - `files`: names of the inputs, for messages, and their bytes.
///
/// # Errors
/// Those of [`read_table_file`]; of files with other columns.
pub fn read_table_files(
    files: &[(&str, &[u8])],
    options: &TableFileOptions,
) -> Result<MachineTable, TableError> {
    let table = |(name, bytes): &(&str, &[u8])| {
        Ok(((*name).to_owned(), read_table_file(name, bytes, options)?))
    };
    MachineTable::joined(files.iter().map(table).collect::<Result<_, _>>()?, "file")
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
) -> Result<MachineTable, TableError> {
    let open_quote = |record: &TextRecord| {
        TableError::new(
            "stiffbench::table::unclosed_quote",
            format!(
                "{}: a quote opens and never ends",
                line_of(source, record.line)
            ),
            "close the quote, or remove it",
        )
    };
    if records
        .iter()
        .all(|record| record.is_comment || record.is_blank())
    {
        return Err(TableError::new(
            "stiffbench::table::empty",
            format!(
                "{source}: the file is empty, expected a line with column names and rows of numbers"
            ),
            "export the measured values as text, CSV or XLSX",
        ));
    }
    let Some(parts) = find::find(&records, &options.columns) else {
        return Err(match records.iter().find(|record| record.is_open) {
            Some(record) => open_quote(record),
            None => no_numbers(source),
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
        return Err(open_quote(open));
    }
    if told.delimiter == Some(FieldDelimiter::Comma) {
        refuse_decimal_commas(source, &records, &parts)?;
    }
    let mut columns = columns(&records, &parts);
    units_above(&mut columns, &records[..parts.header.unwrap_or(0)]);
    for (index, _) in &parts.rows {
        let (found, expected) = (records[*index].len(), columns.len());
        if found > expected {
            let at = line_of(source, records[*index].line);
            return Err(TableError::new(
                "stiffbench::table::field_count",
                format!("{at}: {found} fields, expected {expected}"),
                "are there decimal commas in a table delimited by commas? Then put the numbers in quotes or use another delimiter. Else give every column a name",
            ));
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
        parts: vec![TablePart {
            source: source.to_owned(),
            marks,
        }],
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
            part: 0,
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

/// Units that lines above the names state: `Units: N`, `Travel Unit: mm`, `Einheit Kraft;N`.
///
/// A line without the name of a column is of those whose names have a word of what the unit measures.
fn units_above(columns: &mut [FileColumn], above: &[TextRecord]) {
    const UNIT: &str = "unit units einheit einheiten unite unites unidad unidades unita jednostka jednotka birim единица единицы 单位 単位";
    const OF_KINDS: [(Kind, &str); 4] = [
        (Kind::Force, keywords::FORCE),
        (Kind::Torque, keywords::FORCE),
        (Kind::Displacement, keywords::DISPLACEMENT),
        (Kind::Time, keywords::TIME),
    ];
    for record in above.iter().filter(|record| !record.is_comment) {
        let cells: Vec<&str> = record
            .fields
            .iter()
            .filter(|cell| !cell.is_empty())
            .collect();
        let (key, unit) = match cells[..] {
            [line] => line.split_once(':').unwrap_or((line, "")),
            [key, unit] => (key.trim_end_matches(':'), unit),
            _ => continue,
        };
        let (key, unit) = (keywords::plain(key), unit.trim());
        let unit = in_brackets(unit).unwrap_or(unit);
        if !(keywords::words_of(&key).any(|word| keywords::has(UNIT, word)) && is_unit(unit)) {
            continue;
        }
        let named = |column: &FileColumn| {
            let name = keywords::plain(&column.stem);
            keywords::words_of(&name).any(|word| keywords::words_of(&key).any(|of| of == word))
        };
        let measures = |column: &FileColumn| {
            let name = keywords::plain(&column.stem);
            OF_KINDS.iter().any(|(kind, list)| {
                let is_known = keywords::words_of(&name).any(|word| keywords::has(list, word));
                is_known && Conversion::from_unit(*kind, unit).is_some()
            })
        };
        let by_name = columns.iter().any(named);
        for column in columns.iter_mut().filter(|column| column.unit.is_none()) {
            if named(column) || !by_name && measures(column) {
                column.unit = Some(unit.to_owned());
                column.unit_from = Some(StatedUnit::Header);
            }
        }
    }
}

/// A column is numeric if more of its cells are numbers or times than words.
fn mark_numeric(columns: &mut [FileColumn], records: &[TextRecord], parts: &TableParts) {
    let rows: Vec<usize> = parts.rows.iter().map(|(index, _)| *index).collect();
    let counts = find::kinds_of_columns(records, &rows);
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
