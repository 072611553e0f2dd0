//! Any text as a session header: no panic, and what is read survives being written.
#![no_main]

#[path = "../bodies/session_toml.rs"]
mod body;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| body::run(bytes));
