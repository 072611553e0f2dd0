//! Whether `readings.csv` still holds what the journal holds.
//!
//! The journal is the record; the table is a copy that a spreadsheet or a script can change. A changed number, unit or pose makes another
//! result; a changed status, flag or note is the analyst's own mark and is only listed.

use std::collections::BTreeMap;

use stiffbench_measurement::readings::{
    ReadOptions, Reading, ReadingTable, ReadingsError, RunKey, read_readings,
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
    pub column: &'static str,
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
        Err(ReadingsError::Empty { .. }) => ReadingTable {
            readings: Vec::new(),
            ..table.clone()
        },
        Err(error) => return Err(error),
    };
    let damaged = matches!(journal.end, JournalEnd::Damaged { .. });
    let mut of_table: BTreeMap<u32, &Reading> = BTreeMap::new();
    let last_written = table.readings.iter().map(|reading| reading.seq).max();
    let mut found = Integrity::default();
    for reading in &table.readings {
        if of_table.insert(reading.seq, reading).is_some() {
            found.changed.push(Difference {
                line: Some(reading.line),
                seq: reading.seq,
                column: "seq",
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
                column: "seq",
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
                column: "seq",
                journal: "missing".to_owned(),
                table: seq.to_string(),
            });
        }
    }
    Ok(found)
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
                column,
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
