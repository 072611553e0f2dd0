//! Emulated gauges: devices that send bytes, on the lines and with the faults of real ones.
//!
//! From the inside out: [`EmulatedGauge`] is a pure state machine of bytes and time, on a truth that it is given ([`GaugeTruth`]). Practice
//! sessions, `stiffbench demo` and tests open them through the same code that opens a real port.
//!
//! A gauge is emulated from its description: the fields that read its packets, written backwards. Four makers' gauges are written by hand in the
//! tests of this crate, without its framing, decoding and emulation, so that one can be compared with the other.

mod described;
mod fault;
mod fault_entry;
mod fault_runner;
mod fault_script;
mod gauge;
#[cfg(unix)]
mod host;
mod line;
mod meter;
#[cfg(test)]
mod property_tests;
mod range;
#[cfg(unix)]
mod served;
mod truth;
mod wire;

pub use fault::{Fault, LineFault};
pub use fault_runner::FaultRunner;
pub use fault_script::{
    FAULT_SCHEMA, FaultDuration, FaultScript, FaultScriptError, ScriptedFault, When,
};
pub use gauge::{EmulatedGauge, EmulatorError, PanelAction};
#[cfg(unix)]
pub use host::{HostError, HostOptions, PtyHost};
pub use line::{EmulatedLine, Until};
pub use truth::{GaugeTruth, SharedTruth};
