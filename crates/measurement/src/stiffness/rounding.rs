//! A value and its expanded uncertainty as they are printed.

/// A value and its uncertainty, rounded to the same place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RoundedValue {
    /// The value.
    pub value: String,
    /// The expanded uncertainty, two significant digits.
    pub uncertainty: String,
}

/// Rounds U to two significant digits and the value to the same place (GUM 7.2.6).
///
/// Halves go away from zero, on the decimal digits that identify the number: 9.95 gives 10 and not 9.9, although the nearest
/// binary number lies just below 9.95; and the digit carried over does not become a third one (10, not 10.0). Above 99 the
/// places before the point that are not significant are zeros. `None` if a number is not finite or U is not above zero.
#[must_use]
pub fn format_value_uncertainty(value: f64, expanded: f64) -> Option<RoundedValue> {
    if !value.is_finite() || !expanded.is_finite() || expanded <= 0.0 {
        return None;
    }
    let digits = Decimal::of(expanded)?;
    let place = digits.leading_place() - 1;
    let rounded = digits.rounded_to(place);
    // 99.5 to 100: the leading digit moved up by one place, and the last significant one with it.
    let place = if rounded.mantissa == 100 {
        place + 1
    } else {
        place
    };
    Some(RoundedValue {
        value: Decimal::of(value)?.rounded_to(place).text(),
        uncertainty: digits.rounded_to(place).text(),
    })
}

/// `mantissa` × 10^`exponent`, exactly.
#[derive(Debug, Clone, Copy)]
struct Decimal {
    negative: bool,
    mantissa: u64,
    exponent: i32,
}

impl Decimal {
    /// The shortest decimal that names this `f64`: at most 17 digits.
    fn of(number: f64) -> Option<Self> {
        let text = format!("{:e}", number.abs());
        let (digits, exponent) = text.split_once('e')?;
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        let mantissa = format!("{whole}{fraction}").parse().ok()?;
        let exponent: i32 = exponent.parse().ok()?;
        let decimals = i32::try_from(fraction.len()).ok()?;
        Some(Self {
            negative: number < 0.0,
            mantissa,
            exponent: exponent - decimals,
        })
    }

    /// Power of ten of the first digit.
    fn leading_place(self) -> i32 {
        self.exponent + self.mantissa.checked_ilog10().map_or(0, u32::cast_signed)
    }

    /// Rounded to a multiple of 10^`place`, halves away from zero; a number with fewer places stays as it is, with zeros added.
    fn rounded_to(self, place: i32) -> Self {
        let dropped = place - self.exponent;
        let unit = 10_u64.checked_pow(dropped.unsigned_abs());
        let mantissa = if dropped > 0 {
            unit.map(|unit| {
                self.mantissa / unit + u64::from(self.mantissa % unit >= unit.div_ceil(2))
            })
            .or(Some(0))
        } else {
            unit.and_then(|padding| self.mantissa.checked_mul(padding))
        };
        mantissa.map_or(self, |mantissa| Self {
            mantissa,
            exponent: place,
            ..self
        })
    }

    fn text(self) -> String {
        if self.mantissa == 0 && self.exponent >= 0 {
            return "0".to_owned();
        }
        let is_below_zero = self.negative && self.mantissa != 0;
        let sign = if is_below_zero { "-" } else { "" };
        let digits = self.mantissa.to_string();
        let places = self.exponent.unsigned_abs() as usize;
        if self.exponent >= 0 {
            return format!("{sign}{digits}{}", "0".repeat(places));
        }
        let digits = format!("{digits:0>width$}", width = places + 1);
        let (whole, fraction) = digits.split_at(digits.len() - places);
        format!("{sign}{whole}.{fraction}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rounded(value: f64, expanded: f64) -> (String, String) {
        let rounded = format_value_uncertainty(value, expanded).unwrap();
        (rounded.value, rounded.uncertainty)
    }

    #[test]
    fn the_examples_of_the_gum_come_out_as_printed() {
        // GUM 7.2.6: 10.057 62 Ω with 27 mΩ is given as 10.058 Ω; 28.05 kHz is rounded down to 28 kHz.
        assert_eq!(rounded(10.057_62, 0.027), ("10.058".into(), "0.027".into()));
        assert_eq!(rounded(0.0, 28.05).1, "28");
        // GUM 7.2.4: m = 100.021 47 g, U = 0.79 mg; GUM H.1.7: l = 50.000 838 mm, U = 93 nm.
        assert_eq!(
            rounded(100.021_47, 0.000_79),
            ("100.02147".into(), "0.00079".into())
        );
        assert_eq!(
            rounded(50.000_838, 0.000_093),
            ("50.000838".into(), "0.000093".into())
        );
    }

    #[test]
    fn a_digit_carried_over_does_not_become_a_third() {
        assert_eq!(rounded(123.456, 9.95), ("123".into(), "10".into()));
        assert_eq!(rounded(123.456, 0.995), ("123.5".into(), "1.0".into()));
        assert_eq!(rounded(123.456, 0.0995), ("123.46".into(), "0.10".into()));
        assert_eq!(rounded(1234.0, 99.5), ("1230".into(), "100".into()));
        assert_eq!(rounded(123.456, 9.94), ("123.5".into(), "9.9".into()));
        assert_eq!(rounded(123.456, 0.0996), ("123.46".into(), "0.10".into()));
    }

    #[test]
    fn large_small_and_negative_values_keep_their_place() {
        assert_eq!(
            rounded(-123_456.0, 1234.0),
            ("-123500".into(), "1200".into())
        );
        assert_eq!(rounded(-0.04, 1.2), ("0.0".into(), "1.2".into()));
        assert_eq!(rounded(-4.0, 120.0), ("0".into(), "120".into()));
        assert_eq!(rounded(2.5, 25.0), ("3".into(), "25".into()));
        assert_eq!(rounded(5.0, 0.001), ("5.0000".into(), "0.0010".into()));
    }

    #[test]
    fn what_cannot_be_printed_is_none() {
        for (value, expanded) in [
            (1.0, 0.0),
            (1.0, -1.0),
            (f64::NAN, 1.0),
            (1.0, f64::INFINITY),
        ] {
            assert_eq!(format_value_uncertainty(value, expanded), None);
        }
    }

    proptest! {
        #[test]
        fn two_significant_digits_and_never_far_off(value in -1e6_f64..1e6, exponent in -8.0_f64..8.0) {
            let expanded = 10_f64.powf(exponent);
            let rounded = format_value_uncertainty(value, expanded).unwrap();
            let digits: String = rounded.uncertainty.chars().filter(char::is_ascii_digit).collect();
            let significant = digits.trim_start_matches('0');
            prop_assert!(significant.len() >= 2 && significant[2..].chars().all(|c| c == '0'));
            if rounded.uncertainty.contains('.') {
                prop_assert_eq!(significant.len(), 2);
            }
            let decimals = |text: &str| text.split_once('.').map_or(0, |(_, f)| f.len());
            prop_assert_eq!(decimals(&rounded.value), decimals(&rounded.uncertainty));
            let back: f64 = rounded.uncertainty.parse().unwrap();
            prop_assert!((back - expanded).abs() <= 0.051 * expanded);
            let back: f64 = rounded.value.parse().unwrap();
            prop_assert!((back - value).abs() <= 0.051 * expanded + 1e-9);
        }
    }
}
