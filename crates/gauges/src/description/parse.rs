//! From the text of an instrument description to the description.

use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::{DocumentStep, read};

use super::InstrumentDescription;
use super::compile::compile;
use super::file::{DescriptionFile, SCHEMA};
use super::problem::{DescriptionError, DescriptionProblem};

/// A step into a file that is kept.
#[derive(Debug, Clone)]
pub(super) enum EntryPath {
    /// Into a table.
    Key(String),
    /// Into an array.
    Index(usize),
}

impl From<&str> for EntryPath {
    fn from(key: &str) -> Self {
        Self::Key(key.to_owned())
    }
}

impl From<usize> for EntryPath {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

/// A problem and the way to it.
#[derive(Debug)]
pub(super) struct Misplaced {
    pub(super) path: Vec<EntryPath>,
    pub(super) problem: DescriptionProblem,
}

/// The way to a key, for example `value[0].fields[2]`.
pub(super) fn key_of(path: &[EntryPath]) -> String {
    let mut key = String::new();
    for place in path {
        match place {
            EntryPath::Key(name) if key.is_empty() => key.push_str(name),
            EntryPath::Key(name) => {
                key.push('.');
                key.push_str(name);
            }
            EntryPath::Index(index) => {
                key.push('[');
                key.push_str(&index.to_string());
                key.push(']');
            }
        }
    }
    key
}

impl InstrumentDescription {
    /// Reads a description from the text of a file; also gives a warning for each key that means nothing.
    ///
    /// # Errors
    /// A text that is not TOML, not a description or a newer one, or in which something cannot be: with file, line, key, value and what to do.
    pub fn parse(text: &str, source_name: &str) -> Result<(Self, Vec<String>), DescriptionError> {
        let source = SourceText::new(source_name, text);
        let (file, unknown) = read::<DescriptionFile>(&source)
            .map_err(|error| schema_problem(&source, None).unwrap_or_else(|| error.into()))?;
        if let Some(error) = schema_problem(&source, Some(&file.schema)) {
            return Err(error);
        }
        let description = compile(file).map_err(|misplaced| {
            let path: Vec<DocumentStep<'_>> = misplaced
                .path
                .iter()
                .map(|place| match place {
                    EntryPath::Key(key) => DocumentStep::Key(key),
                    EntryPath::Index(index) => DocumentStep::Index(*index),
                })
                .collect();
            DescriptionError::new(&source, source.toml_span(&path), misplaced.problem)
        })?;
        let warnings = unknown.iter().map(|key| key.warning(source_name));
        Ok((description, warnings.collect()))
    }
}

/// Another schema explains every other problem of a text, so it is reported first.
fn schema_problem(source: &SourceText, read: Option<&str>) -> Option<DescriptionError> {
    let span = source.toml_span(&[DocumentStep::Key("schema")]);
    let written = || {
        source
            .text
            .get(span.clone())
            .map(|text| text.trim_matches(['"', '\'']))
    };
    let found = read.or_else(written).filter(|found| !found.is_empty())?;
    (found != SCHEMA).then(|| {
        let problem = DescriptionProblem::Schema {
            found: found.to_owned(),
            known: SCHEMA,
        };
        DescriptionError::new(source, span.clone(), problem)
    })
}
