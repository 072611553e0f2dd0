//! An emulated gauge: bytes in, bytes out.

use crate::{Channel, InstrumentDescription};

use super::described::Protocol;
use super::meter::{Meter, Range};
use super::truth::SharedTruth;
use super::wire::Packets;

/// An operator action at the gauge itself, or an event on it.
#[derive(Debug, Clone, PartialEq)]
pub enum PanelAction {
    /// Sets the zero here.
    Zero,
    /// Chooses a unit, by the gauge's own word for it or the usual one.
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

/// A gauge that cannot follow a command.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum EmulatorError {
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

/// A gauge in software, at the level of bytes: a pure state machine that receives the time.
pub struct EmulatedGauge {
    name: String,
    meter: Meter,
    protocol: Protocol,
}

impl std::fmt::Debug for EmulatedGauge {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("EmulatedGauge")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

impl EmulatedGauge {
    /// A gauge that behaves as described, in its state after switching on.
    #[must_use]
    pub fn described(description: &InstrumentDescription, truth: SharedTruth) -> Self {
        Self {
            name: description.name.clone(),
            meter: Meter::new(Range::described(description), truth),
            protocol: Protocol::new(description),
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
        self.protocol
            .receive(&mut self.meter, bytes, now_s, &mut out);
        out
    }

    /// As [`EmulatedGauge::tick`], packet by packet.
    pub fn tick_packets(&mut self, now_s: f64) -> Vec<Vec<u8>> {
        let mut out = Packets::new();
        self.protocol.tick(&mut self.meter, now_s, &mut out);
        out
    }

    /// When [`EmulatedGauge::tick`] will have something to send, s; `None` if not before something is received.
    #[must_use]
    pub fn next_due_s(&self) -> Option<f64> {
        self.protocol.next_due_s()
    }

    /// An operator action at the gauge; returns what it sends as a result.
    ///
    /// # Errors
    /// [`EmulatorError::Unit`] for a unit that it does not have.
    pub fn press(&mut self, panel: &PanelAction) -> Result<Vec<Vec<u8>>, EmulatorError> {
        let meter = &mut self.meter;
        match panel {
            PanelAction::Zero => meter.zero(),
            PanelAction::Unit(word) => {
                if !meter.set_unit(self.protocol.unit_named(word)) {
                    let units = meter.range.units.iter();
                    let known: Vec<&str> = units.map(|unit| unit.name.as_str()).collect();
                    return Err(EmulatorError::Unit {
                        gauge: self.name.clone(),
                        unit: word.to_string(),
                        known: known.join(", "),
                    });
                }
            }
            PanelAction::PeakMode(on) => {
                meter.peak_mode = *on;
                meter.clear_peaks();
            }
            PanelAction::Hold(on) => meter.hold(*on),
            PanelAction::DataKey => return Ok(self.protocol.value(meter).into_iter().collect()),
            PanelAction::LowBattery(on) => meter.battery_low = *on,
            PanelAction::Overload(on) => meter.force_overload(*on),
            PanelAction::Freeze(on) => meter.freeze(*on),
            PanelAction::InvertSign(on) => meter.invert(*on),
            PanelAction::ToolOff(on) => meter.tool_off = *on,
        }
        Ok(Packets::new())
    }
}
