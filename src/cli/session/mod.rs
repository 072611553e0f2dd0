//! `stiffbench session`.

mod args;
mod drive;
mod emulation;
mod gauges;
mod line;
mod look;
mod operator;
mod plan;
mod prepare;
mod repair;

pub(super) use args::SessionArgs;

use super::args::Global;
use super::failure::Failure;
use super::outcome::Outcome;

use args::SessionCommand;

/// Plans, runs and looks after guided sessions.
pub(super) fn run(args: SessionArgs, global: &Global) -> Result<Outcome, Failure> {
    match args.what {
        SessionCommand::Plan(args) => plan::run(&args),
        SessionCommand::Run(args) => drive::run(&args, global),
        SessionCommand::Resume(args) => drive::resume(&args, global),
        SessionCommand::Status(args) => look::status(&args.folder),
        SessionCommand::Log(args) => look::log(&args.folder),
        #[cfg(unix)]
        SessionCommand::Faults(args) => crate::cli::practice::run_faults(&args, global),
        SessionCommand::Verify(args) => repair::verify(&args.folder),
        SessionCommand::Recover(args) => repair::recover_into(&args.folder, &args.out),
    }
}
