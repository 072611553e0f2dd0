//! Mark-10 Series 5 (Gauge Control Language 2), 500 N by 0.1 N.
//!
//! # Source
//! Mark-10 Model M5I User's Guide, sections 9 and 13; Series 5 User's Guide. What the port sends in overload is not stated there: this gauge
//! goes on sending the value, the worst that can be met.

use stiffbench_gauges::Channel;

use super::{CommandLine, EmulatedProtocol, Meter, Oracle, Trouble};

/// How a value carries each unit.
const UNITS: [(&str, f64, usize); 5] = [
    ("N", 1.0, 1),
    ("kN", 1000.0, 4),
    ("kgF", 9.806_65, 2),
    ("lbF", 4.448_221_615_260_5, 2),
    ("ozF", 4.448_221_615_260_5 / 16.0, 1),
];

/// The command that sets each unit, the word of the settings line for it, and how a value carries it. Milli, not mega.
const UNIT_COMMANDS: [(&str, &str, &str); 7] = [
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

const ILLEGAL: &str = "*10";
const NOT_APPLICABLE: &str = "*11";
const INVALID: &str = "*21";
const TOO_LARGE: &str = "*22";
const TOO_LONG: &str = "*51";

#[derive(Default)]
struct Mark10 {
    line: CommandLine,
    /// As the settings line has it.
    per_second: u32,
    without_unit: bool,
}

pub(super) fn oracle() -> Oracle {
    Oracle::new(
        Channel::Force,
        Meter::new(&UNITS, 500.0, false),
        Mark10::default(),
    )
}

impl Mark10 {
    fn number(&self, meter: &Meter) -> String {
        let number = meter.shown("", 0);
        if self.without_unit {
            number
        } else {
            format!("{number} {}", meter.unit())
        }
    }

    fn settings(&self, meter: &Meter) -> String {
        let unit = UNIT_COMMANDS.iter().find(|unit| unit.2 == meter.unit());
        let battery = match meter.trouble {
            Some(Trouble::LowBattery) => "B3",
            _ => "B0",
        };
        format!(
            "V1.00;{};CUR;FLTC8;FLTP1;AOUT{:02};AOFF5;{};MIT;POL;{}",
            unit.map_or("N", |unit| unit.1),
            self.per_second,
            if self.without_unit { "NUM" } else { "FULL" },
            battery
        )
    }

    /// Commands that set something are not answered unless they are refused.
    fn handle_command(
        &mut self,
        meter: &mut Meter,
        command: &str,
    ) -> Result<Option<String>, &'static str> {
        if command.len() > LONGEST {
            return Err(TOO_LONG);
        }
        match command {
            "?" | "?C" => return Ok(Some(self.number(meter))),
            "LIST" => return Ok(Some(self.settings(meter))),
            "RS" => return Ok(Some("3791204".to_owned())),
            "Z" => meter.zero(),
            "CUR" => {}
            "FULL" => self.without_unit = false,
            "NUM" => self.without_unit = true,
            _ => {
                let unit = UNIT_COMMANDS.iter().find(|unit| unit.0 == command);
                match unit {
                    Some(unit) if !meter.set_unit(unit.2) => return Err(NOT_APPLICABLE),
                    Some(_) => {}
                    None => self.set_number(command)?,
                }
            }
        }
        Ok(None)
    }

    fn set_number(&mut self, command: &str) -> Result<(), &'static str> {
        let name = ["AOUT", "AOFF"]
            .into_iter()
            .find(|name| command.starts_with(name));
        let name = name.ok_or(ILLEGAL)?;
        let number: u32 = command[name.len()..].parse().map_err(|_| INVALID)?;
        match (name, number) {
            ("AOUT", 0 | 1 | 2 | 5 | 10 | 25 | 50 | 125 | 250) => self.per_second = number,
            ("AOUT", 0..=250) => return Err(INVALID),
            ("AOFF", 0..=30) => {}
            _ => return Err(TOO_LARGE),
        }
        Ok(())
    }
}

impl EmulatedProtocol for Mark10 {
    fn receive(&mut self, meter: &mut Meter, byte: u8, _now_s: f64) -> Vec<u8> {
        let Some(command) = self.line.push(byte) else {
            return Vec::new();
        };
        let text = match self.handle_command(meter, &command) {
            Ok(None) => return Vec::new(),
            Ok(Some(text)) => text,
            Err(code) => code.to_owned(),
        };
        format!("{text}\r\n").into_bytes()
    }

    fn value(&self, meter: &Meter) -> Vec<u8> {
        format!("{}\r\n", self.number(meter)).into_bytes()
    }

    fn per_second(&self) -> Option<f64> {
        match self.per_second {
            0 => None,
            // Kept by the maker for an older indicator.
            1 => Some(50.0),
            number => Some(f64::from(number)),
        }
    }
}

#[test]
fn it_sends_the_makers_literal_packets() {
    let mut gauge = oracle();
    // The gauge of a small capacity that the maker's example is from.
    gauge.meter.units = &[("N", 1.0, 3)];
    *gauge.truth.lock().unwrap() = -4.285;
    assert_eq!(gauge.receive(b"?\r", 0.0), b"4.285 N\r\n");
    let mut gauge = oracle();
    assert_eq!(gauge.receive(b"FOO\r", 0.0), b"*10\r\n");
    assert_eq!(gauge.receive(b"MN\r", 0.0), b"*11\r\n");
    assert_eq!(gauge.receive(b"LB\r", 0.0), b"");
    assert_eq!(
        gauge.receive(b"LIST\r", 0.0),
        b"V1.00;LBF;CUR;FLTC8;FLTP1;AOUT00;AOFF5;FULL;MIT;POL;B0\r\n"
    );
    gauge.receive(b"AOUT1\r", 0.0);
    assert_eq!(gauge.tick(2.0), b"0.00 lbF\r\n".repeat(100));
}
