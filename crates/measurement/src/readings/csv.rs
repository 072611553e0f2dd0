//! Reads `readings.csv`, and tables with fewer or other columns.

use std::io::Read;

use super::column::Column;
use super::defaults::fill_defaults;
use super::error::TableError;
use super::header::ColumnHeader;
use super::row::RowReader;
use super::table::ReadingTable;
use super::text_table::RecordTable;
use super::vector_table::{are_of_vectors, read_vectors};

/// Readings from a table.
///
/// Accepted are the columns of `readings.csv` in any order, of which pose, direction, repeat, force and displacement must be there; the
/// delimiters `,` `;` and tab; decimal point or comma; UTF-8 and, behind a byte order mark, UTF-16; comment lines that start with `#`;
/// any unit of the column's kind in the column's name. A table of a session with gauges along the base axes has a reading for each gauge
/// under each load. What was decided on the way stands in [`ReadingTable::assumptions`].
///
/// # Arguments
/// - `source`: the name of the input, for messages.
/// - `input`: its bytes; read once, in pieces.
///
/// # Errors
/// [`TableError`] with line, column, value and what was expected, for the first thing that is wrong.
pub fn read_readings(source: &str, input: impl Read) -> Result<ReadingTable, TableError> {
    let mut text = RecordTable::open(source, input)?;
    if are_of_vectors(&text.names) {
        return read_vectors(text);
    }
    let header = ColumnHeader::read(&text)?;
    let mut reader = RowReader::new(&header);
    while text.next_record()? {
        reader.take(&mut text)?;
    }
    if reader.readings.is_empty() {
        return Err(text.no_readings());
    }
    let mut assumptions = text.assumptions();
    assumptions.extend(header.conversions());
    let present = reader.present;
    let mut table = ReadingTable {
        source: source.to_owned(),
        session: reader
            .session
            .map(|(session, _)| session)
            .filter(|s| !s.is_empty()),
        origin: reader.origin,
        readings: reader.readings,
        runs: reader.runs.into_keys(),
        zeros: reader.zeros.into_keys(),
        columns: Column::ALL
            .into_iter()
            .filter(|column| present[*column as usize])
            .collect(),
        assumptions,
        ..ReadingTable::default()
    };
    (table.excluded.blank, table.excluded.comments) = text.passed_over();
    let unused = header
        .unused
        .iter()
        .map(|index| format!("column `{}` is not used", header.name_at(*index)));
    table.notes.extend(unused);
    fill_defaults(&mut table, &header, &reader.first_missing)?;
    table.take_stock();
    Ok(table)
}
