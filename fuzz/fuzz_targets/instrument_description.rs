//! Any text as an instrument description: no panic, errors with a line, and what is read decodes any bytes.
#![no_main]

#[path = "../bodies/instrument_description.rs"]
mod body;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| body::run(bytes));
