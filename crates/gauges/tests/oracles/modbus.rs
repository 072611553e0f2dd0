//! Two gauges that speak Modbus RTU: an HP-series force gauge, 500 N by 0.1 N, and a Shahe raster indicator, 0.001 mm.
//!
//! # Source
//! Public programs for each; the checksum and the exception reply from the Modbus over serial line specification V1.02. Which sense of force is
//! plus is not known (here compression), nothing is known of overload (the value goes on).

use stiffbench_gauges::Channel;

use super::{EmulatedProtocol, Meter, Oracle};

const SLAVE: u8 = 1;
const READ_REGISTERS: u8 = 3;
const ILLEGAL_ADDRESS: u8 = 2;

/// Bytes of a request to read registers.
const REQUEST: usize = 8;

/// A silence inside a request longer than this ends it, s: longer than 3.5 characters, as a driver sends it.
const END_OF_REQUEST_S: f64 = 0.05;

struct Modbus {
    registers: fn(&Meter) -> Vec<u16>,
    request: Vec<u8>,
    last_byte_s: f64,
}

pub(super) fn force() -> Oracle {
    let meter = Meter::new(&[("N", 1.0, 1)], 500.0, false);
    Oracle::new(Channel::Force, meter, Modbus::of(force_registers))
}

pub(super) fn displacement() -> Oracle {
    let meter = Meter::new(&[("mm", 1e-3, 3)], 0.065_535, true);
    Oracle::new(
        Channel::Displacement,
        meter,
        Modbus::of(displacement_registers),
    )
}

/// A float in the first two registers, the high word first.
fn force_registers(meter: &Meter) -> Vec<u16> {
    let (negative, steps, decimals) = meter.steps();
    let size = steps as f32 / 10_f32.powi(decimals as i32);
    let bits = if negative { -size } else { size }.to_bits();
    let mut registers = vec![0; 13];
    registers[0] = (bits >> 16) as u16;
    registers[1] = bits as u16;
    registers
}

/// Sign in the high byte of the first register, micrometres in the second.
fn displacement_registers(meter: &Meter) -> Vec<u16> {
    let (negative, steps, _) = meter.steps();
    vec![if negative { 0x0100 } else { 0 }, steps.min(0xffff) as u16]
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

fn reply(registers: &[u16]) -> Vec<u8> {
    let mut reply = vec![SLAVE, READ_REGISTERS, 2 * registers.len() as u8];
    reply.extend(registers.iter().flat_map(|register| register.to_be_bytes()));
    with_checksum(reply)
}

impl Modbus {
    fn of(registers: fn(&Meter) -> Vec<u16>) -> Self {
        Self {
            registers,
            request: Vec::new(),
            last_byte_s: 0.0,
        }
    }

    /// The answer to a whole request; none if it is garbled or for another slave.
    fn answer(&self, meter: &Meter, request: &[u8]) -> Vec<u8> {
        let (body, check) = request.split_at(REQUEST - 2);
        if body[0] != SLAVE || checksum(body) != check {
            return Vec::new();
        }
        let start = usize::from(u16::from_be_bytes([body[2], body[3]]));
        let count = usize::from(u16::from_be_bytes([body[4], body[5]]));
        let registers = (self.registers)(meter);
        let asked = registers.get(start..start + count);
        match asked.filter(|_| body[1] == READ_REGISTERS && count > 0) {
            Some(asked) => reply(asked),
            None => with_checksum(vec![SLAVE, body[1] | 0x80, ILLEGAL_ADDRESS]),
        }
    }
}

impl EmulatedProtocol for Modbus {
    fn receive(&mut self, meter: &mut Meter, byte: u8, now_s: f64) -> Vec<u8> {
        if now_s - self.last_byte_s > END_OF_REQUEST_S {
            self.request.clear();
        }
        self.last_byte_s = now_s;
        self.request.push(byte);
        if self.request.len() < REQUEST {
            return Vec::new();
        }
        let request = std::mem::take(&mut self.request);
        self.answer(meter, &request)
    }

    fn value(&self, meter: &Meter) -> Vec<u8> {
        reply(&(self.registers)(meter))
    }
}

#[test]
fn the_literal_requests_are_answered() {
    let mut gauge = force();
    *gauge.truth.lock().unwrap() = -12.5;
    let answer = gauge.receive(&[0x01, 0x03, 0x00, 0x00, 0x00, 0x0d, 0x84, 0x0f], 0.0);
    // 12.5 is 0x41480000.
    assert_eq!(answer[..7], [0x01, 0x03, 0x1a, 0x41, 0x48, 0x00, 0x00]);
    assert_eq!(answer.len(), 3 + 26 + 2);
    let mut gauge = displacement();
    *gauge.truth.lock().unwrap() = -0.000_415;
    let answer = gauge.receive(&[0x01, 0x03, 0x00, 0x00, 0x00, 0x02, 0xc4, 0x0b], 0.0);
    assert_eq!(answer[..7], [0x01, 0x03, 0x04, 0x01, 0x00, 0x01, 0x9f]);
    assert_eq!(answer.len(), 9);
}
