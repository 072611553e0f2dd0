//! TOML texts, read with the place of every key and value: the one way from a TOML file to what it says.
//!
//! A format with types of its own is read by [`read`]; one that is read key by key by [`TomlDocument`], [`TomlTable`] and [`TomlValue`].

mod document;
mod problem;
mod table;
mod types;
mod unit_keys;

pub use document::{DocumentStep, TomlDocument, TomlNumber};
pub use problem::{TomlError, TomlProblem, UnknownKey};
pub use table::{TomlTable, TomlValue};
pub use types::{Known, read, read_types, remove_null};
pub use unit_keys::split_unit;

/// A value, or what is wrong in its place.
pub type Read<T> = Result<T, TomlError>;

/// A text in the quotes that TOML needs for it.
#[must_use]
pub fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

#[cfg(test)]
mod tests;
