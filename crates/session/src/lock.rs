//! The lock of a session: which process has it. It is on the journal, the file that is written, and where the system can on the folder, so that a
//! journal that another program puts in the place of the first is locked too; `session.lock` only states whose it is.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use jiff::Timestamp;

use super::folder::{FolderError, JOURNAL, put, system};
use super::inside::{alone, inside, read_inside};
use super::journal::Store;
use super::whole_file::replace;

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
    let free = lock_folder(folder, File::try_lock_shared);
    match free
        .and_then(|_free| opened(folder, OpenOptions::new().read(true), File::try_lock_shared))
    {
        Ok(_) => FolderHolder::Nobody,
        Err(TryLockError::WouldBlock) => FolderHolder::Process(holder_text(folder)),
        Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::NotFound => {
            FolderHolder::Nobody
        }
        Err(TryLockError::Error(_)) => FolderHolder::Unknown,
    }
}

/// Locks the folder itself; `None` where the system cannot.
fn lock_folder(
    folder: &Path,
    lock: fn(&File) -> Result<(), TryLockError>,
) -> Result<Option<File>, TryLockError> {
    let Some(file) = File::open(folder).ok().filter(|_| cfg!(unix)) else {
        return Ok(None);
    };
    match lock(&file) {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => Err(TryLockError::WouldBlock),
        Err(TryLockError::Error(_)) => Ok(None),
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

/// The journal of a session on the disk, locked as long as it is open. If another program cuts it, deletes it or puts another file in its
/// place meanwhile, it is written again whole with the next event.
#[derive(Debug)]
pub struct JournalFile {
    folder: PathBuf,
    file: File,
    /// All that it holds.
    whole: Vec<u8>,
    /// The folder, locked.
    _locked: Option<File>,
}

impl JournalFile {
    /// Whether the file of this name is the one that is open, as long as it should be.
    fn is_there(&self) -> io::Result<bool> {
        let Ok(there) = self.folder.join(JOURNAL).symlink_metadata() else {
            return Ok(false);
        };
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            let open = self.file.metadata()?;
            if (open.dev(), open.ino()) != (there.dev(), there.ino()) {
                return Ok(false);
            }
        }
        Ok(there.len() == self.whole.len() as u64)
    }

    /// Cuts it behind so many bytes, and ends the last line if it has no end.
    pub(super) fn cut(&mut self, bytes: usize) -> io::Result<()> {
        self.file.set_len(bytes as u64)?;
        self.whole.truncate(bytes);
        if self.whole.last().is_some_and(|last| *last != b'\n') {
            self.write_all(b"\n")?;
        }
        self.file.sync_all()
    }
}

impl Write for JournalFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.whole.extend_from_slice(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Store for JournalFile {
    fn sync(&mut self) -> io::Result<()> {
        self.file.sync_data()?;
        if !self.is_there()? {
            replace(&self.folder.join(JOURNAL), &self.whole)?;
            let options = &mut OpenOptions::new();
            self.file = opened(&self.folder, options.append(true), File::try_lock)?;
        }
        Ok(())
    }
}

/// Opens the journal of a folder for this process alone, and states whose it is.
pub(super) fn open_alone(
    folder: &Path,
    options: &mut OpenOptions,
    now: Timestamp,
) -> Result<JournalFile, FolderError> {
    let journal = folder.join(JOURNAL);
    let locked = lock_folder(folder, File::try_lock);
    let both = locked.and_then(|locked| Ok((locked, opened(folder, options, File::try_lock)?)));
    let (locked, file) = match both {
        Ok((locked, file)) => (locked, alone(file).map_err(system(&journal))?),
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
    Ok(JournalFile {
        folder: folder.to_owned(),
        file,
        whole: read_inside(folder, JOURNAL).map_err(system(&journal))?,
        _locked: locked,
    })
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
