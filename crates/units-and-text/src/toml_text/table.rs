//! Tables whose keys and values are read one by one, each error in its place.

use std::cell::RefCell;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::nearest::nearest;
use crate::quantity::Kind;
use crate::source_text::{PlacedError, SourceText};

use super::Read;
use super::problem::{TomlError, TomlProblem, UnknownKey};

/// A table in its text.
#[derive(Debug)]
pub struct TomlTable<'a> {
    source: &'a SourceText,
    entries: &'a DeTable<'a>,
    span: Range<usize>,
    /// The keys that lead here; empty for the whole text.
    path: String,
    /// Keys that were asked for.
    asked: RefCell<Vec<String>>,
}

impl<'a> TomlTable<'a> {
    pub(super) fn root(source: &'a SourceText, entries: &'a DeTable<'a>) -> Self {
        Self {
            source,
            entries,
            span: 0..0,
            path: String::new(),
            asked: RefCell::default(),
        }
    }

    /// Where the table stands.
    #[must_use]
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// The text that the table is of.
    #[must_use]
    pub fn source(&self) -> &'a SourceText {
        self.source
    }

    /// The table in messages.
    fn name(&self) -> String {
        match self.path.as_str() {
            "" => "the file".to_owned(),
            path => format!("`{path}`"),
        }
    }

    /// A key with the keys that lead to it.
    fn path_of(&self, key: &str) -> String {
        match self.path.as_str() {
            "" => key.to_owned(),
            path => format!("{path}.{key}"),
        }
    }

    fn error(&self, span: Range<usize>, problem: TomlProblem) -> TomlError {
        TomlError(PlacedError::new(self.source, span, problem))
    }

    /// All keys with their places and values.
    pub fn entries(&self) -> impl Iterator<Item = (&'a str, Range<usize>, TomlValue<'a>)> {
        self.entries.iter().map(|(key, value)| {
            let value = TomlValue {
                source: self.source,
                path: self.path_of(key.get_ref()),
                spanned: value,
            };
            (key.get_ref().as_ref(), key.span(), value)
        })
    }

    /// The value of a key.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<TomlValue<'a>> {
        self.asked.borrow_mut().push(key.to_owned());
        Some(TomlValue {
            source: self.source,
            path: self.path_of(key),
            spanned: self.entries.get(key)?,
        })
    }

    /// The value of a key that must be there.
    ///
    /// # Errors
    /// It is not there.
    pub fn require(&self, key: &str) -> Read<TomlValue<'a>> {
        self.get(key).ok_or_else(|| {
            let (key, table) = (key.to_owned(), self.name());
            self.error(self.span(), TomlProblem::Missing { key, table })
        })
    }

    /// What a key holds, if it is there.
    ///
    /// # Errors
    /// Those of `how`.
    pub fn read<T>(
        &self,
        key: &str,
        how: impl FnOnce(&TomlValue<'a>) -> Read<T>,
    ) -> Read<Option<T>> {
        self.get(key).as_ref().map(how).transpose()
    }

    /// What the members of an array are; none if the key is not there.
    ///
    /// # Errors
    /// No array, and those of `how`.
    pub fn read_all<T>(&self, key: &str, how: impl Fn(&TomlValue<'a>) -> Read<T>) -> Read<Vec<T>> {
        match self.get(key) {
            Some(value) => value.items()?.iter().map(how).collect(),
            None => Ok(Vec::new()),
        }
    }

    /// The key `STEM_UNIT` with its place, its unit and its value; `suffix` may follow the unit.
    #[must_use]
    pub fn find_with_unit(
        &self,
        stem: &str,
        suffix: &str,
        kind: Kind,
    ) -> Option<(Range<usize>, &'a str, TomlValue<'a>)> {
        let usual = kind.units().split(", ").next().unwrap_or_default();
        self.asked
            .borrow_mut()
            .push(format!("{stem}_{usual}{suffix}"));
        let (key, span, unit, value) = self.entries().find_map(|(key, span, value)| {
            let rest = key.strip_prefix(stem)?.strip_prefix('_')?;
            Some((key, span, rest.strip_suffix(suffix)?, value))
        })?;
        self.asked.borrow_mut().push(key.to_owned());
        Some((span, unit, value))
    }

    /// The error for a unit that is not of a kind, at a key that [`find_with_unit`](Self::find_with_unit) found.
    #[must_use]
    pub fn wrong_unit(
        &self,
        key: Range<usize>,
        value: &TomlValue<'_>,
        unit: &str,
        kind: Kind,
    ) -> TomlError {
        let problem = TomlProblem::Unit {
            key: value.path.clone(),
            unit: unit.to_owned(),
            accepted: kind.units(),
        };
        self.error(key, problem)
    }

    /// Refuses keys that are not among `known`.
    ///
    /// # Errors
    /// The first of them, with the nearest known one.
    pub fn only(&self, known: &[&'static str]) -> Read<()> {
        let mut keys = self.entries.keys();
        let Some(key) = keys.find(|key| !known.contains(&key.get_ref().as_ref())) else {
            return Ok(());
        };
        let problem = TomlProblem::UnknownKey {
            key: key.get_ref().to_string(),
            table: self.name(),
            known: known.to_vec(),
        };
        Err(self.error(key.span(), problem))
    }

    /// The keys that are not part of the format, each with the nearest of the known keys.
    #[must_use]
    pub fn unknown(&self) -> Vec<UnknownKey> {
        let asked = self.asked.borrow();
        let unknown = self
            .entries
            .keys()
            .filter(|key| !asked.iter().any(|asked| asked == key.get_ref()));
        unknown
            .map(|key| {
                let (line, column) = self.source.line_and_column(key.span().start);
                let meant = nearest(key.get_ref(), asked.iter().map(String::as_str));
                UnknownKey {
                    key: self.path_of(key.get_ref()),
                    line,
                    column,
                    meant: meant.map(|meant| self.path_of(meant)),
                }
            })
            .collect()
    }

    /// Checks `schema`, a name with a version behind the last slash: `expected` or an older version of it.
    ///
    /// # Errors
    /// Another schema or a newer one; none, where it is `required`.
    pub fn check_schema(&self, expected: &'static str, required: bool) -> Read<()> {
        let Some(value) = self.get("schema") else {
            let problem = TomlProblem::NoSchema { expected };
            return if required {
                Err(self.error(0..0, problem))
            } else {
                Ok(())
            };
        };
        let (key, found) = (value.path.clone(), value.text()?.to_owned());
        let version = |schema: &str| {
            let (name, version) = schema.rsplit_once('/')?;
            Some((name.to_owned(), version.parse::<u32>().ok()?))
        };
        let problem = match (version(&found), version(expected)) {
            (Some((name, number)), Some((known, newest))) if name == known && number > 0 => {
                if number <= newest {
                    return Ok(());
                }
                TomlProblem::NewerSchema {
                    key,
                    found,
                    expected,
                }
            }
            _ => TomlProblem::OtherSchema {
                key,
                found,
                expected,
            },
        };
        Err(self.error(value.span(), problem))
    }
}

/// A value in its text.
#[derive(Debug, Clone)]
pub struct TomlValue<'a> {
    source: &'a SourceText,
    /// The keys that lead here.
    path: String,
    spanned: &'a Spanned<DeValue<'a>>,
}

impl<'a> TomlValue<'a> {
    /// Where the value stands.
    #[must_use]
    pub fn span(&self) -> Range<usize> {
        self.spanned.span()
    }

    /// The value as parsed.
    #[must_use]
    pub fn parsed(&self) -> &'a DeValue<'a> {
        self.spanned.get_ref()
    }

    /// The error for a value that is not what belongs there.
    #[must_use]
    pub fn wrong(&self, expected: &'static str) -> TomlError {
        let found = match self.parsed() {
            DeValue::String(text) => format!("the text `{text}`"),
            DeValue::Array(_) => "an array".to_owned(),
            DeValue::Table(_) => "a table".to_owned(),
            _ => {
                let written = self.source.text.get(self.span());
                format!("`{}`", written.unwrap_or_default())
            }
        };
        self.refused(found, expected)
    }

    /// The same where what stands there has its own words.
    #[must_use]
    pub fn refused(&self, found: String, expected: &'static str) -> TomlError {
        let problem = TomlProblem::Value {
            key: self.path.clone(),
            found,
            expected,
        };
        TomlError(PlacedError::new(self.source, self.span(), problem))
    }

    /// A text.
    ///
    /// # Errors
    /// No text.
    pub fn text(&self) -> Read<&'a str> {
        let text = self.parsed().as_str();
        text.ok_or_else(|| self.wrong("a text in quotes"))
    }

    /// A text; a whole number is taken as its digits, as serial numbers are written.
    ///
    /// # Errors
    /// Neither of them.
    pub fn text_or_digits(&self) -> Read<String> {
        match self.parsed() {
            DeValue::Integer(number) if number.radix() == 10 => Ok(number.as_str().to_owned()),
            _ => self.text().map(str::to_owned),
        }
    }

    /// The digits of a number, as they are written but for separators.
    ///
    /// # Errors
    /// No decimal number.
    pub fn digits(&self) -> Read<&'a str> {
        match self.parsed() {
            DeValue::Float(number) => Ok(number.as_str()),
            DeValue::Integer(number) if number.radix() == 10 => Ok(number.as_str()),
            _ => Err(self.wrong("a number")),
        }
    }

    /// A finite number.
    ///
    /// # Errors
    /// No number, or none that is finite.
    pub fn number(&self) -> Read<f64> {
        let number = self.digits()?.parse::<f64>().ok();
        number
            .filter(|number| number.is_finite())
            .ok_or_else(|| self.wrong("a finite number"))
    }

    /// A whole number from 0; its digits may stand in quotes, as TOML has no number beyond 63 bits.
    ///
    /// # Errors
    /// No whole number from 0, or one that is too large.
    pub fn count<T: TryFrom<u64>>(&self) -> Read<T> {
        let count = match self.parsed() {
            DeValue::Integer(number) => u64::from_str_radix(number.as_str(), number.radix()).ok(),
            DeValue::String(digits) => digits.parse().ok(),
            _ => None,
        };
        let count = count.and_then(|count| T::try_from(count).ok());
        count.ok_or_else(|| self.wrong("a whole number from 0"))
    }

    /// The members of an array.
    ///
    /// # Errors
    /// No array.
    pub fn items(&self) -> Read<Vec<TomlValue<'a>>> {
        let DeValue::Array(items) = self.parsed() else {
            return Err(self.wrong("an array"));
        };
        let item = |spanned| TomlValue {
            source: self.source,
            path: self.path.clone(),
            spanned,
        };
        Ok(items.iter().map(item).collect())
    }

    /// A table.
    ///
    /// # Errors
    /// No table.
    pub fn table(&self) -> Read<TomlTable<'a>> {
        let DeValue::Table(entries) = self.parsed() else {
            return Err(self.wrong("a table"));
        };
        Ok(TomlTable {
            span: self.span(),
            path: self.path.clone(),
            ..TomlTable::root(self.source, entries)
        })
    }
}
