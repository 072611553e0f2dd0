//! Heidenhain ND 28x with a length gauge, 0.001 mm.
//!
//! # Source
//! ND 221 B, 231 B, 281 B and 287 user's manuals. The remote key commands and the texts that begin with `<STX>` are not emulated, but for the
//! error text; the zero is set at the panel.

use crate::Channel;
use crate::emulator::gauge::Maker;
use crate::emulator::meter::{Meter, Range};
use crate::emulator::wire::Packets;

use super::{INCH_M, MILLIMETRE_M, Make, unit};

pub(super) const MAKE: Make = Make {
    name: "heidenhain-nd28x",
    range: || Range {
        channel: Channel::Displacement,
        units: vec![unit("mm", MILLIMETRE_M, 3), unit("inch", INCH_M, 5)],
        capacity_si: 0.1,
        plus_as_truth: true,
    },
    maker: || Box::new(Heidenhain::default()),
};

const REQUEST: u8 = 0x02;
const ERROR_TEXT: u8 = 0x05;
const CONTINUE: u8 = 0x11;
const INTERRUPT: u8 = 0x13;

#[derive(Debug, Default)]
struct Heidenhain {
    interrupted: bool,
}

/// Sign, ten characters, blank, unit, sorting status, series letter: 17 bytes with the end mark.
fn value(meter: &mut Meter) -> Vec<u8> {
    let value_si = meter.displayed_si();
    let digits = meter.digits(value_si);
    let unit = match meter.unit_place() {
        _ if meter.overloaded(value_si) || meter.tool_off => '?',
        0 => ' ',
        _ => '"',
    };
    let series = if meter.peak_mode { 'G' } else { ' ' };
    let sign = digits.sign();
    format!("{sign}{} {unit} {series}\r\n", digits.blank_filled(10)).into_bytes()
}

impl Maker for Heidenhain {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], _now_s: f64, out: &mut Packets) {
        for byte in bytes {
            match *byte {
                INTERRUPT => self.interrupted = true,
                CONTINUE => self.interrupted = false,
                REQUEST if !self.interrupted => out.push(value(meter)),
                ERROR_TEXT if meter.tool_off => out.push(b"\x02SIGNAL X\r\n".to_vec()),
                ERROR_TEXT => out.push(b"\x02\r\n".to_vec()),
                _ => {}
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
    use crate::emulator::Panel;
    use crate::emulator::makers::test_bench::TestBench;

    #[test]
    fn values_have_seventeen_bytes_in_fixed_columns() {
        let mut bench = TestBench::of(&MAKE);
        let value = bench.set(0.012_345).ask("\x02");
        assert_eq!((value.as_str(), value.len()), ("+    12.345    \r\n", 17));
        bench.press(&Panel::Unit("inch".into()));
        assert_eq!(bench.set(-0.0254).ask("\x02"), "-   1.00000 \"  \r\n");
    }

    #[test]
    fn a_fault_stands_in_the_column_of_the_unit_behind_a_number() {
        let mut bench = TestBench::of(&MAKE);
        bench.press(&Panel::ToolOff(true));
        assert_eq!(bench.ask("\x02"), "+     0.000 ?  \r\n");
        bench.press(&Panel::ToolOff(false));
        assert_eq!(bench.set(0.2).ask("\x02"), "+   200.000 ?  \r\n");
    }

    #[test]
    fn it_waits_while_it_is_interrupted_and_marks_a_series() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.ask("\x13\x02"), "");
        assert_eq!(bench.ask("\x11\x02").len(), 17);
        bench.press(&Panel::PeakMode(true));
        assert_eq!(bench.ask("\x02"), "+     0.000   G\r\n");
    }
}
