//! Files that are read whole.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

/// A file that cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{path} cannot be read")]
#[diagnostic(
    code(stiffbench::input::read),
    help("check the permissions, and that it is a text file in UTF-8")
)]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// The error of the operating system.
    pub source: std::io::Error,
}

impl ReadError {
    /// Names the file of a failure.
    pub fn of(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        |source| Self { path, source }
    }
}

/// A text file in UTF-8.
///
/// # Errors
/// For a file that is not there, may not be read or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, ReadError> {
    fs::read_to_string(path).map_err(ReadError::of(path))
}

/// The bytes of a file.
///
/// # Errors
/// For a file that is not there or may not be read.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, ReadError> {
    fs::read(path).map_err(ReadError::of(path))
}

/// The first line of a file, which shows its form.
pub(super) fn first_line(path: &Path) -> Result<String, ReadError> {
    let mut head = [0; 512];
    let read = fs::File::open(path)
        .and_then(|mut file| file.read(&mut head))
        .map_err(ReadError::of(path))?;
    let text = String::from_utf8_lossy(&head[..read]);
    Ok(text
        .trim_start_matches('\u{feff}')
        .lines()
        .next()
        .unwrap_or("")
        .to_owned())
}

/// Whether there is a file or folder of this name.
pub(super) fn is_there(path: &Path) -> bool {
    path.exists()
}
