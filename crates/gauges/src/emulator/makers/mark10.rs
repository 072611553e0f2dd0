//! Mark-10 Series 5 (Gauge Control Language 2), 500 N by 0.1 N.
//!
//! # Source
//! Mark-10 Model M5I User's Guide, sections 9 and 13; Series 5 User's Guide. What the port sends in overload is not stated there: this gauge
//! goes on sending the value, the worst that can be met.

use crate::Channel;
use crate::emulator::gauge::Maker;
use crate::emulator::meter::{KILOGRAM_FORCE_N, Meter, OUNCE_FORCE_N, POUND_FORCE_N, Range};
use crate::emulator::wire::{CommandLine, Packets, Stream};

use super::{Make, unit};

pub(super) const MAKE: Make = Make {
    name: "mark10-series5",
    range: || Range {
        channel: Channel::Force,
        units: vec![
            unit("N", 1.0, 1),
            unit("kN", 1000.0, 4),
            unit("kgF", KILOGRAM_FORCE_N, 2),
            unit("lbF", POUND_FORCE_N, 2),
            unit("ozF", OUNCE_FORCE_N, 1),
        ],
        capacity_si: 500.0,
        plus_as_truth: false,
    },
    maker: || Box::new(Mark10::default()),
};

/// The command that sets each unit, the word of the settings line for it, and how a value carries it.
const UNITS: [(&str, &str, &str); 7] = [
    ("N", "N", "N"),
    ("MN", "MN", "mN"),
    ("KN", "KN", "kN"),
    ("KG", "KGF", "kgF"),
    ("G", "GF", "gF"),
    ("LB", "LBF", "lbF"),
    ("OZ", "OZF", "ozF"),
];

/// Longest command.
const LONGEST: usize = 25;

/// Which value is displayed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Mode {
    #[default]
    Current,
    PeakTension,
    PeakCompression,
}

#[derive(Debug)]
struct Mark10 {
    line: CommandLine,
    stream: Stream,
    per_second: u32,
    mode: Mode,
    without_unit: bool,
    filters: [u32; 2],
    shut_off_minutes: u32,
    digimatic_polarity: bool,
}

impl Default for Mark10 {
    fn default() -> Self {
        Self {
            line: CommandLine::default(),
            stream: Stream::default(),
            per_second: 0,
            mode: Mode::Current,
            without_unit: false,
            filters: [8, 1],
            shut_off_minutes: 5,
            digimatic_polarity: true,
        }
    }
}

/// What an accepted command does.
type Answer = Result<Option<String>, &'static str>;

const ILLEGAL: &str = "*10";
const NOT_APPLICABLE: &str = "*11";
const INVALID: &str = "*21";
const TOO_LARGE: &str = "*22";
const TOO_LONG: &str = "*51";

impl Mark10 {
    fn value(&self, meter: &Meter, value_si: f64) -> String {
        let digits = meter.digits(value_si);
        let number = format!("{}{}", digits.sign_or(""), digits.plain());
        if self.without_unit {
            number
        } else {
            format!("{number} {}", meter.unit().name)
        }
    }

    fn displayed(&self, meter: &mut Meter) -> String {
        let value_si = match self.mode {
            // A peak chosen at the panel, or a display that hangs.
            Mode::Current => meter.displayed_si(),
            Mode::PeakTension => meter.lowest_si(),
            Mode::PeakCompression => meter.highest_si(),
        };
        self.value(meter, value_si)
    }

    fn settings(&self, meter: &Meter) -> String {
        let unit = UNITS.iter().find(|unit| unit.2 == meter.unit().name);
        let mode = match self.mode {
            Mode::Current if meter.peak_mode => "PC",
            Mode::Current => "CUR",
            Mode::PeakTension => "PT",
            Mode::PeakCompression => "PC",
        };
        format!(
            "V1.00;{};{mode};FLTC{};FLTP{};AOUT{:02};AOFF{};{};MIT;{};{}",
            unit.map_or("N", |unit| unit.1),
            self.filters[0],
            self.filters[1],
            self.per_second,
            self.shut_off_minutes,
            if self.without_unit { "NUM" } else { "FULL" },
            if self.digimatic_polarity {
                "POL"
            } else {
                "NPOL"
            },
            if meter.battery_low { "B3" } else { "B0" }
        )
    }

    fn obey(&mut self, meter: &mut Meter, command: &str, now_s: f64) -> Answer {
        if command.len() > LONGEST {
            return Err(TOO_LONG);
        }
        let answer = match command {
            "?" => Some(self.displayed(meter)),
            "?C" | "?A" => {
                let value_si = meter.live_si();
                Some(self.value(meter, value_si))
            }
            "?PT" => {
                let value_si = meter.lowest_si();
                Some(self.value(meter, value_si))
            }
            "?PC" => {
                let value_si = meter.highest_si();
                Some(self.value(meter, value_si))
            }
            "?ET" => return Err(NOT_APPLICABLE),
            "LIST" => Some(self.settings(meter)),
            "RN" => Some("Series 5".to_owned()),
            "RM" => Some("M5-100".to_owned()),
            "RV" => Some("1.00".to_owned()),
            "RS" => Some("3791204".to_owned()),
            _ => {
                self.set(meter, command, now_s)?;
                None
            }
        };
        Ok(answer)
    }

    /// Commands that set something are not answered unless they are refused.
    fn set(&mut self, meter: &mut Meter, command: &str, now_s: f64) -> Result<(), &'static str> {
        match command {
            "Z" => meter.zero(),
            "CLR" => meter.clear_peaks(),
            "CUR" => {
                self.mode = Mode::Current;
                meter.peak_mode = false;
            }
            "PT" => self.mode = Mode::PeakTension,
            "PC" => self.mode = Mode::PeakCompression,
            "FULL" => self.without_unit = false,
            "NUM" => self.without_unit = true,
            "POL" => self.digimatic_polarity = true,
            "NPOL" => self.digimatic_polarity = false,
            _ => {
                if let Some(unit) = UNITS.iter().find(|unit| unit.0 == command) {
                    return meter.set_unit(unit.2).then_some(()).ok_or(NOT_APPLICABLE);
                }
                self.set_number(meter, command, now_s)?;
            }
        }
        Ok(())
    }

    fn set_number(
        &mut self,
        meter: &mut Meter,
        command: &str,
        now_s: f64,
    ) -> Result<(), &'static str> {
        const NUMBERED: [&str; 6] = ["AOUT", "AOFF", "FLTC", "FLTP", "IPOL", "OPOL"];
        let name = NUMBERED.into_iter().find(|name| command.starts_with(name));
        let name = name.ok_or(ILLEGAL)?;
        let number: u32 = command[name.len()..].parse().map_err(|_| INVALID)?;
        match (name, number) {
            ("AOUT", 0) => {
                self.per_second = 0;
                self.stream.stop();
            }
            ("AOUT", 1 | 2 | 5 | 10 | 25 | 50 | 125 | 250) => {
                self.per_second = number;
                // Kept by the maker for an older indicator.
                let per_second = if number == 1 { 50 } else { number };
                self.stream.start(f64::from(per_second), now_s);
            }
            ("AOUT", 0..=250) => return Err(INVALID),
            ("FLTC", 0..=10) => self.filters[0] = number,
            ("FLTP", 0..=10) => self.filters[1] = number,
            ("AOFF", 0..=30) => self.shut_off_minutes = number,
            ("IPOL", 0 | 1) => meter.invert(number == 1),
            ("OPOL", 0) => {}
            _ => return Err(TOO_LARGE),
        }
        Ok(())
    }
}

impl Maker for Mark10 {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], now_s: f64, out: &mut Packets) {
        for &byte in bytes {
            let Some(command) = self.line.push(byte) else {
                continue;
            };
            if let Some(text) = match self.obey(meter, &command, now_s) {
                Ok(answer) => answer,
                Err(code) => Some(code.to_owned()),
            } {
                out.push(format!("{text}\r\n").into_bytes());
            }
        }
    }

    fn tick(&mut self, meter: &mut Meter, now_s: f64, out: &mut Packets) {
        for _ in 0..self.stream.due(now_s) {
            out.push(format!("{}\r\n", self.displayed(meter)).into_bytes());
        }
    }

    fn next_due_s(&self) -> Option<f64> {
        self.stream.next_due_s()
    }

    fn data_key(&mut self, meter: &mut Meter, _now_s: f64, out: &mut Packets) {
        out.push(format!("{}\r\n", self.displayed(meter)).into_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::Panel;
    use crate::emulator::makers::test_bench::TestBench;

    /// The gauge of a small capacity that the maker's example is from.

    #[test]
    fn it_sends_the_makers_literal_packets() {
        let mut small = TestBench::with_units(&MAKE, vec![unit("N", 1.0, 3)]);
        assert_eq!(small.set(-4.285).ask("?\r"), "4.285 N\r\n");
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.ask("FOO\r"), "*10\r\n");
        assert_eq!(bench.ask("LB\r"), "");
        assert_eq!(
            bench.ask("LIST\r"),
            "V1.00;LBF;CUR;FLTC8;FLTP1;AOUT00;AOFF5;FULL;MIT;POL;B0\r\n"
        );
    }

    #[test]
    fn tension_is_minus_and_units_are_in_the_packet() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.set(44.482_216_152_605).ask("?\r\n"), "-44.5 N\r\n");
        assert_eq!(bench.ask("LB\r?\r"), "-10.00 lbF\r\n");
        assert_eq!(bench.ask("KN\r?\r"), "-0.0445 kN\r\n");
        // Milli, not mega; and a gauge of 500 N does not have it.
        assert_eq!(bench.ask("MN\r"), "*11\r\n");
        assert_eq!(bench.ask("N\rNUM\r?\r"), "-44.5\r\n");
        assert_eq!(bench.ask("IPOL1\r?\r"), "44.5\r\n");
    }

    #[test]
    fn one_a_second_is_fifty_a_second() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.ask("AOUT1\r"), "");
        assert_eq!(bench.packets_in_s(0.0, 2.0), 100);
        bench.ask("AOUT0\r");
        assert_eq!(bench.packets_in_s(2.0, 2.0), 0);
        assert_eq!(bench.ask("AOUT3\r"), "*21\r\n");
        assert_eq!(bench.ask("AOUT900\r"), "*22\r\n");
        assert_eq!(bench.ask("THIS COMMAND IS MUCH TOO LONG\r"), "*51\r\n");
    }

    #[test]
    fn a_peak_mode_shows_the_peak_until_it_is_cleared() {
        let mut bench = TestBench::of(&MAKE);
        bench.ask("PC\r");
        bench.set(-60.0).ask("?\r");
        assert_eq!(bench.set(-10.0).ask("?\r?C\r"), "60.0 N\r\n10.0 N\r\n");
        assert_eq!(bench.ask("CLR\r?\r"), "10.0 N\r\n");
        bench.ask("CUR\r");
        bench.press(&Panel::PeakMode(true));
        bench.set(-80.0).ask("?\r");
        assert_eq!(bench.set(0.0).ask("?\r"), "80.0 N\r\n");
        assert!(bench.ask("LIST\r").contains(";PC;"));
    }

    #[test]
    fn zero_battery_and_overload() {
        let mut bench = TestBench::of(&MAKE);
        bench.set(-3.0).ask("Z\r");
        assert_eq!(bench.ask("?\r"), "0.0 N\r\n");
        assert_eq!(bench.set(-13.0).ask("?\r"), "10.0 N\r\n");
        bench.press(&Panel::LowBattery(true));
        assert!(bench.ask("LIST\r").ends_with(";B3\r\n"));
        bench.press(&Panel::Overload(true));
        assert_eq!(bench.ask("?\r"), "575.0 N\r\n");
    }
}
