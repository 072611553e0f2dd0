//! What comes out of a decoder.

use crate::sample::{Rejected, Sample};

/// What bytes turned out to be.
#[derive(Debug, Clone, PartialEq)]
pub enum Decoded {
    /// A value.
    Sample(Sample),
    /// An answer to something other than a request for a value.
    Reply(Reply),
    /// Bytes that are neither.
    Rejected(Rejected),
}

/// An answer to a command.
#[derive(Debug, Clone, PartialEq)]
pub struct Reply {
    /// The packet as it came; bytes that are not printable ASCII as `\xNN`.
    pub raw: Box<str>,
    /// Its content.
    pub meaning: Meaning,
    /// When its last byte arrived, s.
    pub at_s: f64,
}

/// The content of an answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Meaning {
    /// Done.
    Acknowledged,
    /// Not done, and why.
    Refused(String),
    /// Who the gauge is.
    Identity(String),
    /// Its unit, in the spelling of [`stiffbench_units_and_text::quantity::Kind::si_factor`] where it is known.
    Unit(String),
    /// Its mode or settings.
    State(String),
    /// Something else.
    Text(String),
}

/// Bytes as text: printable ASCII as it is, the rest as `\xNN`.
#[must_use]
pub fn raw_text(bytes: &[u8]) -> Box<str> {
    use std::fmt::Write;
    let mut text = String::with_capacity(bytes.len());
    for byte in bytes {
        if matches!(byte, 0x20..=0x7e) {
            text.push(char::from(*byte));
        } else {
            // Writing to a String does not fail.
            let _ = write!(text, "\\x{byte:02x}");
        }
    }
    text.into()
}
