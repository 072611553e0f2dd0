//! The program as a whole, and what holds for the repository.

#![expect(
    clippy::unwrap_used,
    reason = "a test stops at what is not as it must be"
)]

mod architecture;
mod cases;
mod cli;
#[cfg(unix)]
mod compatibility;
mod diagnosis;
mod examples;
mod fuzz_briefly;
mod goldens;
mod paper_tables;
mod paper_transcription;
mod readme;
mod robot_new;
mod schemas;
mod session_crash;
mod session_terminal;
mod shipped;
mod support;
mod words;
