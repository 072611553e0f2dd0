//! Whether `readings.csv` still holds what the journal holds.
//!
//! The journal is the record; the table is a copy that a spreadsheet or a script can change. A changed number, unit or pose makes another
//! result; a changed status, flag or note is the analyst's own mark and is only listed.

use std::collections::BTreeMap;

use stiffbench_measurement::readings::{
    ReadingTable, ReadingText, RunKey, TableError, read_readings,
};

use super::folder::table as write_table;
use super::journal::{JournalEnd, ReadJournal};
use super::state::SessionState;

/// Columns that hold the analyst's own marks; all others make the result.
const MARK_COLUMNS: [&str; 3] = ["status", "flag", "note"];

/// A value of the table that is not that of the journal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// Line of the table, from 1; `None` for a reading that is not in it.
    pub line: Option<u32>,
    /// Number of the reading in the session.
    pub seq: u32,
    /// Column.
    pub column: String,
    /// The journal's value.
    pub journal: String,
    /// The table's value.
    pub table: String,
}

/// A table beside its journal.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Integrity {
    /// Values that were changed, readings that are missing or that the journal does not know.
    pub changed: Vec<Difference>,
    /// Changed status, flags and notes.
    pub marks: Vec<Difference>,
    /// Numbers of readings that stand in no line of a damaged journal.
    pub unknown: Vec<u32>,
    /// Numbers of the last readings, which a session that was broken off has not written into the table yet.
    pub behind: Vec<u32>,
}

/// A column with what the journal and what the table has there.
type ChangedField = (String, String, String);

/// Changed values and changed marks of the reading at a place in the journal's table, and at its place in the other.
fn differences(
    kept: (&ReadingTable, usize),
    table: (&ReadingTable, usize),
) -> [Vec<ChangedField>; 2] {
    let read = columns(table);
    // Fields along the base axes are texts, whose numbers may be written otherwise.
    let is_number_alike = |was: &str, is: &str| {
        let numbers = (is.parse::<f64>(), was.parse::<f64>());
        kept.0.is_of_vectors() && matches!(numbers, (Ok(is), Ok(was)) if is == was)
    };
    let both = columns(kept).into_iter().map(|(column, was)| {
        let mut alike = read.iter();
        let is = alike.find(|(name, _)| *name == column);
        let is = is.map(|(_, is)| is.clone()).unwrap_or_default();
        (column, was, is)
    });
    let changed = both.filter(|(_, was, is)| was != is && !is_number_alike(was, is));
    let (marks, values) = changed.partition(|(column, ..)| MARK_COLUMNS.contains(&column.as_str()));
    [values, marks]
}

/// Number in the session and line of each reading, in the order of the table.
fn numbers_and_lines(table: &ReadingTable) -> Vec<(u32, u32)> {
    if table.is_of_vectors() {
        let rows = table.fields.rows.iter();
        return rows.map(|row| (row.seq, row.line)).collect();
    }
    let readings = table.readings.iter();
    readings.map(|of| (of.seq, of.line)).collect()
}

/// Compares a table with the journal of its session, value by value.
///
/// # Errors
/// [`TableError`] if the journal's own readings make no table.
pub fn integrity(journal: &ReadJournal, table: &ReadingTable) -> Result<Integrity, TableError> {
    let state = SessionState::fold(&journal.records);
    // Through the same file form, so that both have been rounded alike.
    let mut bytes = Vec::new();
    write_table(&state, &mut bytes)?;
    let kept = match read_readings("journal.jsonl", bytes.as_slice()) {
        Ok(kept) => Some(kept),
        // Of a journal that was cut before the first reading.
        Err(_) if state.readings.is_empty() => None,
        Err(error) => return Err(error),
    };
    let damaged = matches!(journal.end, JournalEnd::Damaged { lines: 1.., .. });
    let rows = numbers_and_lines(table);
    let last_written = rows.iter().map(|(seq, _)| *seq).max();
    let mut found = Integrity::default();
    let whole = |line: Option<u32>, seq: u32, journal: String, table: String| Difference {
        line,
        seq,
        column: "seq".to_owned(),
        journal,
        table,
    };
    let mut of_table: BTreeMap<u32, usize> = BTreeMap::new();
    for (at, &(seq, line)) in rows.iter().enumerate() {
        if of_table.insert(seq, at).is_some() {
            let (once, twice) = ("once".to_owned(), "twice".to_owned());
            found.changed.push(whole(Some(line), seq, once, twice));
        }
    }
    if let Some(kept) = &kept {
        for (at, (seq, _)) in numbers_and_lines(kept).into_iter().enumerate() {
            if let Some(other) = of_table.remove(&seq) {
                let [values, marks] = differences((kept, at), (table, other)).map(|changes| {
                    let changes = changes.into_iter();
                    changes.map(|(column, journal, table)| Difference {
                        line: Some(rows[other].1),
                        seq,
                        column,
                        journal,
                        table,
                    })
                });
                found.changed.extend(values);
                found.marks.extend(marks);
            } else if state.ended.is_none() && Some(seq) > last_written {
                found.behind.push(seq);
            } else {
                let missing = "missing".to_owned();
                let lost = whole(None, seq, seq.to_string(), missing);
                found.changed.push(lost);
            }
        }
    }
    for (seq, at) in of_table {
        if damaged {
            found.unknown.push(seq);
        } else {
            let (line, missing) = (Some(rows[at].1), "missing".to_owned());
            let added = whole(line, seq, missing, seq.to_string());
            found.changed.push(added);
        }
    }
    Ok(found)
}

/// What a table has of a reading, by column.
fn columns((table, at): (&ReadingTable, usize)) -> Vec<(String, String)> {
    if table.is_of_vectors() {
        let names = table.fields.names.iter().cloned();
        return names.zip(table.fields.rows[at].fields.clone()).collect();
    }
    let reading = &table.readings[at];
    let label = |keys: &[RunKey], index: u32| {
        let key = keys.get(index as usize);
        key.and_then(|key| key.label.as_deref())
            .map_or_else(|| index.to_string(), str::to_owned)
    };
    let optional = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    let of_table = |value: &Option<String>| value.clone().unwrap_or_default();
    let [force_zero, displacement_zero] = reading
        .text
        .as_deref()
        .map_or([None; 2], |text| text.zero_si);
    let text = |part: fn(&ReadingText) -> &str| {
        let text = reading.text.as_deref();
        text.map_or_else(String::new, |text| part(text).to_owned())
    };
    let columns = [
        ("session", of_table(&table.session)),
        ("utc", text(|text| &text.utc)),
        ("pose", reading.pose.to_string()),
        ("direction", reading.direction.to_string()),
        ("branch", reading.branch.to_string()),
        ("step", reading.step.to_string()),
        ("target_N", reading.target_n.to_string()),
        ("repeat", reading.repeat.to_string()),
        ("attempt", reading.attempt.to_string()),
        ("run", label(&table.runs, reading.run)),
        ("zero_id", label(&table.zeros, reading.zero)),
        ("force_N", reading.force_n.to_string()),
        ("force_raw", text(|text| &text.force_raw)),
        ("force_zero_N", optional(force_zero)),
        (
            "displacement_um",
            (reading.displacement_m * 1e6).to_string(),
        ),
        ("displacement_raw", text(|text| &text.displacement_raw)),
        (
            "displacement_zero_um",
            optional(displacement_zero.map(|m| m * 1e6)),
        ),
        ("t_s", optional(reading.time_s)),
        ("hold_s", optional(reading.hold_s)),
        ("temp_degC", optional(reading.temperature_deg_c)),
        ("status", reading.status.to_string()),
        ("flag", text(|text| &text.flag)),
        ("note", text(|text| &text.note)),
        ("origin", of_table(&table.origin)),
    ];
    columns
        .map(|(column, value)| (column.to_owned(), value))
        .into()
}
