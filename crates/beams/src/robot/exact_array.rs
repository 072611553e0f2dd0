//! Arrays of a robot file with an exact number of entries.

use serde::de::{Deserialize, Deserializer, Error};

/// An array of exactly N entries.
pub(super) fn exactly<'de, D, T, const N: usize>(deserializer: D) -> Result<[T; N], D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    let entries = Vec::deserialize(deserializer)?;
    <[T; N]>::try_from(entries).map_err(|entries: Vec<T>| {
        D::Error::custom(format_args!(
            "this array must have {N} entries, it has {}",
            entries.len()
        ))
    })
}

/// The same for a key that may be absent.
pub(super) fn exactly_if_given<'de, D, T, const N: usize>(
    deserializer: D,
) -> Result<Option<[T; N]>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    exactly(deserializer).map(Some)
}

/// An array of exactly N entries as a type, for use inside other shapes.
#[derive(serde::Deserialize)]
#[serde(bound = "T: Deserialize<'de>")]
pub(super) struct Exactly<T, const N: usize>(
    #[serde(deserialize_with = "exactly")] pub(super) [T; N],
);
