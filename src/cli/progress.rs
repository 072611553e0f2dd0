//! How to show progress on standard error.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressStyle};

use super::args::{Global, ProgressMode};
use super::outcome::print_error;

/// Jobs of more steps than this have a line a tenth of them, not a line a step.
const MOST_LINES: u64 = 20;

/// How far a long job is: a bar, lines, or nothing, as the user wants it.
#[derive(Debug)]
pub struct JobProgress {
    bar: ProgressBar,
    lines: Option<Mutex<ProgressLines>>,
    what: String,
}

#[derive(Debug, Default)]
struct ProgressLines {
    done: u64,
    last: String,
}

/// Progress of a job that was just begun.
///
/// # Arguments
/// - `steps`: how many there will be; 0 if that is not known.
#[must_use]
pub fn progress(global: &Global, what: &str, steps: u64) -> JobProgress {
    let mode = mode(global, std::io::stderr().is_terminal());
    let bar = if mode == ProgressMode::Bar {
        let bar = ProgressBar::new(steps);
        if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:40}] {pos}/{len} {eta}") {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(what.to_owned());
        bar
    } else {
        let hidden = ProgressBar::hidden();
        hidden.set_length(steps);
        hidden
    };
    JobProgress {
        bar,
        lines: (mode == ProgressMode::Text).then(Mutex::default),
        what: what.to_owned(),
    }
}

impl JobProgress {
    /// Some steps more are done.
    pub fn inc(&self, steps: u64) {
        self.bar.inc(steps);
        self.with_lines(|lines| {
            let before = lines.done;
            lines.done += steps;
            let of = self.bar.length().unwrap_or_default();
            line_after(&self.what, [before, lines.done], of)
        });
    }

    /// So many steps of so many are done, and the job is at a place of this name; as text, each place has one line.
    pub fn set(&self, done: u64, of: u64, place: &str) {
        self.bar.set_length(of);
        self.bar.set_position(done);
        if place.is_empty() {
            return;
        }
        self.bar.set_message(format!("{} {place}", self.what));
        self.with_lines(|lines| {
            let is_new = lines.last != place;
            place.clone_into(&mut lines.last);
            is_new.then(|| format!("{}: {place}", self.what))
        });
    }

    /// The job has ended.
    pub fn finish_and_clear(&self) {
        self.bar.finish_and_clear();
    }

    /// Prints what the change of the lines gives, in its order, whichever threads work.
    fn with_lines(&self, change: impl FnOnce(&mut ProgressLines) -> Option<String>) {
        if let Some(lines) = &self.lines {
            let mut lines = lines.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(line) = change(&mut lines) {
                print_error(&line);
            }
        }
    }
}

/// The line to print after a step, if it deserves one.
fn line_after(what: &str, [before, done]: [u64; 2], of: u64) -> Option<String> {
    let each = match of {
        0 => 100,
        _ if of <= MOST_LINES => 1,
        _ => of.div_ceil(10),
    };
    let of_all = if of > 0 {
        format!(" of {of}")
    } else {
        String::new()
    };
    (done / each > before / each || (done == of && before < of))
        .then(|| format!("{what}: {done}{of_all} done"))
}

/// What `auto` stands for: a bar on a terminal, lines in a pipe, nothing beside JSON.
fn mode(global: &Global, on_terminal: bool) -> ProgressMode {
    match global.progress {
        _ if global.quiet => ProgressMode::None,
        ProgressMode::Auto if on_terminal => ProgressMode::Bar,
        ProgressMode::Auto if global.json => ProgressMode::None,
        ProgressMode::Auto => ProgressMode::Text,
        mode => mode,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_steps_have_a_line_each_and_many_a_line_a_tenth() {
        let lines = |of: u64, steps: u64| -> Vec<String> {
            (0..steps)
                .filter_map(|before| line_after("refits", [before, before + 1], of))
                .collect()
        };
        assert_eq!(
            lines(3, 3),
            [
                "refits: 1 of 3 done",
                "refits: 2 of 3 done",
                "refits: 3 of 3 done"
            ]
        );
        let many = lines(995, 995);
        assert_eq!(many.len(), 10);
        assert_eq!(many[0], "refits: 100 of 995 done");
        assert_eq!(many[9], "refits: 995 of 995 done");
        assert_eq!(lines(0, 250), ["refits: 100 done", "refits: 200 done"]);
    }

    #[test]
    fn auto_is_a_bar_on_a_terminal_lines_in_a_pipe_and_nothing_beside_json() {
        let mut global = crate::cli::only_json(false);
        assert_eq!(mode(&global, true), ProgressMode::Bar);
        assert_eq!(mode(&global, false), ProgressMode::Text);
        global.json = true;
        assert_eq!(mode(&global, false), ProgressMode::None);
        global.progress = ProgressMode::Text;
        assert_eq!(mode(&global, false), ProgressMode::Text);
        global.quiet = true;
        assert_eq!(mode(&global, true), ProgressMode::None);
    }
}
