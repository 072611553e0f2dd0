//! Colour: which stream has it, and telling everything that writes colours.

use std::ffi::OsString;
use std::io::IsTerminal;

use clap::{ColorChoice, ValueEnum};

/// The option that decides.
const OPTION: &str = "--color";

/// What the command line says of colour, before it is parsed: what is wrong with it is printed in colour too.
#[must_use]
pub fn choice(arguments: &[OsString]) -> ColorChoice {
    let words = arguments.iter().filter_map(|word| word.to_str());
    let words: Vec<&str> = words.take_while(|word| *word != "--").collect();
    let mut values = words.iter().enumerate().filter_map(|(place, word)| {
        let rest = word.strip_prefix(OPTION)?;
        match rest.strip_prefix('=') {
            None if rest.is_empty() => words.get(place + 1).copied(),
            value => value,
        }
    });
    let last = values.next_back();
    last.and_then(|value| ColorChoice::from_str(value, false).ok())
        .unwrap_or_default()
}

/// The choice for clap, which prints on both streams and knows the variables only roughly.
#[must_use]
pub fn for_clap(choice: ColorChoice) -> ColorChoice {
    let output = is_wanted(choice, std::io::stdout().is_terminal());
    let errors = is_wanted(choice, std::io::stderr().is_terminal());
    match (output, errors) {
        (true, true) => ColorChoice::Always,
        (false, false) => ColorChoice::Never,
        _ => ColorChoice::Auto,
    }
}

/// Tells errors and the full-screen view; clap is told with its tree.
pub fn apply(choice: ColorChoice) {
    let on_errors = is_wanted(choice, std::io::stderr().is_terminal());
    // Fails only where it has been set, which is here.
    let _ = miette::set_hook(Box::new(move |_| {
        let options = miette::MietteHandlerOpts::new();
        // The terminal breaks long lines itself; a command in an advice can then be copied.
        Box::new(options.color(on_errors).wrap_lines(false).build())
    }));
    let on_view = is_wanted(choice, std::io::stdout().is_terminal());
    crossterm::style::force_color_output(on_view);
}

/// Whether a stream has colour: the option goes first, then `NO_COLOR`, then `CLICOLOR_FORCE`, then `CLICOLOR` and the terminal.
pub(super) fn is_wanted(choice: ColorChoice, is_terminal: bool) -> bool {
    let variable = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
    let is_on = |name| variable(name).map(|value| value != "0");
    match choice {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto if variable("NO_COLOR").is_some() => false,
        ColorChoice::Auto if is_on("CLICOLOR_FORCE") == Some(true) => true,
        ColorChoice::Auto => {
            let is_dumb = variable("TERM").is_some_and(|term| term == "dumb");
            is_terminal && !is_dumb && is_on("CLICOLOR") != Some(false)
        }
    }
}
