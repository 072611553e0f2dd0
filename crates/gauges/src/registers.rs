//! Modbus RTU: replies, and the number in the registers.
//!
//! # Source
//! MODBUS over Serial Line, Specification and Implementation Guide V1.02, sections 2.5.1 and 6.2.2 (check sum); MODBUS Application Protocol
//! V1.1b3, sections 6.3, 6.4 and 7 (replies, exceptions).

use super::check_sum::modbus_crc;
use super::description::RegisterFormat;

/// Whether the last two bytes are the check sum of those before.
pub(super) fn is_intact(packet: &[u8]) -> bool {
    match packet.split_last_chunk::<2>() {
        Some((body, sum)) => modbus_crc(body).to_le_bytes() == *sum,
        None => false,
    }
}

/// Why a gauge refused a request, if this intact packet reports it.
pub(super) fn exception(packet: &[u8]) -> Option<String> {
    let [_, function, code, ..] = packet else {
        return None;
    };
    (function & 0x80 != 0).then(|| {
        let words = match code {
            1 => "it does not know the function",
            2 => "it has no such registers",
            3 => "it does not accept the number of registers",
            4 => "it has failed",
            6 => "it is busy",
            _ => "for an unspecified reason",
        };
        format!("the gauge refused the request (Modbus exception {code}): {words}")
    })
}

/// Where the value stands in the registers of a reply.
#[derive(Debug, Clone)]
pub(super) struct Registers {
    pub(super) first: usize,
    pub(super) format: RegisterFormat,
    pub(super) low_word_first: bool,
    pub(super) decimals: u8,
    pub(super) scale: f64,
    pub(super) sign: Option<SignBits>,
    pub(super) require: Vec<RequiredBits>,
}

/// The sign in another register than the value.
#[derive(Debug, Clone)]
pub(super) struct SignBits {
    pub(super) register: usize,
    pub(super) mask: u16,
    pub(super) plus: u16,
    pub(super) minus: u16,
}

/// Bits that must be as they should, and why the value must not be used otherwise.
#[derive(Debug, Clone)]
pub(super) struct RequiredBits {
    pub(super) register: usize,
    pub(super) mask: u16,
    pub(super) equals: u16,
    pub(super) otherwise: String,
}

/// A value and its step, in the unit of the gauge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RegisterValue {
    pub(super) value: f64,
    pub(super) step: f64,
}

impl Registers {
    /// The value of an intact reply.
    ///
    /// # Errors
    /// Why there is none.
    pub(super) fn read(&self, packet: &[u8]) -> Result<RegisterValue, String> {
        let data = packet
            .get(3..packet.len().saturating_sub(2))
            .unwrap_or_default();
        let words: Vec<u16> = data
            .chunks_exact(2)
            .map(|pair| u16::from_be_bytes([pair[0], pair[1]]))
            .collect();
        let word = |register: usize| {
            let short = || {
                format!(
                    "the reply has {} registers, not the {} needed",
                    words.len(),
                    register + 1
                )
            };
            words.get(register).copied().ok_or_else(short)
        };
        for bits in &self.require {
            if word(bits.register)? & bits.mask != bits.equals {
                return Err(bits.otherwise.clone());
            }
        }
        let (size, step) = self.number(&word)?;
        let sign = match &self.sign {
            None => 1.0,
            Some(sign) => match word(sign.register)? & sign.mask {
                bits if bits == sign.plus => 1.0,
                bits if bits == sign.minus => -1.0,
                bits => return Err(format!("the sign is {bits:#06x}, neither plus nor minus")),
            },
        };
        // Divided, not multiplied: the quotient of two exact numbers is the nearest there is.
        let counts = 10_f64.powi(i32::from(self.decimals));
        Ok(RegisterValue {
            value: sign * size / counts * self.scale,
            step: step / counts * self.scale.abs(),
        })
    }

    /// Number and step of its last digit, in counts.
    fn number(&self, word: &dyn Fn(usize) -> Result<u16, String>) -> Result<(f64, f64), String> {
        let one = word(self.first)?;
        let both = || -> Result<u32, String> {
            let other = word(self.first + 1)?;
            let (high, low) = if self.low_word_first {
                (other, one)
            } else {
                (one, other)
            };
            Ok(u32::from(high) << 16 | u32::from(low))
        };
        match self.format {
            RegisterFormat::U16 => Ok((f64::from(one), 1.0)),
            RegisterFormat::I16 => Ok((f64::from(one.cast_signed()), 1.0)),
            RegisterFormat::U32 => Ok((f64::from(both()?), 1.0)),
            RegisterFormat::I32 => Ok((f64::from(both()?.cast_signed()), 1.0)),
            RegisterFormat::F32 => {
                let number = f32::from_bits(both()?);
                if number.is_finite() {
                    Ok((
                        f64::from(number),
                        f64::from(number.abs().next_up() - number.abs()),
                    ))
                } else {
                    Err("the gauge sent no finite number".to_owned())
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_sums_are_those_of_recorded_requests() {
        // The requests of two public programs, as they send them.
        assert_eq!(
            modbus_crc(&[1, 3, 0, 0, 0, 0x0D]).to_le_bytes(),
            [0x84, 0x0F]
        );
        assert_eq!(modbus_crc(&[1, 3, 0, 0, 0, 2]).to_le_bytes(), [0xC4, 0x0B]);
        assert!(is_intact(&[1, 3, 0, 0, 0, 2, 0xC4, 0x0B]));
        assert!(!is_intact(&[1, 3, 0, 0, 0, 3, 0xC4, 0x0B]));
        assert!(!is_intact(&[1]));
    }

    fn registers(format: RegisterFormat, low_word_first: bool) -> Registers {
        Registers {
            first: 0,
            format,
            low_word_first,
            decimals: 0,
            scale: 1.0,
            sign: None,
            require: Vec::new(),
        }
    }

    #[test]
    fn numbers_are_read_in_every_format_and_word_order() {
        // 0x41460000 is 12.375; check sums are not looked at here.
        let high_first = [1, 3, 4, 0x41, 0x46, 0, 0, 0, 0];
        let low_first = [1, 3, 4, 0, 0, 0x41, 0x46, 0, 0];
        let value = |format, low, packet| registers(format, low).read(packet).unwrap().value;
        assert_eq!(value(RegisterFormat::F32, false, &high_first), 12.375);
        assert_eq!(value(RegisterFormat::F32, true, &low_first), 12.375);
        assert_eq!(value(RegisterFormat::U16, false, &high_first), 16710.0);
        let minus_two = [1, 3, 4, 0xFF, 0xFF, 0xFF, 0xFE, 0, 0];
        assert_eq!(value(RegisterFormat::I32, false, &minus_two), -2.0);
        assert_eq!(
            value(RegisterFormat::U32, false, &minus_two),
            4_294_967_294.0
        );
        assert_eq!(value(RegisterFormat::I16, false, &minus_two), -1.0);
    }

    #[test]
    fn absent_and_non_numeric_registers_are_reported() {
        let not_a_number = [1, 3, 4, 0x7F, 0xC0, 0, 0, 0, 0];
        assert!(
            registers(RegisterFormat::F32, false)
                .read(&not_a_number)
                .is_err()
        );
        assert!(
            registers(RegisterFormat::F32, false)
                .read(&[1, 3, 2, 0, 0, 0, 0])
                .is_err()
        );
        assert!(
            exception(&[1, 0x83, 2, 0xC0, 0xF1])
                .unwrap()
                .contains("no such registers")
        );
        assert_eq!(exception(&[1, 3, 2, 0, 0]), None);
    }
}
