//! Nidec-Shimpo FG-7000, 500 N by 0.1 N.
//!
//! # Source
//! "Force & Torque Inst. Data Transfer Protocol V1.0" and the RS-232 command sheet of the torque models, whose three-byte commands are taken to
//! hold here too. That sheet lists codes of torque units only, so a unit command changes nothing, as one for an unavailable unit does.

use crate::Channel;
use crate::emulator::gauge::Maker;
use crate::emulator::meter::{KILOGRAM_FORCE_N, Meter, POUND_FORCE_N, Range};
use crate::emulator::wire::{Packets, Stream};

use super::{Make, unit};

pub(super) const MAKE: Make = Make {
    name: "nidec-shimpo-fg7000",
    range: || Range {
        channel: Channel::Force,
        units: vec![
            unit("N", 1.0, 1),
            unit("kgf", KILOGRAM_FORCE_N, 2),
            unit("lbf", POUND_FORCE_N, 2),
        ],
        capacity_si: 500.0,
        plus_as_truth: true,
    },
    maker: || Box::new(Shimpo::default()),
};

/// What begins a command of three bytes: read and stream, zero, unit.
const READ: [u8; 2] = *b"?C";
const ZERO: [u8; 2] = *b"PZ";
const UNIT: [u8; 2] = *b"SP";

/// The answer to a zero command: no text, and no end mark.
const ZEROED: [u8; 2] = [0x52, 0x06];

#[derive(Debug, Default)]
struct Shimpo {
    stream: Stream,
    /// The beginning of a command of three bytes.
    begun: Vec<u8>,
}

/// `[-]digits unit<CR>`; nothing in front is pull.
fn value(meter: &Meter, value_si: f64) -> Vec<u8> {
    let digits = meter.digits(value_si);
    // A display of noughts is sent as one.
    let number = match digits.steps {
        0 => "0".to_owned(),
        _ => digits.plain(),
    };
    format!("{}{number} {}\r", digits.sign_or(""), meter.unit().name).into_bytes()
}

impl Shimpo {
    fn obey(&mut self, meter: &mut Meter, command: [u8; 3], now_s: f64, out: &mut Packets) {
        let [a, b, number] = command;
        match ([a, b], number) {
            (READ, 0x01) => {
                let value_si = meter.displayed_si();
                out.push(value(meter, value_si));
            }
            (READ, 0x02) => self.stream.start(10.0, now_s),
            (READ, 0x03) => self.stream.start(20.0, now_s),
            (READ, 0x04) => self.stream.start(50.0, now_s),
            (READ, 0x05) => self.stream.start(100.0, now_s),
            (READ, 0xff) => self.stream.stop(),
            (ZERO, 0x00) => {
                meter.zero();
                out.push(ZEROED.to_vec());
            }
            _ => {}
        }
    }
}

impl Maker for Shimpo {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], now_s: f64, out: &mut Packets) {
        for (place, &byte) in bytes.iter().enumerate() {
            self.begun.push(byte);
            match self.begun[..] {
                // Alone it asks for the value; before a C it begins a longer command.
                [b'?'] if bytes.get(place + 1) != Some(&b'C') => {
                    self.begun.clear();
                    let value_si = meter.live_si();
                    out.push(value(meter, value_si));
                }
                [b'?' | b'P' | b'S'] => {}
                [a, b] if [READ, ZERO, UNIT].contains(&[a, b]) => {}
                [a, b, number] => {
                    self.begun.clear();
                    self.obey(meter, [a, b, number], now_s, out);
                }
                _ => self.begun.clear(),
            }
        }
    }

    fn tick(&mut self, meter: &mut Meter, now_s: f64, out: &mut Packets) {
        for _ in 0..self.stream.due(now_s) {
            let value_si = meter.displayed_si();
            out.push(value(meter, value_si));
        }
    }

    fn next_due_s(&self) -> Option<f64> {
        self.stream.next_due_s()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::makers::test_bench::TestBench;

    #[test]
    fn it_sends_the_makers_literal_packet() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.gauge.receive(b"?", 0.0), [0x30, 0x20, 0x4e, 0x0d]);
    }

    #[test]
    fn push_is_minus() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.set(-70.0).ask("?"), "-70.0 N\r");
        assert_eq!(bench.set(5.25).ask("?"), "5.3 N\r");
    }

    #[test]
    fn acknowledgements_are_bytes_between_texts() {
        let mut bench = TestBench::of(&MAKE);
        bench.set(-70.0).gauge.receive(&[0x3f, 0x43, 0x04], 0.0);
        assert_eq!(bench.packets_in_s(0.0, 1.0), 50);
        let zeroed = bench.gauge.receive(&[0x50, 0x5a, 0x00], 1.0);
        assert_eq!(zeroed, [0x52, 0x06]);
        assert_eq!(bench.gauge.tick(1.05).last(), Some(&0x0d));
        bench.gauge.receive(&[0x3f, 0x43, 0xff], 1.05);
        assert_eq!(bench.packets_in_s(1.1, 1.0), 0);
        assert_eq!(bench.gauge.receive(&[0x3f, 0x43, 0x01], 2.0), b"0 N\r");
        // A unit that is not available is ignored, and an unknown byte is none of a command.
        assert!(
            bench
                .gauge
                .receive(&[0x53, 0x50, 0x07, 0x41], 2.0)
                .is_empty()
        );
    }
}
