//! `stiffbench session`.

mod answering;
mod args;
mod diagnostics;
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
mod replay;
mod undo;

pub(super) use args::SessionArgs;
pub(super) use prepare::instrument_records;

use crate::session::Operator;

use super::args::Command;
use super::parse_words;
use super::{CliError, Failure, Global, Outcome};

use args::SessionCommand;

/// Plans, runs and looks after guided sessions.
pub(super) fn run(args: SessionArgs, global: &Global) -> Result<Outcome, Failure> {
    match args.what {
        SessionCommand::Plan(args) => plan::run(&args),
        SessionCommand::Run(args) if args.dry_run => plan::dry_run(&args, global),
        SessionCommand::Run(args) => drive::run(&args, global, None),
        SessionCommand::Resume(args) => drive::resume(&args, global),
        SessionCommand::Status(args) => inspect::status(&args.folder, global),
        SessionCommand::Log(args) => inspect::log(&args.folder, global),
        SessionCommand::Undo(args) => undo::run(&args.folder, global),
        SessionCommand::Replay(args) => replay::run(&args, global),
        SessionCommand::Verify(args) => repair::verify(&args.folder),
        SessionCommand::Recover(args) => repair::recover_into(&args.folder, &args.out, global),
    }
}

/// Runs a `session run` as it is typed, with somebody else to look at it.
///
/// # Errors
/// As the command; also for a session that did not come to its end.
#[cfg(unix)]
pub(super) fn run_command(
    words: &[&str],
    operator: Box<dyn Operator>,
    global: &Global,
) -> Result<(), Failure> {
    let cli = parse_words(words)?;
    let Command::Session(SessionArgs {
        what: SessionCommand::Run(args),
    }) = cli.command
    else {
        return Ok(());
    };
    let global = Global {
        no_input: cli.global.no_input,
        ..global.clone()
    };
    let ended = drive::run(&args, &global, Some(operator))?;
    if ended.exit == 0 {
        return Ok(());
    }
    Err(CliError::Incomplete {
        folder: args.out.clone(),
    }
    .into())
}
