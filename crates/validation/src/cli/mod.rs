//! The command line of `stiffbench-validate`: one file a subcommand. Options, results and failures are those of `stiffbench`.

#[cfg(unix)]
mod counter;
mod doors;
mod error;
#[cfg(unix)]
mod faults;
mod forced;
mod prove;
mod prove_args;
mod recordings;
mod reference;
#[cfg(unix)]
mod rehearsal;
#[cfg(unix)]
mod sustain;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use stiffbench::cli::args::Global;
use stiffbench::cli::colour;
use stiffbench::cli::failure::Failure;
use stiffbench::cli::outcome::{Outcome, print_usage};

/// Whether stiffbench can be trusted: blind tests of diagnoses, recordings by others, the paper's tables, solid elements, faults of gauges.
#[derive(Debug, Parser)]
#[command(
    name = "stiffbench-validate",
    version,
    about,
    max_term_width = 110,
    after_help = "Examples:\n  stiffbench-validate prove --quick                      blind test and error rates in a few minutes\n  stiffbench-validate recordings --from my-recordings    recordings by others, with their known answers\n  stiffbench-validate reference compare                  beams beside solid elements\n  stiffbench-validate faults --phase settle              faults of gauges and lines in a session\n\nExit codes: those of stiffbench."
)]
struct ValidateCli {
    /// What all subcommands share.
    #[command(flatten)]
    global: Global,
    /// What to do.
    #[command(subcommand)]
    command: ValidateCommand,
}

/// Subcommands.
#[derive(Debug, Subcommand)]
enum ValidateCommand {
    /// Blind test of diagnoses on sessions by another simulator; error rates and power on simulated benches
    Prove(prove_args::ProveArgs),
    /// Diagnoses of recordings by others, read from a folder of yours, beside their known answers
    Recordings(recordings::RecordingsArgs),
    /// Beams beside solid elements: write the robot for CalculiX, run it, compare (the paper's Table IV)
    Reference(reference::ReferenceArgs),
    /// Every fault of a gauge or line in every phase of a session, and what became of the readings
    #[cfg(unix)]
    Faults(faults::FaultsArgs),
    /// Two emulated gauges streaming through pseudo-terminals: what is lost, and the cost
    #[cfg(unix)]
    Sustain(sustain::SustainArgs),
}

/// Exit codes of failures that `stiffbench` does not have.
const EXIT_CODES: &[(&str, u8)] = &[
    ("stiffbench::reference::size", 2),
    ("stiffbench::reference::record", 11),
    ("stiffbench::reference::answer", 11),
    ("stiffbench::reference::unfinished", 11),
    ("stiffbench::reference", 10),
    ("stiffbench::prove", 11),
];

/// Runs the program on the given arguments (the first is its name) and prints what comes out.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let choice = colour::choice(&arguments);
    colour::apply(choice);
    let mut tree = ValidateCli::command().color(colour::for_clap(choice));
    let parsed = tree
        .try_get_matches_from_mut(&arguments)
        .and_then(|matches| ValidateCli::from_arg_matches(&matches))
        .map_err(|error| error.format(&mut tree));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => return print_usage(&error, &arguments, "stiffbench-validate"),
    };
    let global = cli.global.clone();
    match run(cli) {
        Ok(outcome) => outcome.print(&global),
        Err(failure) => failure.print(&global, EXIT_CODES),
    }
}

fn run(cli: ValidateCli) -> Result<Outcome, Failure> {
    let global = &cli.global;
    match cli.command {
        ValidateCommand::Prove(args) => prove::run(&args, global),
        ValidateCommand::Recordings(args) => recordings::run(&args, global),
        ValidateCommand::Reference(args) => reference::run(&args, global),
        #[cfg(unix)]
        ValidateCommand::Faults(args) => faults::run(&args, global),
        #[cfg(unix)]
        ValidateCommand::Sustain(args) => sustain::run(&args, global),
    }
}
