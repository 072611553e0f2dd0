//! The program as a user runs it: every subcommand in text and JSON, what it refuses and with which exit code, and which files it writes.

mod config;
mod contract;
mod data_findings;
mod diagnose;
mod doctor;
mod drawn;
#[cfg(unix)]
mod emulate;
mod exit_codes;
mod explain;
mod export;
mod failures;
mod files;
mod fit;
mod forms;
mod help;
mod import;
mod imported_sessions;
mod in_process;
mod inputs;
mod instruments;
#[cfg(unix)]
pub(crate) mod lines;
mod load_case_input;
mod load_cases;
mod map;
mod map_questions;
mod model_export;
mod names;
#[cfg(target_os = "linux")]
mod packaging;
#[cfg(unix)]
mod permissions;
mod physics;
mod positions;
mod predict;
mod random_robots;
mod report;
mod report_forgeries;
mod results;
mod robots;
mod session;
#[cfg(unix)]
mod session_log;
mod session_raw_bytes;
mod session_skips;
mod session_state;
mod session_undo;
mod several_sessions;
mod strict;
#[cfg(unix)]
mod vector_behaviours;
mod vectors;

use std::fmt::Write;

use serde_json::Value;
use stiffbench_test_files::desk::{Desk, Ran, assert_output_contains};

/// A folder of its own to run the program in.
pub(crate) fn desk() -> Desk {
    Desk::new(env!("CARGO_BIN_EXE_stiffbench"))
}

/// A desk with a simulated session `session`, all poses and directions, 480 readings.
fn desk_with_session() -> Desk {
    let desk = desk();
    desk.run("simulate session --seed 4").succeeds();
    desk
}

/// A command with arguments that cannot be used: it ends with exit code 2; the error.
fn misuse(desk: &Desk, arguments: &str) -> Value {
    desk.refusal(arguments, 2, "stiffbench::usage::argument")
}

/// A text with its lines joined, so that words are found wherever a line ends.
pub(crate) fn unwrapped(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A readings file with the five columns that are needed: the same springs in each pose, each repeat with its own zero.
fn five_columns(poses: &[&str], repeats: u32) -> String {
    let mut text = String::from("pose,direction,repeat,force_N,displacement_um\n");
    for pose in poses {
        for (direction, um_per_n) in [("x", 100.0), ("y", 35.0), ("z", 5.0)] {
            for repeat in 1..=repeats {
                for load in [0.0, -20.0, -40.0, -60.0] {
                    let displacement = load * um_per_n + f64::from(repeat);
                    writeln!(text, "{pose},{direction},{repeat},{load},{displacement}").unwrap();
                }
            }
        }
    }
    text
}
