//! What the program tells about itself.

use schemars::JsonSchema;
use serde::Serialize;

/// The commit that the program was built from, with `+changes` if the sources differed from it; empty if not known.
pub const COMMIT: &str = env!("PROGRAM_COMMIT");

/// Version and commit, as `0.1.0 (0123456789ab)`.
pub const VERSION: &str = env!("PROGRAM_VERSION");

/// Completions of a shell.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CompletionScript {
    /// The script.
    pub script: String,
}

/// Words that complete one.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CompletedWords {
    /// The words.
    pub words: Vec<String>,
}

/// What went wrong: `error` of the output of a command that failed.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ErrorReport {
    /// Code of the error, which `stiffbench explain` explains.
    pub code: String,
    /// What went wrong and why, in one sentence.
    pub message: String,
    /// What to do; `null` if nothing can be said.
    pub help: Option<String>,
    /// Exit code of the program.
    pub exit_code: u8,
}

/// The manual page.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ManualPage {
    /// Its source for `man`.
    pub roff: String,
    /// The files that were written, one a command.
    pub files: Vec<std::path::PathBuf>,
}
