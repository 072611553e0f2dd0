//! The lock of a session: which process has it. It is on the journal, the file that is written; `session.lock` only states whose it is.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::Path;

use jiff::Timestamp;

use super::folder::{FolderError, JOURNAL, put, system};
use super::inside::{alone, inside, read_inside};

/// Name of the file that states who has the session; it stays when nobody has.
const HOLDER: &str = "session.lock";

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
    match opened(folder, OpenOptions::new().read(true), File::try_lock_shared) {
        Ok(_) => FolderHolder::Nobody,
        Err(TryLockError::WouldBlock) => FolderHolder::Process(holder_text(folder)),
        Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::NotFound => {
            FolderHolder::Nobody
        }
        Err(TryLockError::Error(_)) => FolderHolder::Unknown,
    }
}

/// Opens the journal and locks it until it is closed. Windows would keep others from reading what is locked; there a file that is open in
/// this way cannot be opened by a second process in the same way.
fn opened(
    folder: &Path,
    options: &mut OpenOptions,
    lock: fn(&File) -> Result<(), TryLockError>,
) -> Result<File, TryLockError> {
    #[cfg(windows)]
    std::os::windows::fs::OpenOptionsExt::share_mode(options, OTHERS_MAY_READ);
    let path = inside(folder, JOURNAL).map_err(TryLockError::Error)?;
    let file = options.open(path).map_err(|error| {
        if cfg!(windows) && error.raw_os_error() == Some(SHARING_VIOLATION) {
            TryLockError::WouldBlock
        } else {
            TryLockError::Error(error)
        }
    })?;
    if cfg!(not(windows)) {
        lock(&file)?;
    }
    Ok(file)
}

/// `FILE_SHARE_READ` of Windows.
#[cfg(windows)]
const OTHERS_MAY_READ: u32 = 1;

/// `ERROR_SHARING_VIOLATION` of Windows.
const SHARING_VIOLATION: i32 = 32;

/// What is stated of the process that has a folder.
fn holder_text(folder: &Path) -> String {
    let holder = read_inside(folder, HOLDER).unwrap_or_default();
    match String::from_utf8_lossy(&holder).trim() {
        "" => "another process".to_owned(),
        holder => holder.to_owned(),
    }
}

/// Opens the journal of a folder for this process alone, and states whose it is.
pub(super) fn open_alone(
    folder: &Path,
    options: &mut OpenOptions,
    now: Timestamp,
) -> Result<File, FolderError> {
    let journal = folder.join(JOURNAL);
    let file = match opened(folder, options, File::try_lock) {
        Ok(file) => alone(file).map_err(system(&journal))?,
        Err(TryLockError::WouldBlock) => {
            return Err(FolderError::InUse {
                path: folder.to_owned(),
                holder: holder_text(folder),
            });
        }
        Err(TryLockError::Error(source)) => return Err(system(&journal)(source)),
    };
    let holder = format!(
        "process {} on {} since {}\n",
        std::process::id(),
        host(),
        now.strftime("%Y-%m-%d %H:%M:%S UTC")
    );
    put(&folder.join(HOLDER), holder.as_bytes())?;
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
