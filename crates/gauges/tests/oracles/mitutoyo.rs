//! Mitutoyo `01A` packets: a tool of 0.001 mm behind a USB-ITN adapter or a gauge interface.
//!
//! # Source
//! QM-Height user's manual (data packet), public programs for the USB-ITN (status packets, commands). What the device information says is
//! not stated. The zero is set at the tool; the unit is not in the packet.

use stiffbench_gauges::Channel;

use super::{CommandLine, EmulatedProtocol, Meter, Oracle, Trouble};

const UNITS: [(&str, f64, usize); 2] = [("mm", 1e-3, 3), ("in", 0.0254, 5)];

/// Code 9, channel 1, nothing comes from the tool; it parses as the number 911.
const NO_DATA: &[u8] = b"911\r";

#[derive(Default)]
struct Mitutoyo {
    line: CommandLine,
}

pub(super) fn oracle() -> Oracle {
    Oracle::new(
        Channel::Displacement,
        Meter::new(&UNITS, 0.05, true),
        Mitutoyo::default(),
    )
}

impl EmulatedProtocol for Mitutoyo {
    fn receive(&mut self, meter: &mut Meter, byte: u8, _now_s: f64) -> Vec<u8> {
        match self.line.push(byte).as_deref() {
            Some("1") => self.value(meter),
            Some("V") => b"1USB-ITN 1.00\r".to_vec(),
            _ => Vec::new(),
        }
    }

    fn value(&self, meter: &Meter) -> Vec<u8> {
        if meter.trouble == Some(Trouble::ToolOff) {
            return NO_DATA.to_vec();
        }
        format!("01A{}\r", meter.shown("+", 8)).into_bytes()
    }
}

#[test]
fn it_sends_the_makers_literal_packets() {
    let mut gauge = oracle();
    *gauge.truth.lock().unwrap() = 0.000_123;
    assert_eq!(gauge.receive(b"1\r", 0.0), b"01A+0000.123\r");
    gauge.meter.set_unit("in");
    *gauge.truth.lock().unwrap() = -0.12345 * 0.0254;
    assert_eq!(gauge.data_key(), b"01A-00.12345\r");
}
