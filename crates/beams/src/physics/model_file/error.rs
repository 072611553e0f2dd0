//! What can be wrong with a model file.

use std::ops::Range;
use std::sync::Arc;

use miette::{NamedSource, SourceSpan};

use crate::physics::effect_text::EffectProblem;
use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::source_text::SourceText;

/// A model file that is wrong at one place.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{file}:{line}:{column}: {problem}")]
#[diagnostic(code(stiffbench::physics::model_file))]
pub struct ModelFileError {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong.
    pub problem: Box<ModelProblem>,
    /// What to do about it.
    #[help]
    pub help: Option<String>,
    /// The text, for quoting.
    #[source_code]
    pub source_text: Arc<NamedSource<String>>,
    /// The place.
    #[label("here")]
    pub span: SourceSpan,
}

/// What is wrong at one place of a model file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelProblem {
    /// Not TOML.
    #[error("{0}")]
    Syntax(String),
    /// Another schema, or a newer version.
    #[error("the schema is `{found}`, this version reads `{expected}`")]
    Schema {
        /// What the file says.
        found: String,
        /// What is known.
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
        key: &'static str,
        /// The table.
        table: String,
    },
    /// A value of another type, or out of range.
    #[error("`{key}` must be {expected}")]
    Value {
        /// The key.
        key: String,
        /// What it must be.
        expected: &'static str,
    },
    /// An effect that is none.
    #[error(transparent)]
    Effect(EffectProblem),
}

impl ModelProblem {
    fn help(&self) -> Option<String> {
        match self {
            Self::UnknownKey { key, known, .. } => {
                Some(match nearest(key, known.iter().copied()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None if known.is_empty() => "it is empty".to_owned(),
                    None => format!("it may have {}", known.join(", ")),
                })
            }
            Self::Schema { expected, .. } => Some(format!(
                "write schema = \"{expected}\", or use the version of the program that wrote the file"
            )),
            Self::Effect(problem) => problem.help(),
            Self::Syntax(_) | Self::Missing { .. } | Self::Value { .. } => None,
        }
    }
}

impl ModelFileError {
    /// An error at a byte range of a file.
    pub(super) fn at(source: &SourceText, span: Range<usize>, problem: ModelProblem) -> Self {
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
