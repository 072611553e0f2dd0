//! Any bytes as a table of readings: no panic, errors with a line, and what is read survives being written.
#![no_main]

#[path = "../bodies/readings_csv.rs"]
mod body;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| body::run(bytes));
