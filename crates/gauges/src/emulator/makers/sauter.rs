//! SAUTER FH, 500 N by 0.1 N.
//!
//! # Source
//! SAUTER FH operating manual and "FH interface description" of 17.05.2016. What the unit commands select on small capacities is not stated
//! (here N, kgf, lbf), and neither is anything about overload (here the value goes on).

use crate::Channel;
use crate::emulator::gauge::Maker;
use crate::emulator::meter::{KILOGRAM_FORCE_N, Meter, POUND_FORCE_N, Range};
use crate::emulator::wire::Packets;

use super::{Make, unit};

pub(super) const MAKE: Make = Make {
    name: "sauter-fh",
    range: || Range {
        channel: Channel::Force,
        units: vec![
            unit("N", 1.0, 1),
            unit("kgf", KILOGRAM_FORCE_N, 2),
            unit("lbf", POUND_FORCE_N, 2),
        ],
        capacity_si: 500.0,
        plus_as_truth: true,
    },
    maker: || Box::new(Sauter),
};

#[derive(Debug)]
struct Sauter;

impl Maker for Sauter {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], _now_s: f64, out: &mut Packets) {
        for byte in bytes {
            match byte {
                b'9' => {
                    let digits = meter.shown();
                    let pull = if digits.negative { '0' } else { '1' };
                    out.push(format!("{pull}{}", digits.zero_filled(6)).into_bytes());
                }
                b'2' => meter.zero(),
                b'3' => _ = meter.set_unit("N"),
                b'4' => _ = meter.set_unit("kgf"),
                b'5' => _ = meter.set_unit("lbf"),
                b'6' => meter.peak_mode = false,
                b'7' => {
                    meter.peak_mode = true;
                    meter.clear_peaks();
                }
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::makers::test_bench::TestBench;

    /// The gauge of a small capacity that the maker's example is from.

    #[test]
    fn it_sends_the_makers_literal_packet() {
        let mut small = TestBench::with_units(&MAKE, vec![unit("N", 1.0, 2)]);
        assert_eq!(small.set(21.15).ask("9"), "1021.15");
    }

    #[test]
    fn push_is_the_digit_nought_and_nothing_ends_a_packet() {
        let mut bench = TestBench::of(&MAKE);
        assert_eq!(bench.set(-70.04).ask("99"), "00070.000070.0");
        assert_eq!(bench.ask("2"), "");
        assert_eq!(bench.ask("9"), "10000.0");
        assert_eq!(bench.set(-79.846_65).ask("49"), "0001.00");
    }

    #[test]
    fn in_peak_mode_the_peak_stays() {
        let mut bench = TestBench::of(&MAKE);
        bench.ask("7");
        bench.set(-30.0).ask("9");
        assert_eq!(bench.set(0.0).ask("9"), "00030.0");
        assert_eq!(bench.ask("69"), "10000.0");
    }
}
