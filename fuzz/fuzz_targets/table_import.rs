//! Any bytes as a table of another program: no panic, and what is imported can be written and read.
#![no_main]

#[path = "../bodies/table_import.rs"]
mod body;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| body::run(bytes));
