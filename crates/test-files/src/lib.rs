//! What the tests of several crates share: files of this repository, a folder to run a program in, and comparison with kept outputs.
//!
//! The program embeds what it ships (`src/shipped` of the root package). A library crate embeds nothing outside its own folder, so its tests
//! read the same files here.

#![expect(
    clippy::unwrap_used,
    clippy::must_use_candidate,
    clippy::return_self_not_must_use,
    reason = "a test stops at what is not as it must be, and runs commands for what they do"
)]

pub mod desk;
pub mod goldens;
pub mod schemas;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use stiffbench_units_and_text::source_text::SourceText;

/// A shipped file: its name without the ending, and its text.
#[derive(Debug, Clone, Copy)]
pub struct ShippedFile {
    /// Name without `.toml`.
    pub name: &'static str,
    /// Text.
    pub text: &'static str,
}

static ROBOTS: LazyLock<Vec<ShippedFile>> = LazyLock::new(|| shipped("data/robots"));
static PROCEDURES: LazyLock<Vec<ShippedFile>> = LazyLock::new(|| shipped("protocols/procedures"));
static INSTRUMENTS: LazyLock<Vec<ShippedFile>> = LazyLock::new(|| shipped("protocols/instruments"));

/// The folder of the repository.
///
/// # Panics
/// If this crate does not lie two folders below it.
#[must_use]
pub fn repository() -> &'static Path {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    crates
        .and_then(Path::parent)
        .expect("this crate lies in crates/test-files of the repository")
}

/// The README and all pages of the documentation, from the folder of the repository.
///
/// # Panics
/// If the folder of the pages cannot be read.
pub fn documentation() -> Vec<PathBuf> {
    let folder = fs::read_dir(repository().join("docs")).unwrap();
    let pages = folder.map(|entry| PathBuf::from("docs").join(entry.unwrap().file_name()));
    let is_page = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "md");
    let mut pages: Vec<PathBuf> = pages.filter(is_page).collect();
    pages.push(PathBuf::from("README.md"));
    pages.sort();
    pages
}

/// The text of a file, by its path from the folder of the repository.
///
/// # Panics
/// If there is no such file.
#[must_use]
pub fn text(path: &str) -> &'static str {
    read(&repository().join(path))
}

/// The first example of a language in a page, by the path of the page.
///
/// # Panics
/// If the page has none.
#[must_use]
pub fn example(page: &str, language: &str) -> &'static str {
    let begins = text(page).split_once(&format!("```{language}\n"));
    let (_, rest) = begins.expect("the page has an example");
    rest.split_once("```").expect("the example ends").0
}

/// Names of the shipped robots.
pub fn shipped_robots() -> impl Iterator<Item = &'static str> {
    ROBOTS.iter().map(|file| file.name)
}

/// Text of a shipped robot.
#[must_use]
pub fn shipped_robot(name: &str) -> Option<SourceText> {
    source(&ROBOTS, name)
}

/// Names of the shipped procedures.
pub fn shipped_procedures() -> impl Iterator<Item = &'static str> {
    PROCEDURES.iter().map(|file| file.name)
}

/// Text of a shipped procedure.
#[must_use]
pub fn shipped_procedure(name: &str) -> Option<SourceText> {
    source(&PROCEDURES, name)
}

/// The shipped instrument descriptions.
#[must_use]
pub fn shipped_instruments() -> &'static [ShippedFile] {
    &INSTRUMENTS
}

/// The TOML files of a folder, by name.
fn shipped(folder: &str) -> Vec<ShippedFile> {
    let folder = repository().join(folder);
    let entries = fs::read_dir(&folder).expect("the folder is in the repository");
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.expect("the folder can be read").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .collect();
    paths.sort();
    let name = |path: &Path| {
        path.file_stem()
            .and_then(|stem| stem.to_str())
            .map(str::to_owned)
    };
    paths
        .iter()
        .map(|path| ShippedFile {
            name: name(path).expect("names are ASCII").leak(),
            text: read(path),
        })
        .collect()
}

fn source(files: &[ShippedFile], name: &str) -> Option<SourceText> {
    let found = files.iter().find(|file| file.name == name)?;
    Some(SourceText::new(found.name, found.text))
}

/// Kept for as long as the tests run.
fn read(path: &Path) -> &'static str {
    fs::read_to_string(path)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        .leak()
}
