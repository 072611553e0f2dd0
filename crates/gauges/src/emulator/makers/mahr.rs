//! Mahr wired instruments on the DK-U1 cable, 0.001 mm.
//!
//! # Source
//! Mahr operating instructions 3723295. Nothing is said there of overrange (here `ERR3`, cannot be executed), and the rate of continuous
//! sending is the highest of the instrument (here ten a second).

use crate::Channel;
use crate::emulator::gauge::Maker;
use crate::emulator::meter::{Meter, Range};
use crate::emulator::wire::{CommandLine, Packets, Stream};

use super::{INCH_M, MILLIMETRE_M, Make, unit};

pub(super) const MAKE: Make = Make {
    name: "mahr-dk-u1",
    range: || Range {
        channel: Channel::Displacement,
        units: vec![unit("mm", MILLIMETRE_M, 3), unit("inch", INCH_M, 5)],
        capacity_si: 0.05,
        plus_as_truth: true,
    },
    maker: || Box::new(Mahr::default()),
};

const PER_SECOND: f64 = 10.0;

/// A longer pause inside a command begins a new one, s.
const LONGEST_PAUSE_S: f64 = 0.020;

/// Commands that set something of no consequence here; they come back as text.
const SETTINGS: [&str; 10] = [
    "RES0", "RES1", "KEY0", "KEY1", "FA", "OFF 000", "OFF 008", "OFF 120", "PRE1", "PRE0",
];

const BAD_COMMAND: &str = "ERR2";
const CANNOT: &str = "ERR3";
const LOCKED: &str = "ERR4";

#[derive(Debug, Default)]
struct Mahr {
    line: CommandLine,
    stream: Stream,
    last_byte_s: f64,
    locked: bool,
    off: bool,
}

fn value(meter: &mut Meter) -> String {
    let value_si = meter.displayed_si();
    if meter.overloaded(value_si) {
        return CANNOT.to_owned();
    }
    let digits = meter.digits(value_si);
    format!(
        "{}{} {}",
        digits.sign(),
        digits.zero_filled(7),
        meter.unit().name
    )
}

impl Mahr {
    fn obey(&mut self, meter: &mut Meter, command: &str, now_s: f64) -> String {
        match command {
            "?" => return value(meter),
            "UN?" => return if meter.unit_place() == 0 { "MM" } else { "IN" }.to_owned(),
            "KEY?" => return "KEY1".to_owned(),
            "PRE?" => return "PRE +000.000 mm".to_owned(),
            "ID?" => return "T 4337661 S 12345678".to_owned(),
            "VER?" => return "V1.00".to_owned(),
            "LCK0" | "LCK1" => self.locked = command == "LCK1",
            "CDT1" => self.stream.start(PER_SECOND, now_s),
            "CDT0" => self.stream.stop(),
            "OFF" => self.off = true,
            _ if self.locked => return LOCKED.to_owned(),
            "RST" => meter.zero(),
            "ABS" => meter.zero_off(),
            "MM" => _ = meter.set_unit("mm"),
            "IN" => _ = meter.set_unit("inch"),
            _ if SETTINGS.contains(&command) || command.starts_with("PRE ") => {}
            _ => return BAD_COMMAND.to_owned(),
        }
        command.to_owned()
    }
}

impl Maker for Mahr {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], now_s: f64, out: &mut Packets) {
        if self.line.has_begun() && now_s - self.last_byte_s > LONGEST_PAUSE_S {
            self.line.clear();
        }
        self.last_byte_s = now_s;
        for &byte in bytes {
            match self.line.push(byte) {
                Some(command) if !command.is_empty() && !self.off => {
                    out.push(format!("{}\r", self.obey(meter, &command, now_s)).into_bytes());
                }
                _ => {}
            }
        }
    }

    fn tick(&mut self, meter: &mut Meter, now_s: f64, out: &mut Packets) {
        for _ in 0..self.stream.due(now_s) {
            out.push(format!("{}\r", value(meter)).into_bytes());
        }
    }

    fn next_due_s(&self) -> Option<f64> {
        self.stream.next_due_s()
    }

    fn data_key(&mut self, meter: &mut Meter, _now_s: f64, out: &mut Packets) {
        out.push(format!("{}\r", value(meter)).into_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::makers::test_bench::TestBench;

    #[test]
    fn the_unit_is_in_every_packet() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.set(-0.000_415).ask("?\r"), "-000.415 mm\r");
        assert_eq!(
            bench.set(0.012_35 * 0.0254).ask("IN\r?\r"),
            "IN\r+0.01235 inch\r"
        );
    }

    #[test]
    fn a_pause_inside_a_command_begins_a_new_one() {
        let mut bench = TestBench::of(&MAKE);
        assert!(bench.gauge.receive(b"RS", 0.0).is_empty());
        assert_eq!(bench.gauge.receive(b"T\r", 0.019), b"RST\r");
        assert!(bench.gauge.receive(b"RS", 1.0).is_empty());
        assert_eq!(bench.gauge.receive(b"T\r", 1.021), b"ERR2\r");
    }

    #[test]
    fn locks_errors_and_the_absolute_zero() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.ask("HELLO\r"), "ERR2\r");
        assert_eq!(bench.set(0.003).ask("RST\r?\r"), "RST\r+000.000 mm\r");
        assert_eq!(bench.ask("LCK1\rABS\r"), "LCK1\rERR4\r");
        assert_eq!(bench.ask("LCK0\rABS\r?\r"), "LCK0\rABS\r+003.000 mm\r");
        assert_eq!(bench.ask("ID?\r"), "T 4337661 S 12345678\r");
        bench.ask("CDT1\r");
        assert_eq!(bench.packets_in_s(0.0, 1.0), 10);
    }
}
