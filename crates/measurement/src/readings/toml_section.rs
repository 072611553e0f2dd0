//! Lenient reading of TOML tables: every key may be absent, a wrong value is shown in place, and what was not asked for is listed.

use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;

use jiff::civil::Date;
use miette::NamedSource;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::number::{Conversion, NumberReader};
use super::session_file::{SessionFileError, UnknownKey, Word};
use stiffbench_units_and_text::quantity::Kind;

/// The text of a file, for messages.
pub(super) struct Source {
    file: Arc<NamedSource<String>>,
}

impl Source {
    pub(super) fn new(name: &str, text: &str) -> Self {
        let file = Arc::new(NamedSource::new(name, text.to_owned()));
        Self { file }
    }

    pub(super) fn file(&self) -> Arc<NamedSource<String>> {
        Arc::clone(&self.file)
    }

    /// The line of a byte, from 1.
    pub(super) fn line(&self, byte: usize) -> u32 {
        let before = self.file.inner().get(..byte).unwrap_or_default();
        1 + before.matches('\n').count() as u32
    }
}

/// The tables of a file.
pub(super) fn parse<'a>(
    source: &Source,
    text: &'a str,
) -> Result<Spanned<DeTable<'a>>, SessionFileError> {
    DeTable::parse(text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        SessionFileError::Syntax {
            line: source.line(span.start),
            message: error.message().to_owned(),
            file: source.file(),
            at: span.into(),
        }
    })
}

/// One table of a file.
pub(super) struct Section<'a> {
    source: &'a Source,
    /// Name with a point behind it; empty for the file itself.
    prefix: String,
    table: &'a DeTable<'a>,
    taken: RefCell<Vec<&'a str>>,
}

type Found<T> = Result<Option<T>, SessionFileError>;

impl<'a> Section<'a> {
    pub(super) fn root(source: &'a Source, table: &'a DeTable<'a>) -> Self {
        Self {
            source,
            prefix: String::new(),
            table,
            taken: RefCell::new(Vec::new()),
        }
    }

    fn get(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        let (key, value) = self
            .table
            .iter()
            .find(|(known, _)| known.get_ref().as_ref() == key)?;
        self.taken.borrow_mut().push(key.get_ref());
        Some(value)
    }

    /// The value of the key `STEM_UNIT`, with its unit; `suffix` may follow the unit.
    fn get_with_unit(
        &self,
        stem: &str,
        suffix: &str,
        kind: Kind,
    ) -> Found<(String, &'a Spanned<DeValue<'a>>, Conversion)> {
        let unit_of = |key: &'a str| {
            let rest = key.strip_prefix(stem)?.strip_prefix('_')?;
            rest.strip_suffix(suffix)
        };
        let mut keys = self.table.iter();
        let Some((key, unit, value)) = keys.find_map(|(key, value)| {
            let unit = unit_of(key.get_ref())?;
            Some((key, unit, value))
        }) else {
            return Ok(None);
        };
        let Some(conversion) = Conversion::from_unit(kind, unit) else {
            return Err(SessionFileError::WrongUnit {
                line: self.source.line(key.span().start),
                key: self.name(key.get_ref()),
                unit: unit.to_owned(),
                accepted: kind.units(),
                file: self.source.file(),
                at: key.span().into(),
            });
        };
        self.taken.borrow_mut().push(key.get_ref());
        Ok(Some((key.get_ref().to_string(), value, conversion)))
    }

    fn name(&self, key: &str) -> String {
        format!("{}{key}", self.prefix)
    }

    fn wrong(
        &self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        expected: &'static str,
    ) -> SessionFileError {
        let span: Range<usize> = value.span();
        let found = match value.get_ref() {
            DeValue::String(text) => format!("the text `{text}`"),
            DeValue::Array(_) => "an array".to_owned(),
            DeValue::Table(_) => "a table".to_owned(),
            _ => {
                let text = self.source.file.inner().get(span.clone());
                format!("`{}`", text.unwrap_or_default())
            }
        };
        SessionFileError::WrongValue {
            line: self.source.line(span.start),
            key: self.name(key),
            found,
            expected,
            file: self.source.file(),
            at: span.into(),
        }
    }

    /// Text; a whole number is taken as its digits, as serial numbers are written.
    pub(super) fn text(&self, key: &str) -> Found<String> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        match value.get_ref() {
            DeValue::String(text) => Ok(Some(text.to_string())),
            DeValue::Integer(number) if number.radix() == 10 => {
                Ok(Some(number.as_str().to_owned()))
            }
            _ => Err(self.wrong(key, value, "a text in quotes")),
        }
    }

    /// A number without a unit.
    pub(super) fn number(&self, key: &str) -> Found<f64> {
        self.get(key)
            .map(|value| self.to_number(key, value, Conversion::NONE))
            .transpose()
    }

    /// A quantity in SI, from the key `STEM_UNIT`.
    pub(super) fn quantity(&self, stem: &str, kind: Kind) -> Found<f64> {
        self.rate(stem, "", kind)
    }

    /// A quantity whose key goes on behind the unit, as in `slope_um_per_s`.
    pub(super) fn rate(&self, stem: &str, suffix: &str, kind: Kind) -> Found<f64> {
        self.get_with_unit(stem, suffix, kind)?
            .map(|(key, value, conversion)| self.to_number(&key, value, conversion))
            .transpose()
    }

    /// Quantities in SI, from the key `STEM_UNIT`; none if the key is absent.
    pub(super) fn quantities(&self, stem: &str, kind: Kind) -> Result<Vec<f64>, SessionFileError> {
        let Some((key, value, conversion)) = self.get_with_unit(stem, "", kind)? else {
            return Ok(Vec::new());
        };
        self.array(&key, value)?
            .map(|value| self.to_number(&key, value, conversion))
            .collect()
    }

    fn to_number(
        &self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        conversion: Conversion,
    ) -> Result<f64, SessionFileError> {
        let text = match value.get_ref() {
            DeValue::Float(number) => number.as_str(),
            DeValue::Integer(number) if number.radix() == 10 => number.as_str(),
            _ => return Err(self.wrong(key, value, "a number")),
        };
        NumberReader::new(None)
            .read(text.as_bytes(), conversion, 0)
            .map_err(|_| self.wrong(key, value, "a finite number"))
    }

    /// A whole number from 0; its digits may stand in quotes, as TOML has no number beyond 63 bits.
    pub(super) fn count<T: TryFrom<u64>>(&self, key: &str) -> Found<T> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        let count = match value.get_ref() {
            DeValue::Integer(number) => u64::from_str_radix(number.as_str(), number.radix()).ok(),
            DeValue::String(digits) => digits.parse().ok(),
            _ => None,
        };
        match count.and_then(|count| T::try_from(count).ok()) {
            Some(count) => Ok(Some(count)),
            None => Err(self.wrong(key, value, "a whole number from 0")),
        }
    }

    /// A day, as a TOML date or as text.
    pub(super) fn date(&self, key: &str) -> Found<Date> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        let text = match value.get_ref() {
            DeValue::String(text) => text.to_string(),
            DeValue::Datetime(time) => time.date.map(|date| date.to_string()).unwrap_or_default(),
            _ => String::new(),
        };
        match text.parse() {
            Ok(date) => Ok(Some(date)),
            Err(_) => Err(self.wrong(key, value, "a date like 2026-03-02")),
        }
    }

    /// One word of a closed list.
    pub(super) fn word<W: Word>(&self, key: &str) -> Found<W> {
        self.get(key)
            .map(|value| self.to_word(key, value))
            .transpose()
    }

    /// Words of a closed list; none if the key is absent.
    pub(super) fn words<W: Word>(&self, key: &str) -> Result<Vec<W>, SessionFileError> {
        let Some(value) = self.get(key) else {
            return Ok(Vec::new());
        };
        self.array(key, value)?
            .map(|value| self.to_word(key, value))
            .collect()
    }

    fn to_word<W: Word>(
        &self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<W, SessionFileError> {
        let text = value.get_ref().as_str();
        W::WORDS
            .iter()
            .find(|(word, _)| text == Some(word))
            .map(|(_, member)| *member)
            .ok_or_else(|| self.wrong(key, value, W::EXPECTED))
    }

    /// Texts; none if the key is absent.
    pub(super) fn texts(&self, key: &str) -> Result<Vec<String>, SessionFileError> {
        let Some(value) = self.get(key) else {
            return Ok(Vec::new());
        };
        self.array(key, value)?
            .map(|value| match value.get_ref() {
                DeValue::String(text) => Ok(text.to_string()),
                _ => Err(self.wrong(key, value, "a text in quotes")),
            })
            .collect()
    }

    fn array(
        &self,
        key: &str,
        value: &'a Spanned<DeValue<'a>>,
    ) -> Result<impl Iterator<Item = &'a Spanned<DeValue<'a>>> + use<'a>, SessionFileError> {
        match value.get_ref() {
            DeValue::Array(items) => Ok(items.iter()),
            _ => Err(self.wrong(key, value, "an array")),
        }
    }

    /// A table within this one.
    pub(super) fn section(&self, key: &str) -> Found<Section<'a>> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        match value.get_ref() {
            DeValue::Table(table) => Ok(Some(Self {
                source: self.source,
                prefix: format!("{}{key}.", self.prefix),
                table,
                taken: RefCell::new(Vec::new()),
            })),
            _ => Err(self.wrong(key, value, "a table")),
        }
    }

    /// Whether a key holds text rather than a table.
    pub(super) fn is_text(&self, key: &str) -> bool {
        self.table
            .iter()
            .any(|(known, value)| known.get_ref().as_ref() == key && value.get_ref().is_str())
    }

    /// Checks `schema`, a name with a version behind the last slash: `expected` or an older version of it.
    pub(super) fn check_schema(
        &self,
        expected: &'static str,
        required: bool,
    ) -> Result<(), SessionFileError> {
        let Some(value) = self.get("schema") else {
            if required {
                let file = self.source.file();
                return Err(SessionFileError::NoSchema { expected, file });
            }
            return Ok(());
        };
        let Some(found) = value.get_ref().as_str() else {
            return Err(self.wrong("schema", value, "a text in quotes"));
        };
        let version = |schema: &str| {
            let (name, version) = schema.rsplit_once('/')?;
            Some((name.to_owned(), version.parse::<u32>().ok()?))
        };
        let line = self.source.line(value.span().start);
        let (key, found, file) = (self.name("schema"), found.to_owned(), self.source.file());
        let at = value.span().into();
        match (version(&found), version(expected)) {
            (Some((name, number)), Some((known, newest))) if name == known => {
                if number <= newest {
                    return Ok(());
                }
                Err(SessionFileError::NewerSchema {
                    line,
                    key,
                    found,
                    expected,
                    file,
                    at,
                })
            }
            _ => Err(SessionFileError::OtherSchema {
                line,
                key,
                found,
                expected,
                file,
                at,
            }),
        }
    }

    /// Lists the keys nobody asked for.
    pub(super) fn finish(self, unknown: &mut Vec<UnknownKey>) {
        let taken = self.taken.borrow();
        for (key, _) in self.table {
            if !taken.contains(&key.get_ref().as_ref()) {
                unknown.push(UnknownKey {
                    key: self.name(key.get_ref()),
                    line: self.source.line(key.span().start),
                });
            }
        }
    }
}
