//! Sessions with displacement gauges along the base axes.

use std::path::{Path, PathBuf};

use crate::readings::{
    OverdueGauge, ReadingTable, SessionHeader, VectorReading, VectorTable, is_vector_table,
    read_vector_readings,
};
use crate::stiffness::{Branches, VectorStiffness, vector_stiffness};

use super::data::{
    LoadedSession, OpenSettings, check_calibration, last_day, readings_file, session_header,
};
use super::error::AnalysisError;
use super::files::{folder_of, is_there, read_bytes, shown};
use super::hash::sha256;
use super::integrity::compare_with_journal;

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
    /// Gauges whose calibration is overdue.
    pub overdue: Vec<OverdueGauge>,
    /// Whether the readings were used though they differ from the journal.
    pub differs_from_journal: bool,
}

impl<T> SessionTable<T> {
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

/// Readings of vectors with the session they belong to.
pub type VectorSession = SessionTable<VectorTable>;

impl VectorSession {
    /// Opens a session folder or readings file if its readings are vectors; `None` if they are not.
    ///
    /// # Errors
    /// For data that are not there or cannot be read, a table that differs from its journal, and an overdue calibration, as the options
    /// have it.
    pub fn open(path: &Path, options: &OpenSettings) -> Result<Option<Self>, AnalysisError> {
        if options.gauge_log.is_some() || !is_there(path) {
            return Ok(None);
        }
        let file = readings_file(path)?;
        let bytes = read_bytes(&file)?;
        if !is_vector_table(&bytes) {
            return Ok(None);
        }
        let name = shown(&file);
        options.gauges.refuse(&name)?;
        let table = read_vector_readings(&name, bytes.as_slice())?;
        let folder = folder_of(&file);
        let mut warnings = Vec::new();
        let header = session_header(&folder, &mut warnings)?;
        let mut differs_from_journal = false;
        if file.file_name().is_some_and(|name| name == "readings.csv") {
            let check = compare_with_journal(&folder, &table, header.as_ref())?;
            differs_from_journal = check.judge(&file, options.trust_csv, &mut warnings)?;
        }
        let measured = last_day(table.readings.iter().map(|reading| reading.utc.as_str()));
        let check = options.calibration;
        let overdue = check_calibration(header.as_ref(), measured, check, &mut warnings)?;
        Ok(Some(Self {
            name: shown(path),
            sha256: sha256(&bytes),
            origin: origin_of(table.origin.as_ref(), header.as_ref()),
            table,
            header,
            folder,
            warnings,
            calibration: Vec::new(),
            overdue,
            differs_from_journal,
        }))
    }

    /// The same with a reading for each gauge, as a session of one gauge has them.
    #[must_use]
    pub fn by_component(self) -> LoadedSession {
        SessionTable {
            table: ReadingTable::of_vectors(&self.table),
            name: self.name,
            sha256: self.sha256,
            origin: self.origin,
            header: self.header,
            folder: self.folder,
            warnings: self.warnings,
            calibration: self.calibration,
            overdue: self.overdue,
            differs_from_journal: self.differs_from_journal,
        }
    }

    /// Compliance along each axis for every pose and direction of load.
    #[must_use]
    pub fn stiffness(&self, branches: Branches) -> Vec<VectorStiffness> {
        let accepted: Vec<&VectorReading> = self.table.accepted().collect();
        vector_stiffness(&accepted, branches, self.preload_n())
    }

    /// Force along the load at which the displacement gauges were zeroed, N; 0 where it is not known.
    #[must_use]
    pub fn preload_n(&self) -> f64 {
        let procedure = self
            .header
            .as_ref()
            .and_then(|header| header.procedure.as_ref());
        procedure
            .and_then(|procedure| procedure.preload_n)
            .unwrap_or(0.0)
    }

    /// Name of its procedure.
    #[must_use]
    pub fn procedure(&self) -> Option<&str> {
        let procedure = self.header.as_ref()?.procedure.as_ref()?;
        procedure.name.as_deref()
    }
}
