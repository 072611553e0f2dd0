//! Progress on standard error.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};

use super::args::{Global, ProgressMode};
use super::outcome::print_error;

/// A bar, a line, or nothing, as the user wants it.
pub(super) fn progress(global: &Global, what: &str, steps: u64) -> ProgressBar {
    let terminal = std::io::stderr().is_terminal();
    let mode = match global.progress {
        _ if global.quiet => ProgressMode::None,
        ProgressMode::Auto if terminal => ProgressMode::Bar,
        ProgressMode::Auto => ProgressMode::None,
        mode => mode,
    };
    match mode {
        ProgressMode::Bar => {
            let bar = ProgressBar::new(steps);
            if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:40}] {pos}/{len} {eta}") {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_message(what.to_owned());
            bar
        }
        ProgressMode::Text => {
            print_error(&format!("{what}: {steps} steps"));
            ProgressBar::hidden()
        }
        ProgressMode::Auto | ProgressMode::None => ProgressBar::hidden(),
    }
}
