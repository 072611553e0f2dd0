//! Whether `readings.csv` still holds what the journal holds.
//!
//! The journal is the record; the table is a copy that a spreadsheet or a script can change. A changed number, unit or pose makes another
//! result; a changed status, flag or note is the analyst's own mark and is only listed.

use std::collections::BTreeMap;

use stiffbench_measurement::readings::{
    MARK_COLUMNS, ReadOptions, Reading, ReadingTable, ReadingsError, RunKey, VectorTable,
    read_readings, read_vector_readings,
};

use super::folder::table as write_table;
use super::journal::{JournalEnd, ReadJournal};
use super::state::SessionState;

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

/// Compares a table with the journal of its session, value by value.
///
/// # Errors
/// [`ReadingsError`] if the journal's own readings make no table.
pub fn integrity(journal: &ReadJournal, table: &ReadingTable) -> Result<Integrity, ReadingsError> {
    let state = SessionState::fold(&journal.records);
    if state.readings.is_empty() && table.readings.is_empty() {
        return Ok(Integrity::default());
    }
    // Through the same file form, so that both have been rounded alike.
    let mut bytes = Vec::new();
    write_table(&state, &mut bytes)?;
    let kept = match read_readings("journal.jsonl", &bytes[..], &ReadOptions::default()) {
        Ok(kept) => kept,
        // Of a journal that was cut before the first reading.
        Err(_) if state.readings.is_empty() => ReadingTable {
            readings: Vec::new(),
            ..table.clone()
        },
        Err(error) => return Err(error),
    };
    let damaged = matches!(journal.end, JournalEnd::Damaged { lines: 1.., .. });
    let mut of_table: BTreeMap<u32, &Reading> = BTreeMap::new();
    let last_written = table.readings.iter().map(|reading| reading.seq).max();
    let mut found = Integrity::default();
    for reading in &table.readings {
        if of_table.insert(reading.seq, reading).is_some() {
            found.changed.push(Difference {
                line: Some(reading.line),
                seq: reading.seq,
                column: "seq".to_owned(),
                journal: "once".to_owned(),
                table: "twice".to_owned(),
            });
        }
    }
    for reading in &kept.readings {
        match of_table.remove(&reading.seq) {
            Some(other) => compare((&kept, reading), (table, other), &mut found),
            None if state.ended.is_none() && Some(reading.seq) > last_written => {
                found.behind.push(reading.seq);
            }
            None => found.changed.push(Difference {
                line: None,
                seq: reading.seq,
                column: "seq".to_owned(),
                journal: reading.seq.to_string(),
                table: "missing".to_owned(),
            }),
        }
    }
    for (seq, reading) in of_table {
        if damaged {
            found.unknown.push(seq);
        } else {
            found.changed.push(Difference {
                line: Some(reading.line),
                seq,
                column: "seq".to_owned(),
                journal: "missing".to_owned(),
                table: seq.to_string(),
            });
        }
    }
    Ok(found)
}

/// Compares a table of vectors with the journal of its session, field by field.
///
/// # Errors
/// [`ReadingsError`] if the journal's own readings make no table.
pub fn vector_integrity(
    journal: &ReadJournal,
    table: &VectorTable,
) -> Result<Integrity, ReadingsError> {
    let state = SessionState::fold(&journal.records);
    let mut bytes = Vec::new();
    write_table(&state, &mut bytes)?;
    let kept = match read_vector_readings("journal.jsonl", &bytes[..]) {
        Ok(kept) => kept,
        Err(_) if state.readings.is_empty() => VectorTable {
            names: table.names.clone(),
            ..VectorTable::default()
        },
        Err(error) => return Err(error),
    };
    let damaged = matches!(journal.end, JournalEnd::Damaged { lines: 1.., .. });
    let last_written = table.readings.iter().map(|reading| reading.seq).max();
    let mut found = Integrity::default();
    let mut of_table: BTreeMap<u32, usize> = BTreeMap::new();
    let whole = |line: Option<u32>, seq: u32, journal: String, table: String| Difference {
        line,
        seq,
        column: "seq".to_owned(),
        journal,
        table,
    };
    for (at, reading) in table.readings.iter().enumerate() {
        if of_table.insert(reading.seq, at).is_some() {
            let (once, twice) = ("once".to_owned(), "twice".to_owned());
            let line = Some(reading.line);
            found.changed.push(whole(line, reading.seq, once, twice));
        }
    }
    for (at, reading) in kept.readings.iter().enumerate() {
        let seq = reading.seq;
        match of_table.remove(&seq) {
            Some(other) => compare_fields((&kept, at), (table, other), &mut found),
            None if state.ended.is_none() && Some(seq) > last_written => found.behind.push(seq),
            None => {
                let missing = "missing".to_owned();
                found
                    .changed
                    .push(whole(None, seq, seq.to_string(), missing));
            }
        }
    }
    for (seq, at) in of_table {
        if damaged {
            found.unknown.push(seq);
        } else {
            let line = Some(table.readings[at].line);
            let missing = "missing".to_owned();
            found
                .changed
                .push(whole(line, seq, missing, seq.to_string()));
        }
    }
    Ok(found)
}

/// The fields of one reading in both, by the names of the journal's columns.
fn compare_fields(
    (journal, kept): (&VectorTable, usize),
    (table, read): (&VectorTable, usize),
    found: &mut Integrity,
) {
    let field = |table: &VectorTable, at: usize, column: &str| {
        let index = table.names.iter().position(|name| name == column);
        index.map_or_else(String::new, |index| table.rows[at][index].clone())
    };
    for column in &journal.names {
        let (is, was) = (field(table, read, column), field(journal, kept, column));
        let alike = is == was
            || matches!((is.parse::<f64>(), was.parse::<f64>()), (Ok(is), Ok(was)) if is == was);
        if alike {
            continue;
        }
        let difference = Difference {
            line: Some(table.readings[read].line),
            seq: table.readings[read].seq,
            column: column.clone(),
            journal: was,
            table: is,
        };
        if MARK_COLUMNS.contains(&column.as_str()) {
            found.marks.push(difference);
        } else {
            found.changed.push(difference);
        }
    }
}

/// One reading in both.
fn compare(
    (journal, kept): (&ReadingTable, &Reading),
    (table, read): (&ReadingTable, &Reading),
    found: &mut Integrity,
) {
    let numbers = [values(journal, kept), values(table, read)];
    let marks = [marks(kept), marks(read)];
    let differences = |[kept, read_values]: [Vec<(&'static str, String)>; 2]| {
        let pairs = kept.into_iter().zip(read_values);
        pairs
            .filter(|((_, journal), (_, table))| journal != table)
            .map(|((column, journal), (_, table))| Difference {
                line: Some(read.line),
                seq: read.seq,
                column: column.to_owned(),
                journal,
                table,
            })
            .collect::<Vec<_>>()
    };
    found.changed.extend(differences(numbers));
    found.marks.extend(differences(marks));
}

/// What makes the result, by column.
fn values(table: &ReadingTable, reading: &Reading) -> Vec<(&'static str, String)> {
    let label = |keys: &[RunKey], index: u32| {
        let key = keys.get(index as usize);
        key.and_then(|key| key.label.as_deref())
            .map_or_else(|| index.to_string(), str::to_owned)
    };
    let optional = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    let raw = |part: fn(&stiffbench_measurement::readings::ReadingText) -> &str| {
        let text = reading.text.as_deref();
        text.map_or_else(String::new, |text| part(text).to_owned())
    };
    vec![
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
        ("force_raw", raw(|text| &text.force_raw)),
        (
            "displacement_um",
            (reading.displacement_m * 1e6).to_string(),
        ),
        ("displacement_raw", raw(|text| &text.displacement_raw)),
        ("t_s", optional(reading.time_s)),
        ("hold_s", optional(reading.hold_s)),
        ("temp_degC", optional(reading.temperature_deg_c)),
    ]
}

/// What an analyst may change.
fn marks(reading: &Reading) -> Vec<(&'static str, String)> {
    let text = reading.text.as_deref();
    vec![
        ("status", format!("{:?}", reading.status).to_lowercase()),
        (
            "flag",
            text.map_or_else(String::new, |text| text.flag.to_string()),
        ),
        (
            "note",
            text.map_or_else(String::new, |text| text.note.to_string()),
        ),
    ]
}
