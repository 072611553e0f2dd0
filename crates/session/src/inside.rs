//! Files in a folder that somebody else may have made: no link is followed, and what is no file is not opened.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// The path of a file or folder in a folder that somebody else may have made, whether it is there or not.
///
/// # Errors
/// [`ErrorKind::InvalidInput`] for a link on the way, and for what is neither file nor folder: to open a pipe may take for ever, and a
/// device may have no end.
pub fn inside(folder: &Path, name: impl AsRef<Path>) -> io::Result<PathBuf> {
    let mut path = folder.to_owned();
    for part in name.as_ref() {
        path.push(part);
        let Ok(found) = path.symlink_metadata() else {
            continue;
        };
        if found.is_symlink() {
            return refused("a link, and links in a session folder are not followed");
        }
        if !found.is_file() && !found.is_dir() {
            return refused("a pipe or a device");
        }
    }
    Ok(path)
}

/// The bytes of a file in such a folder.
///
/// # Errors
/// As [`inside`]; those of the operating system.
pub fn read_inside(folder: &Path, name: impl AsRef<Path>) -> io::Result<Vec<u8>> {
    fs::read(inside(folder, name)?)
}

/// A file in such a folder, to add to it; it is made if it is not there.
///
/// # Errors
/// As [`inside`], also for a file that has a second name elsewhere; those of the operating system.
pub fn append_inside(folder: &Path, name: &str) -> io::Result<File> {
    let path = inside(folder, name)?;
    let file = OpenOptions::new().create(true).append(true).open(path)?;
    alone(file)
}

/// Refuses a file that is also another one.
pub(super) fn alone(file: File) -> io::Result<File> {
    #[cfg(unix)]
    if std::os::unix::fs::MetadataExt::nlink(&file.metadata()?) > 1 {
        return refused("a hard link: a file elsewhere is the same");
    }
    Ok(file)
}

fn refused<T>(what: &str) -> io::Result<T> {
    let text = format!("it is {what}");
    Err(io::Error::new(ErrorKind::InvalidInput, text))
}
