//! The promises of this crate, tested from outside.

#![expect(
    clippy::unwrap_used,
    reason = "a test stops at what is not as it must be"
)]

#[cfg(unix)]
mod commands;
mod goldens;
mod power_on_robot;
mod prove;
mod recordings;
mod reference;
mod reference_commands;
mod schemas;
