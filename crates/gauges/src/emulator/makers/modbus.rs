//! Two gauges that speak Modbus RTU: an HP-series force gauge, 500 N by 0.1 N, and a Shahe raster indicator, 0.001 mm.
//!
//! # Source
//! Public programs for each; the checksum and the exception reply from the Modbus over serial line specification V1.02. Which sense of force is
//! plus is not known (here compression), nothing is known of overload (the value goes on).

use crate::Channel;
use crate::emulator::gauge::Maker;
use crate::emulator::meter::{Meter, Range};
use crate::emulator::wire::Packets;

use super::{MILLIMETRE_M, Make, unit};

pub(super) const HP: Make = Make {
    name: "hp-modbus",
    range: || Range {
        channel: Channel::Force,
        units: vec![unit("N", 1.0, 1)],
        capacity_si: 500.0,
        plus_as_truth: false,
    },
    maker: || {
        Box::new(Modbus {
            registers: force_registers,
            request: Vec::new(),
            last_byte_s: 0.0,
        })
    },
};

pub(super) const SHAHE: Make = Make {
    name: "shahe-modbus",
    range: || Range {
        channel: Channel::Displacement,
        units: vec![unit("mm", MILLIMETRE_M, 3)],
        capacity_si: 0.065_535,
        plus_as_truth: true,
    },
    maker: || {
        Box::new(Modbus {
            registers: displacement_registers,
            request: Vec::new(),
            last_byte_s: 0.0,
        })
    },
};

const SLAVE: u8 = 1;
const READ_REGISTERS: u8 = 3;
const ILLEGAL_ADDRESS: u8 = 2;

/// Bytes of a read request.
const REQUEST: usize = 8;

/// A silence after which a request has ended, s; far above the 3.5 characters of the specification, as adapters make such pauses.
const END_OF_REQUEST_S: f64 = 0.05;

struct Modbus {
    /// All registers, from address 0.
    registers: fn(&mut Meter) -> Vec<u16>,
    request: Vec<u8>,
    last_byte_s: f64,
}

/// The value as a big-endian IEEE float in newton in the first two of thirteen registers; what the others hold is not known.
fn force_registers(meter: &mut Meter) -> Vec<u16> {
    let digits = meter.shown();
    let size = digits.steps as f32 / 10_f32.powi(digits.decimals as i32);
    let bits = if digits.negative { -size } else { size }.to_bits();
    let mut registers = vec![0; 13];
    registers[0] = (bits >> 16) as u16;
    registers[1] = bits as u16;
    registers
}

/// Sign in the high byte of the first register, micrometres in the second.
fn displacement_registers(meter: &mut Meter) -> Vec<u16> {
    let digits = meter.shown();
    let sign = if digits.negative { 0x0100 } else { 0 };
    vec![sign, digits.steps.min(0xffff) as u16]
}

/// Cyclic redundancy check of Modbus: polynomial 0xA001, reflected, from 0xFFFF; sent low byte first.
fn checksum(bytes: &[u8]) -> [u8; 2] {
    let mut crc = 0xffff_u16;
    for &byte in bytes {
        crc ^= u16::from(byte);
        for _ in 0..8 {
            let carry = crc & 1 == 1;
            crc >>= 1;
            if carry {
                crc ^= 0xa001;
            }
        }
    }
    crc.to_le_bytes()
}

fn with_checksum(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.extend(checksum(&bytes));
    bytes
}

impl Modbus {
    /// The answer to a whole request; none if it is garbled or for another slave.
    fn answer(&self, meter: &mut Meter) -> Option<Vec<u8>> {
        let (body, check) = self.request.split_at(REQUEST - 2);
        if body[0] != SLAVE || checksum(body) != check {
            return None;
        }
        let start = usize::from(u16::from_be_bytes([body[2], body[3]]));
        let count = usize::from(u16::from_be_bytes([body[4], body[5]]));
        let registers = (self.registers)(meter);
        let asked = registers.get(start..start + count);
        let Some(asked) = asked.filter(|_| body[1] == READ_REGISTERS && count > 0) else {
            return Some(with_checksum(vec![SLAVE, body[1] | 0x80, ILLEGAL_ADDRESS]));
        };
        let mut reply = vec![SLAVE, READ_REGISTERS, 2 * count as u8];
        reply.extend(asked.iter().flat_map(|register| register.to_be_bytes()));
        Some(with_checksum(reply))
    }
}

impl Maker for Modbus {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], now_s: f64, out: &mut Packets) {
        if now_s - self.last_byte_s > END_OF_REQUEST_S {
            self.request.clear();
        }
        self.last_byte_s = now_s;
        for &byte in bytes {
            self.request.push(byte);
            if self.request.len() == REQUEST {
                out.extend(self.answer(meter));
                self.request.clear();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::makers::test_bench::TestBench;

    const READ_FORCE: [u8; 8] = [0x01, 0x03, 0x00, 0x00, 0x00, 0x0d, 0x84, 0x0f];
    const READ_DISPLACEMENT: [u8; 8] = [0x01, 0x03, 0x00, 0x00, 0x00, 0x02, 0xc4, 0x0b];

    #[test]
    fn the_literal_requests_are_answered() {
        let mut bench = TestBench::of(&HP);
        let reply = bench.set(-12.5).gauge.receive(&READ_FORCE, 0.0);
        assert_eq!(reply.len(), 3 + 26 + 2);
        // 12.5 is 0x41480000.
        assert_eq!(reply[..7], [0x01, 0x03, 0x1a, 0x41, 0x48, 0x00, 0x00]);
        let mut bench = TestBench::of(&SHAHE);
        let reply = bench.set(-0.000_415).gauge.receive(&READ_DISPLACEMENT, 0.0);
        assert_eq!(reply[..7], [0x01, 0x03, 0x04, 0x01, 0x00, 0x01, 0x9f]);
        assert_eq!(reply.len(), 9);
    }

    #[test]
    fn checksums_are_those_of_the_literal_requests() {
        assert_eq!(checksum(&READ_FORCE[..6]), [0x84, 0x0f]);
        assert_eq!(checksum(&READ_DISPLACEMENT[..6]), [0xc4, 0x0b]);
    }

    #[test]
    fn garbled_requests_are_not_answered_and_wrong_ones_refused() {
        let mut bench = TestBench::of(&SHAHE);
        let mut garbled = READ_DISPLACEMENT;
        garbled[7] = 0;
        assert!(bench.gauge.receive(&garbled, 0.0).is_empty());
        let other = with_checksum(vec![0x01, 0x03, 0x00, 0x40, 0x00, 0x02]);
        let refused = bench.gauge.receive(&other, 0.0);
        assert_eq!(refused[..3], [0x01, 0x83, 0x02]);
        // Half a request is forgotten after a silence.
        assert!(bench.gauge.receive(&READ_DISPLACEMENT[..4], 1.0).is_empty());
        assert_eq!(bench.gauge.receive(&READ_DISPLACEMENT, 1.2).len(), 9);
    }
}
