//! A session's table and header beside its journal.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::readings::{ReadingTable, SessionHeader};
use crate::session::{
    Difference, Integrity, OmittedReadings, SessionState, integrity, read_journal,
};

use super::error::{AnalysisError, Failure};
use super::files::{read_bytes, read_text, session_file};
use super::hash::sha256;
use crate::count::counted;

/// Differences that an error lists; the others are counted.
const LISTED: usize = 8;

/// How a table of readings compares with the journal of its session.
#[derive(Debug)]
pub struct JournalCheck {
    /// Value by value.
    table: Integrity,
    /// Changed keys of the header.
    header: Vec<Difference>,
    /// What is wrong with the journal itself.
    damage: Option<String>,
    /// Planned readings that were left out.
    left_out: Vec<OmittedReadings>,
}

/// Compares a table of readings and its header with the journal in their folder; `None` without one.
///
/// # Errors
/// For a journal that cannot be read.
pub fn compare_with_journal(
    folder: &Path,
    table: &ReadingTable,
    header: Option<&SessionHeader>,
) -> Result<Option<JournalCheck>, Failure> {
    let Some(path) = session_file(folder, "journal.jsonl")? else {
        return Ok(None);
    };
    let bytes = read_bytes(&path)?;
    let journal = read_journal(&bytes);
    let state = SessionState::fold(&journal.records);
    let text = read_text(&folder.join("session.toml")).unwrap_or_default();
    Ok(Some(JournalCheck {
        table: integrity(&journal, table)?,
        header: header.map_or_else(Vec::new, |header| header_changes(&state, header, &text)),
        damage: journal.end.warning(),
        left_out: OmittedReadings::of(state.skipped.values()),
    }))
}

/// SHA-256 of a `session.toml` without the records of the instruments, and of these.
#[must_use]
pub fn header_sha256(text: &str) -> [Option<String>; 2] {
    let hash = |is_instruments: bool| {
        let mut table: toml::Table = text.parse().ok()?;
        table.retain(|key, _| (key == "instruments") == is_instruments);
        Some(sha256(table.to_string()))
    };
    [false, true].map(hash)
}

/// What a header and its text have that the session did not begin with.
fn header_changes(state: &SessionState, header: &SessionHeader, text: &str) -> Vec<Difference> {
    let Some(started) = &state.started else {
        return Vec::new();
    };
    let session = Some(started.session.clone()).filter(|session| !session.is_empty());
    let [others, instruments] = header_sha256(text);
    let keys = [
        ("id", session, &header.id),
        (
            "robot_sha256",
            started.robot_sha256.clone(),
            &header.robot_sha256,
        ),
        ("mechanism", started.mechanism.clone(), &header.mechanism),
        ("origin", started.origin.clone(), &header.origin),
        (
            "SHA-256 of all but the instruments",
            started.header_sha256.clone(),
            &others,
        ),
        (
            "SHA-256 of the instruments",
            started.instruments_sha256.clone(),
            &instruments,
        ),
    ];
    let changed = keys.into_iter().filter_map(|(key, journal, header)| {
        let journal = journal?;
        let header = header.clone().unwrap_or_default();
        (journal != header).then_some(Difference {
            line: None,
            seq: 0,
            column: key.to_owned(),
            journal,
            table: header,
        })
    });
    changed.collect()
}

impl JournalCheck {
    /// Refuses changed numbers unless they are to be trusted, and returns whether there are some; states what else was changed.
    ///
    /// # Errors
    /// [`AnalysisError::Changed`].
    pub fn judge(
        &self,
        file: &Path,
        trust: bool,
        warnings: &mut Vec<String>,
    ) -> Result<bool, Failure> {
        let table = &self.table;
        warnings.extend(self.damage.clone());
        warnings.extend(self.left_out.iter().map(ToString::to_string));
        let changes = self.changes(file);
        if !changes.is_empty() {
            if !trust {
                return Err(AnalysisError::Changed {
                    path: file.to_owned(),
                    changes: shortened(&changes),
                }
                .into());
            }
            warnings.push(format!(
                "--trust-csv: {} differs from the journal in {}, and the table was used",
                file.display(),
                counted(table.changed.len() + self.header.len(), "value")
            ));
        }
        if !table.marks.is_empty() {
            let marks = shortened(&marks(file, table));
            warnings.push(format!("marked after the session: {marks}"));
        }
        if !table.behind.is_empty() {
            warnings.push(format!(
                "the session was interrupted before the table had its last {}: stiffbench session resume or recover adds what is missing",
                counted(table.behind.len(), "reading")
            ));
        }
        if !table.unknown.is_empty() {
            warnings.push(format!(
                "in no complete line of the damaged journal, and not protected: {}",
                counted(table.unknown.len(), "reading")
            ));
        }
        Ok(!changes.is_empty())
    }

    /// What was changed, in words.
    #[must_use]
    pub fn changes(&self, file: &Path) -> Vec<String> {
        let header = self.header.iter().map(|key| {
            format!(
                "session.toml: {} is {:?}, the journal has {:?}",
                key.column, key.table, key.journal
            )
        });
        let table = self.table.changed.iter();
        header
            .chain(table.map(|change| in_words(file, change)))
            .collect()
    }

    /// The comparison for programs.
    #[must_use]
    pub fn report(&self, file: &Path) -> TableCheck {
        let differences = ReportDifferences {
            changed: self.changes(file),
            marked: marks(file, &self.table),
            not_in_journal: self.table.unknown.clone(),
            not_in_table: self.table.behind.clone(),
        };
        if differences.changed.is_empty() {
            TableCheck::AsRecorded(differences)
        } else {
            TableCheck::Changed(differences)
        }
    }
}

/// The table of readings of a session beside its journal.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(tag = "state", rename_all = "kebab-case")]
pub enum TableCheck {
    /// There is no journal that it could be compared with.
    NotProtected,
    /// Every number is that of the journal.
    AsRecorded(ReportDifferences),
    /// Some numbers are not those of the journal.
    Changed(ReportDifferences),
    /// There is no table.
    Missing,
    /// It has no reading yet.
    Empty,
    /// It cannot be read.
    Unreadable {
        /// Why.
        reason: String,
    },
}

/// How a table differs from its journal.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
pub struct ReportDifferences {
    /// Changed numbers, in words.
    pub changed: Vec<String>,
    /// Changed marks such as a status or a comment, in words.
    pub marked: Vec<String>,
    /// Readings (`seq`) that the journal does not have.
    pub not_in_journal: Vec<u32>,
    /// Readings (`seq`) that the table does not have.
    pub not_in_table: Vec<u32>,
}

fn marks(file: &Path, table: &Integrity) -> Vec<String> {
    table
        .marks
        .iter()
        .map(|mark| in_words(file, mark))
        .collect()
}

fn in_words(file: &Path, difference: &Difference) -> String {
    let Difference {
        line,
        seq,
        column,
        journal,
        table,
    } = difference;
    let file = file.display();
    match line {
        None => format!("{file}: reading {seq} is missing"),
        Some(line) if column == "seq" && journal == "missing" => {
            format!("{file}:{line}: the journal has no reading {seq}")
        }
        Some(line) if column == "seq" => {
            format!("{file}:{line}: reading {seq} stands here {table}")
        }
        Some(line) => {
            format!(
                "{file}:{line}: {column} of reading {seq} is {table}, the journal has {journal}"
            )
        }
    }
}

/// The first of a list, and how many more.
#[must_use]
pub fn shortened(list: &[String]) -> String {
    let shown = list.iter().take(LISTED).cloned().collect::<Vec<_>>();
    match list.len().saturating_sub(LISTED) {
        0 => shown.join("; "),
        more => format!("{}; and {more} more", shown.join("; ")),
    }
}
