//! Decimal numbers of fixed shape.

use super::sample::Channel;

/// How a number is written.
#[derive(Debug, Clone)]
pub(super) struct NumberShape {
    /// Least characters, point and blanks counted.
    pub(super) least: usize,
    /// Most characters.
    pub(super) most: usize,
    /// Least points.
    pub(super) least_points: usize,
    /// Most points.
    pub(super) most_points: usize,
    /// Decimals where no point is sent.
    pub(super) decimals: u8,
    /// Blanks before the first digit.
    pub(super) leading_blanks: bool,
    /// A comma may stand for the point.
    pub(super) comma: bool,
    /// The last digit is sent first.
    pub(super) reversed: bool,
    /// What it measures and in which unit, where that is not what the gauge does.
    pub(super) other: Option<(Channel, String)>,
}

/// A number as it was sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Digits {
    /// The digits without point, as a whole number.
    pub(super) mantissa: u64,
    /// Digits behind the point.
    pub(super) decimals: u8,
}

/// Most digits of a number: more than any gauge has, and exact in `f64`.
pub(super) const MOST_DIGITS: usize = 15;

impl NumberShape {
    /// Lengths that the number can take at the start of `rest`, the longest first.
    pub(super) fn lengths(&self, rest: &[u8]) -> Vec<(usize, usize)> {
        let (mut digits, mut points) = (0, 0);
        let mut fits = Vec::new();
        for (place, byte) in rest.iter().take(self.most).enumerate() {
            match byte {
                b'0'..=b'9' => digits += 1,
                b'.' => points += 1,
                b',' if self.comma => points += 1,
                b' ' if self.leading_blanks && digits + points == 0 => {}
                _ => break,
            }
            if points > self.most_points || digits > MOST_DIGITS {
                break;
            }
            let length = place + 1;
            if digits > 0 && points >= self.least_points && length >= self.least {
                fits.push((length, 0));
            }
        }
        fits.reverse();
        fits
    }

    /// The number in bytes that fit.
    pub(super) fn read(&self, bytes: &[u8], point_digit: Option<u8>) -> Digits {
        let (mut mantissa, mut behind) = (0_u64, None);
        for place in 0..bytes.len() {
            let place = if self.reversed {
                bytes.len() - 1 - place
            } else {
                place
            };
            let byte = bytes[place];
            match byte {
                b'0'..=b'9' => {
                    mantissa = mantissa * 10 + u64::from(byte - b'0');
                    behind = behind.map(|count: u8| count + 1);
                }
                b'.' | b',' => behind = Some(0),
                _ => {}
            }
        }
        Digits {
            mantissa,
            decimals: behind.or(point_digit).unwrap_or(self.decimals),
        }
    }
}

impl Digits {
    /// The number. Mantissa and power of ten are exact, so the quotient is the nearest `f64` to what was sent.
    pub(super) fn value(self) -> f64 {
        self.mantissa as f64 / self.step_inverse()
    }

    /// Step of the last digit.
    pub(super) fn step(self) -> f64 {
        1.0 / self.step_inverse()
    }

    fn step_inverse(self) -> f64 {
        10_f64.powi(i32::from(self.decimals))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape() -> NumberShape {
        NumberShape {
            least: 3,
            most: 6,
            least_points: 0,
            most_points: 1,
            decimals: 2,
            leading_blanks: true,
            comma: false,
            reversed: false,
            other: None,
        }
    }

    fn lengths(shape: &NumberShape, bytes: &str) -> Vec<usize> {
        let fits = shape.lengths(bytes.as_bytes());
        fits.into_iter().map(|(length, _)| length).collect()
    }

    #[test]
    fn a_number_has_so_many_characters_and_points() {
        let all = shape();
        assert_eq!(lengths(&all, "12.345678"), [6, 5, 4, 3]);
        assert_eq!(lengths(&all, "12"), [] as [usize; 0]);
        assert_eq!(lengths(&all, "12N"), [] as [usize; 0]);
        assert_eq!(lengths(&all, "1.2.3"), [3]);
        assert_eq!(lengths(&all, "1,23"), [] as [usize; 0]);
        assert_eq!(lengths(&all, "...1"), [] as [usize; 0]);
        let with_point = NumberShape {
            least_points: 1,
            ..shape()
        };
        assert_eq!(lengths(&with_point, "123.4"), [5, 4]);
        assert_eq!(lengths(&with_point, "1234"), [] as [usize; 0]);
        let comma = NumberShape {
            comma: true,
            ..shape()
        };
        assert_eq!(lengths(&comma, "1,23"), [4, 3]);
        assert_eq!(lengths(&comma, "1,2,3"), [3]);
    }

    #[test]
    fn blanks_stand_before_the_first_digit_only() {
        assert_eq!(lengths(&shape(), "  1.5 "), [5, 4, 3]);
        assert_eq!(lengths(&shape(), "1 23"), [] as [usize; 0]);
        assert_eq!(lengths(&shape(), "1. 2"), [] as [usize; 0]);
        assert_eq!(lengths(&shape(), ". 12"), [] as [usize; 0]);
        assert_eq!(lengths(&shape(), "    "), [] as [usize; 0]);
        let without = NumberShape {
            leading_blanks: false,
            ..shape()
        };
        assert_eq!(lengths(&without, " 12.5"), [] as [usize; 0]);
    }

    #[test]
    fn a_number_that_no_float_holds_exactly_does_not_fit() {
        let long = NumberShape {
            most: 40,
            ..shape()
        };
        let fits = lengths(&long, "12345678901234567890");
        assert_eq!(fits.first(), Some(&MOST_DIGITS));
        let fits = lengths(&long, "1234567.890123456789");
        assert_eq!(fits.first(), Some(&(MOST_DIGITS + 1)));
    }

    #[test]
    fn digits_are_read_with_their_decimals() {
        let read = |bytes: &str, point_digit| shape().read(bytes.as_bytes(), point_digit);
        let digits = |mantissa, decimals| Digits { mantissa, decimals };
        assert_eq!(read(" 12.305", None), digits(12305, 3));
        assert_eq!(read("0,07", Some(1)), digits(7, 2));
        assert_eq!(read("12.", None), digits(12, 0));
        assert_eq!(read("1234", None), digits(1234, 2));
        assert_eq!(read("1234", Some(3)), digits(1234, 3));
        let reversed = NumberShape {
            reversed: true,
            ..shape()
        };
        assert_eq!(reversed.read(b"503.21", None), digits(12305, 3));
        assert_eq!(digits(12305, 3).value(), 12.305);
        assert_eq!(digits(12305, 3).step(), 0.001);
        assert_eq!(digits(5, 0).step(), 1.0);
    }
}
