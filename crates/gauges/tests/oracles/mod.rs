//! Gauges written by hand from what four makers print, against which gauges that are emulated from descriptions are held, and decoding with them.
//!
//! Nothing here goes through the framing, decoding or emulation of the crate: a mistake there must not find its like here. Where the makers do not
//! say what is sent, the choice is stated. What decoding and sessions do not touch (peaks, filters, locks) is left out.

mod mahr;
mod mark10;
mod mitutoyo;
mod modbus;

use std::sync::{Arc, Mutex};

use stiffbench_gauges::Channel;

/// An oracle as it is after switching on.
type New = fn() -> Oracle;

/// The oracles by the name of the description that each is the judge of.
pub(crate) const ORACLES: [(&str, New); 5] = [
    ("mark10-series5", mark10::oracle),
    ("mitutoyo-01a", mitutoyo::oracle),
    ("mahr-dk-u1", mahr::oracle),
    ("hp-modbus", modbus::force),
    ("shahe-modbus", modbus::displacement),
];

/// The oracle of a description.
pub(crate) fn oracle(name: &str) -> Oracle {
    let known = ORACLES.iter().find(|(known, _)| *known == name);
    known.expect("there is an oracle of this name").1()
}

/// A gauge on a truth that can be set.
pub(crate) struct Oracle {
    pub(crate) channel: Channel,
    pub(crate) truth: Arc<Mutex<f64>>,
    pub(crate) meter: Meter,
    protocol: Box<dyn EmulatedProtocol>,
}

/// A maker's protocol.
trait EmulatedProtocol {
    /// A byte arrives; what is sent.
    fn receive(&mut self, meter: &mut Meter, byte: u8, now_s: f64) -> Vec<u8>;

    /// The packet that a stream or the key at the gauge sends.
    fn value(&self, meter: &Meter) -> Vec<u8>;

    /// Values a second of the stream that is on.
    fn per_second(&self) -> Option<f64> {
        None
    }
}

/// What happens to a gauge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Trouble {
    Overload,
    ToolOff,
    LowBattery,
}

/// The measuring part.
pub(crate) struct Meter {
    value_si: f64,
    zero_si: f64,
    /// Names, N or m in one of each, digits behind the point.
    units: &'static [(&'static str, f64, usize)],
    unit: usize,
    capacity_si: f64,
    /// Whether plus is the truth's.
    plus_as_truth: bool,
    pub(crate) trouble: Option<Trouble>,
    /// Since when a stream is on, s, and how many values of it were sent.
    streamed: (f64, u32),
}

impl Oracle {
    fn new(channel: Channel, meter: Meter, protocol: impl EmulatedProtocol + 'static) -> Self {
        Self {
            channel,
            truth: Arc::new(Mutex::new(0.0)),
            meter,
            protocol: Box::new(protocol),
        }
    }

    /// Bytes arrive; what is sent.
    pub(crate) fn receive(&mut self, bytes: &[u8], now_s: f64) -> Vec<u8> {
        self.meter.value_si = *self.truth.lock().unwrap();
        let mut sent = Vec::new();
        for byte in bytes {
            let before = self.protocol.per_second();
            sent.extend(self.protocol.receive(&mut self.meter, *byte, now_s));
            if self.protocol.per_second() != before {
                self.meter.streamed = (now_s, 0);
            }
        }
        sent
    }

    /// Time passes; what is sent.
    pub(crate) fn tick(&mut self, now_s: f64) -> Vec<u8> {
        self.meter.value_si = *self.truth.lock().unwrap();
        let mut sent = Vec::new();
        let (from_s, count) = &mut self.meter.streamed;
        let mut due = 0;
        if let Some(per_second) = self.protocol.per_second() {
            while *from_s + f64::from(*count + 1) / per_second <= now_s + 1e-9 {
                *count += 1;
                due += 1;
            }
        }
        for _ in 0..due {
            sent.extend(self.protocol.value(&self.meter));
        }
        sent
    }

    /// Somebody presses the key that sends a value.
    pub(crate) fn data_key(&mut self) -> Vec<u8> {
        self.meter.value_si = *self.truth.lock().unwrap();
        self.protocol.value(&self.meter)
    }
}

impl Meter {
    fn new(
        units: &'static [(&'static str, f64, usize)],
        capacity_si: f64,
        plus_as_truth: bool,
    ) -> Self {
        Self {
            value_si: 0.0,
            zero_si: 0.0,
            units,
            unit: 0,
            capacity_si,
            plus_as_truth,
            trouble: None,
            streamed: (0.0, 0),
        }
    }

    fn own_si(&self) -> f64 {
        let value_si = self.value_si - self.zero_si;
        let own_si = if self.plus_as_truth {
            value_si
        } else {
            -value_si
        };
        if self.trouble == Some(Trouble::Overload) {
            (1.15 * self.capacity_si).copysign(own_si)
        } else {
            own_si
        }
    }

    fn overloaded(&self) -> bool {
        self.own_si().abs() > 1.1 * self.capacity_si
    }

    fn zero(&mut self) {
        self.zero_si = self.value_si;
    }

    fn unit(&self) -> &'static str {
        self.units[self.unit].0
    }

    /// Changes the unit; `false` if there is none of that name.
    pub(crate) fn set_unit(&mut self, name: &str) -> bool {
        let place = self.units.iter().position(|unit| unit.0 == name);
        self.unit = place.unwrap_or(self.unit);
        place.is_some()
    }

    /// Whether the display is below zero, its steps, and the decimals.
    fn steps(&self) -> (bool, u64, usize) {
        let (_, si, decimals) = self.units[self.unit];
        let steps = (self.own_si() / si * 10_f64.powi(decimals as i32)).round();
        (steps < 0.0, steps.abs() as u64, decimals)
    }

    /// The display: the sign, or what stands for plus, and digits with noughts in front to a width.
    fn shown(&self, plus: &str, width: usize) -> String {
        let (negative, steps, decimals) = self.steps();
        let scale = 10_u64.pow(decimals as u32);
        let digits = format!("{}.{:0decimals$}", steps / scale, steps % scale);
        format!("{}{digits:0>width$}", if negative { "-" } else { plus })
    }
}

/// The commands of a line, ended by a carriage return; line feeds are overlooked, as all makers' gauges overlook them.
#[derive(Default)]
struct CommandLine(Vec<u8>);

impl CommandLine {
    /// The command that a byte completes, without its end.
    fn push(&mut self, byte: u8) -> Option<String> {
        match byte {
            b'\r' => Some(String::from_utf8_lossy(&std::mem::take(&mut self.0)).into_owned()),
            b'\n' => None,
            byte => {
                self.0.push(byte);
                None
            }
        }
    }
}
