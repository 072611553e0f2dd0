//! Instrument descriptions by name: the user's own, then the shipped ones.

use crate::analysis::{AnalysisError, read_text};
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::instrument::InstrumentDescription;
use crate::shipped::{shipped_instruments, unknown_name};

use crate::cli::failure::Failure;

/// Where descriptions come from besides the shipped ones.
#[derive(Debug, Clone, Default, Args)]
pub struct ProtocolsArgs {
    /// Folder with your own descriptions in FOLDER/instruments/*.toml; they take precedence over shipped ones of the same name
    #[arg(long, value_name = "FOLDER")]
    pub protocols: Option<PathBuf>,
}

/// A description with where it comes from and what a user should know of its file.
pub(in crate::cli) struct LocatedDescription {
    /// The description.
    pub(in crate::cli) description: InstrumentDescription,
    /// The file; `None` for a shipped one.
    pub(in crate::cli) path: Option<PathBuf>,
    /// Its text.
    pub(in crate::cli) toml: String,
    /// Keys that mean nothing, and the like.
    pub(in crate::cli) warnings: Vec<String>,
}

/// The description of a name, or of a file.
pub(in crate::cli) fn find_description(
    name: &str,
    protocols: &ProtocolsArgs,
) -> Result<LocatedDescription, Failure> {
    let path = Path::new(name);
    if path
        .extension()
        .is_some_and(|extension| extension == "toml")
        && path.is_file()
    {
        return read_description(path);
    }
    let own = own_files(protocols)?;
    let own_name = |path: &PathBuf| path.file_stem().is_some_and(|stem| stem == name);
    if let Some(path) = own.iter().find(|path| own_name(path)) {
        return read_description(path);
    }
    if let Some(found) = shipped().find(|found| found.description.name == name) {
        return Ok(found);
    }
    let own = own.iter().filter_map(|path| path.file_stem()?.to_str());
    let known: Vec<&str> = own
        .chain(shipped_instruments().iter().map(|shipped| shipped.name))
        .collect();
    Err(unknown_name(name, known.into_iter()).into())
}

/// All descriptions, the user's own first; of those that cannot be used, why.
pub(in crate::cli) fn all_descriptions(
    protocols: &ProtocolsArgs,
) -> Result<(Vec<LocatedDescription>, Vec<String>), Failure> {
    let (mut found, mut problems) = (Vec::new(), Vec::new());
    for path in own_files(protocols)? {
        match read_description(&path) {
            Ok(own) => found.push(own),
            Err(failure) => problems.push(format!("left out: {}", failure.message())),
        }
    }
    for shipped in shipped() {
        let hidden = found
            .iter()
            .any(|own: &LocatedDescription| own.description.name == shipped.description.name);
        if !hidden {
            found.push(shipped);
        }
    }
    Ok((found, problems))
}

/// The shipped descriptions; that each of them can be read is tested.
fn shipped() -> impl Iterator<Item = LocatedDescription> {
    shipped_instruments().iter().filter_map(|shipped| {
        let (description, warnings) =
            InstrumentDescription::parse(shipped.text, shipped.name).ok()?;
        Some(LocatedDescription {
            description,
            path: None,
            toml: shipped.text.to_owned(),
            warnings,
        })
    })
}

/// The description in a file. Its name is that of the file, so that it is found by it.
pub(in crate::cli) fn read_description(path: &Path) -> Result<LocatedDescription, Failure> {
    let toml = read_text(path)?;
    let (description, mut warnings) =
        InstrumentDescription::parse(&toml, &path.display().to_string())?;
    if path
        .file_stem()
        .is_some_and(|stem| stem != description.name.as_str())
    {
        warnings.push(format!(
            "{}: its name is {}, and by --protocols it is found under the name of the file: make them equal",
            path.display(),
            description.name
        ));
    }
    Ok(LocatedDescription {
        description,
        path: Some(path.to_owned()),
        toml,
        warnings,
    })
}

/// The user's own files, by name.
fn own_files(protocols: &ProtocolsArgs) -> Result<Vec<PathBuf>, Failure> {
    let Some(folder) = &protocols.protocols else {
        return Ok(Vec::new());
    };
    let folder = folder.join("instruments");
    let entries = fs::read_dir(&folder).map_err(|_| AnalysisError::NotFound {
        path: folder.clone(),
        help: "--protocols DIR takes a folder that has descriptions in DIR/instruments/*.toml"
            .to_owned(),
    })?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    files.sort();
    Ok(files)
}
