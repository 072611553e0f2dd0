//! Progress on standard error.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};

use super::args::{Global, ProgressMode};
use super::outcome::print_error;

/// A bar, lines, or nothing, as the user wants it.
#[must_use]
pub fn progress(global: &Global, what: &str, steps: u64) -> ProgressBar {
    match mode(global) {
        ProgressMode::Bar => {
            let bar = ProgressBar::new(steps);
            if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:40}] {pos}/{len} {eta}") {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_message(what.to_owned());
            bar
        }
        ProgressMode::Text => {
            let steps = if steps == 0 {
                String::new()
            } else {
                format!(": {steps} steps")
            };
            print_error(&format!("{what}{steps}"));
            ProgressBar::hidden()
        }
        ProgressMode::Auto | ProgressMode::None => ProgressBar::hidden(),
    }
}

/// One step of a long row; as text every hundredth is a line.
pub fn step_on(global: &Global, bar: &ProgressBar, what: &str) {
    bar.inc(1);
    let done = bar.position();
    if mode(global) == ProgressMode::Text && done.is_multiple_of(100) {
        print_error(&format!("{what}: {done} done"));
    }
}

fn mode(global: &Global) -> ProgressMode {
    let terminal = std::io::stderr().is_terminal();
    match global.progress {
        _ if global.quiet => ProgressMode::None,
        ProgressMode::Auto if terminal => ProgressMode::Bar,
        ProgressMode::Auto => ProgressMode::None,
        mode => mode,
    }
}
