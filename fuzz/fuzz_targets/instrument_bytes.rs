//! Any bytes from a gauge, whose description and whose cuts the first bytes choose: no panic, and the same samples however the bytes are cut.
#![no_main]

#[path = "../bodies/instrument_bytes.rs"]
mod body;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| body::run(bytes));
