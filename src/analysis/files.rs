//! Files that are read whole.

use std::fs;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use crate::nearest::nearest;

/// A file that cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{path} cannot be read")]
#[diagnostic(code(stiffbench::input::read))]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// The error of the operating system.
    pub source: std::io::Error,
    /// What to do about it.
    #[help]
    pub advice: String,
}

impl ReadError {
    /// Names the file of a failure.
    pub fn of(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        |source| Self {
            advice: match source.kind() {
                ErrorKind::NotFound => instead_of(&path),
                ErrorKind::PermissionDenied => "check the permissions of the file".to_owned(),
                ErrorKind::IsADirectory => "name a file; this is a folder".to_owned(),
                _ => "check that it is a text file in UTF-8".to_owned(),
            },
            path,
            source,
        }
    }
}

/// What may be meant by a file that is not there.
fn instead_of(path: &Path) -> String {
    let parent = path.parent().unwrap_or(Path::new(""));
    let folder = if parent == Path::new("") {
        Path::new(".")
    } else {
        parent
    };
    let Ok(entries) = fs::read_dir(folder) else {
        return format!("there is no folder {}", folder.display());
    };
    let names: Vec<String> = entries
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    let wanted = path.file_name().unwrap_or_default().to_string_lossy();
    match nearest(&wanted, names.iter().map(String::as_str)) {
        Some(near) => format!("did you mean {}?", parent.join(near).display()),
        None => "check the name; paths start in the folder you are in".to_owned(),
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
