//! Commands that are now in `stiffbench-validate`.

use std::ffi::OsString;

use clap::Args;

use super::failure::{CliError, Failure};
use super::outcome::Outcome;

/// Whatever follows the name of a command that is now in `stiffbench-validate`.
#[derive(Debug, Args)]
pub(super) struct MovedArgs {
    /// Its arguments
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    arguments: Vec<OsString>,
}

impl MovedArgs {
    /// Says where the command is now.
    pub(super) fn run(&self, command: &'static str, now: &'static str) -> Result<Outcome, Failure> {
        let arguments: Vec<_> = self
            .arguments
            .iter()
            .map(|word| word.to_string_lossy())
            .collect();
        let words = ["stiffbench-validate".into(), now.into()];
        let words: Vec<_> = words.into_iter().chain(arguments).collect();
        Err(CliError::Moved {
            command,
            now: words.join(" "),
        }
        .into())
    }
}
