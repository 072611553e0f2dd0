//! A gauge behind a microcontroller that prints ten lines a second: value, blank, unit. What is no value begins with `#`.

use crate::Channel;
use crate::emulator::meter::{Meter, Range};

use super::unasked::Unasked;
use super::{INCH_M, MILLIMETRE_M, Make, unit};

pub(super) const FORCE: Make = Make {
    name: "generic-ascii",
    range: || Range {
        channel: Channel::Force,
        units: vec![unit("N", 1.0, 2), unit("kN", 1000.0, 5)],
        capacity_si: 200.0,
        plus_as_truth: true,
    },
    maker: || Unasked::boxed(PER_SECOND, value),
};

pub(super) const DISPLACEMENT: Make = Make {
    name: "generic-ascii-displacement",
    range: || Range {
        channel: Channel::Displacement,
        units: vec![unit("mm", MILLIMETRE_M, 3), unit("in", INCH_M, 5)],
        capacity_si: 0.05,
        plus_as_truth: true,
    },
    maker: || Unasked::boxed(PER_SECOND, value),
};

const PER_SECOND: f64 = 10.0;

fn value(meter: &mut Meter) -> Vec<u8> {
    let value_si = meter.displayed_si();
    if meter.overloaded(value_si) {
        return b"# overload\r\n".to_vec();
    }
    let digits = meter.digits(value_si);
    let unit = &meter.unit().name;
    format!("{}{} {unit}\r\n", digits.sign_or(""), digits.plain()).into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::makers::test_bench::TestBench;

    #[test]
    fn it_prints_value_and_unit_unasked() {
        let mut force = TestBench::of(&FORCE);
        force.gauge.tick(0.0);
        force.set(-12.345);
        assert_eq!(force.gauge.tick(0.1), b"-12.35 N\r\n");
        force.set(300.0);
        assert_eq!(force.gauge.tick(0.2), b"# overload\r\n");
        let mut displacement = TestBench::of(&DISPLACEMENT);
        displacement.set(0.000_415).gauge.tick(0.0);
        assert_eq!(displacement.gauge.tick(0.1), b"0.415 mm\r\n");
        assert_eq!(displacement.ask("hello\r"), "");
    }
}
