//! Any bytes as a journal: no panic, the fold of what is read is a state, and what is read survives being written.
#![no_main]

#[path = "../bodies/journal.rs"]
mod body;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| body::run(bytes));
