//! A TOML text and where its keys and values stand.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::source_text::SourceText;

use super::Read;
use super::problem::TomlError;
use super::table::TomlTable;

/// One step into a TOML document.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DocumentStep<'a> {
    /// Into a table.
    Key(&'a str),
    /// Into an array.
    Index(usize),
}

/// A number in a TOML text.
#[derive(Debug, Clone, PartialEq)]
pub struct TomlNumber {
    /// Keys and, in arrays, indices that lead to it.
    pub keys: Vec<String>,
    /// Its value.
    pub value: f64,
    /// Its bytes.
    pub span: Range<usize>,
}

/// A TOML text with its places.
#[derive(Debug)]
pub struct TomlDocument<'a> {
    pub(super) source: &'a SourceText,
    pub(super) root: Spanned<DeTable<'a>>,
}

impl<'a> TomlDocument<'a> {
    /// Parses a text.
    ///
    /// # Errors
    /// What is no TOML, in its place.
    pub fn parse(source: &'a SourceText) -> Read<Self> {
        let root = DeTable::parse(&source.text);
        let root = root.map_err(|error| TomlError::of_reader(source, &error))?;
        Ok(Self { source, root })
    }

    /// The whole text as a table.
    #[must_use]
    pub fn root(&self) -> TomlTable<'_> {
        TomlTable::root(self.source, self.root.get_ref())
    }

    /// Bytes of the value at `path`; of the longest part of the path that exists otherwise.
    #[must_use]
    pub fn value_span(&self, path: &[DocumentStep<'_>]) -> Range<usize> {
        self.spans(path).0
    }

    /// Bytes of the key that the last step of `path` names; of the value if the path does not end at a key that exists.
    #[must_use]
    pub fn key_span(&self, path: &[DocumentStep<'_>]) -> Range<usize> {
        let (value, key) = self.spans(path);
        key.unwrap_or(value)
    }

    /// All numbers in the table of a name, in the order of the text.
    #[must_use]
    pub fn numbers(&self, table: &str) -> Vec<TomlNumber> {
        let mut found = Vec::new();
        let mut open: Vec<(Vec<String>, &Spanned<DeValue<'_>>)> = Vec::new();
        if let Some(value) = self.root.get_ref().get(table) {
            open.push((vec![table.to_owned()], value));
        }
        while let Some((keys, value)) = open.pop() {
            let below = |key: String| [&keys[..], &[key]].concat();
            match value.get_ref() {
                DeValue::Table(table) => {
                    let entries = table.iter();
                    open.extend(
                        entries.map(|(key, value)| (below(key.get_ref().to_string()), value)),
                    );
                }
                DeValue::Array(array) => {
                    let entries = array.iter().enumerate();
                    open.extend(entries.map(|(place, value)| (below(place.to_string()), value)));
                }
                DeValue::Integer(_) | DeValue::Float(_) => {
                    let text = self.source.text[value.span()].replace('_', "");
                    if let Ok(value_of) = text.parse() {
                        found.push(TomlNumber {
                            keys,
                            value: value_of,
                            span: value.span(),
                        });
                    }
                }
                _ => {}
            }
        }
        found.sort_by_key(|number| number.span.start);
        found
    }

    /// Spans of the last value on a path that exists and, if that is the end of the path, of its key.
    fn spans(&self, path: &[DocumentStep<'_>]) -> (Range<usize>, Option<Range<usize>>) {
        let mut spans = (0..0, None);
        let mut value: Option<&DeValue<'_>> = None;
        for (depth, step) in path.iter().enumerate() {
            let table = match value {
                None if depth == 0 => Some(self.root.get_ref()),
                Some(DeValue::Table(table)) => Some(table),
                _ => None,
            };
            let next = match (step, value) {
                (DocumentStep::Key(key), _) => table
                    .and_then(|table| table.get_key_value(*key))
                    .map(|(key, next)| (Some(key.span()), next)),
                (DocumentStep::Index(index), Some(DeValue::Array(array))) => {
                    array.get(*index).map(|next| (None, next))
                }
                _ => None,
            };
            let Some((key, next)) = next else { break };
            let is_last = depth + 1 == path.len();
            spans = (next.span(), key.filter(|_| is_last));
            value = Some(next.get_ref());
        }
        spans
    }
}

impl SourceText {
    /// Bytes of the value at `path` in this TOML text; of the longest part of the path that exists otherwise.
    #[must_use]
    pub fn toml_span(&self, path: &[DocumentStep<'_>]) -> Range<usize> {
        TomlDocument::parse(self).map_or(0..0, |document| document.value_span(path))
    }

    /// Bytes of the key that the last step of `path` names; of the value if the path does not end at a key that exists.
    #[must_use]
    pub fn toml_key_span(&self, path: &[DocumentStep<'_>]) -> Range<usize> {
        TomlDocument::parse(self).map_or(0..0, |document| document.key_span(path))
    }
}
