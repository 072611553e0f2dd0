//! CDI Logic and Starrett iQ, 0.001 mm.
//!
//! # Source
//! The makers' communication protocol pages. Whether `C` and `H` are acknowledged is not stated; here they are, as settings are.

use crate::Channel;
use crate::emulator::gauge::Maker;
use crate::emulator::meter::{Meter, Range};
use crate::emulator::wire::{CommandLine, Packets};

use super::{INCH_M, MILLIMETRE_M, Make, unit};

pub(super) const MAKE: Make = Make {
    name: "cdi-logic",
    range: || Range {
        channel: Channel::Displacement,
        units: vec![unit("MM", MILLIMETRE_M, 3), unit("IN", INCH_M, 5)],
        capacity_si: 0.025,
        plus_as_truth: true,
    },
    maker: || Box::new(Cdi::default()),
};

const DONE: &str = "SUCCESS";

#[derive(Debug, Default)]
struct Cdi {
    line: CommandLine,
    reversed: bool,
    mode: u32,
    quiet: bool,
}

/// What a setting may be: its number and the largest value.
const SETTINGS: [(u32, u32); 7] = [(7, 5), (11, 2), (13, 2), (19, 1), (21, 1), (22, 1), (63, 1)];

impl Cdi {
    fn value(meter: &mut Meter) -> String {
        let digits = meter.shown();
        format!(
            "{}{}, {}",
            digits.sign(),
            digits.blank_filled(8),
            meter.unit().name
        )
    }

    fn setting(&self, meter: &Meter, number: u32) -> Option<u32> {
        SETTINGS
            .iter()
            .any(|known| known.0 == number)
            .then(|| match number {
                7 => 4,
                11 => self.mode,
                13 if meter.unit().name == "MM" => 2,
                13 => 1,
                19 => u32::from(self.reversed),
                21 => u32::from(meter.is_held()),
                63 => u32::from(self.quiet),
                _ => 0,
            })
    }

    fn set(&mut self, meter: &mut Meter, number: &str, value: &str) -> &'static str {
        let Ok(number) = number.parse::<u32>() else {
            return "NOT FOUND";
        };
        let Some((_, most)) = SETTINGS.iter().find(|known| known.0 == number) else {
            return "NOT FOUND";
        };
        let Ok(value) = value.parse::<u32>() else {
            return "NON NUMERIC";
        };
        if value > *most || (number == 13 && value == 0) {
            return "OUT OF BOUNDS";
        }
        match number {
            11 => self.mode = value,
            13 => _ = meter.set_unit(if value == 1 { "IN" } else { "MM" }),
            19 => {
                self.reversed = value == 1;
                meter.invert(self.reversed);
            }
            21 => meter.hold(value == 1),
            63 => self.quiet = value == 1,
            _ => {}
        }
        DONE
    }

    fn obey(&mut self, meter: &mut Meter, command: &str) -> Option<String> {
        let status = match command {
            "R" => return Some(Self::value(meter)),
            "C" => {
                meter.zero();
                DONE
            }
            // A toggle.
            "H" => {
                let held = meter.is_held();
                meter.hold(!held);
                DONE
            }
            "rstERR" => DONE,
            _ => {
                if let Some(number) = command.strip_prefix("?p") {
                    let value = number.parse().ok().and_then(|n| self.setting(meter, n));
                    return value.map_or_else(|| self.status("NOT FOUND"), |v| Some(v.to_string()));
                }
                let setting = command
                    .strip_prefix('p')
                    .and_then(|rest| rest.split_once('='));
                setting.map_or("NOT FOUND", |(number, value)| {
                    self.set(meter, number, value)
                })
            }
        };
        self.status(status)
    }

    /// With parameter 063 set, nothing is said.
    fn status(&self, text: &str) -> Option<String> {
        (!self.quiet).then(|| text.to_owned())
    }
}

impl Maker for Cdi {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], _now_s: f64, out: &mut Packets) {
        for &byte in bytes {
            let command = self.line.push(byte);
            if let Some(text) = command.and_then(|command| self.obey(meter, &command)) {
                out.push(format!("{text}\r\n").into_bytes());
            }
        }
    }

    fn data_key(&mut self, meter: &mut Meter, _now_s: f64, out: &mut Packets) {
        out.push(format!("{}\r\n", Self::value(meter)).into_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::Panel;
    use crate::emulator::makers::test_bench::TestBench;

    #[test]
    fn blanks_stand_between_sign_and_digits() {
        let mut bench = TestBench::of(&MAKE);
        let value = bench.set(-0.000_415).ask("R\r");
        assert_eq!((value.as_str(), value.len()), ("-   0.415, MM\r\n", 15));
        assert_eq!(bench.ask("p013=1\rR\r"), "SUCCESS\r\n- 0.01634, IN\r\n");
    }

    #[test]
    fn hold_toggles_and_is_a_setting_too() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.ask("?p021\rH\r?p021\r"), "0\r\nSUCCESS\r\n1\r\n");
        assert_eq!(bench.set(0.001).ask("R\r"), "+   0.000, MM\r\n");
        bench.ask("H\r");
        assert_eq!(bench.ask("R\r"), "+   1.000, MM\r\n");
        bench.press(&Panel::Hold(true));
        assert_eq!(bench.ask("?p021\r"), "1\r\n");
    }

    #[test]
    fn refusals_are_words_unless_they_are_suppressed() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.ask("?p999\r"), "NOT FOUND\r\n");
        assert_eq!(bench.ask("p013=7\r"), "OUT OF BOUNDS\r\n");
        assert_eq!(bench.ask("p013=x\r"), "NON NUMERIC\r\n");
        assert_eq!(bench.ask("p063=1\rFOO\rC\r"), "");
        assert_eq!(bench.ask("?p063\r"), "1\r\n");
    }
}
