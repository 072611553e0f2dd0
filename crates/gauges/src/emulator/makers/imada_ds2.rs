//! IMADA DS2, 500 N by 0.1 N.
//!
//! # Source
//! The command table in the drivers that are public; the maker's manual was not found. Which direction is plus is not known: here compression.

use crate::Channel;
use crate::emulator::gauge::Maker;
use crate::emulator::meter::{KILOGRAM_FORCE_N, Meter, POUND_FORCE_N, Range};
use crate::emulator::wire::{CommandLine, Packets};

use super::{Make, unit};

pub(super) const MAKE: Make = Make {
    name: "imada-ds2",
    range: || Range {
        channel: Channel::Force,
        units: vec![
            unit("N", 1.0, 1),
            unit("K", KILOGRAM_FORCE_N, 2),
            unit("O", POUND_FORCE_N, 1),
        ],
        capacity_si: 500.0,
        plus_as_truth: false,
    },
    maker: || Box::new(ImadaDs2::default()),
};

#[derive(Debug)]
struct ImadaDs2 {
    line: CommandLine,
    /// Set points above and below zero, steps of the display.
    high: i64,
    low: i64,
    off: bool,
}

impl Default for ImadaDs2 {
    fn default() -> Self {
        Self {
            line: CommandLine::default(),
            high: 9999,
            low: 9999,
            off: false,
        }
    }
}

impl ImadaDs2 {
    /// Sign, four digits with a point, unit, mode, judgement.
    fn value(&self, meter: &mut Meter) -> String {
        let value_si = meter.displayed_si();
        let digits = meter.digits(value_si);
        let steps = digits.steps as i64 * if digits.negative { -1 } else { 1 };
        let judgement = match steps {
            _ if meter.overloaded(value_si) => 'E',
            steps if steps < -self.low => 'L',
            steps if steps > self.high => 'H',
            _ => 'O',
        };
        format!(
            "{}{}{}{}{judgement}",
            digits.sign(),
            digits.zero_filled(5),
            meter.unit().name,
            if meter.peak_mode { 'P' } else { 'T' }
        )
    }

    fn set_points(&mut self, digits: &str) -> Option<()> {
        let (high, low) = digits.split_at_checked(4)?;
        let whole = |text: &str| (text.len() == 4).then(|| text.parse().ok()).flatten();
        (self.high, self.low) = (whole(high)?, whole(low)?);
        Some(())
    }

    fn obey(&mut self, meter: &mut Meter, command: &str) -> String {
        let done = match command {
            "D" => return self.value(meter),
            "E" => return format!("E{:04}{:04}", self.high, self.low),
            "Z" => {
                meter.zero();
                true
            }
            "T" | "P" => {
                meter.peak_mode = command == "P";
                meter.clear_peaks();
                true
            }
            "N" | "K" | "O" => meter.set_unit(command),
            "Q" => {
                self.off = true;
                true
            }
            _ => command
                .strip_prefix('E')
                .is_some_and(|digits| self.set_points(digits).is_some()),
        };
        if done { "R" } else { "E" }.to_owned()
    }
}

impl Maker for ImadaDs2 {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], _now_s: f64, out: &mut Packets) {
        for &byte in bytes {
            if self.off {
                return;
            }
            if let Some(command) = self.line.push(byte) {
                out.push(format!("{}\r", self.obey(meter, &command)).into_bytes());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::Panel;
    use crate::emulator::makers::test_bench::TestBench;

    #[test]
    fn values_carry_unit_mode_and_judgement() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.set(-12.3).ask("D\r"), "+012.3NTO\r");
        assert_eq!(bench.ask("E50000500\r"), "R\r");
        assert_eq!(bench.ask("P\r"), "R\r");
        assert_eq!(bench.set(56.7).ask("D\r"), "-056.7NPL\r");
        assert_eq!(bench.set(-512.0).ask("T\rD\r"), "R\r+512.0NTH\r");
        assert_eq!(bench.ask("E\r"), "E50000500\r");
    }

    #[test]
    fn overload_is_a_letter_behind_a_number() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.set(-550.1).ask("D\r"), "+550.1NTE\r");
        bench.set(-5.0).press(&Panel::Overload(true));
        assert_eq!(bench.ask("D\r"), "+575.0NTE\r");
    }

    #[test]
    fn letters_mean_what_their_place_says() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.ask("O\r"), "R\r");
        assert_eq!(bench.set(-44.482_216).ask("D\r"), "+010.0OTO\r");
        assert_eq!(bench.ask("X\r"), "E\r");
        assert_eq!(bench.ask("E12\r"), "E\r");
        assert_eq!(bench.ask("Z\rD\r"), "R\r+000.0OTO\r");
        assert_eq!(bench.ask("Q\r"), "R\r");
        assert_eq!(bench.ask("D\r"), "");
    }
}
