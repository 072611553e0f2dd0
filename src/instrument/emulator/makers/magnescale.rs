//! Magnescale LT20A, 0.0001 mm; basic format, channel A.
//!
//! # Source
//! LT20A operating manual (formats). Its requests were not among the pages read, so it sends by itself here, ten times a second, each packet
//! ended by `<CR><LF>`.

use crate::instrument::Channel;
use crate::instrument::emulator::gauge::Maker;
use crate::instrument::emulator::meter::{Meter, Range};
use crate::instrument::emulator::wire::{Packets, Stream};

use super::{MILLIMETRE_M, Make, unit};

pub(super) const MAKE: Make = Make {
    name: "magnescale-lt20a",
    range: Range {
        channel: Channel::Displacement,
        units: &[unit("mm", MILLIMETRE_M, 4)],
        capacity_si: 0.06,
        plus_as_truth: true,
    },
    maker: || Box::new(Magnescale::default()),
};

const PER_SECOND: f64 = 10.0;

#[derive(Debug, Default)]
struct Magnescale {
    stream: Stream,
}

/// Channel, sign, seven characters with a point; in overflow an `F` and digits that are none of a value.
fn value(meter: &mut Meter) -> Vec<u8> {
    let value_si = meter.displayed_si();
    let digits = meter.digits(value_si);
    let sign = digits.sign();
    if meter.tool_off {
        return b"AE\r\n".to_vec();
    }
    if meter.overloaded(value_si) {
        return format!("A{sign}F{:06}\r\n", digits.steps).into_bytes();
    }
    format!("A{sign}{}\r\n", digits.zero_filled(7)).into_bytes()
}

impl Maker for Magnescale {
    fn receive(&mut self, _: &mut Meter, _: &[u8], _: f64, _: &mut Packets) {}

    fn tick(&mut self, meter: &mut Meter, now_s: f64, out: &mut Packets) {
        if !self.stream.is_on() {
            self.stream.start(PER_SECOND, now_s);
        }
        for _ in 0..self.stream.due(now_s) {
            out.push(value(meter));
        }
    }

    fn next_due_s(&self) -> Option<f64> {
        Some(self.stream.next_due_s().unwrap_or(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instrument::emulator::Panel;
    use crate::instrument::emulator::makers::test_bench::TestBench;

    #[test]
    fn values_alarms_and_overflow() {
        let mut bench = TestBench::of(&MAKE);
        bench.gauge.tick(0.0);
        bench.set(0.012_345_6);
        assert_eq!(bench.gauge.tick(0.1), b"A+12.3456\r\n");
        bench.set(-0.000_05);
        assert_eq!(bench.gauge.tick(0.2), b"A-00.0500\r\n");
        bench.press(&Panel::Overload(true));
        assert_eq!(bench.gauge.tick(0.3), b"A-F690000\r\n");
        bench.press(&Panel::ToolOff(true));
        assert_eq!(bench.gauge.tick(0.4), b"AE\r\n");
    }
}
