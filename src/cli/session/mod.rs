//! `stiffbench session`.

mod args;
mod drive;
mod emulation;
mod gauges;
mod inspect;
mod line;
mod operator;
mod plan;
mod prepare;
mod repair;
mod repeats;

pub(super) use args::SessionArgs;
pub(super) use prepare::instrument_records;

use crate::analysis::ArgumentError;
use crate::session::Operator;

use super::args::{Cli, Command, Global};
use super::failure::{CliError, Failure};
use super::outcome::Outcome;

use args::SessionCommand;
use clap::Parser;

/// Plans, runs and looks after guided sessions.
pub(super) fn run(args: SessionArgs, global: &Global) -> Result<Outcome, Failure> {
    match args.what {
        SessionCommand::Plan(args) => plan::run(&args),
        SessionCommand::Run(args) => drive::run(&args, global, None),
        SessionCommand::Resume(args) => drive::resume(&args, global),
        SessionCommand::Status(args) => inspect::status(&args.folder),
        SessionCommand::Log(args) => inspect::log(&args.folder),
        SessionCommand::Faults(args) => args.run("session faults", "faults"),
        SessionCommand::Verify(args) => repair::verify(&args.folder),
        SessionCommand::Recover(args) => repair::recover_into(&args.folder, &args.out),
    }
}

/// Runs a `session run` as it is typed, with somebody else to look at it.
///
/// # Errors
/// As the command; also for a session that did not come to its end.
pub(super) fn run_command(
    words: &[&str],
    operator: Box<dyn Operator>,
    global: &Global,
) -> Result<(), Failure> {
    let cli = Cli::try_parse_from(words).map_err(|error| ArgumentError {
        argument: words.join(" "),
        problem: error.to_string(),
        help: None,
    })?;
    let Command::Session(SessionArgs {
        what: SessionCommand::Run(args),
    }) = cli.command
    else {
        return Ok(());
    };
    let ended = drive::run(&args, global, Some(operator))?;
    if ended.exit == 0 {
        return Ok(());
    }
    Err(CliError::Incomplete {
        folder: args.out.clone(),
    }
    .into())
}
