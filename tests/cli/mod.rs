//! The program as a user runs it: every subcommand in text and JSON, what it refuses and with which exit code, and which files it writes.

mod contract;
mod diagnose;
mod drawn;
#[cfg(unix)]
mod emulate;
mod failures;
mod files;
mod inputs;
mod instruments;
#[cfg(unix)]
mod lines;
mod map;
mod map_questions;
#[cfg(unix)]
mod permissions;
mod physics;
mod reference;
mod results;
mod robots;
mod session;
mod strict;

use std::fmt::Write;
use std::path::PathBuf;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

/// A folder of its own to run the program in.
struct Desk {
    folder: TempDir,
}

/// What a run of the program left behind.
struct Ran {
    code: i32,
    stdout: String,
    stderr: String,
}

impl Desk {
    fn new() -> Self {
        Self {
            folder: TempDir::new().unwrap(),
        }
    }

    /// A desk with a simulated session `session`, all poses and directions, 480 readings.
    fn with_session() -> Self {
        let desk = Self::new();
        desk.run("simulate session --seed 4").succeeds();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    /// Copies a program here. Another process does so: while this one has it open for writing, one that another test starts has it open as well, and the system runs no program that somebody may be writing.
    #[cfg(unix)]
    fn install(&self, program: &str, name: &str) {
        let mut command = Command::new("install");
        command.current_dir(&self.folder);
        command.args(["-m", "755", program, name]).unwrap();
    }

    fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stiffbench"));
        command.current_dir(&self.folder);
        command.args(arguments.split_whitespace());
        command
    }

    /// Runs the program; arguments are separated by blanks.
    fn run(&self, arguments: &str) -> Ran {
        Ran::of(&mut self.command(arguments))
    }

    /// The `data` of a run with `--json` that succeeds.
    fn data(&self, arguments: &str) -> Value {
        let mut object = self.run(&format!("{arguments} --json")).succeeds().json();
        object["data"].take()
    }
}

impl Ran {
    fn of(command: &mut Command) -> Self {
        let output = command.output().unwrap();
        Self {
            code: output
                .status
                .code()
                .expect("it was not stopped by a signal"),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    fn succeeds(self) -> Self {
        self.exits_with(0)
    }

    fn exits_with(self, code: i32) -> Self {
        assert_eq!(self.code, code, "{}{}", self.stdout, self.stderr);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        self
    }

    /// Standard output as one JSON object.
    fn json(&self) -> Value {
        serde_json::from_str(&self.stdout)
            .unwrap_or_else(|error| panic!("{error}: {}", self.stdout))
    }
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
