//! Numbers and intervals as printed.

use stiffbench_document::sign_of;

pub use crate::digits::significant;
use crate::mismatch::ReadQuantity;
use crate::quantity::METRES_PER_MICROMETRE;
use crate::reported::Reported;
use crate::stiffness::format_value_uncertainty;

/// What a value is printed as, or a dash where there is none.
pub(super) fn or_dash<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "-".to_owned(), text)
}

/// A number with so many digits, or a dash where there is none.
pub(super) fn digits(value: Option<f64>, digits: usize) -> String {
    or_dash(value, |value| significant(value, digits))
}

/// A value and its expanded uncertainty with the digits that count.
///
/// # Arguments
/// - `digits`: of a value without uncertainty.
/// - `none`: what stands where there is nothing.
pub(super) fn value_and_u(
    [value, expanded]: [Option<f64>; 2],
    digits: usize,
    none: &str,
) -> [String; 2] {
    let both = value.zip(expanded);
    let rounded = both.and_then(|(value, expanded)| format_value_uncertainty(value, expanded));
    if let Some(rounded) = rounded {
        return [rounded.value, rounded.uncertainty];
    }
    let alone = value.map(|value| significant(value, digits));
    [alone.unwrap_or_else(|| none.to_owned()), none.to_owned()]
}

/// A reported value and its expanded uncertainty, or a dash.
pub(super) fn with_u(value: &Reported, digits: usize) -> [String; 2] {
    value_and_u([value.value, value.expanded_uncertainty], digits, "-")
}

/// A name with its unit; that of a plain number is not said.
pub(super) fn with_unit(name: &str, unit: &str) -> String {
    match unit {
        "1" => name.to_owned(),
        unit => format!("{name}, {}", sign_of(unit)),
    }
}

/// A unit behind its number; that of a plain number is not said.
pub(super) fn unit_behind(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        unit => format!(" {}", sign_of(unit)),
    }
}

/// A probability as printed.
pub(super) fn p_text(p: f64) -> String {
    if p < 0.01 {
        format!("{p:.1e}")
    } else {
        format!("{p:.2}")
    }
}

/// What was read, with so many digits, and its unit: positions in mm to a hundredth of what a tracker scatters by, displacements in µm,
/// rotations in µrad.
pub(crate) fn reading_shown(
    value: f64,
    quantity: ReadQuantity,
    digits: usize,
) -> (String, &'static str) {
    match quantity {
        ReadQuantity::Position => (format!("{:.3}", 1e3 * value), "mm"),
        _ => (significant(micro(value), digits), quantity.micro_unit()),
    }
}

/// A length in µm, or an angle in µrad.
pub(crate) fn micro(value: f64) -> f64 {
    value / METRES_PER_MICROMETRE
}

/// An interval in words.
#[must_use]
pub(super) fn interval(ends: Option<[f64; 2]>, digits: usize) -> String {
    or_dash(ends, |[a, b]| {
        format!("{} to {}", significant(a, digits), significant(b, digits))
    })
}

/// The interval of a value of a law, of which an end may be open: the bound of what is plausible.
pub(super) fn open_interval(ends: Option<[f64; 2]>, is_open: [bool; 2], digits: usize) -> String {
    let [lower, upper] = [0, 1].map(|end| or_dash(ends, |ends| significant(ends[end], digits)));
    match is_open {
        [false, false] => interval(ends, digits),
        [true, false] => format!("at most {upper}"),
        [false, true] => format!("at least {lower}"),
        [true, true] => "not determined".to_owned(),
    }
}

/// A share with two decimals, or its bound where these would be zero.
pub(super) fn share_of_tables(share: f64) -> String {
    if share < 1e-4 {
        "fewer than 0.01 %".to_owned()
    } else {
        format!("{:.2} %", 100.0 * share)
    }
}
