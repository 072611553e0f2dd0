//! Figures to files.

use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use crate::plot::{Figure, to_png};
use crate::session::write_whole;

use rayon::prelude::*;

use super::{CliError, Failure, Outcome};
use crate::analysis::{ArgumentError, Inputs, is_dash, is_input};

/// Pixels in a unit of the drawing: sharp on a page and on a screen.
const PNG_SCALE: f64 = 2.0;

/// Bytes by which results of one kind are alike.
const KIND_BYTES: usize = 5;

/// Endings that ask for a format there is not; any other ending is part of the name.
const OTHER_FORMATS: [&str; 9] = [
    "pdf", "eps", "ps", "jpg", "jpeg", "gif", "tif", "tiff", "webp",
];

/// Writes a figure, its inputs before the caption, as `path.svg` and `path.png`, or one of them if the name ends so; returns what was written.
///
/// # Errors
/// For another format, or a file that cannot be written.
pub fn write_figure(
    path: &Path,
    figure: &Figure,
    inputs: &Inputs,
) -> Result<Vec<PathBuf>, Failure> {
    let wanted = path
        .extension()
        .and_then(|extension| extension.to_str())
        .map(str::to_lowercase);
    if let Some(other) = wanted
        .as_deref()
        .filter(|wanted| OTHER_FORMATS.contains(wanted))
    {
        return ArgumentError::refuse(
            path.display().to_string(),
            format!("figures are written as SVG and PNG, not as {other}"),
            "end the name with .svg or .png, or with nothing for both",
        );
    }
    let base = match wanted.as_deref() {
        Some("svg" | "png") => path.with_extension(""),
        _ => path.to_owned(),
    };
    let svg = inputs.on(figure).to_svg();
    let mut written = Vec::new();
    for extension in ["svg", "png"] {
        if wanted
            .as_deref()
            .is_some_and(|wanted| ["svg", "png"].contains(&wanted) && wanted != extension)
        {
            continue;
        }
        let mut name = base.clone().into_os_string();
        name.push(format!(".{extension}"));
        let file = PathBuf::from(name);
        let bytes = if extension == "svg" {
            svg.clone().into_bytes()
        } else {
            to_png(&svg, PNG_SCALE)?
        };
        write_again(&file, &bytes)?;
        written.push(file);
    }
    Ok(written)
}

/// Writes figures into a folder, each under its name, on all cores; returns what was written.
///
/// # Errors
/// As [`write_figure`].
pub(super) fn write_figures(
    folder: &Path,
    figures: Vec<(impl AsRef<Path> + Send, Figure)>,
    inputs: &Inputs,
) -> Result<Vec<PathBuf>, Failure> {
    let figures = figures.into_par_iter();
    let written = figures.map(|(name, figure)| write_figure(&folder.join(name), &figure, inputs));
    let written: Vec<Vec<PathBuf>> = written.collect::<Result<_, Failure>>()?;
    Ok(written.concat())
}

/// Writes a new file whole, and makes its folder if there is none.
///
/// # Errors
/// For a file that exists and is not empty, a folder or file that cannot be written, and for `-`.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), CliError> {
    put(path, bytes, false)
}

/// Writes a result of which an earlier one of the same kind may be there: that one is replaced.
///
/// # Errors
/// As [`write()`], but for an earlier one.
pub fn write_again(path: &Path, bytes: &[u8]) -> Result<(), CliError> {
    put(path, bytes, true)
}

/// Writes texts into a folder, each under its name; returns what was written.
pub(super) fn write_texts(
    folder: &Path,
    texts: impl IntoIterator<Item = (impl AsRef<Path>, String)>,
) -> Result<Vec<PathBuf>, CliError> {
    let texts = texts.into_iter();
    let written = texts.map(|(name, text)| {
        let path = folder.join(name);
        write_again(&path, text.as_bytes())?;
        Ok(path)
    });
    written.collect()
}

/// Writes a result into a folder, for people and as what `--json` prints; returns what was written.
///
/// # Arguments
/// - `files`: names of the text and of the JSON.
pub(super) fn write_result(
    folder: &Path,
    files: [&str; 2],
    result: &Outcome,
) -> Result<Vec<PathBuf>, CliError> {
    write_texts(folder, files.into_iter().zip(result.texts()))
}

/// Writes a file that must not exist, whoever else writes at the same time.
pub(super) fn write_new(path: &Path, text: &str) -> Result<(), CliError> {
    let mut file = File::create_new(path).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => CliError::FileExists {
            path: path.to_owned(),
        },
        _ => CliError::write(path)(error),
    })?;
    file.write_all(text.as_bytes()).map_err(|error| {
        // On a full disk no part of it is left.
        let _ = std::fs::remove_file(path);
        CliError::write(path)(error)
    })
}

/// Refuses a file that exists before work is done for it.
pub(super) fn check_new(path: &Path) -> Result<(), CliError> {
    if path.exists() {
        let path = path.to_owned();
        return Err(CliError::FileExists { path });
    }
    Ok(())
}

fn put(path: &Path, bytes: &[u8], replaces_earlier: bool) -> Result<(), CliError> {
    if is_dash(path) {
        return Err(CliError::Dash);
    }
    let is_earlier = || replaces_earlier && !path.is_symlink() && !is_input(path);
    if is_filled_file(path) && !(is_earlier() && begins_as(path, bytes)) {
        let path = path.to_owned();
        return Err(CliError::FileExists { path });
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
    }
    write_whole(path, bytes).map_err(CliError::write(path))
}

/// Whether there is a file that holds something; a pipe or a device is none.
fn is_filled_file(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() > 0)
}

/// Whether a file begins as these bytes: the mark of its format, or the first words of a result.
fn begins_as(path: &Path, bytes: &[u8]) -> bool {
    let mut begin = [0; KIND_BYTES];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut begin));
    read.is_ok() && bytes.starts_with(&begin)
}

/// A name, for example of a mechanism, as a part of a file's name.
pub(super) fn file_part(name: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    name.chars()
        .map(|c| if plain(c) { c } else { '_' })
        .collect()
}
