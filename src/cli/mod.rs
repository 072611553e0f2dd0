//! The command line: arguments, files, terminal. One file a subcommand; each returns an `Outcome`, and only this module prints.

pub mod args;
pub mod colour;
mod compare;
mod complete;
mod config;
mod data_args;
mod demo;
mod diagnose;
mod doctor;
#[cfg(unix)]
pub mod emulated;
mod excerpt;
mod explain;
mod export;
pub mod failure;
pub mod figure_files;
mod fit;
pub mod gauge;
mod global;
mod help;
mod import;
mod locale;
mod map;
mod model;
mod numbers;
mod option_values;
pub mod outcome;
mod parameter_args;
mod part;
mod pose_args;
mod predict;
mod procedure;
pub mod progress;
#[cfg(unix)]
pub mod rehearsal;
pub mod report;
mod robot;
mod robot_export;
mod robot_new;
mod screen;
mod session;
mod significance;
mod simulate;
mod specimen_args;
mod stiffness;

use std::any::Any;
use std::ffi::OsString;
use std::process::ExitCode;

use clap::{ColorChoice, FromArgMatches};
use serde_json::Value;

use crate::analysis::{ArgumentError, forget_inputs};
use crate::export::tidy::TidyTable;
use args::{Cli, Command};

// What a command takes and gives: all of them import it from here.
use args::Global;
use failure::{CliError, Failure};
use outcome::Outcome;

/// Runs the program on the given arguments (the first is its name) and prints what comes out.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let json = arguments.iter().any(|argument| argument == "--json");
    let colour = colour::choice(&arguments);
    colour::apply(colour);
    let settled = match config::with_settings(arguments, &command()) {
        Ok(settled) => settled,
        Err(error) => return Failure::from(error).print(&only_json(json), &[]),
    };
    let parsed = parse(&settled.arguments, colour::for_clap(colour));
    if !parsed.as_ref().is_ok_and(|cli| cli.global.quiet) {
        for note in &settled.notes {
            outcome::print_error(&format!("note: {note}"));
        }
    }
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => return outcome::print_usage(&error, &settled.arguments, "stiffbench"),
    };
    let mut global = cli.global.clone();
    global.json |= json;
    #[cfg(panic = "abort")]
    end_on_panic(&global);
    match guarded(|| run(cli)) {
        Ok(outcome) => outcome.print(&global),
        Err(failure) => failure.print(&global, &[]),
    }
}

/// Runs a command as it is typed, without the program's name before it, and returns the object that it prints with `--json` instead of
/// printing it; the configuration counts as it does there. It is for other programs: no command that asks or waits belongs here.
///
/// # Errors
/// The object of the failure; its `error` holds `code`, `message`, `help` and `exit_code`.
pub fn json_of(words: impl IntoIterator<Item = OsString>) -> Result<Value, Value> {
    forget_inputs();
    let cli = parse_for_json(words)?;
    let outcome = run(cli).map_err(|failure| failure.to_json())?;
    Ok(outcome.json())
}

/// The tables that `stiffbench export` writes, for other programs; the words are those behind `stiffbench export`, without `--out`.
///
/// # Errors
/// As [`json_of`].
pub fn tables_of(words: impl IntoIterator<Item = OsString>) -> Result<Vec<TidyTable>, Value> {
    // Nothing is written, and so any folder will do.
    let command = ["export", "--out", "."].map(OsString::from);
    let cli = parse_for_json(command.into_iter().chain(words))?;
    let Command::Export(args) = &cli.command else {
        return Ok(Vec::new());
    };
    export::tables(args, &cli.global).map_err(|failure| failure.to_json())
}

/// A command line that prints nothing.
fn parse_for_json(words: impl IntoIterator<Item = OsString>) -> Result<Cli, Value> {
    let all: Vec<OsString> = std::iter::once("stiffbench".into()).chain(words).collect();
    let settled = config::with_settings(all, &command());
    let settled = settled.map_err(|error| Failure::from(error).to_json())?;
    let parsed = parse(&settled.arguments, ColorChoice::Never);
    let mut cli = parsed.map_err(|error| outcome::usage_json(&error, "stiffbench"))?;
    cli.global.json = true;
    cli.global.quiet = true;
    Ok(cli)
}

/// The tree of commands and options as clap has it.
#[must_use]
pub fn command() -> clap::Command {
    help::tree()
}

/// A command line, in colour where that is wanted.
fn parse<T: Into<OsString> + Clone>(
    arguments: impl IntoIterator<Item = T>,
    colour: ColorChoice,
) -> Result<Cli, clap::Error> {
    let mut tree = command().color(colour);
    let matches = tree.try_get_matches_from_mut(arguments)?;
    Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut tree))
}

/// A command line as it is typed, without the program's name before it.
fn parse_words(words: &[&str]) -> Result<Cli, ArgumentError> {
    let all = std::iter::once(&"stiffbench").chain(words);
    parse(all, ColorChoice::Never).map_err(|error| ArgumentError {
        argument: words.join(" "),
        problem: error.to_string(),
        help: None,
    })
}

/// Runs a command as it is typed; its result is not printed.
fn run_words(words: &[&str], global: &Global) -> Result<Outcome, Failure> {
    let mut cli = parse_words(words)?;
    cli.global = Global {
        quiet: true,
        no_input: cli.global.no_input,
        ..global.clone()
    };
    run(cli)
}

/// The options of every command before they are read.
fn only_json(json: bool) -> Global {
    Global {
        json,
        ..Global::default()
    }
}

/// What a command does; a panic, which is a mistake of the program, becomes a failure with its exit code.
fn guarded(work: impl FnOnce() -> Result<Outcome, Failure>) -> Result<Outcome, Failure> {
    let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(work));
    done.unwrap_or_else(|panic| Err(mistake(&*panic)))
}

/// A panic as a failure.
fn mistake(panic: &dyn Any) -> Failure {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    let problem = text.unwrap_or("it stopped without a word").to_owned();
    CliError::Internal { problem }.into()
}

/// Where panics are not caught, as in the profile `dist`, the program ends with the same failure and exit code.
#[cfg(panic = "abort")]
fn end_on_panic(global: &Global) {
    let global = global.clone();
    std::panic::set_hook(Box::new(move |panic| {
        let _ = mistake(panic.payload()).print(&global, &[]);
        std::process::exit(i32::from(failure::INTERNAL_ERROR));
    }));
}

fn run(cli: Cli) -> Result<Outcome, Failure> {
    let global = &cli.global;
    match cli.command {
        Command::Demo(args) => demo::run(&args, global),
        Command::Robot(args) => robot::run(&args, global),
        Command::Stiffness(args) => stiffness::run(&args, global),
        Command::Fit(args) => fit::run(&args, global),
        Command::Simulate(args) => simulate::run(&args),
        Command::Session(args) => session::run(args, global),
        Command::Compare(args) => compare::run(&args, global),
        Command::Diagnose(args) => diagnose::run(&args, global),
        Command::Part(args) => part::run(&args, global),
        Command::Config(args) => config::run(&args, global),
        Command::Doctor(args) => Ok(doctor::run(&args, global)),
        Command::Explain(args) => explain::run(&args),
        Command::Export(args) => export::run(&args, global),
        Command::Import(args) => import::run(&args, global),
        Command::Gauge(args) => gauge::run(&args, global),
        Command::Report(args) => report::run(&args, global),
        Command::Completions { shell } => Ok(outcome::completions(shell)),
        Command::Complete { of } => complete::run(of),
        Command::Man(args) => help::run(&args),
    }
}

#[cfg(test)]
mod tests {
    use super::guarded;

    #[test]
    fn a_panic_is_an_internal_error() {
        let failure = guarded(|| panic!("a mistake")).unwrap_err();
        assert_eq!(failure.message(), "internal error: a mistake");
        assert_eq!(super::failure::exit_code_of("stiffbench::internal"), 70);
    }
}
