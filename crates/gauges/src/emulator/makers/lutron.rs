//! Lutron FG-6020SD class, 196 N by 0.01 N; sends by itself.
//!
//! # Source
//! Lutron RS-232 data format, 16 bytes. How often it sends is not stated (here four times a second, as its display changes), and which
//! direction is plus neither (here compression). Nothing is said of overload, and the value goes on.

use crate::Channel;
use crate::emulator::meter::{KILOGRAM_FORCE_N, Meter, OUNCE_FORCE_N, POUND_FORCE_N, Range};

use super::unasked::Unasked;
use super::{Make, unit};

pub(super) const MAKE: Make = Make {
    name: "lutron-fg",
    range: || Range {
        channel: Channel::Force,
        units: vec![
            unit("N", 1.0, 2),
            unit("kg", KILOGRAM_FORCE_N, 3),
            unit("g", KILOGRAM_FORCE_N / 1000.0, 0),
            unit("lb", POUND_FORCE_N, 2),
            unit("oz", OUNCE_FORCE_N, 1),
        ],
        capacity_si: 196.1,
        plus_as_truth: false,
    },
    maker: || Unasked::boxed(PER_SECOND, value),
};

/// Packets a second.
const PER_SECOND: f64 = 4.0;

fn value(meter: &mut Meter) -> Vec<u8> {
    let digits = meter.shown();
    let unit = match meter.unit().name.as_str() {
        "kg" => 55,
        "lb" => 56,
        "g" => 57,
        "oz" => 58,
        _ => 59,
    };
    let polarity = u8::from(digits.negative);
    format!(
        "\x0241{unit}{polarity}{}{:08}\r",
        digits.decimals, digits.steps
    )
    .into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::Panel;
    use crate::emulator::makers::test_bench::TestBench;

    fn next(bench: &mut TestBench, now_s: f64) -> String {
        let packets = bench.gauge.tick_packets(now_s);
        String::from_utf8(packets.last().unwrap().clone()).unwrap()
    }

    #[test]
    fn it_sends_sixteen_bytes_unasked() {
        let mut bench = TestBench::of(&MAKE);
        bench.set(-12.34);
        assert!(bench.gauge.tick(0.0).is_empty());
        assert_eq!(next(&mut bench, 0.25), "\x0241590200001234\r");
        assert_eq!(next(&mut bench, 0.5).len(), 16);
        assert_eq!(bench.ask("?"), "");
        bench.set(12.34);
        assert_eq!(next(&mut bench, 0.75), "\x0241591200001234\r");
        bench.press(&Panel::Unit("g".into()));
        assert_eq!(next(&mut bench, 1.0), "\x0241571000001258\r");
    }
}
