//! Values as they are written into TOML files.

use jiff::civil::Date;
use toml::{Table, Value};

use super::number::write_decimal;
use super::session_file::Word;

pub(super) fn put(table: &mut Table, key: &str, value: Option<Value>) {
    if let Some(value) = value {
        table.insert(key.to_owned(), value);
    }
}

pub(super) fn put_text(table: &mut Table, key: &str, text: Option<&String>) {
    put(table, key, text.map(|text| Value::from(text.as_str())));
}

/// A number with its decimal point `shift` places further right.
pub(super) fn put_number(table: &mut Table, key: &str, value: Option<f64>, shift: i32) {
    put(table, key, value.map(|value| decimal(value, shift).into()));
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
    put(
        table,
        key,
        Some(Value::Array(items.map(Into::into).collect())),
    );
}

pub(super) fn words<W: Word>(members: &[W]) -> impl Iterator<Item = Value> {
    members.iter().map(|member| word(*member))
}

pub(super) fn word<W: Word>(member: W) -> Value {
    Value::from(member.word())
}

/// The number nearest to the decimal digits of `value`, their point moved; see [`write_decimal`].
pub(super) fn decimal(value: f64, shift: i32) -> f64 {
    let mut text = String::new();
    write_decimal(value, shift, &mut text);
    // What is not finite has no digits to move and is not accepted back either.
    text.parse().unwrap_or(value)
}

pub(super) fn date(date: Date) -> Value {
    let text = date.to_string();
    text.parse()
        .map_or_else(|_| Value::from(text), Value::Datetime)
}
