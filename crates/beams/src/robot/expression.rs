//! Lengths and angles as numbers or as signed sums of numbers and parameter names.

use std::fmt::Write as _;

use schemars::JsonSchema;
use serde::Deserialize;

/// A number, or text such as `"y_base + l_A1A2"` or `"-l_C"`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a number or text such as \"a + b\"")]
pub enum Expression {
    /// A number.
    Number(f64),
    /// A signed sum of numbers and names.
    Text(String),
}

/// Why an expression has no value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExpressionError {
    /// A name that is no parameter.
    #[error("`{name}` is not a parameter")]
    UnknownName {
        /// The name.
        name: String,
    },
    /// Text that is no signed sum.
    #[error("`{text}` is not a signed sum of numbers and parameter names")]
    Malformed {
        /// The text.
        text: String,
    },
    /// A value that is not finite, or too large for any length or angle.
    #[error("the value is {value}: it must lie between -1e9 and 1e9")]
    OutOfRange {
        /// The value.
        value: f64,
    },
}

/// Largest length, m, or angle, degrees, that is taken for meant.
///
/// Far beyond any robot, yet small enough that sums and products of the numbers of a file stay finite and that an angle keeps
/// more digits than a file can state.
const LARGEST: f64 = 1e9;

/// The number itself, if it can be a length, an angle or a coefficient.
pub(super) fn in_range(value: f64) -> Result<f64, ExpressionError> {
    if value.abs() <= LARGEST {
        Ok(value)
    } else {
        Err(ExpressionError::OutOfRange { value })
    }
}

impl Expression {
    /// Value of the expression, in the unit of its field; `lookup` gives the value of a parameter.
    ///
    /// # Errors
    /// [`ExpressionError`] for an unknown name, text that is no sum, or a value beyond ±1e9.
    pub fn value(&self, lookup: &dyn Fn(&str) -> Option<f64>) -> Result<f64, ExpressionError> {
        in_range(match self {
            Self::Number(number) => *number,
            Self::Text(text) => sum(text, lookup)?,
        })
    }

    /// The expression with its numbers, not its names, converted; a text that is no sum as it is.
    pub(super) fn with_numbers(&self, convert: &dyn Fn(f64) -> f64) -> Self {
        match self {
            Self::Number(number) => Self::Number(convert(*number)),
            Self::Text(text) => {
                let converted = converted(text, convert);
                Self::Text(converted.unwrap_or_else(|| text.clone()))
            }
        }
    }

    /// The names that stand in the expression, in order.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        if let Self::Text(text) = self {
            for term in text.split(|c: char| c.is_whitespace() || c == '+' || c == '-') {
                if !term.is_empty() && !starts_number(term) {
                    names.push(term.to_owned());
                }
            }
        }
        names
    }
}

/// Whether a term is a number rather than a name.
fn starts_number(term: &str) -> bool {
    term.starts_with(|c: char| c.is_ascii_digit() || c == '.')
}

/// Value of a signed sum.
fn sum(text: &str, lookup: &dyn Fn(&str) -> Option<f64>) -> Result<f64, ExpressionError> {
    let malformed = || ExpressionError::Malformed {
        text: text.to_owned(),
    };
    let mut rest = text.trim();
    let mut total = 0.0;
    let mut first = true;
    while !rest.is_empty() {
        let (sign, unsigned) = match (rest.strip_prefix('-'), rest.strip_prefix('+')) {
            (Some(after), _) => (-1.0, after),
            (_, Some(after)) => (1.0, after),
            _ if first => (1.0, rest),
            _ => return Err(malformed()),
        };
        rest = unsigned.trim_start();
        let end = term_length(rest);
        let (term, after) = rest.split_at(end);
        if term.is_empty() {
            return Err(malformed());
        }
        total += sign * term_value(term, lookup)?;
        rest = after.trim_start();
        first = false;
    }
    if first { Err(malformed()) } else { Ok(total) }
}

/// A text with its numbers converted; `None` where one of them is none.
fn converted(text: &str, convert: &dyn Fn(f64) -> f64) -> Option<String> {
    let mut written = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let end = term_length(rest);
        let (term, after) = rest.split_at(end.max(first.len_utf8()));
        if starts_number(term) {
            write!(written, "{:?}", convert(term.parse().ok()?)).ok()?;
        } else {
            written.push_str(term);
        }
        rest = after;
    }
    Some(written)
}

/// Bytes of the first term: up to a sign that is not part of an exponent, or white space.
fn term_length(text: &str) -> usize {
    let is_number = starts_number(text);
    let mut previous = ' ';
    for (place, c) in text.char_indices() {
        let in_exponent = is_number && matches!(previous, 'e' | 'E');
        if c.is_whitespace() || (matches!(c, '+' | '-') && !in_exponent) {
            return place;
        }
        previous = c;
    }
    text.len()
}

fn term_value(term: &str, lookup: &dyn Fn(&str) -> Option<f64>) -> Result<f64, ExpressionError> {
    if starts_number(term) {
        return term.parse().map_err(|_| ExpressionError::Malformed {
            text: term.to_owned(),
        });
    }
    lookup(term).ok_or_else(|| ExpressionError::UnknownName {
        name: term.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Result<f64, ExpressionError> {
        let lookup = |name: &str| match name {
            "a" => Some(2.0),
            "l_A1A2" => Some(0.155),
            _ => None,
        };
        Expression::Text(text.to_owned()).value(&lookup)
    }

    #[test]
    fn signed_sums() {
        assert_eq!(value("a"), Ok(2.0));
        assert_eq!(value(" -a "), Ok(-2.0));
        assert_eq!(value("0.15 + l_A1A2"), Ok(0.305));
        assert_eq!(value("a-1.5e-1+.5"), Ok(2.35));
    }

    #[test]
    fn what_is_no_sum_is_refused() {
        for text in [
            "", "  ", "a b", "a *2", "2a", "+", "1e", "--a--", "--a", "a - -a", "+-1",
        ] {
            assert!(value(text).is_err(), "{text}");
        }
        assert_eq!(
            value("b"),
            Err(ExpressionError::UnknownName { name: "b".into() })
        );
        let infinite = ExpressionError::OutOfRange {
            value: f64::INFINITY,
        };
        assert_eq!(value("1e999"), Err(infinite));
        assert!(Expression::Number(f64::NAN).value(&|_| None).is_err());
        assert!(value("1e9 + 1").is_err());
    }

    #[test]
    fn numbers_of_a_sum_are_converted_and_names_are_not() {
        let text = |text: &str| Expression::Text(text.to_owned());
        let converted = text("b2 - 20 + 1e1").with_numbers(&|mm| mm / 1e3);
        assert_eq!(converted, text("b2 - 0.02 + 0.01"));
        assert_eq!(text("2a").with_numbers(&|mm| mm / 1e3), text("2a"));
    }

    #[test]
    fn names_of_an_expression() {
        let names = |text: &str| Expression::Text(text.to_owned()).names();
        assert_eq!(names("a - 1e-3 + l_A1A2"), ["a", "l_A1A2"]);
        assert!(names("2.5").is_empty());
        assert!(Expression::Number(1.0).names().is_empty());
    }
}
