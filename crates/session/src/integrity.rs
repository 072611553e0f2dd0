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

/// A table of readings that can be held against the journal of its session.
pub trait KeptTable: Sized {
    /// Reads what the journal's own readings are written as.
    ///
    /// # Errors
    /// [`ReadingsError`] if they make no table.
    fn read_back(bytes: &[u8]) -> Result<Self, ReadingsError>;

    /// Number in the session and line of each reading, in the order of the table.
    fn numbers_and_lines(&self) -> Vec<(u32, u32)>;

    /// Changed values and changed marks of the reading at a place in this table, of the journal, and at its place in the other.
    fn differences(&self, kept: usize, table: &Self, read: usize) -> [Vec<ChangedField>; 2];
}

/// A column with what the journal and what the table has there.
type ChangedField = (String, String, String);

impl KeptTable for ReadingTable {
    fn read_back(bytes: &[u8]) -> Result<Self, ReadingsError> {
        read_readings("journal.jsonl", bytes, &ReadOptions::default())
    }

    fn numbers_and_lines(&self) -> Vec<(u32, u32)> {
        let readings = self.readings.iter();
        readings.map(|of| (of.seq, of.line)).collect()
    }

    fn differences(&self, kept: usize, table: &Self, read: usize) -> [Vec<ChangedField>; 2] {
        let (kept, read) = (&self.readings[kept], &table.readings[read]);
        let both = [
            (values(self, kept), values(table, read)),
            (marks(kept), marks(read)),
        ];
        both.map(|(kept, read)| {
            let pairs = kept.into_iter().zip(read);
            let changed = pairs.filter(|((_, journal), (_, table))| journal != table);
            changed
                .map(|((column, journal), (_, table))| (column.to_owned(), journal, table))
                .collect()
        })
    }
}

impl KeptTable for VectorTable {
    fn read_back(bytes: &[u8]) -> Result<Self, ReadingsError> {
        read_vector_readings("journal.jsonl", bytes)
    }

    fn numbers_and_lines(&self) -> Vec<(u32, u32)> {
        let readings = self.readings.iter();
        readings.map(|of| (of.seq, of.line)).collect()
    }

    /// By the names of the journal's columns.
    fn differences(&self, kept: usize, table: &Self, read: usize) -> [Vec<ChangedField>; 2] {
        let field = |table: &Self, at: usize, column: &str| {
            let index = table.names.iter().position(|name| name == column);
            index.map_or_else(String::new, |index| table.rows[at][index].clone())
        };
        let both = self.names.iter().map(|column| {
            let (was, is) = (field(self, kept, column), field(table, read, column));
            (column.clone(), was, is)
        });
        let changed = both.filter(|(_, was, is)| {
            let numbers = (is.parse::<f64>(), was.parse::<f64>());
            is != was && !matches!(numbers, (Ok(is), Ok(was)) if is == was)
        });
        let (marks, values) =
            changed.partition(|(column, ..)| MARK_COLUMNS.contains(&column.as_str()));
        [values, marks]
    }
}

/// Compares a table with the journal of its session, value by value.
///
/// # Errors
/// [`ReadingsError`] if the journal's own readings make no table.
pub fn integrity<T: KeptTable>(
    journal: &ReadJournal,
    table: &T,
) -> Result<Integrity, ReadingsError> {
    let state = SessionState::fold(&journal.records);
    // Through the same file form, so that both have been rounded alike.
    let mut bytes = Vec::new();
    write_table(&state, &mut bytes)?;
    let kept = match T::read_back(&bytes) {
        Ok(kept) => Some(kept),
        // Of a journal that was cut before the first reading.
        Err(_) if state.readings.is_empty() => None,
        Err(error) => return Err(error),
    };
    let damaged = matches!(journal.end, JournalEnd::Damaged { lines: 1.., .. });
    let rows = table.numbers_and_lines();
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
        for (at, (seq, _)) in kept.numbers_and_lines().into_iter().enumerate() {
            if let Some(other) = of_table.remove(&seq) {
                let [values, marks] = kept.differences(at, table, other).map(|changes| {
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
