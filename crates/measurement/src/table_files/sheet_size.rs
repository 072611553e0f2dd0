//! How large a spreadsheet becomes when it is read, found before it is read.
//!
//! Some five kilobytes can stand for gigabytes: parts that are packed well, cells that are repeated, a cell in the far corner of a sheet, and
//! sectors that follow each other in a circle.

use std::borrow::Cow;
use std::io::{Cursor, Read, Result as IoResult, Write};

use calamine::{Cell, Data, DataRef, DataType, Range};
use cfb::{CompoundFile, Version};
use zip::ZipArchive;

/// Most bytes that a part of a file, and the cells of its sheets, may take.
const MOST: u64 = 256 << 20;

/// Bytes of a cell, the empty ones between others included.
const OF_A_CELL: u64 = 64;

/// Refuses what would take too many bytes.
fn within(bytes: u64) -> Result<(), String> {
    let most = MOST >> 20;
    let problem = || {
        format!(
            "its content takes more than the {most} MiB that are read: keep the table alone, without cells far from it"
        )
    };
    (bytes <= MOST).then_some(()).ok_or_else(problem)
}

/// The bytes of a spreadsheet, if it does not become too large.
pub(super) fn of_bounded_size(bytes: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    let words = |error: std::io::Error| error.to_string();
    if !bytes.starts_with(b"PK") {
        let (alone, records) = old_workbook(bytes).map_err(words)?;
        within(cells_of_records(&records).saturating_mul(OF_A_CELL))?;
        return Ok(alone.into());
    }
    let mut parts = ZipArchive::new(Cursor::new(bytes)).map_err(|error| words(error.into()))?;
    let mut unpacked = 0;
    for index in 0..parts.len() {
        // What cannot be unpacked is stated by who reads it.
        let Ok(part) = parts.by_index(index) else {
            continue;
        };
        let is_open_document = part.name().is_ok_and(|name| name == "content.xml");
        let mut part = part.take(MOST + 1 - unpacked);
        let mut content = Vec::new();
        if is_open_document {
            let _ = part.read_to_end(&mut content);
            within(bytes_of_open_document(&String::from_utf8_lossy(&content)))?;
        }
        let rest = std::io::copy(&mut part, &mut std::io::sink()).unwrap_or_default();
        unpacked += content.len() as u64 + rest;
        within(unpacked)?;
    }
    Ok(bytes.into())
}

/// The workbook of a file of Excel 97, alone in a new file, and its records.
fn old_workbook(bytes: &[u8]) -> IoResult<(Vec<u8>, Vec<u8>)> {
    let mut file = CompoundFile::open(Cursor::new(bytes))?;
    let name = if file.is_stream("Book") {
        "Book"
    } else {
        "Workbook"
    };
    let mut records = Vec::new();
    file.open_stream(name)?.read_to_end(&mut records)?;
    let mut alone = CompoundFile::create_with_version(Version::V3, Cursor::new(Vec::new()))?;
    alone.create_stream(name)?.write_all(&records)?;
    Ok((alone.into_inner().into_inner(), records))
}

/// Cells that the sheets of a workbook of Excel 97 span together, at most.
fn cells_of_records(all: &[u8]) -> u64 {
    let word = |content: &[u8], at: usize| {
        let two = content.get(at..).and_then(<[u8]>::first_chunk);
        two.map_or(0, |two| u64::from(u16::from_le_bytes(*two)))
    };
    // Kind and content of the records from a place on.
    let records = |start: u64| {
        let mut rest = all.get(start as usize..).unwrap_or_default();
        std::iter::from_fn(move || {
            let (head, behind) = rest.split_at_checked(4)?;
            let (content, next) = behind.split_at_checked(word(head, 2) as usize)?;
            rest = next;
            Some((word(head, 0), content))
        })
    };
    // A sheet begins where its record in the workbook says, and what follows it counts as its own.
    let sheets = records(0).filter(|(kind, _)| *kind == 0x85);
    let starts = sheets.map(|(_, content)| word(content, 0) + (word(content, 2) << 16));
    let cells = starts.map(|start| {
        if start as usize > all.len() {
            return u64::MAX;
        }
        let (mut rows, mut columns) = (1, 1);
        for (kind, content) in records(start) {
            let [row, column] = match kind {
                // What a sheet says that it spans; in newer files rows have four bytes.
                0x200 if content.len() > 12 => [
                    word(content, 4) + (word(content, 6) << 16),
                    word(content, 10),
                ],
                0x200 => [word(content, 2), word(content, 6)],
                // Cells begin with row and column; those of a record with several have six bytes each.
                0x06 | 0xBD | 0xD6 | 0xFD | 0x203..=0x205 | 0x27E => [
                    word(content, 0) + 1,
                    word(content, 2) + 1 + content.len() as u64 / 6,
                ],
                _ => continue,
            };
            (rows, columns) = (rows.max(row), columns.max(column));
        }
        rows * columns
    });
    cells.fold(0, u64::saturating_add)
}

/// Bytes that the sheets of an `OpenDocument` file take at most, once what is repeated stands there as often.
fn bytes_of_open_document(content: &str) -> u64 {
    let (mut bytes, mut rows, mut filled_rows, mut width) = (0_u64, 0, 0_u64, 0);
    let (mut repeats, mut columns, mut filled, mut of_row) = (0, 0, 0, 0_u64);
    for element in content.split('<').chain(["table:table-row"]) {
        let times = |name: &str| {
            let number = |rest: &str| rest.strip_prefix("=\"")?.split('"').next()?.parse().ok();
            let stated = element.split_once(name);
            // A number that is written in another way may be any.
            stated.map_or(1, |(_, rest)| {
                number(rest).unwrap_or(1 << 20).min(1_u64 << 20)
            })
        };
        if element.starts_with("table:table-row") {
            rows += repeats;
            if filled > 0 {
                (filled_rows, width) = (rows, filled.max(width));
                bytes = bytes.saturating_add(of_row.saturating_mul(repeats));
            }
            (repeats, columns, filled, of_row) = (times("number-rows-repeated"), 0, 0, 0);
        } else if element.contains("table-cell") && !element.starts_with('/') {
            let cells = times("number-columns-repeated");
            columns += cells;
            let is_empty = element.trim_end().ends_with("/>") && !element.contains("value");
            if !is_empty || element.contains("formula") {
                filled = columns;
                of_row = of_row.saturating_add(cells * (OF_A_CELL + element.len() as u64));
            }
        }
    }
    bytes.max(OF_A_CELL.saturating_mul(filled_rows).saturating_mul(width))
}

/// The sheet that a stream of cells gives.
pub(super) fn range<'a>(
    mut next: impl FnMut() -> Result<Option<Cell<DataRef<'a>>>, String>,
) -> Result<Range<Data>, String> {
    let (mut cells, mut texts) = (Vec::new(), 0);
    let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
    while let Some(cell) = next()? {
        let (row, column) = cell.get_position();
        let value = Data::from(cell.get_value().clone());
        if value == Data::Empty {
            continue;
        }
        texts += value.get_string().map_or(0, |text| text.len() as u64);
        low = [low[0].min(row), low[1].min(column)];
        high = [high[0].max(row), high[1].max(column)];
        let [rows, columns] = [0, 1].map(|way| u64::from(high[way] - low[way]) + 1);
        within(rows.saturating_mul(columns).saturating_mul(OF_A_CELL))?;
        within(texts)?;
        cells.push(Cell::new((row, column), value));
    }
    Ok(Range::from_sparse(cells))
}
