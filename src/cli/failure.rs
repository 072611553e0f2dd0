//! Failures: one form for people, one for programs, one table of exit codes.

use std::path::PathBuf;
use std::process::ExitCode;

use miette::Diagnostic;
use serde_json::json;

use super::args::Global;
use super::outcome::{envelope, not_printed, print_error, print_json};

/// Errors of the command line itself.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum CliError {
    /// A file that cannot be read.
    #[error("{path} cannot be read")]
    #[diagnostic(
        code(stiffbench::input::read),
        help("check the permissions, and that it is a text file in UTF-8")
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Neither a file nor a folder nor a shipped name.
    #[error("{path}: there is no such file or folder")]
    #[diagnostic(code(stiffbench::input::not_found))]
    NotFound {
        /// What the user named.
        path: PathBuf,
        /// What could be meant.
        #[help]
        help: String,
    },
    /// A folder that is no session.
    #[error("{path} holds no readings.csv")]
    #[diagnostic(
        code(stiffbench::input::no_session),
        help(
            "a session is a folder with readings.csv in it; a readings file may also be named itself"
        )
    )]
    NoSession {
        /// The folder.
        path: PathBuf,
    },
    /// A table that no longer holds what the journal holds.
    #[error("{path} was changed after the session: {changes}")]
    #[diagnostic(
        code(stiffbench::input::changed),
        help(
            "stiffbench session recover FOLDER --out NEW writes the table anew from the journal; --trust-csv uses it as it is, and every result \
             says so"
        )
    )]
    Changed {
        /// The table.
        path: PathBuf,
        /// What was changed.
        changes: String,
    },
    /// A file that cannot be written.
    #[error("{path} cannot be written")]
    #[diagnostic(
        code(stiffbench::output::write),
        help("choose another place, or free the space; nothing else was changed")
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A folder that exists already.
    #[error("{path} exists already")]
    #[diagnostic(
        code(stiffbench::output::exists),
        help("choose another name; a session is never written over")
    )]
    Exists {
        /// The folder.
        path: PathBuf,
    },
    /// A session that did not come to its end.
    #[error("{folder}: the session is not complete")]
    #[diagnostic(
        code(stiffbench::session::incomplete),
        help("stiffbench session log FOLDER says why; stiffbench session resume FOLDER goes on")
    )]
    Incomplete {
        /// The session.
        folder: PathBuf,
    },
    /// An argument with a meaning that cannot be.
    #[error("{argument}: {problem}")]
    #[diagnostic(code(stiffbench::usage::argument))]
    Argument {
        /// The argument.
        argument: String,
        /// What is wrong with it.
        problem: String,
        /// What to write instead.
        #[help]
        help: Option<String>,
    },
    /// A command that checks the program, no longer part of it.
    #[error("stiffbench {command} has moved to another program: {now}")]
    #[diagnostic(
        code(stiffbench::usage::moved),
        help(
            "cargo run --release --bin stiffbench-validate -- --help, in a clone of the repository (docs/validation.md)"
        )
    )]
    Moved {
        /// The command.
        command: &'static str,
        /// The program and its command.
        now: String,
    },
    /// A command that is not built yet.
    #[error("stiffbench {command} is planned and not built yet: it {purpose}")]
    #[diagnostic(code(stiffbench::usage::planned))]
    Planned {
        /// The command.
        command: &'static str,
        /// What it will do.
        purpose: &'static str,
        /// What does that today.
        #[help]
        today: String,
    },
    /// Data that need a model, and no robot is named.
    #[error("no robot: neither --robot nor a session.toml beside the data names one")]
    #[diagnostic(code(stiffbench::usage::no_robot))]
    NoRobot {
        /// What to add.
        #[help]
        help: String,
    },
    /// A robot file that is not the session's.
    #[error("{robot} is not the robot file the session was measured with: its SHA-256 differs")]
    #[diagnostic(
        code(stiffbench::robot::other_file),
        help("put the file of the session back, or name the robot that is meant with --robot")
    )]
    OtherRobot {
        /// The file.
        robot: String,
    },
    /// A session or model that names a robot which is not there.
    #[error(
        "{file} names the robot {robot}, and there is no such file beside it and no shipped robot of that name"
    )]
    #[diagnostic(
        code(stiffbench::session_file::robot),
        help("put the robot file beside it, or name another with --robot")
    )]
    NamedRobot {
        /// The session's header, or the model.
        file: PathBuf,
        /// The robot as it stands there.
        robot: String,
    },
    /// A factor file that is not one.
    #[error("{file} is no factor set: {problem}")]
    #[diagnostic(
        code(stiffbench::robot::factor_file),
        help(
            "write two tables: beam = {{ A = 1.0, Iy = 1.0, Iz = 1.0, J = 1.0 }} and the same for link"
        )
    )]
    Factors {
        /// The file.
        file: String,
        /// What is wrong with it.
        problem: String,
    },
    /// Data without readings where readings are needed.
    #[error("{data} holds stiffness values, not readings: {needs} needs readings")]
    #[diagnostic(
        code(stiffbench::usage::needs_readings),
        help("give a session folder or a readings file")
    )]
    NeedsReadings {
        /// The data.
        data: String,
        /// What needs readings.
        needs: &'static str,
    },
    /// Records that do not say what the noise of a reading is.
    #[error(
        "{data}: --noise records needs the step of the displacement gauge, and no record states it"
    )]
    #[diagnostic(
        code(stiffbench::session_file::no_resolution),
        help(
            "put resolution_um under [instruments.displacement] of session.toml, or take the noise from the readings (--noise estimated)"
        )
    )]
    NoResolution {
        /// The data.
        data: String,
    },
    /// An instrument description from memory.
    #[error(
        "the description {instrument} is recalled: no manual and no working program was found for it"
    )]
    #[diagnostic(
        code(stiffbench::instrument::unverified),
        help(
            "check it at the bench against the display of the gauge, then name --allow-unverified"
        )
    )]
    Unverified {
        /// Name of the description.
        instrument: String,
    },
    /// Overdue calibration under --strict.
    #[error("calibration overdue: {instruments}")]
    #[diagnostic(
        code(stiffbench::calibration::overdue),
        help("have the gauge calibrated, or leave out --strict and accept a warning")
    )]
    CalibrationOverdue {
        /// Which gauges, since when.
        instruments: String,
    },
}

/// A failure on its way out of the program.
#[derive(Debug)]
pub struct Failure {
    report: miette::Report,
    /// What a user should know besides.
    warnings: Vec<String>,
}

impl<E: Diagnostic + Send + Sync + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        Self {
            report: miette::Report::new(error),
            warnings: Vec::new(),
        }
    }
}

impl Failure {
    /// Exit code by the first part of the error's code that has one, here or among `more`.
    fn exit_code(&self, more: &[(&str, u8)]) -> u8 {
        // The first that fits counts: single errors stand before their stage.
        const CODES: &[(&str, u8)] = &[
            ("stiffbench::usage", 2),
            ("stiffbench::calibration", 12),
            ("stiffbench::fit::stiffness_list", 11),
            ("stiffbench::robot::model_parameter", 2),
            ("stiffbench::fit::bounds", 2),
            ("stiffbench::fit::tie", 2),
            ("stiffbench::fit::weights", 2),
            ("stiffbench::fit", 40),
            ("stiffbench::least_squares::tie_cycle", 2),
            ("stiffbench::least_squares", 40),
            ("stiffbench::readings", 11),
            ("stiffbench::input_needed", 3),
            ("stiffbench::session::in_use", 21),
            ("stiffbench::session::damaged", 30),
            ("stiffbench::session::journal", 14),
            ("stiffbench::session", 10),
            ("stiffbench::input", 11),
            ("stiffbench::output::exists", 13),
            ("stiffbench::output", 14),
            ("stiffbench::procedure", 10),
            ("stiffbench::robot", 10),
            ("stiffbench::structure", 10),
            ("stiffbench::stiffness", 10),
            ("stiffbench::distribution", 10),
            ("stiffbench::bench", 10),
            ("stiffbench::emulator", 70),
            ("stiffbench::physics", 10),
            ("stiffbench::instrument::description", 10),
            ("stiffbench::instrument", 2),
            ("stiffbench::specimen", 11),
            ("stiffbench::mismatch::unknown_law", 2),
            ("stiffbench::mismatch::parameter", 2),
            ("stiffbench::mismatch::empty", 11),
            ("stiffbench::mismatch", 40),
            ("stiffbench::port::absent", 20),
            ("stiffbench::port::no_line", 20),
            ("stiffbench::port::wrong_device", 20),
            ("stiffbench::port::silent", 20),
            ("stiffbench::port::lost", 22),
            ("stiffbench::port::not_allowed", 23),
            ("stiffbench::port", 21),
            ("stiffbench::bindings", 10),
            ("stiffbench::live", 10),
            ("stiffbench::trace", 11),
        ];
        let code = self.code();
        more.iter()
            .chain(CODES)
            .find(|(prefix, _)| code.starts_with(prefix))
            .map_or(70, |(_, exit)| *exit)
    }

    fn code(&self) -> String {
        self.report
            .code()
            .map_or_else(String::new, |code| code.to_string())
    }

    /// With what a user should know besides.
    #[must_use]
    pub fn with_warnings(mut self, warnings: &[String]) -> Self {
        self.warnings.extend(warnings.iter().cloned());
        self
    }

    /// What went wrong and why, in one sentence.
    pub fn message(&self) -> String {
        let causes: Vec<String> = self.report.chain().map(ToString::to_string).collect();
        causes.join(": ")
    }

    /// Prints the failure: JSON on standard output, or text on standard error. `more` gives the exit codes of errors that only the calling
    /// program has, by the beginning of their code.
    #[must_use]
    pub fn print(&self, global: &Global, more: &[(&str, u8)]) -> ExitCode {
        let exit = self.exit_code(more);
        if global.json {
            let mut object = envelope("error", false);
            object["error"] = json!({
                "code": self.code(),
                "message": self.message(),
                "help": self.report.help().map(|help| help.to_string()),
                "exit_code": exit,
            });
            object["warnings"] = json!(self.warnings);
            if let Err(error) = print_json(&object) {
                return not_printed(&error);
            }
        } else {
            print_error(&format!("{:?}", self.report));
            for warning in self.warnings.iter().filter(|_| !global.quiet) {
                print_error(&format!("note: {warning}"));
            }
        }
        ExitCode::from(exit)
    }
}
