//! What can be wrong with a TOML text, whatever its format.

use std::fmt::Display;

use miette::Diagnostic;
use thiserror::Error;

use crate::nearest::nearest;
use crate::source_text::PlacedError;

/// What is wrong at one place of a TOML text.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum TomlProblem {
    /// Not TOML, or not of the types of a format.
    #[error("{0}")]
    Syntax(String),
    /// A text without a schema.
    #[error("no `schema`, expected `{expected}`")]
    NoSchema {
        /// What was expected.
        expected: &'static str,
    },
    /// A text of another kind.
    #[error("`{key}` is `{found}`, expected `{expected}`")]
    OtherSchema {
        /// The key with its tables.
        key: String,
        /// Its content.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A text that is newer than this program.
    #[error("`{key}` is `{found}`; this program supports up to `{expected}`")]
    NewerSchema {
        /// The key with its tables.
        key: String,
        /// Its content.
        found: String,
        /// The newest known.
        expected: &'static str,
    },
    /// A key that the format does not have.
    #[error("there is no key `{key}` in {table}")]
    UnknownKey {
        /// The key.
        key: String,
        /// The table.
        table: String,
        /// The keys it may have.
        known: Vec<&'static str>,
    },
    /// A key that is missing.
    #[error("`{key}` is missing in {table}")]
    Missing {
        /// The key.
        key: String,
        /// The table.
        table: String,
    },
    /// A value of another type, or out of range.
    #[error("`{key}` is {found}, expected {expected}")]
    Value {
        /// The key with its tables.
        key: String,
        /// What stands there.
        found: String,
        /// What belongs there.
        expected: &'static str,
    },
    /// A key that stands in its table twice, with different units.
    #[error("`{key}` is given twice, in two units")]
    GivenTwice {
        /// The key without unit.
        key: String,
    },
    /// A key that ends in a unit of another quantity, or in none.
    #[error("`{key}` has the unit `{unit}`, expected one of {accepted}")]
    Unit {
        /// The key with its tables.
        key: String,
        /// The unit found.
        unit: String,
        /// The units that would do.
        accepted: &'static str,
    },
}

impl TomlProblem {
    /// What to do about it.
    fn advice(&self) -> String {
        match self {
            Self::Syntax(_) => {
                "the file must be TOML: `key = value` lines under `[table]` headings".to_owned()
            }
            Self::NoSchema { expected } => format!("start the file with: schema = \"{expected}\""),
            Self::OtherSchema { .. } => "this file is not of the expected kind".to_owned(),
            Self::NewerSchema { .. } => {
                "read it with a newer version of stiffbench; the file was not changed".to_owned()
            }
            Self::UnknownKey { key, known, .. } => match nearest(key, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None if known.is_empty() => "it is empty".to_owned(),
                None => format!("it may have {}", known.join(", ")),
            },
            Self::Missing { key, .. } => format!("add `{key}`"),
            Self::Value { .. } => "correct the value, or leave the key out".to_owned(),
            Self::GivenTwice { .. } => "leave one of them out".to_owned(),
            Self::Unit { .. } => {
                "the unit follows the last underscore of the key: range_N, resolution_um".to_owned()
            }
        }
    }

    /// The problem in one word, the last part of an error code.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Syntax(_) => "syntax",
            Self::NoSchema { .. } => "no_schema",
            Self::OtherSchema { .. } => "other_schema",
            Self::NewerSchema { .. } => "newer_schema",
            Self::UnknownKey { .. } => "unknown_key",
            Self::Missing { .. } => "missing_key",
            Self::Value { .. } => "wrong_value",
            Self::GivenTwice { .. } => "given_twice",
            Self::Unit { .. } => "wrong_unit",
        }
    }
}

impl Diagnostic for TomlProblem {
    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new(self.advice()))
    }
}

/// A problem in its place; becomes the error of a format whose problems these are among.
#[derive(Debug, Clone)]
pub struct TomlError(pub PlacedError<TomlProblem>);

impl<P: From<TomlProblem> + Diagnostic> From<TomlError> for PlacedError<P> {
    fn from(error: TomlError) -> Self {
        error.0.map(P::from)
    }
}

/// A key that means nothing in its format and was passed over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownKey {
    /// Its whole path, for example `line.bauds`.
    pub key: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The key that may be meant.
    pub meant: Option<String>,
}

impl UnknownKey {
    /// The warning for it in a file.
    #[must_use]
    pub fn warning(&self, file: &str) -> String {
        let Self {
            key, line, column, ..
        } = self;
        let advice = self.advice();
        format!("{file}:{line}:{column}: key `{key}` is not known and was not used{advice}")
    }

    /// What may be meant, to be put behind a sentence; empty if nothing is near.
    #[must_use]
    pub fn advice(&self) -> String {
        let meant = self.meant.as_ref();
        meant.map_or_else(String::new, |near| format!("; is `{near}` meant?"))
    }
}
