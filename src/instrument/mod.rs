//! Gauges: from bytes on a serial line to samples, for one gauge and for the two of a bench.
//!
//! Three layers. Decoding is pure: a description (data, `protocols/instruments`) turns bytes into samples, and never finds a number inside a
//! line. Ports and the live engine move bytes and give each its time. [`Gauges`] is what a session sees: live ports, pseudo-terminals,
//! recorded traces and mock devices all look the same from there.

mod decode;
pub mod description;
pub mod driver;
pub mod emulator;
mod framing;
mod gauges;
mod grammar;
pub mod live;
mod number;
pub mod port;
pub mod probe;
pub mod reader;
mod registers;
mod registry;
mod sample;
pub mod trace;
mod units;

pub use decode::{Decoded, Decoder, DecoderError, Meaning, Reply, raw_text};
pub use description::{
    Command, DescriptionError, Effect, Expect, Flow, InstrumentDescription, LineSettings,
    ModemLines, Parity, Role, Status, Timing,
};
pub use gauges::{Ask, GaugeEvent, Gauges, LinkState};
pub use registers::modbus_crc;
pub use registry::{
    RegistryError, ShippedInstrument, shipped_instrument, shipped_instruments, unknown_name,
};
pub use sample::{Channel, Mark, Rejected, Sample};
