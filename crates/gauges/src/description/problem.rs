//! What can be wrong with an instrument description.

use std::ops::Range;
use std::sync::Arc;

use miette::{Diagnostic, NamedSource, SourceSpan};
use thiserror::Error;

use stiffbench_units_and_text::source_text::SourceText;

/// Why a description cannot be used; shows the place in the file.
#[derive(Debug, Error, Diagnostic)]
#[error("{file}:{line}:{column}: {problem}")]
#[diagnostic(code(stiffbench::instrument::description))]
pub struct DescriptionError {
    /// The file, or the name of a shipped description.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong.
    pub problem: Box<DescriptionProblem>,
    /// What to do about it.
    #[help]
    pub help: String,
    #[source_code]
    source_text: Arc<NamedSource<String>>,
    #[label("here")]
    span: SourceSpan,
}

impl DescriptionError {
    /// A problem at a place of a text.
    pub(super) fn at(source: &SourceText, span: Range<usize>, problem: DescriptionProblem) -> Self {
        let (line, column) = source.line_and_column(span.start);
        Self {
            file: source.name.clone(),
            line,
            column,
            help: problem.help(),
            problem: Box::new(problem),
            source_text: Arc::new(source.named_source()),
            span: span.into(),
        }
    }
}

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

impl DescriptionProblem {
    fn help(&self) -> String {
        match self {
            Self::Syntax(_) => {
                "docs/instrument-description.md lists the keys; copy a line of a shipped description (stiffbench instrument show NAME)"
                    .to_owned()
            }
            Self::Schema { known, .. } => {
                format!("write schema = \"{known}\", or take the version of this program that knows the other")
            }
            Self::Value { key, expected, .. } => format!("give `{key}` {expected}"),
            Self::Missing { key, .. } => format!("add `{key}`"),
            Self::Conflict { key, other, .. } => format!("take out `{key}` or `{other}`"),
        }
    }
}
