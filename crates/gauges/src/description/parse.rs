//! From the text of an instrument description to the description.

use serde_json::Value;

use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::source_text::{SourceText, Step, UnknownKey};

use super::InstrumentDescription;
use super::compile::compile;
use super::file::{DescriptionFile, SCHEMA, json_schema};
use super::problem::{DescriptionError, DescriptionProblem};

/// A step into a file that is kept.
#[derive(Debug, Clone)]
pub(super) enum Place {
    /// Into a table.
    Key(String),
    /// Into an array.
    Index(usize),
}

impl From<&str> for Place {
    fn from(key: &str) -> Self {
        Self::Key(key.to_owned())
    }
}

impl From<usize> for Place {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

/// A problem and the way to it.
#[derive(Debug)]
pub(super) struct Misplaced {
    pub(super) path: Vec<Place>,
    pub(super) problem: DescriptionProblem,
}

/// The way to a key, for example `value[0].fields[2]`.
pub(super) fn key_of(path: &[Place]) -> String {
    let mut key = String::new();
    for place in path {
        match place {
            Place::Key(name) if key.is_empty() => key.push_str(name),
            Place::Key(name) => {
                key.push('.');
                key.push_str(name);
            }
            Place::Index(index) => {
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
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let source = SourceText::new(source_name, text);
        let (file, unknown) = source.read_toml::<DescriptionFile>().map_err(|problem| {
            schema_problem(&source, None).unwrap_or_else(|| {
                DescriptionError::at(
                    &source,
                    problem.span,
                    DescriptionProblem::Syntax(problem.message),
                )
            })
        })?;
        if let Some(error) = schema_problem(&source, Some(&file.schema)) {
            return Err(error);
        }
        let description = compile(file).map_err(|misplaced| {
            let path: Vec<Step<'_>> = misplaced
                .path
                .iter()
                .map(|place| match place {
                    Place::Key(key) => Step::Key(key),
                    Place::Index(index) => Step::Index(*index),
                })
                .collect();
            DescriptionError::at(&source, source.toml_span(&path), misplaced.problem)
        })?;
        let warnings = unknown.iter().map(|key| unknown_key(source_name, key));
        Ok((description, warnings.collect()))
    }
}

/// Another schema explains every other problem of a text, so it is told first.
fn schema_problem(source: &SourceText, read: Option<&str>) -> Option<DescriptionError> {
    let span = source.toml_span(&[Step::Key("schema")]);
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
        DescriptionError::at(source, span.clone(), problem)
    })
}

fn unknown_key(file: &str, unknown: &UnknownKey) -> String {
    let last = unknown.key.rsplit('.').next().unwrap_or(&unknown.key);
    let mut keys = Vec::new();
    collect_keys(&json_schema(), &mut keys);
    let advice = nearest(last, keys.iter().map(String::as_str))
        .map_or_else(String::new, |near| format!("; is `{near}` meant?"));
    format!(
        "{file}:{}:{}: key `{}` is not known and was not used{advice}",
        unknown.line, unknown.column, unknown.key
    )
}

/// All keys of a schema.
fn collect_keys(schema: &Value, keys: &mut Vec<String>) {
    if let Some(properties) = schema.get("properties").and_then(Value::as_object) {
        keys.extend(properties.keys().cloned());
    }
    match schema {
        Value::Object(object) => object.values().for_each(|part| collect_keys(part, keys)),
        Value::Array(parts) => parts.iter().for_each(|part| collect_keys(part, keys)),
        _ => {}
    }
}
