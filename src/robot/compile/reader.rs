//! From text to the types of the file, with its errors in the words of TOML.

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::file::RobotFile;
use crate::source_text::SourceText;
use crate::source_text::Step::{self, Index, Key};

/// The file's types from its text, and a warning for each key that belongs to none of them.
pub(super) fn deserialize(source: &SourceText) -> Result<(RobotFile, Vec<String>), RobotError> {
    let syntax = |error: &toml::de::Error| {
        let span = error.span().unwrap_or(0..0);
        let problem = RobotProblem::Syntax(in_words_of_toml(error.message()));
        RobotError::at(source, span, problem, None)
    };
    let deserializer = toml::Deserializer::parse(&source.text).map_err(|error| syntax(&error))?;
    let spans = source.toml_spans();
    let mut warnings = Vec::new();
    let file = serde_ignored::deserialize(deserializer, |path| {
        let mut steps = Vec::new();
        collect_steps(&path, &mut steps);
        let start = spans.as_ref().map_or(0, |spans| spans.key(&steps).start);
        let (line, column) = source.line_and_column(start);
        let file = &source.name;
        let key = path.to_string();
        warnings.push(format!(
            "{file}:{line}:{column}: key `{key}` is not known and was not used"
        ));
    })
    .map_err(|error| syntax(&error))?;
    Ok((file, warnings))
}

/// The way to an ignored key.
fn collect_steps<'a>(path: &'a serde_ignored::Path<'_>, steps: &mut Vec<Step<'a>>) {
    use serde_ignored::Path;
    match path {
        Path::Root => {}
        Path::Seq { parent, index } => {
            collect_steps(parent, steps);
            steps.push(Index(*index));
        }
        Path::Map { parent, key } => {
            collect_steps(parent, steps);
            steps.push(Key(key));
        }
        Path::Some { parent }
        | Path::NewtypeStruct { parent }
        | Path::NewtypeVariant { parent } => collect_steps(parent, steps),
    }
}

/// A message of the reader in words that the author of a TOML file knows.
fn in_words_of_toml(message: &str) -> String {
    let message = match message.split_once("expected struct ") {
        Some((before, _)) => format!("{before}expected a table"),
        None => message.to_owned(),
    };
    [
        ("missing field", "missing key"),
        ("unknown variant", "unknown word"),
        ("expected f64", "expected a number"),
        ("expected i64", "expected a whole number"),
        ("a sequence", "an array"),
        ("a map", "a table"),
    ]
    .into_iter()
    .fold(message, |text, (from, to)| text.replace(from, to))
}
