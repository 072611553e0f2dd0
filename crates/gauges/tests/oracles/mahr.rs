//! Mahr wired instruments on the DK-U1 cable, 0.001 mm.
//!
//! # Source
//! Mahr operating instructions 3723295. Nothing is said there of overrange (here `ERR3`, cannot be executed), and the rate of continuous
//! sending is the highest of the instrument (here ten a second).

use stiffbench_gauges::Channel;

use super::{CommandLine, EmulatedProtocol, Meter, Oracle};

const UNITS: [(&str, f64, usize); 2] = [("mm", 1e-3, 3), ("inch", 0.0254, 5)];

const PER_SECOND: f64 = 10.0;

/// A longer pause inside a command begins a new one, s.
const LONGEST_PAUSE_S: f64 = 0.020;

const BAD_COMMAND: &str = "ERR2";
const CANNOT: &str = "ERR3";

#[derive(Default)]
struct Mahr {
    line: CommandLine,
    last_byte_s: f64,
    streams: bool,
}

pub(super) fn oracle() -> Oracle {
    Oracle::new(
        Channel::Displacement,
        Meter::new(&UNITS, 0.05, true),
        Mahr::default(),
    )
}

fn number(meter: &Meter) -> String {
    if meter.overloaded() {
        return CANNOT.to_owned();
    }
    format!("{} {}", meter.shown("+", 7), meter.unit())
}

impl Mahr {
    fn handle_command(&mut self, meter: &mut Meter, command: &str) -> String {
        match command {
            "?" => return number(meter),
            "UN?" if meter.unit() == "mm" => return "MM".to_owned(),
            "UN?" => return "IN".to_owned(),
            "ID?" => return "T 4337661 S 12345678".to_owned(),
            "CDT1" => self.streams = true,
            "CDT0" => self.streams = false,
            "RST" => meter.zero(),
            "MM" => _ = meter.set_unit("mm"),
            "IN" => _ = meter.set_unit("inch"),
            "OFF 000" => {}
            _ => return BAD_COMMAND.to_owned(),
        }
        command.to_owned()
    }
}

impl EmulatedProtocol for Mahr {
    fn receive(&mut self, meter: &mut Meter, byte: u8, now_s: f64) -> Vec<u8> {
        if now_s - self.last_byte_s > LONGEST_PAUSE_S {
            self.line = CommandLine::default();
        }
        self.last_byte_s = now_s;
        match self.line.push(byte) {
            Some(command) if !command.is_empty() => {
                format!("{}\r", self.handle_command(meter, &command)).into_bytes()
            }
            _ => Vec::new(),
        }
    }

    fn value(&self, meter: &Meter) -> Vec<u8> {
        format!("{}\r", number(meter)).into_bytes()
    }

    fn per_second(&self) -> Option<f64> {
        self.streams.then_some(PER_SECOND)
    }
}

#[test]
fn it_sends_the_makers_literal_packets() {
    let mut gauge = oracle();
    *gauge.truth.lock().unwrap() = -0.000_415;
    assert_eq!(gauge.receive(b"?\r", 0.0), b"-000.415 mm\r");
    *gauge.truth.lock().unwrap() = 0.012_35 * 0.0254;
    assert_eq!(gauge.receive(b"IN\r?\r", 0.0), b"IN\r+0.01235 inch\r");
    assert_eq!(gauge.receive(b"RS", 1.0), b"");
    assert_eq!(gauge.receive(b"T\r", 1.021), b"ERR2\r");
}
