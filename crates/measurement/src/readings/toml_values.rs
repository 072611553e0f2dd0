//! Quantities, words and days as TOML files have them: read and written.

use jiff::civil::Date;
use toml::de::DeValue;
use toml::{Table, Value};

use super::number::{Conversion, NumberReader};
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::toml_text::{self, Read};

/// A word of a closed list, as it stands in files.
pub(super) trait Word: Copy + PartialEq + 'static {
    /// The members of the list with their words.
    const WORDS: &'static [(&'static str, Self)];
    /// The list, for messages.
    const EXPECTED: &'static str;

    fn word(self) -> &'static str {
        Self::WORDS
            .iter()
            .find(|(_, member)| *member == self)
            .map_or("", |(word, _)| word)
    }
}

/// A quantity in SI, from the key `STEM_UNIT`.
pub(super) fn quantity(
    table: &toml_text::TomlTable<'_>,
    stem: &str,
    kind: Kind,
) -> Read<Option<f64>> {
    rate(table, stem, "", kind)
}

/// A quantity whose key goes on behind the unit, as in `slope_um_per_s`.
pub(super) fn rate(
    table: &toml_text::TomlTable<'_>,
    stem: &str,
    suffix: &str,
    kind: Kind,
) -> Read<Option<f64>> {
    let found = with_unit(table, stem, suffix, kind)?;
    found
        .map(|(value, conversion)| in_si(&value, conversion))
        .transpose()
}

/// Quantities in SI, from the key `STEM_UNIT`; none if the key is absent.
pub(super) fn quantities(
    table: &toml_text::TomlTable<'_>,
    stem: &str,
    kind: Kind,
) -> Read<Vec<f64>> {
    let Some((value, conversion)) = with_unit(table, stem, "", kind)? else {
        return Ok(Vec::new());
    };
    let items = value.items()?;
    items.iter().map(|item| in_si(item, conversion)).collect()
}

fn with_unit<'a>(
    table: &toml_text::TomlTable<'a>,
    stem: &str,
    suffix: &str,
    kind: Kind,
) -> Read<Option<(toml_text::TomlValue<'a>, Conversion)>> {
    let Some((key, unit, value)) = table.find_with_unit(stem, suffix, kind) else {
        return Ok(None);
    };
    match Conversion::from_unit(kind, unit) {
        Some(conversion) => Ok(Some((value, conversion))),
        None => Err(table.wrong_unit(key, &value, unit, kind)),
    }
}

pub(super) fn in_si(value: &toml_text::TomlValue<'_>, conversion: Conversion) -> Read<f64> {
    let digits = value.digits()?.as_bytes();
    let number = NumberReader::new(None).read(digits, conversion, 0);
    number.map_err(|_| value.wrong("a finite number"))
}

/// One word of a closed list.
pub(super) fn one_of<W: Word>(value: &toml_text::TomlValue<'_>) -> Read<W> {
    let text = value.parsed().as_str();
    let found = W::WORDS.iter().find(|(word, _)| text == Some(word));
    found
        .map(|(_, member)| *member)
        .ok_or_else(|| value.wrong(W::EXPECTED))
}

/// A day, as a TOML date or as text.
pub(super) fn day(value: &toml_text::TomlValue<'_>) -> Read<Date> {
    let text = match value.parsed() {
        DeValue::String(text) => text.to_string(),
        DeValue::Datetime(time) => time.date.map(|date| date.to_string()).unwrap_or_default(),
        _ => String::new(),
    };
    text.parse()
        .map_err(|_| value.wrong("a date like 2026-03-02"))
}

pub(super) fn put(table: &mut Table, key: &str, value: Option<impl Into<Value>>) {
    if let Some(value) = value {
        table.insert(key.to_owned(), value.into());
    }
}

/// A number with its decimal point `shift` places further right.
pub(super) fn put_number(table: &mut Table, key: &str, value: Option<f64>, shift: i32) {
    put(table, key, value.map(|value| decimal(value, shift)));
}

/// TOML has no whole number beyond that of 63 bits; a seed from there is written as text.
pub(super) fn seed(seed: u64) -> Value {
    i64::try_from(seed).map_or_else(|_| Value::from(seed.to_string()), Value::from)
}

pub(super) fn put_list<T: Into<Value>>(
    table: &mut Table,
    key: &str,
    items: impl Iterator<Item = T>,
) {
    put(table, key, Some(items.collect::<Vec<_>>()));
}

pub(super) fn words<W: Word>(members: &[W]) -> impl Iterator<Item = Value> {
    members.iter().map(|member| word(*member))
}

pub(super) fn word<W: Word>(member: W) -> Value {
    Value::from(member.word())
}

/// The number nearest to the decimal digits of `value`, their point moved; see [`super::number::write_decimal`].
pub(super) fn decimal(value: f64, shift: i32) -> f64 {
    let text = super::number::decimal(value, shift);
    // What is not finite has no digits to move and is not accepted back either.
    text.parse().unwrap_or(value)
}

pub(super) fn date(date: Date) -> Value {
    let text = date.to_string();
    text.parse()
        .map_or_else(|_| Value::from(text), Value::Datetime)
}
