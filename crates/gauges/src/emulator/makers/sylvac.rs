//! Sylvac with an Opto-RS or USB cable, 0.001 mm.
//!
//! # Source
//! Sylvac Opto-RS command list (opto instruments, Unical, Z-Cal), which says that set commands come back as text. The text of the identity and
//! the fields of `SET?` beyond the battery are not printed there, nor is the rate of the stream (here eight a second).

use crate::Channel;
use crate::emulator::gauge::Maker;
use crate::emulator::meter::{Meter, Range};
use crate::emulator::wire::{CommandLine, Packets, Stream};

use super::{INCH_M, MILLIMETRE_M, Make, unit};

pub(super) const MAKE: Make = Make {
    name: "sylvac-opto-rs",
    range: || Range {
        channel: Channel::Displacement,
        units: vec![unit("MM", MILLIMETRE_M, 3), unit("IN", INCH_M, 5)],
        capacity_si: 0.05,
        plus_as_truth: true,
    },
    maker: || Box::new(Sylvac::default()),
};

const PER_SECOND: f64 = 8.0;

/// Commands that set something of no consequence here; they come back as text.
const SETTINGS: [&str; 16] = [
    "NOR", "RES2", "RES3", "CHA*1", "CHA*2", "KEY0", "KEY1", "ON", "SBY", "ECO0", "ECO1", "PRE",
    "DEL", "TOL0", "OUT1", "OUT0",
];

const OUT_OF_RANGE: &str = "ERR3";
const BAD_COMMAND: &str = "ERR1";

#[derive(Debug, Default)]
struct Sylvac {
    line: CommandLine,
    stream: Stream,
    /// `MAX` or `MIN`, if not the value itself is shown.
    extreme: Option<&'static str>,
    reversed: bool,
    held_by_button: bool,
    off: bool,
}

impl Sylvac {
    fn value(&self, meter: &mut Meter) -> String {
        let value_si = match self.extreme {
            Some("MAX") => meter.highest_si(),
            Some(_) => meter.lowest_si(),
            None => meter.displayed_si(),
        };
        if meter.overloaded(value_si) {
            return OUT_OF_RANGE.to_owned();
        }
        let digits = meter.digits(value_si);
        // +012.345, +0.01235: as many places as the display has.
        let width = if digits.decimals == 3 { 7 } else { 8 };
        format!("{}{}", digits.sign(), digits.zero_filled(width))
    }

    fn obey(&mut self, meter: &mut Meter, command: &str, now_s: f64) -> String {
        match command {
            "?" | "PRI" => {
                let value = self.value(meter);
                // A value sent by its own button holds the display; the next request shows it once more and lets it go.
                if std::mem::take(&mut self.held_by_button) {
                    meter.hold(false);
                }
                return value;
            }
            "UNI?" => return meter.unit().name.clone(),
            "MOD?" if meter.peak_mode => return "MAX".to_owned(),
            "MOD?" => return self.extreme.unwrap_or("NOR").to_owned(),
            "CHA?" => return if self.reversed { "CHA-" } else { "CHA+" }.to_owned(),
            "BAT?" => return if meter.battery_low { "BAT0" } else { "BAT1" }.to_owned(),
            "ID?" => return "SYLVAC 12345678".to_owned(),
            "VER?" => return "V1.00".to_owned(),
            "SET?" => {
                let battery = if meter.battery_low { "B0" } else { "B1" };
                return format!("{} NOR RES2 {battery}", meter.unit().name);
            }
            "SET" => meter.zero(),
            "MM" | "IN" => _ = meter.set_unit(command),
            "STO1" | "STO0" => meter.hold(command == "STO1"),
            "MAX" | "MIN" => {
                self.extreme = Some(if command == "MAX" { "MAX" } else { "MIN" });
                meter.clear_peaks();
            }
            "CHA+" | "CHA-" => {
                self.reversed = command == "CHA-";
                meter.invert(self.reversed);
            }
            "OFF" => self.off = true,
            _ if SETTINGS.contains(&command) => self.set(meter, command, now_s),
            _ => return BAD_COMMAND.to_owned(),
        }
        command.to_owned()
    }

    fn set(&mut self, meter: &mut Meter, command: &str, now_s: f64) {
        match command {
            "OUT1" => self.stream.start(PER_SECOND, now_s),
            "OUT0" => self.stream.stop(),
            "NOR" => {
                self.extreme = None;
                meter.peak_mode = false;
            }
            _ => {}
        }
    }
}

impl Maker for Sylvac {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], now_s: f64, out: &mut Packets) {
        for &byte in bytes {
            let Some(command) = self.line.push(byte) else {
                continue;
            };
            if self.off {
                return;
            }
            let command = command.to_ascii_uppercase();
            out.push(format!("{}\r", self.obey(meter, &command, now_s)).into_bytes());
        }
    }

    fn tick(&mut self, meter: &mut Meter, now_s: f64, out: &mut Packets) {
        for _ in 0..self.stream.due(now_s) {
            out.push(format!("{}\r", self.value(meter)).into_bytes());
        }
    }

    fn next_due_s(&self) -> Option<f64> {
        self.stream.next_due_s()
    }

    fn data_key(&mut self, meter: &mut Meter, _now_s: f64, out: &mut Packets) {
        out.push(format!("{}\r", self.value(meter)).into_bytes());
        meter.hold(true);
        self.held_by_button = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::Panel;
    use crate::emulator::makers::test_bench::TestBench;

    #[test]
    fn values_and_errors_as_the_grammar_has_them() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.set(0.012_345).ask("?\r"), "+012.345\r");
        assert_eq!(bench.ask("pri\r"), "+012.345\r");
        assert_eq!(bench.ask("QQ\r"), "ERR1\r");
        assert_eq!(bench.set(0.06).ask("?\r"), "ERR3\r");
        assert_eq!(bench.ask("UNI?\r"), "MM\r");
    }

    #[test]
    fn the_unit_is_not_in_the_packet_and_settings_come_back() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.set(0.0254).ask("IN\r?\r"), "IN\r+01.00000\r");
        assert_eq!(bench.ask("SET\r?\r"), "SET\r+00.00000\r");
        bench.press(&Panel::LowBattery(true));
        assert_eq!(bench.ask("BAT?\r"), "BAT0\r");
    }

    #[test]
    fn the_first_value_after_its_button_is_stale() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.set(0.001).press(&Panel::DataKey), "+001.000\r");
        assert_eq!(bench.set(0.002).ask("?\r"), "+001.000\r");
        assert_eq!(bench.ask("?\r"), "+002.000\r");
        // A hold that was set as such stays.
        bench.press(&Panel::Hold(true));
        assert_eq!(bench.set(0.003).ask("?\r?\r"), "+002.000\r+002.000\r");
        assert_eq!(bench.ask("STO0\r?\r"), "STO0\r+003.000\r");
    }

    #[test]
    fn it_streams_and_stops() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.ask("OUT1\r"), "OUT1\r");
        assert_eq!(bench.packets_in_s(0.0, 2.0), 16);
        bench.ask("OUT0\r");
        assert_eq!(bench.packets_in_s(2.0, 2.0), 0);
    }
}
