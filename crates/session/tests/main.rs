//! The promises of this crate, tested from outside.

#![expect(
    clippy::unwrap_used,
    reason = "a test stops at what is not as it must be"
)]

mod session_ends;
mod session_faults;
mod session_journal;
mod session_kinds;
mod session_limits;
mod session_repeats;
mod session_replay;
mod session_run;
mod session_scatter;
mod session_simulated;
mod session_undo;
mod session_vectors;
mod support;
