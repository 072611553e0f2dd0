//! The log of a session: what a helper needs to know when something went wrong. The journal stays the primary record.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::time::Duration;

use jiff::Timestamp;
use serde_json::json;

use crate::cli::args::Global;
use crate::cli::outcome::print_error;
use crate::report::VERSION;
use crate::session::{Event, Operator, OperatorEvent, Prompt, Record, SkipScope, append_inside};

use super::inspect::event_text;

/// Name of the file in the session folder.
const FILE: &str = "session.log";

/// How much a line matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LogLevel {
    /// Every reading; only with `-vv`.
    Debug,
    /// What goes as it should.
    Info,
    /// What an operator should know.
    Warn,
    /// What ended the session.
    Error,
}

impl LogLevel {
    fn word(self) -> &'static str {
        match self {
            Self::Debug => "DEBUG",
            Self::Info => "INFO",
            Self::Warn => "WARN",
            Self::Error => "ERROR",
        }
    }
}

/// The end of the log, where lines are added.
pub(super) struct DiagnosticLog {
    file: Option<File>,
    /// How often `--verbose` is given.
    verbose: u8,
}

impl DiagnosticLog {
    /// Opens the log of a session folder. One that cannot be written stops no session: a note states it.
    pub(super) fn open(folder: &Path, global: &Global) -> Self {
        let file = append_inside(folder, FILE).map_err(|error| {
            print_error(&format!(
                "note: {} cannot be written: {error}",
                folder.join(FILE).display()
            ));
        });
        let mut log = Self {
            file: file.ok(),
            verbose: global.verbose,
        };
        let words: Vec<String> = std::env::args().skip(1).collect();
        let (system, processor) = (std::env::consts::OS, std::env::consts::ARCH);
        log.line(
            LogLevel::Info,
            &format!(
                "stiffbench {VERSION}, {system} {processor}, process {}",
                std::process::id()
            ),
        );
        log.line(LogLevel::Info, &format!("options: {}", words.join(" ")));
        log
    }

    /// Adds a line, a JSON object with time (UTC), level and message; with `--verbose` on standard error too, as text. It is written before
    /// this returns, so that no line is lost.
    pub(super) fn line(&mut self, level: LogLevel, message: &str) {
        if level == LogLevel::Debug && self.verbose < 2 {
            return;
        }
        let utc = Timestamp::now().strftime("%Y-%m-%dT%H:%M:%S.%3fZ");
        // A message is one line, whatever is in it.
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        let level = level.word();
        let line = json!({ "utc": utc.to_string(), "level": level, "message": message });
        if let Some(file) = &mut self.file
            && writeln!(file, "{line}").is_err()
        {
            self.file = None;
        }
        if self.verbose > 0 {
            print_error(&format!("{utc} {level:<5} {message}"));
        }
    }
}

/// An operator whose questions, answers and notes are logged, with the events of the journal.
pub(super) struct LoggedOperator<'a> {
    inner: &'a mut dyn Operator,
    log: &'a mut DiagnosticLog,
}

impl<'a> LoggedOperator<'a> {
    /// Logs what passes between a session and its operator.
    pub(super) fn new(inner: &'a mut dyn Operator, log: &'a mut DiagnosticLog) -> Self {
        Self { inner, log }
    }
}

impl Operator for LoggedOperator<'_> {
    fn behind(&mut self) -> Option<&mut dyn Operator> {
        Some(&mut *self.inner)
    }

    fn prompt(&mut self, prompt: &Prompt) {
        let line = format!("question {}: {}", prompt.name(), prompt.text);
        self.log.line(LogLevel::Info, &line);
        self.inner.prompt(prompt);
    }

    fn poll(&mut self, wait: Duration) -> Option<OperatorEvent> {
        let event = self.inner.poll(wait)?;
        self.log.line(LogLevel::Info, &operator_text(&event));
        Some(event)
    }

    fn notify(&mut self, line: &str) {
        let is_reading = line.starts_with("reading ");
        let level = if is_reading {
            LogLevel::Debug
        } else {
            LogLevel::Info
        };
        self.log.line(level, line);
        self.inner.notify(line);
    }

    fn recorded(&mut self, record: &Record) {
        let line = format!("event {}: {}", record.seq, event_text(&record.event));
        self.log.line(level(&record.event), &line);
        self.inner.recorded(record);
    }
}

fn level(event: &Event) -> LogLevel {
    match event {
        Event::Reading(_) => LogLevel::Debug,
        Event::Superseded(_)
        | Event::Flagged(_)
        | Event::Skipped(_)
        | Event::Undone(_)
        | Event::Link(_)
        | Event::Gap(_)
        | Event::ClockJump(_)
        | Event::CalibrationWarning(_) => LogLevel::Warn,
        _ => LogLevel::Info,
    }
}

/// What an operator did, in words.
fn operator_text(event: &OperatorEvent) -> String {
    let done = match event {
        OperatorEvent::Capture => "take the reading".to_owned(),
        OperatorEvent::Redo => "take the last reading again".to_owned(),
        OperatorEvent::Goto { cell } => format!("go to cell {}", cell + 1),
        OperatorEvent::Skip { what, .. } => match what {
            SkipScope::Reading => "leave the reading out".to_owned(),
            SkipScope::Cell => "leave the rest of the cell out".to_owned(),
        },
        OperatorEvent::Note { .. } => "write a note".to_owned(),
        OperatorEvent::Pause => "pause, or continue".to_owned(),
        OperatorEvent::Answer { id, answer } => return format!("answer {id}: {answer}"),
        OperatorEvent::NoInput => "the input has ended".to_owned(),
        OperatorEvent::Interrupt => "end at the next safe point".to_owned(),
        OperatorEvent::Abort => "end at once".to_owned(),
    };
    format!("operator: {done}")
}
