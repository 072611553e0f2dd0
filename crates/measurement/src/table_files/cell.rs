//! What a cell holds: nothing, a number, a time, or words.

use super::times::TimeStamp;
use crate::readings::DecimalSign;

/// What kind of text a cell holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CellKind {
    /// Nothing, or a word for nothing.
    Absent,
    /// A number in one of the usual spellings, or a time.
    Numeric,
    /// Anything else.
    Words,
}

/// The kind of a cell without blanks around it.
pub(super) fn kind(text: &str) -> CellKind {
    if is_absent(text) {
        CellKind::Absent
    } else if DecimalHint::of(text).is_some() || TimeStamp::parse(text).is_some() {
        CellKind::Numeric
    } else {
        CellKind::Words
    }
}

/// Whether a cell states that there is no value.
pub(super) fn is_absent(text: &str) -> bool {
    const WORDS: [&str; 6] = ["NA", "N/A", "#N/A", "NaN", "null", "none"];
    text.bytes().all(|b| b == b'-') || WORDS.iter().any(|word| text.eq_ignore_ascii_case(word))
}

/// What the marks in a number say of the decimal sign of its file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DecimalHint {
    /// No mark.
    None,
    /// The mark can only be the decimal sign, or only that between thousands.
    Sign(DecimalSign),
    /// One mark with three digits behind it: decimals or thousands.
    Either(DecimalSign),
}

impl DecimalHint {
    /// Those of a number; `None` of what is no number in any spelling.
    pub(super) fn of(text: &str) -> Option<Self> {
        let unsigned = unsigned(text);
        if ["inf", "infinity"]
            .iter()
            .any(|word| unsigned.eq_ignore_ascii_case(word))
        {
            return Some(Self::None);
        }
        let (digits, has_exponent) = mantissa(unsigned)?;
        let mut marks = digits.char_indices().filter(|(_, c)| !c.is_ascii_digit());
        let is_mark = |c: char| matches!(c, ',' | '.' | '\'' | '’') || is_blank(c);
        if digits.chars().any(|c| !c.is_ascii_digit() && !is_mark(c))
            || !digits.contains(|c: char| c.is_ascii_digit())
        {
            return None;
        }
        let points = digits.matches('.').count();
        let commas = digits.matches(',').count();
        let sign = |place: Option<usize>, sign, other| {
            let place = place?;
            grouped(&digits[..place], other).then_some(DecimalHint::Sign(sign))
        };
        Some(match (points, commas) {
            (0, 0) => {
                let first = marks.next();
                match first {
                    None => DecimalHint::None,
                    Some((_, mark)) if grouped(digits, Some(mark)) => DecimalHint::None,
                    Some(_) => return None,
                }
            }
            (1, 0) => one_mark(digits, '.', DecimalSign::Point, has_exponent)?,
            (0, 1) => one_mark(digits, ',', DecimalSign::Comma, has_exponent)?,
            (1, _) if digits.rfind(',') < digits.find('.') => {
                sign(digits.find('.'), DecimalSign::Point, Some(','))?
            }
            (_, 1) if digits.rfind('.') < digits.find(',') => {
                sign(digits.find(','), DecimalSign::Comma, Some('.'))?
            }
            (_, 0) if grouped(digits, Some('.')) => DecimalHint::Sign(DecimalSign::Comma),
            (0, _) if grouped(digits, Some(',')) => DecimalHint::Sign(DecimalSign::Point),
            _ => return None,
        })
    }
}

fn one_mark(
    digits: &str,
    mark: char,
    sign: DecimalSign,
    has_exponent: bool,
) -> Option<DecimalHint> {
    let (whole, part) = digits.split_once(mark)?;
    if !part.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let blanks = whole.chars().find(|c| !c.is_ascii_digit());
    if blanks.is_some() && !grouped(whole, blanks) {
        return None;
    }
    let either = blanks.is_none() && !has_exponent && grouped(digits, Some(mark));
    Some(if either {
        DecimalHint::Either(sign)
    } else {
        DecimalHint::Sign(sign)
    })
}

fn is_blank(c: char) -> bool {
    matches!(c, ' ' | '\u{a0}' | '\u{202f}' | '\u{2009}')
}

fn unsigned(text: &str) -> &str {
    text.strip_prefix(['+', '-', '−']).unwrap_or(text)
}

/// The text before the exponent, and whether there is one; `None` if the exponent is none.
fn mantissa(text: &str) -> Option<(&str, bool)> {
    match text.split_once(['e', 'E']) {
        None => Some((text, false)),
        Some((digits, exponent)) => {
            let whole = unsigned(exponent);
            let is_whole = !whole.is_empty() && whole.bytes().all(|b| b.is_ascii_digit());
            is_whole.then_some((digits, true))
        }
    }
}

/// Whether digits stand in groups of three with one mark between them, the first of one to three and not zero; or without any mark.
fn grouped(digits: &str, mark: Option<char>) -> bool {
    let all = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
    let Some(mark) = mark.filter(|mark| digits.contains(*mark)) else {
        return all(digits);
    };
    let mut groups = digits.split(mark);
    let first = groups.next().unwrap_or("");
    (1..=3).contains(&first.len())
        && all(first)
        && !first.starts_with('0')
        && groups.all(|group| group.len() == 3 && all(group))
}

/// The marks of the numbers of a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NumberMarks {
    /// The decimal sign.
    pub(super) decimal: DecimalSign,
    /// A sign seen between thousands.
    pub(super) thousands: Option<char>,
}

/// Why a text is no number of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CellFault {
    /// It is none in any spelling.
    NotANumber,
    /// It is one with the other decimal sign.
    OtherDecimalSign,
}

impl NumberMarks {
    /// The decimal sign.
    pub(super) fn sign(self) -> char {
        match self.decimal {
            DecimalSign::Point => '.',
            DecimalSign::Comma => ',',
        }
    }

    /// The sign between the thousands of a number; `None` without one.
    pub(super) fn thousands_of(self, text: &str) -> Option<char> {
        let (digits, _) = mantissa(unsigned(text))?;
        let whole = digits.split(self.sign()).next()?;
        whole.chars().find(|c| !c.is_ascii_digit())
    }

    /// The number with a decimal point and nothing between its thousands.
    pub(super) fn plain(self, text: &str, into: &mut String) -> Result<(), CellFault> {
        into.clear();
        let hint = DecimalHint::of(text).ok_or(CellFault::NotANumber)?;
        if matches!(hint, DecimalHint::Sign(sign) if sign != self.decimal) {
            return Err(CellFault::OtherDecimalSign);
        }
        let decimal = self.sign();
        for c in text.chars() {
            match c {
                '−' => into.push('-'),
                c if c == decimal => into.push('.'),
                ',' | '.' | '\'' | '’' => {}
                c if is_blank(c) => {}
                c => into.push(c),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use DecimalSign::{Comma, Point};

    #[test]
    fn forms_of_numbers() {
        for (text, hint) in [
            ("12", DecimalHint::None),
            ("-1e-3", DecimalHint::None),
            ("1 234 567", DecimalHint::None),
            ("1'234", DecimalHint::None),
            ("1.5", DecimalHint::Sign(Point)),
            ("−1,5E+03", DecimalHint::Sign(Comma)),
            (".5", DecimalHint::Sign(Point)),
            ("5.", DecimalHint::Sign(Point)),
            ("0,125", DecimalHint::Sign(Comma)),
            ("1,234", DecimalHint::Either(Comma)),
            ("1.234", DecimalHint::Either(Point)),
            ("1.234e3", DecimalHint::Sign(Point)),
            ("1,234.5", DecimalHint::Sign(Point)),
            ("1.234.567,8", DecimalHint::Sign(Comma)),
            ("1,234,567", DecimalHint::Sign(Point)),
            ("1.234.567", DecimalHint::Sign(Comma)),
            ("1 234,5", DecimalHint::Sign(Comma)),
        ] {
            assert_eq!(DecimalHint::of(text), Some(hint), "{text}");
        }
        for text in [
            "",
            "-",
            "N",
            "1.2.3",
            "1,23,456",
            "1 23",
            "5 200,1 1",
            "e5",
            "1e",
            "1.5 N",
            "0x10",
            "12,34.5",
            ".",
        ] {
            assert_eq!(DecimalHint::of(text), None, "{text}");
        }
    }

    #[test]
    fn numbers_become_plain() {
        let comma = NumberMarks {
            decimal: Comma,
            thousands: None,
        };
        let point = NumberMarks {
            decimal: Point,
            thousands: None,
        };
        let mut plain = String::new();
        for (marks, text, expected) in [
            (comma, "−1.234,5", "-1234.5"),
            (comma, "1.234", "1234"),
            (comma, "1\u{a0}234,5e-3", "1234.5e-3"),
            (point, "1,234.5", "1234.5"),
            (point, "1'234.5", "1234.5"),
            (point, "1.234", "1.234"),
        ] {
            marks.plain(text, &mut plain).unwrap();
            assert_eq!(plain, expected);
        }
        assert_eq!(
            comma.plain("1.5", &mut plain),
            Err(CellFault::OtherDecimalSign)
        );
        assert_eq!(point.plain("12 N", &mut plain), Err(CellFault::NotANumber));
        assert_eq!(comma.thousands_of("1.234,5"), Some('.'));
        assert_eq!(comma.thousands_of("1234,5"), None);
    }

    #[test]
    fn kinds_of_cells() {
        for absent in ["", "NA", "nan", "----", "#N/A"] {
            assert_eq!(kind(absent), CellKind::Absent);
        }
        assert_eq!(kind("2024-01-02 10:00:00"), CellKind::Numeric);
        assert_eq!(kind("inf"), CellKind::Numeric);
        assert_eq!(kind("12 N"), CellKind::Words);
    }
}
