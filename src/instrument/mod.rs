//! Gauges: from bytes on a serial line to samples, for one gauge and for the two of a bench.
//!
//! Three layers. Decoding is pure: a description (data, `protocols/instruments`) turns bytes into samples, and never finds a number inside a
//! line. Ports and the live engine move bytes and give each its time. [`Gauges`] is what a session sees: live ports, pseudo-terminals,
//! recorded traces and mock devices all look the same from there.

mod gauges;
mod sample;

pub use gauges::{Ask, GaugeEvent, Gauges, LinkState};
pub use sample::{Channel, Mark, Rejected, Sample};
