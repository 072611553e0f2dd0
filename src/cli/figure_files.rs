//! Figures to files.

use std::path::{Path, PathBuf};

use crate::plot::{Figure, to_png};
use crate::session::write_whole;

use super::failure::{CliError, Failure};
use crate::analysis::{ArgumentError, Inputs, is_dash};

/// Pixels in a unit of the drawing: sharp on a page and on a screen.
const PNG_SCALE: f64 = 2.0;

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
        return Err(ArgumentError::new(
            path.display().to_string(),
            format!("figures are written as SVG and PNG, not as {other}"),
            "end the name with .svg or .png, or with nothing for both",
        )
        .into());
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
        write(&file, &bytes)?;
        written.push(file);
    }
    Ok(written)
}

/// Writes a whole file, and makes its folder if there is none.
///
/// # Errors
/// For a folder or file that cannot be written, and for `-`.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), CliError> {
    if is_dash(path) {
        return Err(CliError::Dash);
    }
    if let Some(folder) = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
    {
        std::fs::create_dir_all(folder).map_err(|source| CliError::Write {
            path: folder.to_owned(),
            source,
        })?;
    }
    write_whole(path, bytes).map_err(|source| CliError::Write {
        path: path.to_owned(),
        source,
    })
}

/// A name, for example of a mechanism, as a part of a file's name.
pub(super) fn file_part(name: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    name.chars()
        .map(|c| if plain(c) { c } else { '_' })
        .collect()
}
