//! A table with the session it belongs to.

use std::path::{Path, PathBuf};

use crate::mismatch::StatedScatter;
use crate::readings::{OverdueGauge, SessionHeader};

use super::hash::sha256;

/// A table of readings or load cases with the session it belongs to.
#[derive(Debug, Clone)]
pub struct SessionTable<T> {
    /// What the user called it.
    pub name: String,
    /// SHA-256 of its file, in hexadecimal.
    pub sha256: String,
    /// The table.
    pub table: T,
    /// How it came about if it was not measured.
    pub origin: Option<String>,
    /// `session.toml` beside it, if there is one.
    pub header: Option<SessionHeader>,
    /// Folder of `session.toml`.
    pub folder: PathBuf,
    /// What was assumed, and what a user should know.
    pub warnings: Vec<String>,
    /// Calibrations that were given beside the session, in words.
    pub calibration: Vec<String>,
    /// What is stated of the scatter of its readings; `None` as they show it.
    pub scatter: Option<StatedScatter>,
    /// Gauges whose calibration is overdue.
    pub overdue: Vec<OverdueGauge>,
    /// Whether the readings were used though they differ from the journal.
    pub differs_from_journal: bool,
}

impl<T> SessionTable<T> {
    /// A table of which nothing else is known.
    ///
    /// # Arguments
    /// - `bytes`: the text that it is from.
    pub(super) fn bare(name: String, bytes: &[u8], table: T) -> Self {
        Self {
            name,
            sha256: sha256(bytes),
            table,
            origin: None,
            header: None,
            folder: PathBuf::new(),
            warnings: Vec::new(),
            calibration: Vec::new(),
            scatter: None,
            overdue: Vec::new(),
            differs_from_journal: false,
        }
    }

    /// The same session with what is made of its table.
    pub(super) fn with_table<U>(&self, table: U) -> SessionTable<U> {
        SessionTable {
            table,
            name: self.name.clone(),
            sha256: self.sha256.clone(),
            origin: self.origin.clone(),
            header: self.header.clone(),
            folder: self.folder.clone(),
            warnings: self.warnings.clone(),
            calibration: self.calibration.clone(),
            scatter: self.scatter,
            overdue: self.overdue.clone(),
            differs_from_journal: self.differs_from_journal,
        }
    }

    /// Its identifier, else the last part of its name: not a path, so that it is called the same wherever it lies.
    #[must_use]
    pub fn short_name(&self) -> String {
        let header = self.header.as_ref();
        let id = header.and_then(|header| header.id.clone());
        id.or_else(|| {
            let file_name = Path::new(&self.name).file_name()?;
            Some(file_name.to_string_lossy().into_owned())
        })
        .unwrap_or_else(|| self.name.clone())
    }
}

/// What the table states, else what its header does.
pub(super) fn origin_of(table: Option<&String>, header: Option<&SessionHeader>) -> Option<String> {
    let of_header = header.and_then(|header| header.origin.as_ref());
    table.or(of_header).cloned()
}
