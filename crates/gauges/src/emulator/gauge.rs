//! An emulated gauge: bytes in, bytes out.

use crate::{Channel, InstrumentDescription};
use stiffbench_units_and_text::nearest::nearest;

use super::described::{self, Described};
use super::makers;
use super::meter::{Meter, Range};
use super::truth::SharedTruth;
use super::wire::Packets;

/// The protocol of a maker, written from what the maker printed.
pub(super) trait Maker: Send {
    /// Bytes arrive from the host.
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], now_s: f64, out: &mut Packets);

    /// Time passes: values of a stream.
    fn tick(&mut self, _meter: &mut Meter, _now_s: f64, _out: &mut Packets) {}

    /// When time will have something to send, s.
    fn next_due_s(&self) -> Option<f64> {
        None
    }

    /// The key or foot switch that sends a value; gauges without one do nothing.
    fn data_key(&mut self, _meter: &mut Meter, _now_s: f64, _out: &mut Packets) {}
}

/// What somebody does at the gauge itself, or what happens to it.
#[derive(Debug, Clone, PartialEq)]
pub enum Panel {
    /// Sets the zero here.
    Zero,
    /// Chooses a unit, by the gauge's own word for it.
    Unit(Box<str>),
    /// Shows the peak instead of the value, or the value again.
    PeakMode(bool),
    /// Holds the display, or lets it go.
    Hold(bool),
    /// Presses the key or foot switch that sends a value.
    DataKey,
    /// The battery runs low, or is new.
    LowBattery(bool),
    /// The gauge is overloaded whatever acts on it, or no longer.
    Overload(bool),
    /// The value hangs, or goes on.
    Freeze(bool),
    /// The sign is turned round, or back.
    InvertSign(bool),
    /// The measuring tool is unplugged from its adapter or switched off, or back.
    ToolOff(bool),
}

/// A gauge that cannot be emulated, or cannot do what it is told.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum EmulatorError {
    /// No gauge of that name.
    #[error("no gauge {name} is emulated")]
    #[diagnostic(code(stiffbench::usage::emulated_gauge))]
    Unknown {
        /// The name.
        name: String,
        /// What there is.
        #[help]
        help: String,
    },
    /// A unit that the gauge does not have.
    #[error("an emulated {gauge} has no unit {unit}")]
    #[diagnostic(code(stiffbench::usage::emulated_unit), help("its units are {known}"))]
    Unit {
        /// The gauge.
        gauge: String,
        /// The unit.
        unit: String,
        /// What it has.
        known: String,
    },
}

/// A gauge in software, at the level of bytes: a pure state machine that is told the time.
pub struct EmulatedGauge {
    name: String,
    meter: Meter,
    maker: Box<dyn Maker>,
}

impl std::fmt::Debug for EmulatedGauge {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("EmulatedGauge")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

impl EmulatedGauge {
    /// The gauge of a shipped description, as it is after switching on.
    ///
    /// # Errors
    /// [`EmulatorError::Unknown`].
    pub fn new(name: &str, truth: SharedTruth) -> Result<Self, EmulatorError> {
        let known = makers::EMULATED.iter().find(|make| make.name == name);
        let Some(make) = known else {
            let names = || emulated_gauges().map(|(name, _)| name);
            let meant = nearest(name, names())
                .map_or_else(String::new, |near| format!("did you mean {near}? "));
            return Err(EmulatorError::Unknown {
                name: name.to_owned(),
                help: format!(
                    "{meant}emulated gauges are {}",
                    names().collect::<Vec<_>>().join(", ")
                ),
            });
        };
        Ok(Self::made(make.name, (make.range)(), (make.maker)(), truth))
    }

    /// A gauge that does what a description says, as it is after switching on.
    #[must_use]
    pub fn described(description: &InstrumentDescription, truth: SharedTruth) -> Self {
        let maker = Described::boxed(description);
        let range = described::range(description);
        Self::made(&description.name, range, maker, truth)
    }

    pub(super) fn made(
        name: &str,
        range: Range,
        maker: Box<dyn Maker>,
        truth: SharedTruth,
    ) -> Self {
        Self {
            name: name.to_owned(),
            meter: Meter::new(range, truth),
            maker,
        }
    }

    /// The name of its description.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it measures force or displacement.
    #[must_use]
    pub fn channel(&self) -> Channel {
        self.meter.range.channel
    }

    /// Bytes arrive from the host; what the gauge answers.
    ///
    /// # Arguments
    /// - `now_s`: time, s, never going back from call to call.
    pub fn receive(&mut self, bytes: &[u8], now_s: f64) -> Vec<u8> {
        self.receive_packets(bytes, now_s).concat()
    }

    /// Time passes; what the gauge sends by itself.
    pub fn tick(&mut self, now_s: f64) -> Vec<u8> {
        self.tick_packets(now_s).concat()
    }

    /// As [`EmulatedGauge::receive`], packet by packet.
    pub fn receive_packets(&mut self, bytes: &[u8], now_s: f64) -> Vec<Vec<u8>> {
        let mut out = Packets::new();
        self.maker.receive(&mut self.meter, bytes, now_s, &mut out);
        out
    }

    /// As [`EmulatedGauge::tick`], packet by packet.
    pub fn tick_packets(&mut self, now_s: f64) -> Vec<Vec<u8>> {
        let mut out = Packets::new();
        self.maker.tick(&mut self.meter, now_s, &mut out);
        out
    }

    /// When [`EmulatedGauge::tick`] will have something to send, s; `None` if not before something is received.
    #[must_use]
    pub fn next_due_s(&self) -> Option<f64> {
        self.maker.next_due_s()
    }

    /// Somebody does something at the gauge; what it sends because of that.
    ///
    /// # Errors
    /// [`EmulatorError::Unit`] for a unit that it does not have.
    pub fn press(&mut self, panel: &Panel, now_s: f64) -> Result<Vec<Vec<u8>>, EmulatorError> {
        let mut out = Packets::new();
        let meter = &mut self.meter;
        match panel {
            Panel::Zero => meter.zero(),
            Panel::Unit(name) => {
                if !meter.set_unit(name) {
                    let units = meter.range.units.iter();
                    let known: Vec<&str> = units.map(|unit| unit.name.as_str()).collect();
                    return Err(EmulatorError::Unit {
                        gauge: self.name.clone(),
                        unit: name.to_string(),
                        known: known.join(", "),
                    });
                }
            }
            Panel::PeakMode(on) => {
                meter.peak_mode = *on;
                meter.clear_peaks();
            }
            Panel::Hold(on) => meter.hold(*on),
            Panel::DataKey => self.maker.data_key(meter, now_s, &mut out),
            Panel::LowBattery(on) => meter.battery_low = *on,
            Panel::Overload(on) => meter.force_overload(*on),
            Panel::Freeze(on) => meter.freeze(*on),
            Panel::InvertSign(on) => meter.invert(*on),
            Panel::ToolOff(on) => meter.tool_off = *on,
        }
        Ok(out)
    }
}

/// Names of the gauges that can be emulated, with what they measure: one for each shipped description.
pub fn emulated_gauges() -> impl Iterator<Item = (&'static str, Channel)> {
    makers::EMULATED
        .iter()
        .map(|make| (make.name, (make.range)().channel))
}
