//! A session's table and header beside its journal.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::readings::{ReadingTable, SessionHeader};
use crate::session::{Difference, Integrity, SessionState, integrity, read_journal};

use super::failure::{CliError, Failure};

/// Differences that an error lists; the others are counted.
const LISTED: usize = 8;

/// What became of the comparison.
#[derive(Debug)]
pub(super) enum Protection {
    /// No journal stands beside the table.
    None,
    /// Compared.
    Compared {
        /// Value by value.
        table: Integrity,
        /// Changed keys of the header.
        header: Vec<Difference>,
    },
}

/// Compares a table of readings and its header with the journal in their folder.
pub(super) fn compare_with_journal(
    folder: &Path,
    table: &ReadingTable,
    header: Option<&SessionHeader>,
) -> Result<Protection, Failure> {
    let path = folder.join("journal.jsonl");
    if !path.is_file() {
        return Ok(Protection::None);
    }
    let bytes = fs::read(&path).map_err(|source| CliError::Read { path, source })?;
    let journal = read_journal(&bytes);
    let state = SessionState::fold(&journal.records);
    Ok(Protection::Compared {
        table: integrity(&journal, table)?,
        header: header.map_or_else(Vec::new, |header| header_changes(&state, header)),
    })
}

/// Keys of a header that are not what the session began with.
fn header_changes(state: &SessionState, header: &SessionHeader) -> Vec<Difference> {
    let Some(started) = &state.started else {
        return Vec::new();
    };
    let session = Some(started.session.clone()).filter(|session| !session.is_empty());
    let keys = [
        ("id", session, &header.id),
        (
            "robot_sha256",
            started.robot_sha256.clone(),
            &header.robot_sha256,
        ),
        ("mechanism", started.mechanism.clone(), &header.mechanism),
        ("origin", started.origin.clone(), &header.origin),
    ];
    let changed = keys.into_iter().filter_map(|(key, journal, header)| {
        let journal = journal?;
        let header = header.clone().unwrap_or_default();
        (journal != header).then_some(Difference {
            line: None,
            seq: 0,
            column: key,
            journal,
            table: header,
        })
    });
    changed.collect()
}

impl Protection {
    /// Refuses changed numbers unless they are to be trusted; says what else was changed.
    pub(super) fn judge(
        &self,
        file: &Path,
        trust: bool,
        warnings: &mut Vec<String>,
    ) -> Result<(), Failure> {
        let Self::Compared { table, header } = self else {
            return Ok(());
        };
        let changes = self.changes(file);
        if !changes.is_empty() {
            if !trust {
                return Err(CliError::Changed {
                    path: file.to_owned(),
                    changes: shortened(&changes),
                }
                .into());
            }
            warnings.push(format!(
                "--trust-csv: {} differs from the journal in {} value(s), and the table was used",
                file.display(),
                table.changed.len() + header.len()
            ));
        }
        if !table.marks.is_empty() {
            let marks: Vec<String> = table
                .marks
                .iter()
                .map(|mark| in_words(file, mark))
                .collect();
            warnings.push(format!("marked after the session: {}", shortened(&marks)));
        }
        if !table.behind.is_empty() {
            warnings.push(format!(
                "the session was broken off before its last {} reading(s) were in the table: stiffbench session resume or recover writes them",
                table.behind.len()
            ));
        }
        if !table.unknown.is_empty() {
            warnings.push(format!(
                "{} reading(s) stand in no whole line of the damaged journal and are not protected",
                table.unknown.len()
            ));
        }
        Ok(())
    }

    /// What was changed, in words.
    pub(super) fn changes(&self, file: &Path) -> Vec<String> {
        match self {
            Self::None => Vec::new(),
            Self::Compared { table, header } => {
                let header = header.iter().map(|key| {
                    format!(
                        "session.toml: {} is {:?}, the journal has {:?}",
                        key.column, key.table, key.journal
                    )
                });
                let table = table.changed.iter().map(|change| in_words(file, change));
                header.chain(table).collect()
            }
        }
    }

    /// For JSON.
    pub(super) fn json(&self, file: &Path) -> Value {
        match self {
            Self::None => json!({ "state": "not-protected" }),
            Self::Compared { table, .. } => {
                let changes = self.changes(file);
                let state = if changes.is_empty() {
                    "as-recorded"
                } else {
                    "changed"
                };
                let marks: Vec<String> = table
                    .marks
                    .iter()
                    .map(|mark| in_words(file, mark))
                    .collect();
                json!({
                    "state": state,
                    "changed": changes,
                    "marked": marks,
                    "not_in_journal": table.unknown,
                    "not_in_table": table.behind,
                })
            }
        }
    }
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
        Some(line) if *column == "seq" && journal == "missing" => {
            format!("{file}:{line}: the journal has no reading {seq}")
        }
        Some(line) if *column == "seq" => {
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
pub(super) fn shortened(list: &[String]) -> String {
    let shown = list.iter().take(LISTED).cloned().collect::<Vec<_>>();
    match list.len().saturating_sub(LISTED) {
        0 => shown.join("; "),
        more => format!("{}; and {more} more", shown.join("; ")),
    }
}
