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
        for byte in bytes {
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
