//! The session folder on the disk: made once, held by one process at a time, never written over.

use std::error::Error;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use jiff::Timestamp;
use miette::Diagnostic;

use stiffbench_measurement::readings::{TableError, WrittenRows};

use super::inside::{append_inside, inside, read_inside};
use super::journal::{Journal, JournalEnd, ReadJournal, Record, Store, read_journal, write_lines};
use super::lock::{JournalFile, open_alone};
use super::state::SessionState;
use super::whole_file::{replace, sync_folder};

/// Names of the files of a session.
const HEADER: &str = "session.toml";
const ROBOT: &str = "robot.toml";
pub(super) const JOURNAL: &str = "journal.jsonl";
const READINGS: &str = "readings.csv";
const RAW: &str = "raw";

/// A session folder that this process holds as long as its journal is open.
#[derive(Debug)]
pub struct SessionFolder {
    path: PathBuf,
}

/// Why a session folder cannot be used.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum FolderError {
    /// There is something of that name.
    #[error("{path} exists already")]
    #[diagnostic(
        code(stiffbench::output::exists),
        help(
            "a session is never overwritten: choose another name, or continue this one with stiffbench session resume"
        )
    )]
    Exists {
        /// The folder.
        path: PathBuf,
    },
    /// No session there.
    #[error("{path} is not a session folder: it has no {file}")]
    #[diagnostic(
        code(stiffbench::session::no_session),
        help(
            "name the folder that stiffbench session run made; paths start in the folder you are in"
        )
    )]
    NoSession {
        /// The folder.
        path: PathBuf,
        /// What it lacks.
        file: &'static str,
    },
    /// Another process has it.
    #[error("{path} is in use by {holder}")]
    #[diagnostic(
        code(stiffbench::session::in_use),
        help(
            "end that session first; its readings are safe, and this command can then be given again"
        )
    )]
    InUse {
        /// The folder.
        path: PathBuf,
        /// Process, machine, and since when.
        holder: String,
    },
    /// The journal is damaged before its end.
    #[error("{path}: {finding}")]
    #[diagnostic(
        code(stiffbench::session::damaged),
        help(
            "stiffbench session recover FOLDER --out NEW keeps all others; this folder stays as it is"
        )
    )]
    Damaged {
        /// The journal.
        path: PathBuf,
        /// What is wrong with it.
        finding: String,
    },
    /// Something else in place of a file.
    #[error("{path} is not opened")]
    #[diagnostic(
        code(stiffbench::session::not_a_file),
        help(
            "put the file itself in its place. A folder that you did not make may lead to files elsewhere, which would be written over"
        )
    )]
    NotAFile {
        /// What it stands for.
        path: PathBuf,
        /// What it is.
        source: io::Error,
    },
    /// The system refuses.
    #[error("{path} cannot be used")]
    #[diagnostic(
        code(stiffbench::output::session_folder),
        help(
            "the folder must be writable and its disk have room; nothing that was confirmed is lost"
        )
    )]
    System {
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
}

pub(super) fn system(path: &Path) -> impl FnOnce(io::Error) -> FolderError {
    let path = path.to_owned();
    |source| match source.kind() {
        io::ErrorKind::InvalidInput => FolderError::NotAFile { path, source },
        _ => FolderError::System { path, source },
    }
}

/// What a file cannot hold.
fn unwritable<E: Into<Box<dyn Error + Send + Sync>>>(path: &Path) -> impl FnOnce(E) -> FolderError {
    let failed = system(path);
    |error| failed(io::Error::other(error))
}

impl SessionFolder {
    /// Whether a folder of this name can be made.
    ///
    /// # Errors
    /// [`FolderError::Exists`] if there is something of that name, whatever it is.
    pub fn check_new(path: &Path) -> Result<(), FolderError> {
        // A link that leads nowhere is something too.
        if path.symlink_metadata().is_ok() {
            return Err(FolderError::Exists {
                path: path.to_owned(),
            });
        }
        Ok(())
    }

    /// Makes a new folder with an empty journal, the robot file, and its `session.toml`; that comes last, so that a folder that has it is whole.
    ///
    /// # Errors
    /// [`FolderError::Exists`] if there is something of that name, whatever it is; [`FolderError::System`].
    pub fn create(
        path: &Path,
        header: &str,
        robot: Option<&str>,
        now: Timestamp,
    ) -> Result<(Self, Journal<JournalFile>), FolderError> {
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(system(parent))?;
        }
        fs::create_dir(path).map_err(|source| match source.kind() {
            io::ErrorKind::AlreadyExists => FolderError::Exists {
                path: path.to_owned(),
            },
            _ => system(path)(source),
        })?;
        let file = open_alone(path, OpenOptions::new().append(true).create_new(true), now)?;
        if let Some(robot) = robot {
            put(&path.join(ROBOT), robot.as_bytes())?;
        }
        put(&path.join(HEADER), header.as_bytes())?;
        // The names of the new files are on the disk only once the folder is.
        sync_folder(path).map_err(system(path))?;
        let path = path.to_owned();
        Ok((Self { path }, Journal::behind(file, 0)))
    }

    /// Opens a folder to go on with its session. A record that was being written when the session stopped is taken off; how many bytes, is
    /// the last of what comes back.
    ///
    /// # Errors
    /// [`FolderError::InUse`] if another process has it, [`FolderError::Damaged`] if its journal is damaged before the end.
    pub fn open(
        path: &Path,
        now: Timestamp,
    ) -> Result<(Self, Journal<JournalFile>, ReadJournal, u64), FolderError> {
        // A folder that is no session gets no lock file; what was read before the lock was ours may have grown since.
        read_folder(path)?;
        let mut file = open_alone(path, OpenOptions::new().append(true), now)?;
        let read = read_folder(path)?;
        let journal_path = path.join(JOURNAL);
        let cut_bytes = match read.journal.end {
            JournalEnd::Clean => 0,
            JournalEnd::Cut { bytes } => {
                let cut = file.cut(read.journal.good_bytes);
                cut.map_err(system(&journal_path))?;
                bytes as u64
            }
            JournalEnd::Damaged { .. } => {
                return Err(FolderError::Damaged {
                    path: journal_path,
                    finding: read.journal.end.finding(),
                });
            }
        };
        let folder = Self {
            path: path.to_owned(),
        };
        let journal = Journal::behind(file, read.journal.records.len() as u64);
        Ok((folder, journal, read.journal, cut_bytes))
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The folder for the bytes of the ports, made if it is not there.
    ///
    /// # Errors
    /// [`FolderError::System`].
    pub fn raw(&self) -> Result<PathBuf, FolderError> {
        let raw = self.path.join(RAW);
        inside(&self.path, RAW)
            .and_then(fs::create_dir_all)
            .map_err(system(&raw))?;
        Ok(raw)
    }

    /// Adds the last reading of a session to `readings.csv`, the live table: a row behind each reading. It can be rebuilt from the journal at
    /// any time.
    ///
    /// # Errors
    /// [`FolderError::System`].
    pub fn add_last_row(&self, state: &SessionState) -> Result<(), FolderError> {
        let path = self.path.join(READINGS);
        if state.readings.len() < 2 || !path.is_file() {
            return self.rewrite_table(state);
        }
        let mut row = Vec::new();
        write_rows(state, &mut row, true).map_err(unwritable(&path))?;
        let file = append_inside(&self.path, READINGS);
        let written = file.and_then(|mut file| file.write_all(&row));
        written.map_err(system(&path))
    }

    /// Writes all readings of a session into the table, as when one is superseded: into a file beside it, which then takes its place.
    ///
    /// # Errors
    /// [`FolderError::System`].
    pub fn rewrite_table(&self, state: &SessionState) -> Result<(), FolderError> {
        let path = self.path.join(READINGS);
        let mut text = Vec::new();
        table(state, &mut text).map_err(unwritable(&path))?;
        put(&path, &text)
    }
}

/// `session.toml` and the journal of a folder, read without touching it.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadFolder {
    /// Name of the header, for messages.
    pub header_name: String,
    /// Text of `session.toml`.
    pub header: String,
    /// The journal.
    pub journal: ReadJournal,
}

/// Reads a session folder without touching it.
///
/// # Errors
/// [`FolderError::NoSession`] if it is none, [`FolderError::System`].
pub fn read_folder(path: &Path) -> Result<ReadFolder, FolderError> {
    let read = |file: &'static str| {
        read_inside(path, file).map_err(|source| match source.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => FolderError::NoSession {
                path: path.to_owned(),
                file,
            },
            _ => system(&path.join(file))(source),
        })
    };
    let header_name = path.join(HEADER).display().to_string();
    let header = String::from_utf8_lossy(&read(HEADER)?).into_owned();
    let journal = read_journal(&read(JOURNAL)?);
    Ok(ReadFolder {
        header_name,
        header,
        journal,
    })
}

/// Copies what is good of a session into a new folder and reads it back; the old one is not touched.
///
/// # Errors
/// As [`SessionFolder::create`]; [`FolderError::Damaged`] if what was written cannot be read back.
pub fn recover(from: &Path, to: &Path, now: Timestamp) -> Result<ReadJournal, FolderError> {
    let read = read_folder(from)?;
    let target = to.join(JOURNAL);
    let lines = write_lines(&read.journal.records).map_err(unwritable(&target))?;
    let robot = read_inside(from, ROBOT).ok();
    let robot = robot.and_then(|robot| String::from_utf8(robot).ok());
    let (folder, journal) = SessionFolder::create(to, &read.header, robot.as_deref(), now)?;
    let mut store = journal.into_store();
    let written = store.write_all(&lines).and_then(|()| store.sync());
    written.map_err(system(&target))?;
    let state = SessionState::fold(&read.journal.records);
    folder.rewrite_table(&state)?;
    // Files of our own making beside the journal go along as they are.
    let raw = inside(from, RAW).and_then(fs::read_dir);
    for entry in raw.into_iter().flatten().flatten() {
        // Links, pipes and folders are none of them.
        if entry.file_type().is_ok_and(|kind| kind.is_file()) {
            let name = folder.raw()?.join(entry.file_name());
            fs::copy(entry.path(), &name).map_err(system(&name))?;
        }
    }
    let again = read_folder(to)?.journal;
    let kept = |record: &&Record| read.journal.records.contains(record);
    if again.end != JournalEnd::Clean
        || !again.records.iter().filter(kept).eq(&read.journal.records)
    {
        return Err(FolderError::Damaged {
            path: target,
            finding: "what was written does not come back".to_owned(),
        });
    }
    Ok(read.journal)
}

/// The table of readings of a session.
///
/// # Errors
/// As [`write_rows`](stiffbench_measurement::readings::write_rows).
pub fn table(state: &SessionState, output: impl Write) -> Result<(), TableError> {
    write_rows(state, output, false)
}

/// The rows of that table with their header, or the last without it; none before the first reading.
fn write_rows(state: &SessionState, output: impl Write, only_last: bool) -> Result<(), TableError> {
    let rows = WrittenRows {
        of_vectors: state.is_of_vectors(),
        only_last,
    };
    stiffbench_measurement::readings::write_rows(&state.table(), rows, output)
}

/// Writes a file whole or not at all.
pub(super) fn put(path: &Path, bytes: &[u8]) -> Result<(), FolderError> {
    replace(path, bytes).map_err(system(path))
}
