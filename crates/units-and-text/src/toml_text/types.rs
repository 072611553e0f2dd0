//! TOML texts as the types of a format.

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::nearest::nearest;
use crate::source_text::{PlacedError, SourceText};

use super::problem::{TomlError, TomlProblem, UnknownKey};
use super::{DocumentStep, Read, TomlDocument};

/// The content of a text, and the keys that belong to nothing in the format.
pub type Known<T> = (T, Vec<UnknownKey>);

/// The content of a TOML text in the types of a format, and the keys that belong to none of them.
///
/// # Errors
/// What is wrong, in the words of TOML, in its place.
pub fn read<T: DeserializeOwned + JsonSchema>(source: &SourceText) -> Read<Known<T>> {
    let (read, mut unknown) = read_strict(source)?;
    if !unknown.is_empty() {
        let mut known = Vec::new();
        collect_keys(&schemars::schema_for!(T).to_value(), &mut known);
        for key in &mut unknown {
            let last = key.key.rsplit('.').next().unwrap_or(&key.key);
            let meant = nearest(last, known.iter().map(String::as_str));
            key.meant = meant.map(str::to_owned);
        }
    }
    Ok((read, unknown))
}

/// The same for a format that refuses unknown keys itself, or passes them over.
///
/// # Errors
/// As [`read`].
pub fn read_types<T: DeserializeOwned>(source: &SourceText) -> Read<T> {
    read_strict(source).map(|(read, _)| read)
}

impl TomlDocument<'_> {
    /// The content in the types of a format that refuses unknown keys itself.
    ///
    /// # Errors
    /// What is wrong, in the words of TOML, in its place.
    pub fn types<T: DeserializeOwned>(&self) -> Read<T> {
        let deserializer = toml::Deserializer::from(self.root.clone());
        T::deserialize(deserializer).map_err(|error| TomlError::of_reader(self.source, &error))
    }
}

/// The content of a text, and the keys that were ignored, without a guess at what was meant.
fn read_strict<T: DeserializeOwned>(source: &SourceText) -> Read<Known<T>> {
    let wrong = |error: &toml::de::Error| TomlError::of_reader(source, error);
    let deserializer = toml::Deserializer::parse(&source.text).map_err(|error| wrong(&error))?;
    let document = TomlDocument::parse(source)?;
    let mut unknown = Vec::new();
    let read = serde_ignored::deserialize(deserializer, |path| {
        let mut steps = Vec::new();
        collect_steps(&path, &mut steps);
        let (line, column) = source.line_and_column(document.key_span(&steps).start);
        unknown.push(UnknownKey {
            key: path.to_string(),
            line,
            column,
            meant: None,
        });
    })
    .map_err(|error| wrong(&error))?;
    Ok((read, unknown))
}

impl TomlError {
    /// The error of the TOML reader, with its place and in the terms of the format.
    pub(super) fn of_reader(source: &SourceText, error: &toml::de::Error) -> Self {
        let problem = TomlProblem::Syntax(in_words_of_toml(error.message()));
        let span = error.span().unwrap_or(0..0);
        Self(PlacedError::new(source, span, problem))
    }
}

/// The way to an ignored key.
fn collect_steps<'a>(path: &'a serde_ignored::Path<'_>, steps: &mut Vec<DocumentStep<'a>>) {
    use serde_ignored::Path;
    match path {
        Path::Root => {}
        Path::Seq { parent, index } => {
            collect_steps(parent, steps);
            steps.push(DocumentStep::Index(*index));
        }
        Path::Map { parent, key } => {
            collect_steps(parent, steps);
            steps.push(DocumentStep::Key(key));
        }
        Path::Some { parent }
        | Path::NewtypeStruct { parent }
        | Path::NewtypeVariant { parent } => collect_steps(parent, steps),
    }
}

/// A message of the reader in the terms of the format; an unknown key or word with the nearest known one.
fn in_words_of_toml(message: &str) -> String {
    let message = match message.split_once("expected struct ") {
        Some((before, _)) => format!("{before}expected a table"),
        None => message.to_owned(),
    };
    let mut names = message.split('`').skip(1).step_by(2);
    let unknown = message.starts_with("unknown").then(|| names.next());
    let meant = unknown.flatten().and_then(|name| nearest(name, names));
    let advice = meant.map_or_else(String::new, |near| format!("; is `{near}` meant?"));
    [
        ("missing field", "missing key"),
        ("unknown field", "unknown key"),
        ("unknown variant", "unknown word"),
        ("expected f64", "expected a number"),
        ("expected i64", "expected a whole number"),
        ("a sequence", "an array"),
        ("a map", "a table"),
    ]
    .into_iter()
    .fold(message, |text, (from, to)| text.replace(from, to))
        + &advice
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

/// Takes out of the JSON Schema of a TOML format the `null` that JSON allows for a key that may be absent: TOML has none.
pub fn remove_null(schema: &mut Value) {
    if let Some(types) = schema.get_mut("type")
        && let Some([one, null]) = types.as_array().map(Vec::as_slice)
        && null == "null"
    {
        *types = one.clone();
    }
    if let Some(choices) = schema.get_mut("anyOf").and_then(Value::as_array_mut) {
        choices.retain(|choice| choice.get("type").is_none_or(|name| name != "null"));
        if let [only] = &choices[..]
            && let Some(reference) = only.get("$ref").cloned()
            && let Some(object) = schema.as_object_mut()
        {
            object.insert("$ref".to_owned(), reference);
            object.shift_remove("anyOf");
        }
    }
    match schema {
        Value::Object(object) => {
            object.retain(|key, value| key != "default" || !value.is_null());
            object.values_mut().for_each(remove_null);
        }
        Value::Array(entries) => entries.iter_mut().for_each(remove_null),
        _ => {}
    }
}
