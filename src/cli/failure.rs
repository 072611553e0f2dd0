//! Failures: one form for people, one for programs, one table of exit codes.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use miette::Diagnostic;
use serde_json::Value;

use super::args::Global;
use crate::analysis::ArgumentError;
pub use crate::analysis::Failure;
use crate::report::ErrorReport;

use super::excerpt::excerpt;
use super::outcome::{error_object, not_printed, print_error, print_json};

/// Errors of the command line itself.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum CliError {
    /// A file that cannot be written.
    #[error("{path} cannot be written")]
    #[diagnostic(
        code(stiffbench::output::write),
        help("choose another place, or free the space; nothing else was changed")
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A folder that exists already.
    #[error("{path} exists already")]
    #[diagnostic(
        code(stiffbench::output::exists),
        help("choose another name; a session is never overwritten")
    )]
    Exists {
        /// The folder.
        path: PathBuf,
    },
    /// A folder for new files that holds some already.
    #[error("{path} exists already and is not empty")]
    #[diagnostic(
        code(stiffbench::output::exists),
        help("choose another name; nothing in it is overwritten")
    )]
    NotEmpty {
        /// The folder.
        path: PathBuf,
    },
    /// A format that this build does not write.
    #[cfg(not(feature = "parquet"))]
    #[error("this build of stiffbench does not write Parquet")]
    #[diagnostic(
        code(stiffbench::usage::no_parquet),
        help(
            "build it with cargo build --release --features parquet, or write --format csv or --format xlsx"
        )
    )]
    NoParquet,
    /// A file that exists already and would be replaced by a result.
    #[error("{path} exists already")]
    #[diagnostic(
        code(stiffbench::output::exists),
        help(
            "name another file, for example with --out FILE, or remove this one. Figures and results replace their earlier ones, but no other file, no link and no input"
        )
    )]
    FileExists {
        /// The file.
        path: PathBuf,
    },
    /// A file for standard output, of a command that cannot write it there.
    #[error("- is standard output, and this file cannot be written to it")]
    #[diagnostic(
        code(stiffbench::usage::no_standard_output),
        help("name a file; ./- is a file of this name")
    )]
    Dash,
    /// A mistake of the program.
    #[error("internal error: {problem}")]
    #[diagnostic(
        code(stiffbench::internal),
        help("this is a bug of the program: please report it with the command that led to it")
    )]
    Internal {
        /// What broke.
        problem: String,
    },
    /// A session that did not come to its end.
    #[error("{folder}: the session is not complete")]
    #[diagnostic(
        code(stiffbench::session::incomplete),
        help(
            "stiffbench session log FOLDER shows why; stiffbench session resume FOLDER continues"
        )
    )]
    Incomplete {
        /// The session.
        folder: PathBuf,
    },
    /// A name that `explain` does not know.
    #[error("there is no explanation of {name}")]
    #[diagnostic(code(stiffbench::usage::unknown_topic))]
    UnknownTopic {
        /// What the user named.
        name: String,
        /// What could be meant.
        #[help]
        advice: String,
    },
    /// An instrument description from memory.
    #[error(
        "the description {instrument} is recalled: no manual and no working program was found for it"
    )]
    #[diagnostic(
        code(stiffbench::instrument::unverified),
        help(
            "check it at the bench against the display of the gauge, then give --allow-unverified"
        )
    )]
    Unverified {
        /// Name of the description.
        instrument: String,
    },
}

impl CliError {
    /// Names the file or folder of a failure to write.
    pub(super) fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        |source| Self::Write { path, source }
    }

    /// The same of what must be new.
    pub(super) fn create(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        |source| match source.kind() {
            ErrorKind::AlreadyExists => Self::Exists { path },
            _ => Self::Write { path, source },
        }
    }
}

/// Exit codes by the beginning of an error's code. The first that fits counts: single errors stand before their stage.
const EXIT_CODES: &[(&str, u8)] = &[
    ("stiffbench::usage", 2),
    ("stiffbench::internal", 70),
    ("stiffbench::calibration_table", 11),
    ("stiffbench::calibration", 12),
    ("stiffbench::import::missing", 3),
    ("stiffbench::import::unknown_role", 2),
    ("stiffbench::import::unit", 2),
    ("stiffbench::import", 11),
    ("stiffbench::fit::stiffness_list", 11),
    ("stiffbench::robot::model_parameter", 2),
    ("stiffbench::fit::bounds", 2),
    ("stiffbench::fit::tie", 2),
    ("stiffbench::fit::weights", 2),
    ("stiffbench::fit", 40),
    ("stiffbench::least_squares::tie_cycle", 2),
    ("stiffbench::least_squares", 40),
    ("stiffbench::readings", 11),
    ("stiffbench::load_cases::no_repeats", 2),
    ("stiffbench::load_cases::too_few", 40),
    ("stiffbench::load_cases", 11),
    ("stiffbench::input_needed", 3),
    ("stiffbench::session::in_use", 21),
    ("stiffbench::session::damaged", 30),
    ("stiffbench::session::journal", 14),
    ("stiffbench::session", 10),
    ("stiffbench::input", 11),
    ("stiffbench::output::exists", 13),
    ("stiffbench::output", 14),
    ("stiffbench::procedure", 10),
    ("stiffbench::report::not_a_report", 11),
    ("stiffbench::report::other_template", 11),
    ("stiffbench::report", 10),
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
    ("stiffbench::part_model", 10),
    ("stiffbench::table", 11),
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
    ("stiffbench::config", 10),
    ("stiffbench::live", 10),
    ("stiffbench::trace", 11),
];

/// What each exit code means, in ascending order; the one table that help, manual pages and `docs/commands.md` show.
pub const EXIT_CODE_MEANINGS: &[(u8, &str)] = &[
    (0, "done"),
    (1, "findings under --strict"),
    (2, "usage"),
    (3, "unanswered question: --no-input, or end of input"),
    (
        10,
        "configuration, robot, procedure or session file invalid",
    ),
    (11, "input file invalid or missing"),
    (12, "calibration overdue under --strict"),
    (13, "output exists"),
    (14, "output cannot be written"),
    (20, "instrument not found"),
    (21, "instrument or session busy"),
    (22, "instrument lost"),
    (23, "instrument not permitted"),
    (30, "journal damaged, or table or report changed"),
    (31, "journal unreadable"),
    (40, "fit impossible"),
    (41, "factors not identifiable under --strict"),
    (70, "internal error"),
    (130, "interrupted, can be resumed"),
];

/// Exit code for a result that names an overdue calibration, under `--strict`.
pub(super) const OVERDUE: u8 = 12;

/// The exit code of an error code.
pub(super) fn exit_code_of(code: &str) -> u8 {
    let mut codes = EXIT_CODES.iter();
    codes
        .find(|(prefix, _)| code.starts_with(prefix))
        .map_or(INTERNAL_ERROR, |(_, exit)| *exit)
}

/// The exit code of an error that has none.
pub(super) const INTERNAL_ERROR: u8 = 70;

impl Failure {
    /// Exit code by the first part of the error's code that has one, here or among `more`.
    fn exit_code(&self, more: &[(&str, u8)]) -> u8 {
        let code = self.code();
        let mut more = more.iter();
        more.find(|(prefix, _)| code.starts_with(prefix))
            .map_or_else(|| exit_code_of(&code), |(_, exit)| *exit)
    }

    fn code(&self) -> String {
        self.report
            .code()
            .map_or_else(String::new, |code| code.to_string())
    }

    /// The one object of `--json`.
    fn json(&self, exit: u8) -> Value {
        let error = ErrorReport {
            code: self.code(),
            message: self.message(),
            help: self.report.help().map(|help| help.to_string()),
            exit_code: exit,
        };
        error_object(&error, &self.warnings)
    }

    /// The object that the program prints for this failure with `--json`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        self.json(self.exit_code(&[]))
    }

    /// Prints the failure: JSON on standard output, or text on standard error. `more` gives the exit codes of errors that only the calling
    /// program has, by the beginning of their code.
    #[must_use]
    pub fn print(&self, global: &Global, more: &[(&str, u8)]) -> ExitCode {
        let exit = self.exit_code(more);
        if global.json {
            if let Err(error) = print_json(&self.json(exit)) {
                return not_printed(&error);
            }
        } else {
            print_error(&format!("{:?}", self.report));
            if let Some(excerpt) = excerpt(&self.report) {
                print_error(&excerpt);
            }
            for warning in self.warnings.iter().filter(|_| !global.quiet) {
                print_error(&format!("note: {warning}"));
            }
        }
        ExitCode::from(exit)
    }
}

/// Options without effect are a misunderstanding, and worth an error.
///
/// # Arguments
/// - `options`: each with whether it was given.
/// - `help`: what to write instead of such an option.
pub(super) fn refuse_given(
    options: &[(&str, bool)],
    problem: &str,
    help: impl Fn(&str) -> String,
) -> Result<(), ArgumentError> {
    match options.iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => Err(ArgumentError::new(*option, problem, help(option))),
    }
}
