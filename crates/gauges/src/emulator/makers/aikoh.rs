//! AIKOH RX, 500 N by 0.1 N.
//!
//! # Source
//! RX data communication command list. Which direction is plus is not stated: here compression; nothing is said of overload, and the value goes
//! on. The stream of raw converter values and the memory are not emulated (`NG`).

use crate::Channel;
use crate::emulator::gauge::Maker;
use crate::emulator::meter::{KILOGRAM_FORCE_N, Meter, POUND_FORCE_N, Range};
use crate::emulator::wire::{CommandLine, Packets};

use super::{Make, unit};

pub(super) const MAKE: Make = Make {
    name: "aikoh-rx",
    range: || Range {
        channel: Channel::Force,
        units: vec![
            unit("N", 1.0, 1),
            unit("kg", KILOGRAM_FORCE_N, 2),
            unit("lb", POUND_FORCE_N, 2),
        ],
        capacity_si: 500.0,
        plus_as_truth: false,
    },
    maker: || Box::new(Aikoh::default()),
};

/// Clears the receive buffer; no answer.
const CLEAR: u8 = 0x02;

const DONE: &str = "OK";
const NOT_UNDERSTOOD: &str = "NG";
const NO_SUCH_DATA: &str = "NO";

#[derive(Debug, Default)]
struct Aikoh {
    line: CommandLine,
}

fn value(meter: &Meter, value_si: f64) -> String {
    let digits = meter.digits(value_si);
    let number = digits.zero_filled(6);
    format!(" {}{number} {}", digits.sign(), meter.unit().name)
}

fn obey(meter: &mut Meter, command: &str) -> String {
    let value_si = match command {
        "RDF0" => meter.displayed_si(),
        "RDF1" => meter.live_si(),
        "RDF2" if meter.peak_mode => meter.lowest_si(),
        "RDF3" if meter.peak_mode => meter.highest_si(),
        // Peaks in track mode; displacement without a tool plugged into the gauge.
        "RDF2" | "RDF3" | "RDFD1" => return NO_SUCH_DATA.to_owned(),
        "RDMD" => return if meter.peak_mode { "PEAK" } else { "TRACK" }.to_owned(),
        "RDMDL" => return "500N".to_owned(),
        "RDVR" => return "1.00".to_owned(),
        _ => return set(meter, command).to_owned(),
    };
    value(meter, value_si)
}

fn set(meter: &mut Meter, command: &str) -> &'static str {
    match command {
        "WRFZ" => meter.zero(),
        "WRPZ" => meter.clear_peaks(),
        "WRUNN" => _ = meter.set_unit("N"),
        "WRUNKG" => _ = meter.set_unit("kg"),
        "WRUNLB" => _ = meter.set_unit("lb"),
        _ => return NOT_UNDERSTOOD,
    }
    DONE
}

impl Maker for Aikoh {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], _now_s: f64, out: &mut Packets) {
        for &byte in bytes {
            if byte == CLEAR {
                self.line.clear();
            } else if let Some(command) = self.line.push(byte) {
                out.push(format!("{}\r\n", obey(meter, &command)).into_bytes());
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
    fn it_sends_the_makers_literal_packets() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.ask("WRUNKG\r"), "OK\r\n");
        assert_eq!(bench.set(-980.665).ask("RDF0\r"), " +100.00 kg\r\n");
        assert_eq!(bench.ask("HELLO\r"), "NG\r\n");
        assert_eq!(bench.ask("RDFD1\r"), "NO\r\n");
    }

    #[test]
    fn peaks_are_there_in_peak_mode_only() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.ask("RDMD\rRDF3\r"), "TRACK\r\nNO\r\n");
        bench.press(&Panel::PeakMode(true));
        bench.set(-20.0).ask("RDF1\r");
        assert_eq!(bench.set(0.0).ask("RDMD\rRDF0\r"), "PEAK\r\n +0020.0 N\r\n");
        assert_eq!(bench.ask("RDF1\r"), " +0000.0 N\r\n");
    }

    #[test]
    fn a_single_byte_clears_what_has_come_of_a_command() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.set(10.0).ask("RD\x02WRFZ\r"), "OK\r\n");
        assert_eq!(bench.ask("RDF0\r"), " +0000.0 N\r\n");
    }
}
