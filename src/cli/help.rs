//! How every command presents itself: help with its examples before its options, `-o` for `--out`, and manual pages.

use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};
use clap::{Args, Command, CommandFactory};
use clap_mangen::roff::{Roff, roman};

use crate::analysis::{ArgumentError, is_dash};
use crate::nearest::nearest;
use crate::report::ManualPage;

use super::args::Cli;
use super::failure::EXIT_CODE_MEANINGS;
use super::figure_files::write_again;
use super::{CliError, Failure, Outcome};

/// Help with the examples before the options.
const TEMPLATE: &str = "{about-with-newline}\n{usage-heading} {usage}{after-help}\n\n{all-args}";

/// What the examples of a command begin with, in its help.
const EXAMPLES: &str = "Examples:";

/// Arguments of `man`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench man | man -l -                        the page of the program\n  stiffbench man session run > session-run.1       the page of one command\n  stiffbench man --out man                         a file for every command"
)]
pub(super) struct ManArgs {
    /// Words of the command [default: the page of the program]
    #[arg(value_name = "COMMAND")]
    words: Vec<String>,
    /// Write the pages of the command and of all below it into this folder, as stiffbench-COMMAND.1
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

/// The tree of commands with what holds for each.
pub(super) fn tree() -> Command {
    let root = dressed(Cli::command(), "stiffbench", "");
    let examples = after_help(&root);
    // The list of commands stands before the exit codes.
    root.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{examples}\n\n{{all-args}}{{after-help}}"
    ))
    .after_help(exit_codes())
}

/// A command and all below it, with examples and `-o`.
///
/// # Arguments
/// - `path`: its words, with that of the program.
/// - `of_group`: the help of its group, whose examples serve a command that has none of its own.
fn dressed(command: Command, path: &str, of_group: &str) -> Command {
    let own = after_help(&command);
    let borrowed = examples_of(of_group, path).filter(|_| !own.contains(EXAMPLES));
    let command = match borrowed {
        Some(examples) => command.after_help(examples),
        None => command,
    };
    command
        .help_template(TEMPLATE)
        .mut_args(|argument| {
            let argument = match argument.get_long() {
                Some("out") => argument.short('o'),
                _ => argument,
            };
            let names = argument.get_value_names().unwrap_or_default();
            if names
                .iter()
                .any(|name| ["FOLDER", "SESSION"].contains(&name.as_str()))
            {
                argument.value_parser(PathBufValueParser::new().try_map(folder))
            } else {
                argument
            }
        })
        .mut_subcommands(|below| {
            let path = format!("{path} {}", below.get_name());
            dressed(below, &path, &own)
        })
}

/// A path that is to be a folder.
fn folder(path: PathBuf) -> Result<PathBuf, &'static str> {
    if is_dash(&path) {
        return Err("- is standard input or output, which cannot be a folder; name a folder");
    }
    Ok(path)
}

/// The examples of a group that call one of its commands, each with the lines that it goes on in; `None` if there is none.
fn examples_of(of_group: &str, path: &str) -> Option<String> {
    let mut found = String::new();
    let mut goes_on = false;
    for line in of_group.lines() {
        if goes_on || format!("{line} ").contains(&format!("{path} ")) {
            found = found + "\n" + line;
            goes_on = line.ends_with('\\');
        }
    }
    (!found.is_empty()).then(|| format!("{EXAMPLES}{found}"))
}

fn after_help(command: &Command) -> String {
    command
        .get_after_help()
        .map_or_else(String::new, ToString::to_string)
}

/// The table of exit codes as one paragraph.
fn exit_codes() -> String {
    let rows = EXIT_CODE_MEANINGS.iter();
    let rows: Vec<String> = rows
        .map(|(code, means)| format!("{code} {means}"))
        .collect();
    format!("Exit codes: {}.", rows.join("; "))
}

/// Prints one manual page, or writes those of a command and of all below it.
pub(super) fn run(args: &ManArgs) -> Result<Outcome, Failure> {
    let command = find(&args.words)?;
    let roff = page(&command);
    let Some(folder) = &args.out else {
        let files = Vec::new();
        return Ok(Outcome::new(
            "man",
            roff.clone(),
            ManualPage { roff, files },
        ));
    };
    let mut files = Vec::new();
    write_pages(&command, folder, &mut files)?;
    let text = format!("{} manual pages in {}\n", files.len(), folder.display());
    Ok(Outcome::new("man", text, ManualPage { roff, files }))
}

/// The command of these words, with its full name.
fn find(words: &[String]) -> Result<Command, ArgumentError> {
    let mut command = dressed(Cli::command(), "stiffbench", "").disable_help_subcommand(true);
    command.build();
    for word in words {
        let shown = command
            .get_subcommands()
            .filter(|below| !below.is_hide_set());
        let names: Vec<&str> = shown.map(Command::get_name).collect();
        if !names.contains(&word.as_str()) {
            let help = match nearest(word, names.iter().copied()) {
                Some(near) => format!("did you mean {near}?"),
                None if names.is_empty() => "there is no command below it".to_owned(),
                None => format!("name one of {}", names.join(", ")),
            };
            let problem = format!("there is no command {word}");
            return Err(ArgumentError::new(words.join(" "), problem, &help));
        }
        let below = command.find_subcommand(word).cloned();
        command = below.unwrap_or(command);
    }
    Ok(command)
}

fn write_pages(command: &Command, folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), CliError> {
    let name = command.get_display_name().unwrap_or(command.get_name());
    let file = folder.join(format!("{name}.1"));
    write_again(&file, page(command).as_bytes())?;
    files.push(file);
    let below = command.get_subcommands();
    for below in below.filter(|below| !below.is_hide_set()) {
        write_pages(below, folder, files)?;
    }
    Ok(())
}

/// The manual page of a command, with its examples and the exit codes of the program.
fn page(command: &Command) -> String {
    let after = after_help(command);
    let bare = command.clone().after_help(None::<&'static str>);
    let mut page = Vec::new();
    // Writing into memory does not fail.
    let program = format!("stiffbench {}", env!("CARGO_PKG_VERSION"));
    let _ = clap_mangen::Man::new(bare)
        .source(program)
        .render(&mut page);
    let (examples, notes): (Vec<&str>, Vec<&str>) = after
        .split("\n\n")
        .filter(|paragraph| !paragraph.is_empty())
        .partition(|paragraph| paragraph.starts_with(EXAMPLES));
    let mut more = Roff::new();
    if !notes.is_empty() {
        more.control("SH", ["NOTES"]);
        more.text([roman(notes.join("\n\n"))]);
    }
    for paragraph in examples {
        more.control("SH", ["EXAMPLES"]).control("nf", []);
        for line in paragraph.lines().skip(1) {
            more.text([roman(line)]);
        }
        more.control("fi", []);
    }
    more.control("SH", ["EXIT STATUS"]);
    for (code, means) in EXIT_CODE_MEANINGS {
        more.control("TP", []);
        more.text([roman(code.to_string())]);
        more.text([roman(*means)]);
    }
    String::from_utf8_lossy(&page).into_owned() + &more.to_roff()
}
