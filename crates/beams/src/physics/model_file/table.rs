//! Tables of a TOML text whose keys and values are read one by one, each error at its place.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use stiffbench_units_and_text::source_text::SourceText;

use super::error::{ModelFileError, ModelProblem};

/// A value in its file.
pub(super) type Value<'a> = Spanned<DeValue<'a>>;

/// A table with its place and its name in messages.
pub(super) struct Table<'a> {
    source: &'a SourceText,
    entries: &'a DeTable<'a>,
    span: Range<usize>,
    name: String,
}

type Read<T> = Result<T, ModelFileError>;

impl<'a> Table<'a> {
    /// The whole file.
    pub(super) fn root(source: &'a SourceText, entries: &'a DeTable<'a>) -> Self {
        Self {
            source,
            entries,
            span: 0..0,
            name: "the file".to_owned(),
        }
    }

    /// An error at a place of the file.
    pub(super) fn error(&self, span: Range<usize>, problem: ModelProblem) -> ModelFileError {
        ModelFileError::at(self.source, span, problem)
    }

    /// An error at a value.
    pub(super) fn wrong(
        &self,
        key: &str,
        value: &Value<'_>,
        expected: &'static str,
    ) -> ModelFileError {
        let key = key.to_owned();
        self.error(value.span(), ModelProblem::Value { key, expected })
    }

    /// Where the table stands.
    pub(super) fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// Refuses keys that are not among `known`.
    pub(super) fn only(&self, known: &[&'static str]) -> Read<()> {
        let unknown = self
            .entries
            .iter()
            .find(|(key, _)| !known.contains(&key.get_ref().as_ref()));
        unknown.map_or(Ok(()), |(key, _)| {
            let problem = ModelProblem::UnknownKey {
                key: key.get_ref().to_string(),
                table: self.name.clone(),
                known: known.to_vec(),
            };
            Err(self.error(key.span(), problem))
        })
    }

    /// All keys with their places and values.
    pub(super) fn entries(&self) -> impl Iterator<Item = (&'a str, Range<usize>, &'a Value<'a>)> {
        self.entries
            .iter()
            .map(|(key, value)| (key.get_ref().as_ref(), key.span(), value))
    }

    /// The value of a key.
    pub(super) fn get(&self, key: &str) -> Option<&'a Value<'a>> {
        self.entries
            .iter()
            .find(|(known, _)| known.get_ref().as_ref() == key)
            .map(|(_, value)| value)
    }

    /// The value of a key that must be there.
    pub(super) fn require(&self, key: &'static str) -> Read<&'a Value<'a>> {
        self.get(key).ok_or_else(|| {
            let table = self.name.clone();
            self.error(self.span(), ModelProblem::Missing { key, table })
        })
    }

    /// A text that may be absent.
    pub(super) fn text(&self, key: &str) -> Read<Option<&'a str>> {
        let text = |value: &'a Value<'a>| {
            let text = value.get_ref().as_str();
            text.ok_or_else(|| self.wrong(key, value, "a text in quotes"))
        };
        self.get(key).map(text).transpose()
    }

    /// A finite number.
    pub(super) fn number(&self, key: &str, value: &Value<'_>) -> Read<f64> {
        let text = match value.get_ref() {
            DeValue::Float(number) => number.as_str(),
            DeValue::Integer(number) if number.radix() == 10 => number.as_str(),
            _ => return Err(self.wrong(key, value, "a number")),
        };
        let number = text.replace('_', "").parse::<f64>().ok();
        number
            .filter(|number| number.is_finite())
            .ok_or_else(|| self.wrong(key, value, "a finite number"))
    }

    /// A whole number from 0.
    pub(super) fn count(&self, key: &str, value: &Value<'_>) -> Read<u32> {
        let count = match value.get_ref() {
            DeValue::Integer(number) => u32::from_str_radix(number.as_str(), number.radix()).ok(),
            _ => None,
        };
        count.ok_or_else(|| self.wrong(key, value, "a whole number from 0"))
    }

    /// A table in this one.
    pub(super) fn table(&self, key: &str, value: &'a Value<'a>) -> Read<Table<'a>> {
        match value.get_ref() {
            DeValue::Table(entries) => Ok(Self {
                source: self.source,
                entries,
                span: value.span(),
                name: format!("`{key}`"),
            }),
            _ => Err(self.wrong(key, value, "a table")),
        }
    }

    /// The tables of an array; none if it is absent.
    pub(super) fn tables(&self, key: &str) -> Read<Vec<Table<'a>>> {
        let Some(value) = self.get(key) else {
            return Ok(Vec::new());
        };
        match value.get_ref() {
            DeValue::Array(items) => items.iter().map(|item| self.table(key, item)).collect(),
            _ => Err(self.wrong(key, value, "an array of tables")),
        }
    }
}
