//! A session in plain lines: for pipes, logs, and terminals that can do no more.

use std::fmt::Write;
use std::io::{BufRead, IsTerminal, Write as _};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use crate::cli::outcome::print_error;
use crate::cli::screen::labels;
use crate::session::{
    Bell, GaugeView, Operator, OperatorEvent, Prompt, PromptKind, Purpose, SessionView, SkipScope,
    Task,
};

/// Session time between two lines of live values, s.
const BETWEEN_LINES_S: f64 = 5.0;

/// What the keys do.
const KEYS: &str = "enter or any other line: take the reading; r: repeat it; g N: go to cell N; s, S: skip reading, cell; n TEXT: note; p: pause; q: end";

/// An operator who reads lines on standard error and types them on standard input.
pub(super) struct LineOperator {
    typed: Receiver<String>,
    prompt: Option<Prompt>,
    task: Option<Task>,
    shown_s: f64,
    quiet: bool,
    /// Whether standard input has ended: nobody can be asked any more.
    ended: bool,
    events: Vec<OperatorEvent>,
}

impl LineOperator {
    /// Reads standard input from now on.
    ///
    /// # Arguments
    /// - `no_input`: nobody types, and standard input is left alone.
    pub(super) fn new(quiet: bool, no_input: bool) -> Self {
        let (sender, typed) = channel();
        let read = move || {
            for line in std::io::stdin().lock().lines() {
                let Ok(line) = line else {
                    return;
                };
                if sender.send(line).is_err() {
                    return;
                }
            }
        };
        if !no_input {
            thread::spawn(read);
        }
        Self {
            typed,
            prompt: None,
            task: None,
            shown_s: f64::NEG_INFINITY,
            quiet,
            ended: false,
            events: Vec::new(),
        }
    }

    fn line(&mut self, line: &str) -> Option<OperatorEvent> {
        if let Some(prompt) = &self.prompt {
            if let Some(text) = note_at(prompt, line) {
                return Some(OperatorEvent::Note { text: Some(text) });
            }
            match prompt.read_line(line) {
                Ok(answer) => {
                    let id = prompt.id.clone();
                    self.prompt = None;
                    return Some(OperatorEvent::Answer { id, answer });
                }
                Err(complaint) => {
                    print_error(&complaint);
                    return None;
                }
            }
        }
        command(line)
    }
}

/// The note that a line is though a question is open; a question for a text takes every line as its answer.
fn note_at(prompt: &Prompt, line: &str) -> Option<String> {
    let text = line.trim().strip_prefix("n ")?.trim();
    let is_text = matches!(prompt.kind, PromptKind::Text);
    (!is_text && !text.is_empty()).then(|| text.to_owned())
}

/// What a line means where nothing is asked.
fn command(line: &str) -> Option<OperatorEvent> {
    let (word, rest) = line.trim().split_once(' ').unwrap_or((line.trim(), ""));
    let text = (!rest.is_empty()).then(|| rest.to_owned());
    Some(match word {
        "r" => OperatorEvent::Redo,
        "g" => {
            let number = rest.parse::<usize>().ok();
            let Some(cell) = number.and_then(|n| n.checked_sub(1)) else {
                print_error("g needs the number of a cell, for example g 3");
                return None;
            };
            OperatorEvent::Goto { cell }
        }
        "s" => OperatorEvent::Skip {
            what: SkipScope::Reading,
            reason: text,
        },
        "S" => OperatorEvent::Skip {
            what: SkipScope::Cell,
            reason: text,
        },
        "n" => OperatorEvent::Note { text },
        "p" => OperatorEvent::Pause,
        "q" => OperatorEvent::Interrupt,
        "?" => {
            print_error(KEYS);
            return None;
        }
        _ => OperatorEvent::Capture,
    })
}

impl Operator for LineOperator {
    fn show(&mut self, view: &SessionView) {
        if view.prompt.is_none() {
            self.prompt = None;
        }
        let another = self.task.as_ref() != Some(&view.task);
        let holding = matches!(view.task, Task::Hold { .. });
        let first = another && !(holding && matches!(self.task, Some(Task::Hold { .. })));
        let due = view.now_s - self.shown_s >= BETWEEN_LINES_S;
        self.task = Some(view.task.clone());
        if self.quiet || self.prompt.is_some() || !(first || due) {
            return;
        }
        self.shown_s = view.now_s;
        if let Some(text) = task_line(view).filter(|_| first) {
            print_error(&text);
        }
        print_error(&live_line(view));
    }

    fn prompt(&mut self, prompt: &Prompt) {
        print_error(&format!("? {}{}", prompt.text, choices(prompt)));
        for detail in &prompt.details {
            print_error(&format!("  {detail}"));
        }
        if self.ended {
            print_error("standard input has ended: no answer is possible");
            self.events.push(OperatorEvent::NoInput);
        }
        self.prompt = Some(prompt.clone());
    }

    fn poll(&mut self, wait: Duration) -> Option<OperatorEvent> {
        if let Some(event) = self.events.pop() {
            return Some(event);
        }
        match self.typed.recv_timeout(wait) {
            Ok(line) => self.line(&line),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => {
                let first = !std::mem::replace(&mut self.ended, true);
                (first && self.prompt.is_some()).then_some(OperatorEvent::NoInput)
            }
        }
    }

    fn bell(&mut self, bell: Bell) {
        let mut errors = std::io::stderr();
        if errors.is_terminal() {
            // Without a terminal there is nothing that rings.
            let _ = errors.write_all(bell.rings());
        }
        if bell == Bell::Attention && !self.quiet {
            print_error("!");
        }
    }

    fn notify(&mut self, line: &str) {
        if !self.quiet {
            print_error(line);
        }
    }
}

/// The answers that a prompt takes.
fn choices(prompt: &Prompt) -> String {
    match &prompt.kind {
        PromptKind::Text => String::new(),
        PromptKind::Number { unit, .. } => format!(" [{unit}]"),
        PromptKind::Confirm => " [yes/no]".to_owned(),
        PromptKind::Choice(choices) => {
            let lines = choices.iter();
            let lines = lines.map(|choice| format!("\n  {}: {}", choice.word, choice.text));
            lines.collect()
        }
        PromptKind::Checklist(items) => {
            let items = items.join("\n  [ ] ");
            format!("\n  [ ] {items}\n  [yes when all of it is true]")
        }
    }
}

/// What the operator is to do; `None` where there is nothing to say.
fn task_line(view: &SessionView) -> Option<String> {
    let place = view.place.as_ref().map_or_else(String::new, |place| {
        format!(
            "{} {} step {}/{} repeat {}/{}",
            place.pose,
            place.direction,
            place.step + 1,
            place.steps,
            place.repeat,
            place.repeats
        )
    });
    match &view.task {
        Task::Load { target_n, purpose } => {
            let what = match purpose {
                Purpose::Free => "take the gauge off, so that it hangs free".to_owned(),
                Purpose::Preload => format!("preload to {target_n} N"),
                Purpose::Release => format!("release to {target_n} N"),
                Purpose::Again => format!("to {target_n} N, not recorded"),
                Purpose::Reading => format!("to {target_n} N"),
                Purpose::ZeroCheck => format!("back to {target_n} N to check the zero"),
            };
            let at = if place.is_empty() { "" } else { ": " };
            Some(format!("> {place}{at}{what}"))
        }
        Task::Hold { target_n, left_s } => Some(format!("> hold {target_n} N for {left_s:.0} s")),
        Task::PushByHand { direction, .. } => Some(format!("> sign check along {direction}")),
        Task::Paused => Some("> paused: p continues".to_owned()),
        Task::CheckInstruments => Some("> waiting for the gauges".to_owned()),
        Task::Answer | Task::SetUp { .. } | Task::Wait | Task::Done => None,
    }
}

/// Both values with their range, age and rate, how far they have settled, and what holds the session up.
fn live_line(view: &SessionView) -> String {
    let value = |gauge: &GaugeView, factor: f64, unit: &str| match gauge.value_si {
        Some(value) => {
            let extremes = labels::extremes(gauge, 1.0 / factor);
            let age = labels::age(gauge.age_s);
            let rate = gauge
                .rate_hz
                .map_or(String::new(), |hz| format!(", {hz:.0}/s"));
            format!("{:.2} {unit} ({extremes}, {age}{rate})", value * factor)
        }
        None if gauge.stale => format!("- {unit} (STALE, {})", labels::age(gauge.age_s)),
        None => format!("- {unit}"),
    };
    let displacements = view.displacements.iter().map(|gauge| {
        let axis = gauge.channel.axis();
        let axis = axis.map_or_else(String::new, |axis| format!("{axis} "));
        format!("  {axis}{}", value(gauge, 1e6, "um"))
    });
    let displacements: String = displacements.collect();
    let mut text = format!("  {}{displacements}", value(&view.force, 1.0, "N"));
    // Writing to a String cannot fail.
    if let Some(settle) = &view.settle {
        let dwell_s = settle.dwell_s.min(settle.dwell_needed_s);
        let _ = write!(
            text,
            "  settled {dwell_s:.1} of {:.1} s",
            settle.dwell_needed_s
        );
    }
    let progress = &view.progress;
    let done = progress.accepted + progress.skipped;
    let minutes = progress.left_s / 60.0;
    let _ = write!(text, "  {done}/{}, {minutes:.0} min left", progress.planned);
    for line in &view.held_up {
        let _ = write!(text, "\n  waiting: {line}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_commands_and_anything_else_is_the_pedal() {
        assert_eq!(command(""), Some(OperatorEvent::Capture));
        assert_eq!(command("x"), Some(OperatorEvent::Capture));
        assert_eq!(command("g 3"), Some(OperatorEvent::Goto { cell: 2 }));
        assert_eq!(command("g 0"), None);
        let reason = Some("a cable in the way".to_owned());
        let what = SkipScope::Reading;
        assert_eq!(
            command("s a cable in the way"),
            Some(OperatorEvent::Skip { what, reason })
        );
        assert_eq!(command("n"), Some(OperatorEvent::Note { text: None }));
    }

    #[test]
    fn a_note_can_be_written_while_a_question_is_open() {
        let setup = Prompt::confirm("setup", "Done?");
        assert_eq!(
            note_at(&setup, "n bolt loose"),
            Some("bolt loose".to_owned())
        );
        assert_eq!(note_at(&setup, "n"), None);
        assert_eq!(note_at(&setup, "no"), None);
        let text = Prompt::new("skip-reason", "Why?", PromptKind::Text);
        assert_eq!(note_at(&text, "n bolt loose"), None);
    }
}
