//! Mitutoyo `01A` packets: a tool of 0.001 mm behind a USB-ITN adapter or a gauge interface.
//!
//! # Source
//! QM-Height user's manual (data packet), public programs for the USB-ITN (status packets, commands). What the device information says is
//! not stated. The zero is set at the tool; the unit is not in the packet.

use crate::Channel;
use crate::emulator::gauge::Maker;
use crate::emulator::meter::{Meter, Range};
use crate::emulator::wire::{CommandLine, Packets};

use super::{INCH_M, MILLIMETRE_M, Make, unit};

pub(super) const MAKE: Make = Make {
    name: "mitutoyo-01a",
    range: || Range {
        channel: Channel::Displacement,
        units: vec![unit("mm", MILLIMETRE_M, 3), unit("in", INCH_M, 5)],
        capacity_si: 0.05,
        plus_as_truth: true,
    },
    maker: || Box::new(Mitutoyo::default()),
};

/// Code 9, channel 1, nothing comes from the tool; it parses as the number 911.
const NO_DATA: &[u8] = b"911\r";

#[derive(Debug, Default)]
struct Mitutoyo {
    line: CommandLine,
}

fn value(meter: &mut Meter) -> Vec<u8> {
    if meter.tool_off {
        return NO_DATA.to_vec();
    }
    let digits = meter.shown();
    format!("01A{}{}\r", digits.sign(), digits.zero_filled(8)).into_bytes()
}

impl Maker for Mitutoyo {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], _now_s: f64, out: &mut Packets) {
        for &byte in bytes {
            match self.line.push(byte).as_deref() {
                Some("1") => out.push(value(meter)),
                Some("V") => out.push(b"1USB-ITN 1.00\r".to_vec()),
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
    fn it_sends_the_makers_literal_packets() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.set(0.000_123).ask("1\r"), "01A+0000.123\r");
        bench.press(&Panel::Unit("in".into()));
        assert_eq!(bench.set(0.12345 * 0.0254).ask("1\r"), "01A+00.12345\r");
    }

    #[test]
    fn a_tool_that_is_off_is_three_digits_without_a_sign() {
        let mut bench = TestBench::of(&MAKE);
        bench.press(&Panel::ToolOff(true));
        assert_eq!(bench.ask("1\r"), "911\r");
        bench.press(&Panel::ToolOff(false));
        assert_eq!(bench.set(-0.0007).ask("1\r"), "01A-0000.700\r");
    }

    #[test]
    fn the_data_key_sends_and_the_zero_is_set_at_the_tool() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.set(0.002).press(&Panel::DataKey), "01A+0002.000\r");
        bench.press(&Panel::Zero);
        assert_eq!(bench.ask("1\r"), "01A+0000.000\r");
        assert_eq!(bench.ask("Z\r"), "");
    }
}
