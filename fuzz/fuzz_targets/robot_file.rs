//! Any text as a robot file: no panic, and what is read can be placed, weighed and solved, or refused.
#![no_main]

#[path = "../bodies/robot_file.rs"]
mod body;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| body::run(bytes));
