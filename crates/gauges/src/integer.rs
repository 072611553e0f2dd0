//! Integers in hexadecimal digits and in bytes.

/// How an integer is written.
#[derive(Debug, Clone)]
pub(super) struct IntegerShape {
    pub(super) coding: IntegerCoding,
    /// Digits or bytes.
    pub(super) width: usize,
    /// Two's complement over the whole width.
    pub(super) signed: bool,
    /// Decimals of the value.
    pub(super) decimals: u8,
    /// Factor besides.
    pub(super) scale: f64,
}

/// What an integer is written in.
#[derive(Debug, Clone)]
pub(super) enum IntegerCoding {
    /// Sixteen characters for the digits from 0 to 15, the highest digit first; letters in either case.
    Hexadecimal([u8; 16]),
    /// Bytes, the highest first.
    HighByteFirst,
    /// Bytes, the lowest first.
    LowByteFirst,
}

/// Most bits of an integer: exact in `f64`.
const MOST_BITS: usize = 48;

impl IntegerCoding {
    /// Bits of one digit or byte.
    pub(super) fn bits(&self) -> usize {
        match self {
            Self::Hexadecimal(_) => 4,
            Self::HighByteFirst | Self::LowByteFirst => 8,
        }
    }

    /// Most digits or bytes of an integer.
    pub(super) fn widest(&self) -> usize {
        MOST_BITS / self.bits()
    }
}

impl IntegerShape {
    /// The integer at the start of `rest`, if there is one.
    pub(super) fn counts(&self, rest: &[u8]) -> Option<i64> {
        let mut places = Vec::with_capacity(self.width);
        for byte in rest.get(..self.width)? {
            places.push(match &self.coding {
                IntegerCoding::Hexadecimal(digits) => {
                    let digit = |digit: &u8| digit.eq_ignore_ascii_case(byte);
                    digits.iter().position(digit)? as i64
                }
                IntegerCoding::HighByteFirst | IntegerCoding::LowByteFirst => i64::from(*byte),
            });
        }
        if matches!(self.coding, IntegerCoding::LowByteFirst) {
            places.reverse();
        }
        let bits = self.coding.bits();
        let counts = places
            .iter()
            .fold(0, |counts, place| counts << bits | place);
        let range = 1_i64 << (bits * self.width);
        let negative = self.signed && counts >= range / 2;
        Some(if negative { counts - range } else { counts })
    }

    /// The value of so many counts. Divided, not multiplied: the quotient of two exact numbers is the nearest there is.
    pub(super) fn value(&self, counts: i64) -> f64 {
        counts as f64 / 10_f64.powi(i32::from(self.decimals)) * self.scale
    }

    /// Step of the value.
    pub(super) fn step(&self) -> f64 {
        self.value(1).abs()
    }

    /// The integer nearest to a value as it is written; `None` if it has no room.
    pub(super) fn write(&self, value: f64) -> Option<Vec<u8>> {
        let counts = (value / self.value(1)).round();
        let bits = self.coding.bits();
        let range = (1_i64 << (bits * self.width)) as f64;
        let (least, most) = if self.signed {
            (-range / 2.0, range / 2.0 - 1.0)
        } else {
            (0.0, range - 1.0)
        };
        if !(least..=most).contains(&counts) {
            return None;
        }
        let counts = counts as i64;
        let place = |place: usize| (counts >> (bits * place)) & ((1 << bits) - 1);
        let places = (0..self.width).map(place);
        Some(match &self.coding {
            IntegerCoding::Hexadecimal(digits) => places
                .rev()
                .map(|place| digits[usize::try_from(place).unwrap_or_default() & 15])
                .collect(),
            IntegerCoding::HighByteFirst => places.rev().map(|place| place as u8).collect(),
            IntegerCoding::LowByteFirst => places.map(|place| place as u8).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn shape(coding: IntegerCoding, width: usize, signed: bool) -> IntegerShape {
        IntegerShape {
            coding,
            width,
            signed,
            decimals: 3,
            scale: 1.0,
        }
    }

    #[test]
    fn bytes_and_digits_are_read_in_their_order_and_sign() {
        let bytes = [0x01, 0xff, 0xff];
        let high = shape(IntegerCoding::HighByteFirst, 3, true);
        let low = shape(IntegerCoding::LowByteFirst, 3, true);
        assert_eq!(high.counts(&bytes), Some(0x01_ffff));
        assert_eq!(low.counts(&bytes), Some(0xff_ff01 - 0x100_0000));
        let text = shape(IntegerCoding::Hexadecimal(*b"0123456789ABCDEF"), 4, true);
        assert_eq!(text.counts(b"fFfE"), Some(-2));
        assert_eq!(text.value(-2), -0.002);
        assert_eq!(text.counts(b"00G0"), None);
        assert_eq!(text.counts(b"00"), None);
        // The low four bits of each byte, as some desktop gauges send them.
        let nibbles = shape(IntegerCoding::Hexadecimal(*b"0123456789:;<=>?"), 5, false);
        assert_eq!(nibbles.counts(b"0003?"), Some(63));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(counts in -0x8000_i64..0x8000, which in 0_usize..3) {
            let coding = match which {
                0 => IntegerCoding::Hexadecimal(*b"0123456789ABCDEF"),
                1 => IntegerCoding::HighByteFirst,
                _ => IntegerCoding::LowByteFirst,
            };
            let width = 16 / coding.bits();
            let shape = shape(coding, width, true);
            let written = shape.write(shape.value(counts)).unwrap();
            prop_assert_eq!(written.len(), width);
            prop_assert_eq!(shape.counts(&written), Some(counts));
            prop_assert_eq!(shape.write(shape.value(0x8000)), None);
        }
    }
}
