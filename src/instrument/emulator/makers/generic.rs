//! A gauge behind a microcontroller that answers a question mark with a line of text: value, blank, unit.

use crate::instrument::Channel;
use crate::instrument::emulator::gauge::Maker;
use crate::instrument::emulator::meter::{Meter, Range};
use crate::instrument::emulator::wire::{CommandLine, Packets};

use super::{INCH_M, MILLIMETRE_M, Make, unit};

pub(super) const FORCE: Make = Make {
    name: "generic-ascii-force",
    range: Range {
        channel: Channel::Force,
        units: &[unit("N", 1.0, 2), unit("kN", 1000.0, 5)],
        capacity_si: 200.0,
        plus_as_truth: true,
    },
    maker: || Box::new(Generic::default()),
};

pub(super) const DISPLACEMENT: Make = Make {
    name: "generic-ascii-displacement",
    range: Range {
        channel: Channel::Displacement,
        units: &[unit("mm", MILLIMETRE_M, 3), unit("in", INCH_M, 5)],
        capacity_si: 0.05,
        plus_as_truth: true,
    },
    maker: || Box::new(Generic::default()),
};

#[derive(Debug, Default)]
struct Generic {
    line: CommandLine,
}

fn value(meter: &mut Meter) -> Vec<u8> {
    let value_si = meter.displayed_si();
    if meter.overloaded(value_si) {
        return b"OVERLOAD\r\n".to_vec();
    }
    let digits = meter.digits(value_si);
    let unit = meter.unit().name;
    format!("{}{} {unit}\r\n", digits.sign_or(""), digits.plain()).into_bytes()
}

impl Maker for Generic {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], _now_s: f64, out: &mut Packets) {
        for &byte in bytes {
            match self.line.push(byte).as_deref() {
                Some("?") => out.push(value(meter)),
                Some("Z") => {
                    meter.zero();
                    out.push(b"OK\r\n".to_vec());
                }
                Some(_) => out.push(b"ERROR\r\n".to_vec()),
                None => {}
            }
        }
    }

    fn data_key(&mut self, meter: &mut Meter, _now_s: f64, out: &mut Packets) {
        out.push(value(meter));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instrument::emulator::makers::test_bench::TestBench;

    #[test]
    fn a_question_mark_is_answered_by_value_and_unit() {
        let mut force = TestBench::of(&FORCE);
        assert_eq!(force.set(-12.345).ask("?\r"), "-12.35 N\r\n");
        assert_eq!(force.ask("Z\r\n?\r\n"), "OK\r\n0.00 N\r\n");
        assert_eq!(force.set(300.0).ask("?\r"), "OVERLOAD\r\n");
        let mut displacement = TestBench::of(&DISPLACEMENT);
        assert_eq!(displacement.set(0.000_415).ask("?\r"), "0.415 mm\r\n");
        assert_eq!(displacement.ask("hello\r"), "ERROR\r\n");
    }
}
