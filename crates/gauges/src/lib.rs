//! Gauges: from bytes on a serial line to samples, for one gauge and for the two of a bench.
//!
//! Three layers. Decoding is pure: a description (data, `protocols/instruments`) turns bytes into samples, and never finds a number inside a
//! line. Ports and the live engine move bytes and give each its time. [`Gauges`] is what a session sees: live ports, pseudo-terminals,
//! recorded traces and mock devices all look the same from there.

mod check_sum;
mod decode;
pub mod description;
pub mod driver;
#[cfg(feature = "emulator")]
pub mod emulator;
mod framing;
mod gauges;
mod grammar;
mod integer;
#[cfg(feature = "live")]
pub mod live;
mod number;
#[cfg(feature = "live")]
pub mod port;
#[cfg(feature = "live")]
pub mod probe;
#[cfg(feature = "live")]
pub mod reader;
mod registers;
mod sample;
#[cfg(test)]
mod shipped;
pub mod trace;
mod units;
mod write;

pub use check_sum::modbus_crc;
pub use decode::{Decoded, Decoder, DecoderError, Meaning, Reply, raw_text};
pub use description::{
    CommandEffect, CommandRole, DescriptionError, DescriptionStatus, Expect, Flow, GaugeCommand,
    InstrumentDescription, LineSettings, ModemLines, Parity, Timing,
};
pub use gauges::{Ask, GaugeEvent, Gauges, LinkState};
pub use sample::{Channel, Mark, Rejected, Sample};
