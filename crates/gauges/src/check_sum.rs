//! Check sums of packets.

use crc::{CRC_16_IBM_3740, CRC_16_MODBUS, CRC_16_XMODEM, Crc};

use super::description::CheckSumKind;
use super::integer::IntegerShape;

/// CRC-16 of Modbus.
const MODBUS: Crc<u16> = Crc::<u16>::new(&CRC_16_MODBUS);
/// CRC-16 with the polynomial 0x1021, start 0.
const XMODEM: Crc<u16> = Crc::<u16>::new(&CRC_16_XMODEM);
/// The same, start 0xFFFF.
const CCITT_FALSE: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

/// A check sum of the bytes before it.
#[derive(Debug, Clone)]
pub(super) struct CheckSum {
    pub(super) kind: CheckSumKind,
    /// First byte of the packet that it covers, from 0.
    pub(super) from: usize,
    /// How it is written.
    pub(super) shape: IntegerShape,
}

impl CheckSumKind {
    /// Its bytes.
    pub(super) fn width(self) -> usize {
        match self {
            Self::Xor | Self::Sum | Self::SumOnesComplement | Self::SumTwosComplement => 1,
            Self::Crc16Modbus | Self::Crc16Xmodem | Self::Crc16CcittFalse => 2,
        }
    }

    fn of(self, bytes: &[u8]) -> u16 {
        let sum = || bytes.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
        match self {
            Self::Xor => bytes.iter().fold(0, |sum, byte| sum ^ byte).into(),
            Self::Sum => sum().into(),
            Self::SumOnesComplement => (!sum()).into(),
            Self::SumTwosComplement => sum().wrapping_neg().into(),
            Self::Crc16Modbus => modbus_crc(bytes),
            Self::Crc16Xmodem => XMODEM.checksum(bytes),
            Self::Crc16CcittFalse => CCITT_FALSE.checksum(bytes),
        }
    }
}

impl CheckSum {
    /// The check sum of the bytes before it.
    pub(super) fn of(&self, before: &[u8]) -> i64 {
        self.kind
            .of(before.get(self.from..).unwrap_or_default())
            .into()
    }

    /// The one that stands at the start of `rest`.
    pub(super) fn sent(&self, rest: &[u8]) -> Option<i64> {
        self.shape.counts(rest)
    }

    /// The check sum of the bytes before it, as it is sent.
    pub(super) fn write(&self, before: &[u8]) -> Option<Vec<u8>> {
        self.shape.write(self.of(before) as f64)
    }
}

/// Check sum of a packet of Modbus RTU: CRC-16/MODBUS; sent low byte first.
///
/// # Source
/// MODBUS over Serial Line, Specification and Implementation Guide V1.02, section 6.2.2.
#[must_use]
pub fn modbus_crc(bytes: &[u8]) -> u16 {
    MODBUS.checksum(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of "123456789": the check values of the catalogue of parametrised CRC algorithms; sums by hand: 49 + 50 + ... + 57 = 477 = 0x1DD.
    #[test]
    fn check_sums_of_nine_digits_are_those_of_the_catalogue() {
        let of = |kind: CheckSumKind| kind.of(b"123456789");
        assert_eq!(of(CheckSumKind::Xor), 0x31);
        assert_eq!(of(CheckSumKind::Sum), 0xDD);
        assert_eq!(of(CheckSumKind::SumOnesComplement), 0x22);
        assert_eq!(of(CheckSumKind::SumTwosComplement), 0x23);
        assert_eq!(of(CheckSumKind::Crc16Modbus), 0x4B37);
        assert_eq!(of(CheckSumKind::Crc16Xmodem), 0x31C3);
        assert_eq!(of(CheckSumKind::Crc16CcittFalse), 0x29B1);
    }
}
