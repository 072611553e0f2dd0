//! Numbers of the command line, and how large they may be.

use clap::builder::{RangedU64ValueParser, TypedValueParser};

/// A whole number above zero.
#[must_use]
pub fn at_least_one() -> impl TypedValueParser<Value = usize> {
    count_up_to(u64::MAX)
}

/// A whole number above zero, and not beyond a limit.
pub(super) fn count_up_to(most: u64) -> impl TypedValueParser<Value = usize> {
    RangedU64ValueParser::<usize>::new().range(1..=most)
}

/// Most poses of a sample: their places take up to 10 GB.
pub(super) const MOST_POSES: u64 = 100_000_000;

/// Most simulated load cases or positions.
pub(super) const MOST_LOAD_CASES: u64 = 1_000_000;

/// Most replicates of a bootstrap.
pub(super) const MOST_REPLICATES: u64 = 10_000_000;

/// Three finite numbers with commas between them.
pub(super) fn three_numbers(text: &str) -> Result<[f64; 3], String> {
    let numbers: Vec<f64> = text
        .split(',')
        .filter_map(|part| part.trim().parse().ok())
        .filter(|number: &f64| number.is_finite())
        .collect();
    match (numbers.try_into(), text.matches(',').count()) {
        (Ok(three), 2) => Ok(three),
        _ => {
            Err("three numbers with commas between them are needed, for example 0,-50,0".to_owned())
        }
    }
}

/// Parses a positive number of seconds.
///
/// # Errors
/// For anything else, in words.
pub fn seconds(text: &str) -> Result<f64, String> {
    let wrong = "it must be a positive number of seconds";
    number_that(text, |seconds| seconds > 0.0, wrong)
}

/// A finite number for which something holds; else what is wrong.
pub(super) fn number_that(
    text: &str,
    holds: impl Fn(f64) -> bool,
    wrong: &str,
) -> Result<f64, String> {
    let number = text.parse().ok();
    let number = number.filter(|number: &f64| number.is_finite() && holds(*number));
    number.ok_or_else(|| wrong.to_owned())
}
