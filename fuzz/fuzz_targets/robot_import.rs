//! Any text as a URDF and as a Denavit-Hartenberg table: no panic, and what is imported is a robot file or is refused.
#![no_main]

#[path = "../bodies/robot_import.rs"]
mod body;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| body::run(bytes));
