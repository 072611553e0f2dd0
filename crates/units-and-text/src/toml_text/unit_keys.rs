//! Keys that end in a unit: `at_mm = [0, 20, 5]` for `at`.

use std::borrow::Cow;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use crate::source_text::{PlacedError, SourceText};

use super::problem::{TomlError, TomlProblem};
use super::{Read, TomlDocument};

/// Stands between a number and its unit where [`TomlDocument::parse_with_units`] joined them; no key of a file can hold it in plain sight.
const SEPARATOR: char = '\u{1f}';

/// A number or expression as text, and the unit that its key ended in.
#[must_use]
pub fn split_unit(text: &str) -> (&str, Option<&str>) {
    match text.split_once(SEPARATOR) {
        Some((value, unit)) => (value, Some(unit)),
        None => (text, None),
    }
}

impl<'a> TomlDocument<'a> {
    /// Parses a text, and takes the unit off every key that ends in one of `units`.
    ///
    /// Such a key gets its stem as name. Numbers and texts of its value, and of the entries of its array, become texts that hold the unit,
    /// which [`split_unit`] takes apart. Keys of tables keep their name.
    ///
    /// # Errors
    /// What is no TOML, and a key that is given in two units, in its place.
    pub fn parse_with_units(source: &'a SourceText, units: &[&str]) -> Read<Self> {
        let mut document = Self::parse(source)?;
        take_units(source, document.root.get_mut(), units)?;
        Ok(document)
    }
}

/// The stem and the unit of a key: the longest unit that fits.
fn split_key<'k>(key: &'k str, units: &[&'k str]) -> Option<(&'k str, &'k str)> {
    let stem = |unit: &str| {
        let stem = key.strip_suffix(unit)?.strip_suffix('_')?;
        (!stem.is_empty()).then_some(stem)
    };
    let fitting = units.iter().filter_map(|unit| Some((stem(unit)?, *unit)));
    fitting.max_by_key(|(_, unit)| unit.len())
}

fn take_units(source: &SourceText, table: &mut DeTable<'_>, units: &[&str]) -> Read<()> {
    let mut renamed = DeTable::default();
    for (key, mut value) in std::mem::take(table) {
        let split =
            split_key(key.get_ref(), units).map(|(stem, unit)| (stem.to_owned(), unit.to_owned()));
        let key = match (value.get_mut(), split) {
            (DeValue::Table(inner), _) => {
                take_units(source, inner, units)?;
                key
            }
            (value, Some((stem, unit))) => {
                join(value, &unit);
                Spanned::new(key.span(), DeString::from(stem))
            }
            (value, None) => {
                take_units_of_entries(source, value, units)?;
                key
            }
        };
        if renamed.contains_key(key.get_ref().as_ref()) {
            let key_name = key.get_ref().to_string();
            let problem = TomlProblem::GivenTwice { key: key_name };
            return Err(TomlError(PlacedError::new(source, key.span(), problem)));
        }
        renamed.insert(key, value);
    }
    *table = renamed;
    Ok(())
}

/// Tables in an array have keys of their own.
fn take_units_of_entries(source: &SourceText, value: &mut DeValue<'_>, units: &[&str]) -> Read<()> {
    if let DeValue::Array(entries) = value {
        for entry in entries.iter_mut() {
            match entry.get_mut() {
                DeValue::Table(inner) => take_units(source, inner, units)?,
                other => take_units_of_entries(source, other, units)?,
            }
        }
    }
    Ok(())
}

/// Writes a unit to the numbers and texts of a value.
fn join(value: &mut DeValue<'_>, unit: &str) {
    let text = match value {
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::String(text) => text.to_string(),
        DeValue::Array(entries) => {
            for entry in entries.iter_mut() {
                join(entry.get_mut(), unit);
            }
            return;
        }
        _ => return,
    };
    *value = DeValue::String(Cow::Owned(format!("{text}{SEPARATOR}{unit}")));
}

#[cfg(test)]
mod tests {
    use super::*;

    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    struct Format {
        at: Vec<String>,
        stiffness: String,
        rows: Vec<Row>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Row {
        d: String,
    }

    const UNITS: [&str; 4] = ["m", "mm", "N_per_m", "m_per_N"];

    #[test]
    fn numbers_get_the_unit_of_their_key() {
        let text = "at_mm = [1, 2.5, \"h - 3\"]\nstiffness_N_per_m = 1_000\nrows = [{ d_m = 2 }]\n";
        let source = SourceText::new("f", text);
        let read: Format = TomlDocument::parse_with_units(&source, &UNITS)
            .unwrap()
            .types()
            .unwrap();
        let split: Vec<_> = read.at.iter().map(|text| split_unit(text)).collect();
        assert_eq!(
            split,
            [
                ("1", Some("mm")),
                ("2.5", Some("mm")),
                ("h - 3", Some("mm"))
            ]
        );
        assert_eq!(split_unit(&read.stiffness), ("1000", Some("N_per_m")));
        assert_eq!(split_unit(&read.rows[0].d), ("2", Some("m")));
        assert_eq!(split_unit("2"), ("2", None));
    }

    #[test]
    fn places_are_those_of_the_text() {
        let source = SourceText::new(
            "f",
            "at_mm = [1]\nstiffness = \"a\"\nrows = [{ d_mm = 2, e_mm = 3 }]",
        );
        let document = TomlDocument::parse_with_units(&source, &UNITS).unwrap();
        let error = document.types::<Format>().unwrap_err().0;
        assert_eq!((error.line, error.column), (3, 21), "{error}");
        assert!(error.to_string().contains("unknown key `e`"), "{error}");
        let twice = SourceText::new("f", "at = [1]\nat_mm = [2]");
        let error = TomlDocument::parse_with_units(&twice, &UNITS)
            .unwrap_err()
            .0;
        assert_eq!((error.line, error.problem.word()), (2, "given_twice"));
    }
}
