//! What can keep a proof from being made.

use stiffbench::bench::BenchError;
use stiffbench_beams::physics::EffectError;
use stiffbench_beams::robot::RobotError;
use stiffbench_diagnosis::mismatch::MismatchError;
use stiffbench_measurement::readings::{SessionFileError, TableError};
use stiffbench_numeric::least_squares::LeastSquaresError;
use stiffbench_units_and_text::toml_text::TomlError;

/// Why there is no proof.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ProveError {
    /// Sealed answers that are none.
    #[error("the sealed answers cannot be opened: {problem}")]
    #[diagnostic(
        code(stiffbench::prove::seal),
        help(
            "take answers.sealed from the repository again; data/concealed/README.md describes its form"
        )
    )]
    Seal {
        /// What is wrong with them.
        problem: String,
    },
    /// Sealed answers that are not as they were.
    #[error(
        "the sealed answers are damaged: {found_bytes} bytes with SHA-256 {found_sha256}, stated are {stated_bytes} with {stated_sha256}"
    )]
    #[diagnostic(
        code(stiffbench::prove::damaged),
        help("take answers.sealed from the repository again")
    )]
    Damaged {
        /// Length as the header states it.
        stated_bytes: String,
        /// Length found.
        found_bytes: usize,
        /// SHA-256 as the header states it.
        stated_sha256: String,
        /// SHA-256 found.
        found_sha256: String,
    },
    /// A file of answers, sets or recordings with another form.
    #[error("{file} is not as expected: {problem}")]
    #[diagnostic(
        code(stiffbench::prove::form),
        help("take the file from the repository again")
    )]
    Form {
        /// The file, with line and column where they are known.
        file: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A session without an answer.
    #[error("there is no answer for session {session}")]
    #[diagnostic(
        code(stiffbench::prove::no_answer),
        help(
            "answers.sealed and the folder sessions belong together: take both from the repository again"
        )
    )]
    NoAnswer {
        /// The session.
        session: String,
    },
    /// Readings that cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Table(#[from] TableError),
    /// A header that cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    SessionFile(#[from] SessionFileError),
    /// A robot that cannot be read or placed.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Robot(#[from] RobotError),
    /// A trial that cannot be computed.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Mismatch(#[from] MismatchError),
    /// A fit that cannot be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    LeastSquares(#[from] LeastSquaresError),
    /// A plan that cannot be followed.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Bench(#[from] BenchError),
    /// An effect of a trial that cannot be.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Effect(#[from] EffectError),
}

impl From<TomlError> for ProveError {
    fn from(TomlError(error): TomlError) -> Self {
        Self::Form {
            file: error.place(),
            problem: error.problem.to_string(),
        }
    }
}
