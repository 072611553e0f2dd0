//! Numbers as files hold them: decimal point or comma, and a unit that is a power of ten or a factor.

use std::fmt::Write as _;

use stiffbench_units_and_text::quantity::Kind;

/// The sign between the whole and the decimal part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DecimalSign {
    /// `3.5`
    Point,
    /// `3,5`
    Comma,
}

impl DecimalSign {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Comma => "comma",
        }
    }
}

/// How a number in a column's unit becomes SI (°C for temperatures).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Conversion {
    /// The unit is a power of ten of the SI unit.
    ///
    /// The decimal point is moved in the text, so that `4` in µm is the number nearest to 0.000004 m, which a multiplication by
    /// 1e-6 need not give.
    Shift(i32),
    /// The unit is this many SI units.
    Factor(f64),
    /// The value is this much above the value in the unit: kelvin to degrees Celsius.
    Offset(f64),
    /// The value is this many SI units, and so much above zero: degrees Fahrenheit.
    Affine {
        /// SI units in one.
        factor: f64,
        /// SI value of its zero.
        zero: f64,
    },
}

impl Conversion {
    pub(crate) const NONE: Self = Self::Shift(0);

    /// SI units in one unit.
    pub(crate) fn factor(self) -> f64 {
        match self {
            Self::Shift(shift) => 10_f64.powi(shift),
            Self::Factor(factor) | Self::Affine { factor, .. } => factor,
            Self::Offset(_) => 1.0,
        }
    }

    /// The conversion from `unit`; `None` if that is not a unit of this kind.
    ///
    /// Capitals are forgiven where they change nothing: `UM` is taken as `um`, but `MN` is not taken as `mN`, nor `NN` as `nN`.
    pub(crate) fn from_unit(kind: Kind, unit: &str) -> Option<Self> {
        let unit = unit.trim();
        let forgiven = || {
            let alike = |known: &&str| {
                !["mN", "MN", "nN", "MPa", "nm"].contains(known) && known.eq_ignore_ascii_case(unit)
            };
            let known = kind.units().split(", ").find(alike)?;
            Some((known, kind.si_factor(known)?))
        };
        let (unit, factor) = match kind.si_factor(unit) {
            Some(factor) => (unit, factor),
            None => forgiven()?,
        };
        if (kind, unit) == (Kind::Temperature, "K") {
            return Some(Self::Offset(-273.15));
        }
        if kind == Kind::Temperature && factor != 1.0 {
            let zero = -32.0 * factor;
            return Some(Self::Affine { factor, zero });
        }
        let power = [
            (1e-9, -9),
            (1e-6, -6),
            (1e-3, -3),
            (1.0, 0),
            (1e3, 3),
            (1e6, 6),
            (1e9, 9),
        ];
        let shift = power.iter().find(|(value, _)| *value == factor);
        Some(shift.map_or(Self::Factor(factor), |(_, shift)| Self::Shift(*shift)))
    }
}

/// Why a text is not a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberFault {
    NotANumber,
    NotFinite,
    /// The sign differs from the one settled on this line.
    OtherDecimalSign(DecimalSign, u32),
}

/// Reads numbers of one file, which has one decimal sign.
#[derive(Debug)]
pub(crate) struct NumberReader {
    settled: Option<(DecimalSign, u32)>,
    scratch: String,
}

impl NumberReader {
    /// `sign`: known beforehand, or found out from the first number that has one.
    pub(crate) fn new(sign: Option<DecimalSign>) -> Self {
        Self {
            settled: sign.map(|sign| (sign, 0)),
            scratch: String::new(),
        }
    }

    /// The line that settled a decimal comma.
    pub(crate) fn decimal_comma(&self) -> Option<u32> {
        match self.settled {
            Some((DecimalSign::Comma, line)) => Some(line),
            _ => None,
        }
    }

    /// The number in SI.
    pub(crate) fn read(
        &mut self,
        text: &[u8],
        conversion: Conversion,
        line: u32,
    ) -> Result<f64, NumberFault> {
        let text = std::str::from_utf8(text).map_err(|_| NumberFault::NotANumber)?;
        self.normalise(text, line)?;
        if let Conversion::Shift(shift) = conversion {
            self.shift(shift);
        }
        let number: f64 = self.scratch.parse().map_err(|_| NumberFault::NotANumber)?;
        let value = match conversion {
            Conversion::Shift(_) => number,
            Conversion::Factor(factor) => number * factor,
            Conversion::Offset(offset) => number + offset,
            Conversion::Affine { factor, zero } => number * factor + zero,
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(NumberFault::NotFinite)
        }
    }

    /// Leaves the text with a decimal point in `scratch`.
    fn normalise(&mut self, text: &str, line: u32) -> Result<(), NumberFault> {
        self.scratch.clear();
        self.scratch.push_str(text);
        let Some(at) = text.find([',', '.']) else {
            return Ok(());
        };
        let sign = if text.as_bytes()[at] == b',' {
            DecimalSign::Comma
        } else {
            DecimalSign::Point
        };
        // A comma in a word is not a decimal comma: only what is a number settles the sign.
        if sign == DecimalSign::Comma {
            self.scratch.replace_range(at..=at, ".");
        }
        let rest = &text[at + 1..];
        if rest.contains(['.', ',']) {
            let digits = text
                .bytes()
                .all(|b| b.is_ascii_digit() || b",.+-".contains(&b));
            return Err(match self.settled {
                Some((settled, first)) if digits => NumberFault::OtherDecimalSign(settled, first),
                _ => NumberFault::NotANumber,
            });
        }
        match self.settled {
            Some((settled, first)) if settled != sign => {
                let is_number = self.scratch.parse::<f64>().is_ok();
                Err(if is_number {
                    NumberFault::OtherDecimalSign(settled, first)
                } else {
                    NumberFault::NotANumber
                })
            }
            Some(_) => Ok(()),
            None => {
                if self.scratch.parse::<f64>().is_ok() {
                    self.settled = Some((sign, line));
                }
                Ok(())
            }
        }
    }

    /// Moves the decimal point of the text in `scratch` by `shift` places to the right.
    fn shift(&mut self, shift: i32) {
        if shift == 0
            || !self
                .scratch
                .ends_with(|c: char| c.is_ascii_digit() || c == '.')
        {
            return;
        }
        let exponent = match self.scratch.find(['e', 'E']) {
            Some(at) => match self.scratch[at + 1..].parse::<i32>() {
                Ok(exponent) => {
                    self.scratch.truncate(at);
                    exponent
                }
                // An exponent beyond i32 is zero or infinity in any unit.
                Err(_) => return,
            },
            None => 0,
        };
        // Writing to a String cannot fail.
        let _ = write!(self.scratch, "e{}", exponent.saturating_add(shift));
    }
}

/// A whole number from 0; a decimal part of zeros is forgiven, as spreadsheets and data frames add it.
pub(crate) fn read_count(text: &[u8]) -> Option<u32> {
    let text = std::str::from_utf8(text).ok()?;
    if let Ok(count) = text.parse() {
        return Some(count);
    }
    let at = text.find(['.', ','])?;
    let zeros = text[at + 1..].bytes().all(|b| b == b'0');
    if zeros { text[..at].parse().ok() } else { None }
}

/// `value` in decimal digits, its point moved `shift` places to the right: 4e-6 with 6 gives `4`.
///
/// Rounds to 15 significant digits. That many always survive the way through a double (`f64::DIGITS`), so a gauge's text comes back as it
/// was, and the last-bit noise of a unit change, 4.000000000000001 for 4, does not. The relative change is below 5e-15, at least
/// seven decades under the resolution of any gauge.
pub(crate) fn write_decimal(value: f64, shift: i32, into: &mut String) {
    into.clear();
    if value == 0.0 {
        into.push('0');
        return;
    }
    let mut text = String::with_capacity(24);
    // Writing to a String cannot fail.
    let _ = write!(text, "{value:.14e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent = exponent.parse::<i32>().unwrap_or(0) + shift;
    let (sign, mantissa) = mantissa
        .strip_prefix('-')
        .map_or(("", mantissa), |rest| ("-", rest));
    let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    let digits = digits.trim_end_matches('0');
    into.push_str(sign);
    place_point(digits, exponent, into);
}

/// [`write_decimal`] as a text of its own.
pub(crate) fn decimal(value: f64, shift: i32) -> String {
    let mut text = String::new();
    write_decimal(value, shift, &mut text);
    text
}

/// Digits d1 d2 d3 … with value d1.d2d3… × 10^exponent, written plainly where that is short.
fn place_point(digits: &str, exponent: i32, into: &mut String) {
    // At most 15 digits.
    let count = i32::try_from(digits.len()).unwrap_or(i32::MAX);
    if !(-7..18).contains(&exponent) {
        let (first, rest) = digits.split_at(1);
        let point = if rest.is_empty() { "" } else { "." };
        let _ = write!(into, "{first}{point}{rest}e{exponent}");
    } else if exponent < 0 {
        into.push_str("0.");
        into.extend(std::iter::repeat_n('0', (-exponent - 1) as usize));
        into.push_str(digits);
    } else if exponent >= count - 1 {
        into.push_str(digits);
        into.extend(std::iter::repeat_n('0', (exponent - count + 1) as usize));
    } else {
        let (whole, part) = digits.split_at((exponent + 1) as usize);
        into.push_str(whole);
        into.push('.');
        into.push_str(part);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(text: &str, unit: &str, kind: Kind) -> Result<f64, NumberFault> {
        let conversion = Conversion::from_unit(kind, unit).unwrap();
        NumberReader::new(None).read(text.as_bytes(), conversion, 1)
    }

    fn written(value: f64, shift: i32) -> String {
        let mut text = String::new();
        write_decimal(value, shift, &mut text);
        text
    }

    #[test]
    fn units_give_the_nearest_si_number() {
        assert_eq!(read("4", "um", Kind::Displacement), Ok(4e-6));
        assert_eq!(read("-1.276e3", "um", Kind::Displacement), Ok(-0.001_276));
        assert_eq!(read("0,5", "mm", Kind::Displacement), Ok(5e-4));
        assert_eq!(read("2", "kN", Kind::Force), Ok(2000.0));
        // NIST SP 811 (2008), B.8: 1 lbf = 4.448 222 N, 1 in = 25.4 mm.
        assert!((read("1", "lbf", Kind::Force).unwrap() - 4.448_222).abs() < 1e-6);
        assert_eq!(read("1", "in", Kind::Displacement), Ok(0.025_4));
        assert_eq!(read("293.15", "K", Kind::Temperature), Ok(20.0));
    }

    #[test]
    fn capitals_are_forgiven_unless_they_change_the_unit() {
        let shift = |kind, unit| Conversion::from_unit(kind, unit);
        assert_eq!(shift(Kind::Displacement, "UM"), Some(Conversion::Shift(-6)));
        assert_eq!(shift(Kind::Temperature, "DEGC"), Some(Conversion::Shift(0)));
        assert_eq!(shift(Kind::Force, "mN"), Some(Conversion::Shift(-3)));
        assert_eq!(shift(Kind::Force, "MN"), Some(Conversion::Shift(6)));
        assert_eq!(shift(Kind::Force, "mn"), None);
        assert_eq!(shift(Kind::Force, "mm"), None);
    }

    #[test]
    fn one_file_has_one_decimal_sign() {
        let mut reader = NumberReader::new(None);
        assert_eq!(reader.read(b"7", Conversion::NONE, 2), Ok(7.0));
        assert_eq!(reader.read(b"-9,9", Conversion::NONE, 3), Ok(-9.9));
        assert_eq!(reader.decimal_comma(), Some(3));
        let other = Err(NumberFault::OtherDecimalSign(DecimalSign::Comma, 3));
        assert_eq!(reader.read(b"9.9", Conversion::NONE, 4), other);
        assert_eq!(reader.read(b"1.234,5", Conversion::NONE, 5), other);
    }

    #[test]
    fn text_that_is_no_number_is_reported() {
        let mut reader = NumberReader::new(None);
        let mut fault = |text: &str| reader.read(text.as_bytes(), Conversion::Shift(-6), 1);
        for text in ["abc", "", "12 N", "1,2,3", "0x10", "e", "--1", "a,b"] {
            assert_eq!(fault(text), Err(NumberFault::NotANumber), "{text}");
        }
        for text in ["NaN", "nan", "inf", "-Infinity", "1e999", "1e99999999999"] {
            assert_eq!(fault(text), Err(NumberFault::NotFinite), "{text}");
        }
        assert_eq!(fault("1e-99999999999"), Ok(0.0));
    }

    #[test]
    fn counts_are_whole() {
        assert_eq!(read_count(b"12"), Some(12));
        assert_eq!(read_count(b"3.0"), Some(3));
        assert_eq!(read_count(b"3,0"), Some(3));
        for text in ["-1", "1.5", "", "x", "1e3", "4294967296", ".0"] {
            assert_eq!(read_count(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn written_numbers_have_no_noise() {
        assert_eq!(written(4e-6, 6), "4");
        assert_eq!(written(4.000_000_000_000_001e-6, 6), "4");
        assert_eq!(written(-1276.0 * 1e-6, 6), "-1276");
        assert_eq!(written(0.1 + 0.2, 0), "0.3");
        assert_eq!(written(-0.0, 6), "0");
        assert_eq!(written(1.25e-13, 6), "0.000000125");
        assert_eq!(written(1.5e-15, 6), "1.5e-9");
        assert_eq!(written(1e300, 6), "1e306");
        assert_eq!(written(120.5, 0), "120.5");
        assert_eq!(written(1200.0, 0), "1200");
    }

    proptest! {
        #[test]
        fn gauge_texts_come_back(digits in -999_999_999_999_999_i64..=999_999_999_999_999, places in 0_usize..10) {
            let text = format!("{digits}e-{places}");
            let metres = read(&text, "um", Kind::Displacement).unwrap();
            let again = read(&written(metres, 6), "um", Kind::Displacement).unwrap();
            prop_assert_eq!(metres, again);
        }

        #[test]
        fn any_number_changes_by_less_than_its_fifteenth_digit(value in proptest::num::f64::NORMAL) {
            prop_assume!(value.abs() < 1e300);
            let again: f64 = written(value, 0).parse().unwrap();
            prop_assert!((again - value).abs() <= 5.1e-15 * value.abs());
            prop_assert_eq!(written(again, 0), written(value, 0));
        }
    }
}
