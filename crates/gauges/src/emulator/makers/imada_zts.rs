//! IMADA ZTS, 500 N by 0.1 N (X commands).
//!
//! # Source
//! Two public programs; the grammar is known in part. Bytes 7 to 14 of a value, the marker in front, the overload mark and the direction of
//! plus are not: here `r`, noughts, none, compression. The emulated gauge must therefore not be taken for one.

use crate::Channel;
use crate::emulator::gauge::Maker;
use crate::emulator::meter::{KILOGRAM_FORCE_N, Meter, POUND_FORCE_N, Range};
use crate::emulator::wire::{CommandLine, Packets, Stream};

use super::{Make, unit};

pub(super) const MAKE: Make = Make {
    name: "imada-zts",
    range: || Range {
        channel: Channel::Force,
        units: vec![
            unit("N", 1.0, 1),
            unit("kgf", KILOGRAM_FORCE_N, 2),
            unit("lbf", POUND_FORCE_N, 1),
        ],
        capacity_si: 500.0,
        plus_as_truth: false,
    },
    maker: || Box::new(ImadaZts::default()),
};

/// Codes of the units of the gauge's six value slots: N, kgf, lbf, and the same again.
const UNIT_CODES: &str = "020811020811";

#[derive(Debug, Default)]
struct ImadaZts {
    line: CommandLine,
    stream: Stream,
}

fn value(meter: &mut Meter) -> Vec<u8> {
    let digits = meter.shown();
    let number = format!("{}{}", digits.sign(), digits.zero_filled(5));
    format!("r{number}00000000{}\r", meter.unit_place()).into_bytes()
}

impl Maker for ImadaZts {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], now_s: f64, out: &mut Packets) {
        for &byte in bytes {
            match self.line.push(byte).as_deref() {
                Some("XAR") => out.push(value(meter)),
                Some("XFC") => out.push(format!("XFC{UNIT_CODES}\r").into_bytes()),
                Some("XAg") => self.stream.start(10.0, now_s),
                Some("XAG") => self.stream.start(2000.0, now_s),
                Some("XAS") => self.stream.stop(),
                _ => {}
            }
        }
    }

    fn tick(&mut self, meter: &mut Meter, now_s: f64, out: &mut Packets) {
        for _ in 0..self.stream.due(now_s) {
            out.push(value(meter));
        }
    }

    fn next_due_s(&self) -> Option<f64> {
        self.stream.next_due_s()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::Panel;
    use crate::emulator::makers::test_bench::TestBench;

    #[test]
    fn the_unit_is_a_place_in_a_list() {
        let mut bench = TestBench::of(&MAKE);
        let value = bench.set(-56.7).ask("XAR\r");
        assert_eq!(value.len(), 17);
        assert_eq!((&value[1..7], &value[15..16]), ("+056.7", "0"));
        bench.press(&Panel::Unit("lbf".into()));
        let value = bench.ask("XAR\r");
        assert_eq!((&value[1..7], &value[15..16]), ("+012.7", "2"));
        assert_eq!(bench.ask("XFC\r"), "XFC020811020811\r");
    }

    #[test]
    fn it_streams_ten_or_two_thousand_a_second() {
        let mut bench = TestBench::of(&MAKE);
        bench.ask("XAg\r");
        assert_eq!(bench.packets_in_s(0.0, 2.0), 20);
        bench.gauge.receive(b"XAG\r", 2.0);
        assert!(bench.packets_in_s(2.0, 1.0) >= 1999);
        bench.ask("XAS\r");
        assert_eq!(bench.packets_in_s(3.0, 1.0), 0);
    }
}
