//! The promises of this crate, tested from outside.

#![expect(
    clippy::unwrap_used,
    reason = "a test stops at what is not as it must be"
)]

mod load_cases;
mod procedures;
mod readings_bad_input;
mod readings_round_trip;
mod session_files;
mod specimen_tables;
mod specimen_thinned;
mod table_files;
