//! What can be wrong with an instrument description.

use std::fmt::Display;

use miette::Diagnostic;
use thiserror::Error;

use stiffbench_units_and_text::source_text::PlacedError;
use stiffbench_units_and_text::toml_text::TomlProblem;

/// Why a description cannot be used; shows the place in the file.
pub type DescriptionError = PlacedError<DescriptionProblem>;

/// What is wrong with a description.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DescriptionProblem {
    /// Not TOML, or a key that is missing or of the wrong kind.
    #[error("{0}")]
    Syntax(String),
    /// Another schema, or a newer one.
    #[error("`schema` is {found:?}, and only {known:?} is known")]
    Schema {
        /// What stands there.
        found: String,
        /// What is known.
        known: &'static str,
    },
    /// A value that cannot be.
    #[error("`{key}` is {value}: expected {expected}")]
    Value {
        /// The key.
        key: String,
        /// What stands there.
        value: String,
        /// What could.
        expected: String,
    },
    /// A key that is needed beside others.
    #[error("`{key}` is missing: {why}")]
    Missing {
        /// The key.
        key: String,
        /// Why it is needed.
        why: String,
    },
    /// Two keys that exclude each other.
    #[error("`{key}` and `{other}` exclude each other: {why}")]
    Conflict {
        /// The one.
        key: String,
        /// The other.
        other: String,
        /// Why.
        why: String,
    },
}

impl From<TomlProblem> for DescriptionProblem {
    fn from(problem: TomlProblem) -> Self {
        Self::Syntax(problem.to_string())
    }
}

impl Diagnostic for DescriptionProblem {
    fn code<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new("stiffbench::instrument::description"))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new(self.advice()))
    }
}

impl DescriptionProblem {
    fn advice(&self) -> String {
        match self {
            Self::Syntax(_) => {
                "docs/instrument-description.md lists the keys; copy a line of a shipped description (stiffbench gauge show NAME)"
                    .to_owned()
            }
            Self::Schema { known, .. } => {
                format!("write schema = \"{known}\", or use the version of this program that supports the other")
            }
            Self::Value { key, expected, .. } => format!("give `{key}` {expected}"),
            Self::Missing { key, .. } => format!("add `{key}`"),
            Self::Conflict { key, other, .. } => format!("take out `{key}` or `{other}`"),
        }
    }
}
