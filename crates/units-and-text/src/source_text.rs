//! Where in a text something stands, so that an error can point at it; TOML texts as the types of a format.
//!
//! Leaf module.

use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A named text: a file's content under the name the user knows it by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceText {
    /// Path or shipped name.
    pub name: String,
    /// The whole text.
    pub text: String,
}

/// One step into a TOML document.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step<'a> {
    /// Into a table.
    Key(&'a str),
    /// Into an array.
    Index(usize),
}

impl SourceText {
    /// A text under a name.
    #[must_use]
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            text: text.into(),
        }
    }

    /// Line and column of a byte offset, both from 1; columns count characters.
    #[must_use]
    pub fn line_and_column(&self, offset: usize) -> (usize, usize) {
        let mut end = offset.min(self.text.len());
        while !self.text.is_char_boundary(end) {
            end -= 1;
        }
        let before = &self.text[..end];
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        (line, column)
    }

    /// Bytes of the value at `path` in this TOML text; of the longest part of the path that exists otherwise.
    #[must_use]
    pub fn toml_span(&self, path: &[Step<'_>]) -> Range<usize> {
        self.toml_spans().map_or(0..0, |spans| spans.value(path))
    }

    /// Bytes of the key that the last step of `path` names; of the value if the path does not end at a key that exists.
    #[must_use]
    pub fn toml_key_span(&self, path: &[Step<'_>]) -> Range<usize> {
        self.toml_spans().map_or(0..0, |spans| spans.key(path))
    }

    /// The keys of the table at `path` in this TOML text, of the whole text for an empty path; none if there is no such table.
    #[must_use]
    pub fn toml_keys(&self, path: &[Step<'_>]) -> Vec<String> {
        let names =
            |table: &DeTable<'_>| table.keys().map(|key| key.get_ref().to_string()).collect();
        let Ok(document) = DeTable::parse(&self.text) else {
            return Vec::new();
        };
        let Some((first, rest)) = path.split_first() else {
            return names(document.get_ref());
        };
        let Step::Key(first) = first else {
            return Vec::new();
        };
        let mut value = document.get_ref().get(*first).map(Spanned::get_ref);
        for step in rest {
            value = match (step, value) {
                (Step::Key(key), Some(DeValue::Table(table))) => {
                    table.get(*key).map(Spanned::get_ref)
                }
                (Step::Index(index), Some(DeValue::Array(array))) => {
                    array.get(*index).map(Spanned::get_ref)
                }
                _ => None,
            };
        }
        match value {
            Some(DeValue::Table(table)) => names(table),
            _ => Vec::new(),
        }
    }

    /// What this TOML text says in the types of a format, and the keys that belong to none of them.
    ///
    /// # Errors
    /// What is wrong, in the words of TOML, and its bytes.
    pub fn read_toml<T: DeserializeOwned>(&self) -> Result<(T, Vec<UnknownKey>), TomlProblem> {
        let problem = |error: &toml::de::Error| TomlProblem {
            message: in_words_of_toml(error.message()),
            span: error.span().unwrap_or(0..0),
        };
        let deserializer =
            toml::Deserializer::parse(&self.text).map_err(|error| problem(&error))?;
        let spans = self.toml_spans();
        let mut unknown = Vec::new();
        let read = serde_ignored::deserialize(deserializer, |path| {
            let mut steps = Vec::new();
            collect_steps(&path, &mut steps);
            let start = spans.as_ref().map_or(0, |spans| spans.key(&steps).start);
            let (line, column) = self.line_and_column(start);
            unknown.push(UnknownKey {
                key: path.to_string(),
                line,
                column,
            });
        })
        .map_err(|error| problem(&error))?;
        Ok((read, unknown))
    }

    /// All places of this TOML text, for more than one question; `None` if it is not TOML.
    #[must_use]
    pub fn toml_spans(&self) -> Option<TomlSpans<'_>> {
        DeTable::parse(&self.text).ok().map(TomlSpans)
    }

    /// This text in the form error reports quote from.
    #[must_use]
    pub fn named_source(&self) -> miette::NamedSource<String> {
        miette::NamedSource::new(&self.name, self.text.clone()).with_language("TOML")
    }
}

/// A key that a format does not know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownKey {
    /// Its whole path, for example `line.bauds`.
    pub key: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

/// Why a text is not TOML, or not of a format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TomlProblem {
    /// What is wrong.
    pub message: String,
    /// Its bytes.
    pub span: Range<usize>,
}

/// The way to an ignored key.
fn collect_steps<'a>(path: &'a serde_ignored::Path<'_>, steps: &mut Vec<Step<'a>>) {
    use serde_ignored::Path;
    match path {
        Path::Root => {}
        Path::Seq { parent, index } => {
            collect_steps(parent, steps);
            steps.push(Step::Index(*index));
        }
        Path::Map { parent, key } => {
            collect_steps(parent, steps);
            steps.push(Step::Key(key));
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

/// Takes out of the JSON Schema of a TOML format the `null` that JSON allows for a key that may be absent: TOML has none.
pub fn remove_null(schema: &mut serde_json::Value) {
    if let Some(types) = schema.get_mut("type")
        && let Some([one, null]) = types.as_array().map(Vec::as_slice)
        && null == "null"
    {
        *types = one.clone();
    }
    if let Some(choices) = schema
        .get_mut("anyOf")
        .and_then(serde_json::Value::as_array_mut)
    {
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
        serde_json::Value::Object(object) => {
            object.retain(|key, value| key != "default" || !value.is_null());
            object.values_mut().for_each(remove_null);
        }
        serde_json::Value::Array(entries) => entries.iter_mut().for_each(remove_null),
        _ => {}
    }
}

/// Where the keys and values of a TOML text stand.
#[derive(Debug)]
pub struct TomlSpans<'a>(Spanned<DeTable<'a>>);

impl TomlSpans<'_> {
    /// Bytes of the value at `path`; of the longest part of the path that exists otherwise.
    #[must_use]
    pub fn value(&self, path: &[Step<'_>]) -> Range<usize> {
        self.of(path).0
    }

    /// Bytes of the key that the last step of `path` names; of the value if the path does not end at a key that exists.
    #[must_use]
    pub fn key(&self, path: &[Step<'_>]) -> Range<usize> {
        let (value, key) = self.of(path);
        key.unwrap_or(value)
    }

    /// Spans of the last value on a path that exists and, if that is the end of the path, of its key.
    fn of(&self, path: &[Step<'_>]) -> (Range<usize>, Option<Range<usize>>) {
        let mut spans = (0..0, None);
        let mut value: Option<&DeValue<'_>> = None;
        for (depth, step) in path.iter().enumerate() {
            let is_last = depth + 1 == path.len();
            let named = |(key, next): (&Spanned<_>, _)| (is_last.then(|| key.span()), next);
            let next = match (step, value) {
                (Step::Key(key), None) if depth == 0 => {
                    self.0.get_ref().get_key_value(*key).map(named)
                }
                (Step::Key(key), Some(DeValue::Table(table))) => {
                    table.get_key_value(*key).map(named)
                }
                (Step::Index(index), Some(DeValue::Array(array))) => {
                    array.get(*index).map(|next| (None, next))
                }
                _ => None,
            };
            let Some((key, next)) = next else { break };
            spans = (next.span(), key);
            value = Some(next.get_ref());
        }
        spans
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_values_in_nested_toml() {
        let source = SourceText::new(
            "f",
            "a = 1\nlist = [\n  { x = 2, y = \"µ\" },\n  { x = 3 },\n]\n[t.u]\nv = 4\n",
        );
        let at = |path: &[Step<'_>]| source.line_and_column(source.toml_span(path).start);
        assert_eq!(
            at(&[Step::Key("list"), Step::Index(1), Step::Key("x")]),
            (4, 9)
        );
        assert_eq!(
            at(&[Step::Key("t"), Step::Key("u"), Step::Key("v")]),
            (7, 5)
        );
        // A path that leads nowhere points at the last thing that exists.
        assert_eq!(
            at(&[Step::Key("list"), Step::Index(0), Step::Key("z")]),
            (3, 3)
        );
    }

    #[test]
    fn lists_the_keys_of_tables() {
        let source = SourceText::new("f", "a = 1\n[b]\nc = 1\n[[l]]\nd = 2\n");
        let keys = |path: &[Step<'_>]| source.toml_keys(path).join(" ");
        assert_eq!(keys(&[]), "a b l");
        assert_eq!(keys(&[Step::Key("b")]), "c");
        assert_eq!(keys(&[Step::Key("l"), Step::Index(0)]), "d");
        assert_eq!(keys(&[Step::Key("a")]), "");
        assert_eq!(keys(&[Step::Index(0)]), "");
        assert_eq!(SourceText::new("f", "a =").toml_keys(&[]).len(), 0);
    }

    #[test]
    fn finds_keys_in_nested_toml() {
        let source = SourceText::new("f", "[a]\nb = { c = 1, d = 2 }\n");
        let at = |path: &[Step<'_>]| source.line_and_column(source.toml_key_span(path).start);
        assert_eq!(
            at(&[Step::Key("a"), Step::Key("b"), Step::Key("d")]),
            (2, 14)
        );
        // A key that is not there: the table it should be in.
        assert_eq!(
            at(&[Step::Key("a"), Step::Key("b"), Step::Key("e")]),
            (2, 5)
        );
    }
}
