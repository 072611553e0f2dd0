//! The command line: arguments, files, terminal. One file a subcommand; each returns an `Outcome`, and only this module prints.

mod args;
mod compare;
mod data;
mod demo;
mod descriptions;
mod design;
mod diagnose;
mod diagnose_args;
mod diagnose_earlier;
mod diagnose_specimen;
#[cfg(unix)]
mod emulate;
#[cfg(unix)]
mod emulated;
mod failure;
mod figure_files;
mod fit;
mod gauge;
mod hash;
mod inputs;
mod instrument;
mod instrument_args;
mod instrument_read;
mod integrity;
mod map;
mod model;
mod outcome;
mod paper;
mod plausible;
mod plot;
mod ports;
mod practice;
mod procedure;
mod progress;
mod prove;
mod prove_args;
mod reference;
mod robot;
mod screen;
mod session;
mod significance;
mod simulate;
mod specimen_args;
mod stiffness;
mod trace;
mod trace_counter;
mod trace_sustain;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use failure::Failure;
use outcome::Outcome;

/// Runs the program on the given arguments (the first is its name) and prints what comes out.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(error) => return outcome::print_usage(&error, &arguments),
    };
    let global = cli.global.clone();
    match run(cli) {
        Ok(outcome) => outcome.print(&global),
        Err(failure) => failure.print(&global),
    }
}

fn run(cli: Cli) -> Result<Outcome, Failure> {
    let global = &cli.global;
    match cli.command {
        Command::Demo(args) => demo::run(&args, global),
        Command::Robot(args) => robot::run(args),
        Command::Stiffness(args) => stiffness::run(&args, global),
        Command::Fit(args) => fit::run(&args, global),
        Command::Significance(args) => significance::run(&args),
        Command::Plot(args) => plot::run(&args, global),
        Command::Simulate(args) => simulate::run(&args),
        #[cfg(unix)]
        Command::Emulate(args) => emulate::run(&args, global),
        Command::Session(args) => session::run(args, global),
        Command::Compare(args) => compare::run(&args, global),
        Command::Diagnose(args) => diagnose::run(&args, global),
        Command::Map(args) => map::run(&args),
        Command::Paper(args) => paper::run(&args),
        Command::Prove(args) => prove::run(&args, global),
        Command::Reference(args) => reference::run(&args, global),
        Command::Instrument(args) => instrument::run(&args, global),
        Command::Ports(args) => ports::run(&args, global),
        Command::Trace(args) => trace::run(&args, global),
        Command::Completions { shell } => Ok(outcome::completions(shell)),
        Command::Man => Ok(outcome::man_page()?),
    }
}
