//! Magnescale LT20A, 0.0001 mm; basic format, channel A.
//!
//! # Source
//! LT20A operating manual (formats). Its requests were not among the pages read, so it sends by itself here, ten times a second, each packet
//! ended by `<CR><LF>`.

use crate::Channel;
use crate::emulator::meter::{Meter, Range};

use super::unasked::Unasked;
use super::{MILLIMETRE_M, Make, unit};

pub(super) const MAKE: Make = Make {
    name: "magnescale-lt20a",
    range: || Range {
        channel: Channel::Displacement,
        units: vec![unit("mm", MILLIMETRE_M, 4)],
        capacity_si: 0.06,
        plus_as_truth: true,
    },
    maker: || Unasked::boxed(PER_SECOND, value),
};

const PER_SECOND: f64 = 10.0;

/// Channel, sign, seven characters with a point; in overflow an `F` and digits that are none of a value.
fn value(meter: &mut Meter) -> Vec<u8> {
    let value_si = meter.displayed_si();
    let digits = meter.digits(value_si);
    let sign = digits.sign();
    if meter.tool_off {
        return b"AE\r\n".to_vec();
    }
    if meter.overloaded(value_si) {
        return format!("A{sign}F{:06}\r\n", digits.steps).into_bytes();
    }
    format!("A{sign}{}\r\n", digits.zero_filled(7)).into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::Panel;
    use crate::emulator::makers::test_bench::TestBench;

    #[test]
    fn values_alarms_and_overflow() {
        let mut bench = TestBench::of(&MAKE);
        bench.gauge.tick(0.0);
        bench.set(0.012_345_6);
        assert_eq!(bench.gauge.tick(0.1), b"A+12.3456\r\n");
        bench.set(-0.000_05);
        assert_eq!(bench.gauge.tick(0.2), b"A-00.0500\r\n");
        bench.press(&Panel::Overload(true));
        assert_eq!(bench.gauge.tick(0.3), b"A-F690000\r\n");
        bench.press(&Panel::ToolOff(true));
        assert_eq!(bench.gauge.tick(0.4), b"AE\r\n");
    }
}
