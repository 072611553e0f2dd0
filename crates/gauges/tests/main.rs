//! The promises of this crate, tested from outside.

#![expect(
    clippy::unwrap_used,
    reason = "a test stops at what is not as it must be"
)]

mod emulated_decoding;
mod emulated_lines;
mod emulated_oracles;
mod instrument_contract;
mod instrument_descriptions;
mod lines;
mod oracles;
mod support;
