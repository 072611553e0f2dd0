//! The lock of a session folder: which process has it.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::Path;

use jiff::Timestamp;

use super::folder::{FolderError, system};

/// Name of the lock file; it may stay when nobody holds the lock.
const LOCK: &str = "session.lock";

/// Who has a session folder now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FolderHolder {
    /// Nobody.
    Nobody,
    /// A process, with machine and since when.
    Process(String),
    /// The system does not say.
    Unknown,
}

/// Who has a session folder; nothing in it is changed.
#[must_use]
pub fn folder_holder(folder: &Path) -> FolderHolder {
    let path = folder.join(LOCK);
    let file = match File::open(&path) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return FolderHolder::Nobody,
        Err(_) => return FolderHolder::Unknown,
    };
    match file.try_lock_shared() {
        Ok(()) => FolderHolder::Nobody,
        Err(TryLockError::WouldBlock) => FolderHolder::Process(holder_text(&path)),
        Err(TryLockError::Error(_)) => FolderHolder::Unknown,
    }
}

/// What the lock file states of the process that has it.
fn holder_text(lock: &Path) -> String {
    let holder = fs::read_to_string(lock).unwrap_or_default();
    match holder.trim() {
        "" => "another process".to_owned(),
        holder => holder.to_owned(),
    }
}

/// Takes the lock of a folder and writes into it who has it.
pub(super) fn lock(folder: &Path, now: Timestamp) -> Result<File, FolderError> {
    let path = folder.join(LOCK);
    let open = OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(&path);
    let mut file = open.map_err(system(&path))?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            return Err(FolderError::InUse {
                path: folder.to_owned(),
                holder: holder_text(&path),
            });
        }
        Err(TryLockError::Error(source)) => return Err(system(&path)(source)),
    }
    let holder = format!(
        "process {} on {} since {}\n",
        std::process::id(),
        host(),
        now.strftime("%Y-%m-%d %H:%M:%S UTC")
    );
    let written = file
        .set_len(0)
        .and_then(|()| file.write_all(holder.as_bytes()))
        .and_then(|()| file.flush());
    written.map_err(system(&path))?;
    Ok(file)
}

/// Name of the machine, as far as the system reports it.
#[must_use]
pub fn host() -> String {
    let from_environment = ["HOSTNAME", "COMPUTERNAME"]
        .into_iter()
        .find_map(|name| std::env::var(name).ok());
    let name = from_environment.or_else(|| fs::read_to_string("/etc/hostname").ok());
    let name = name.map(|name| name.trim().to_owned());
    name.filter(|name| !name.is_empty())
        .unwrap_or_else(|| "this machine".to_owned())
}
