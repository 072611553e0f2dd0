//! Files that are read whole.

use std::collections::BTreeSet;
use std::fs;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use crate::nearest::nearest;
use crate::session::inside;

/// Bytes of the largest file that is read: a device has no end, and memory has one.
const LARGEST: u64 = 1 << 28;

/// The files that a user named and that were read, by their true paths.
static INPUTS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

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
                ErrorKind::InvalidInput => "put the file itself in its place".to_owned(),
                ErrorKind::FileTooLarge => "name a smaller file, and no device".to_owned(),
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

/// Whether a path stands for standard input or standard output.
#[must_use]
pub fn is_dash(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// A path in words.
#[must_use]
pub fn shown(path: &Path) -> String {
    if is_dash(path) {
        "standard input".to_owned()
    } else {
        path.display().to_string()
    }
}

/// The bytes of standard input. They are there once, and looked at by every reader that tries whether they are of its form.
fn standard_input() -> std::io::Result<Vec<u8>> {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    if let Some(bytes) = BYTES.get() {
        return Ok(bytes.clone());
    }
    let bytes = read_whole(std::io::stdin().lock())?;
    Ok(BYTES.get_or_init(|| bytes).clone())
}

fn read_whole(source: impl Read) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    source.take(LARGEST + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LARGEST {
        let text = format!("it has more than {} MiB", LARGEST >> 20);
        return Err(std::io::Error::new(ErrorKind::FileTooLarge, text));
    }
    Ok(bytes)
}

fn inputs() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    INPUTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether this command has read a file, under any name.
#[must_use]
pub fn is_input(path: &Path) -> bool {
    let path = path.canonicalize();
    path.is_ok_and(|path| inputs().contains(&path))
}

/// Begins another command in the same process.
pub fn forget_inputs() {
    inputs().clear();
}

/// The path of a file of a session folder; `None` if there is none.
///
/// # Errors
/// As [`inside`].
pub fn session_file(folder: &Path, name: &str) -> Result<Option<PathBuf>, ReadError> {
    let path = inside(folder, name).map_err(ReadError::of(&folder.join(name)))?;
    Ok(path.is_file().then_some(path))
}

/// A text file in UTF-8; `-` is standard input.
///
/// # Errors
/// For a file that is not there, may not be read or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, ReadError> {
    String::from_utf8(read_bytes(path)?).map_err(|error| {
        let advice = "save it in UTF-8, for example: iconv -f UTF-16 -t UTF-8 FILE > NEW";
        match error.as_bytes() {
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => ReadError {
                path: path.to_owned(),
                source: std::io::Error::new(ErrorKind::InvalidData, "it is text in UTF-16"),
                advice: advice.to_owned(),
            },
            _ => {
                let source = std::io::Error::new(ErrorKind::InvalidData, error.utf8_error());
                ReadError::of(path)(source)
            }
        }
    })
}

/// The bytes of a file; `-` is standard input.
///
/// # Errors
/// For a file that is not there or may not be read.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, ReadError> {
    let read = if is_dash(path) {
        standard_input()
    } else {
        inputs().extend(path.canonicalize());
        fs::File::open(path).and_then(read_whole)
    };
    read.map_err(ReadError::of(path))
}

/// The first line of a file, which shows its form.
pub(super) fn first_line(path: &Path) -> Result<String, ReadError> {
    let mut head = Vec::new();
    let most = 512;
    if is_dash(path) {
        head = read_bytes(path)?;
        head.truncate(most);
    } else {
        fs::File::open(path)
            .and_then(|file| file.take(most as u64).read_to_end(&mut head))
            .map_err(ReadError::of(path))?;
    }
    let text = String::from_utf8_lossy(&head);
    Ok(text
        .trim_start_matches('\u{feff}')
        .lines()
        .next()
        .unwrap_or("")
        .to_owned())
}

/// Whether there is a file or folder of this name.
pub(super) fn is_there(path: &Path) -> bool {
    is_dash(path) || path.exists()
}

/// Whether there is a file of this name.
pub(super) fn is_file(path: &Path) -> bool {
    is_dash(path) || path.is_file()
}

/// The folder in which the other files of a session lie; beside standard input there are none.
pub(super) fn folder_of(file: &Path) -> PathBuf {
    if is_dash(file) {
        return file.to_owned();
    }
    file.parent().map(Path::to_owned).unwrap_or_default()
}
