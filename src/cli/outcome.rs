//! What a subcommand hands back, and how it is printed.

use std::borrow::Cow;
use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use serde::Serialize;
use serde_json::{Value, json};

use super::args::Global;
#[cfg(unix)]
use super::failure::CliError;
use super::failure::{OVERDUE, exit_code_of};
use super::locale::in_locale;
use crate::analysis::Inputs;
use crate::report::{CompletionScript, ErrorReport};

/// What a user should know beside a result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum OutcomeNote {
    /// What has to be done before the numbers are used.
    Act(String),
    /// What the numbers rest on, or what puts them in doubt.
    Remark(String),
    /// A file that was written.
    Written(PathBuf),
}

impl std::fmt::Display for OutcomeNote {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Act(words) | Self::Remark(words) => f.write_str(words),
            Self::Written(path) => write!(f, "wrote {}", path.display()),
        }
    }
}

/// A result: text for people, data for programs, and notes for both.
#[derive(Debug, Default)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each states one thing about the printing"
)]
pub struct Outcome {
    /// Word for the kind of result, also the name of its schema.
    pub(super) kind: &'static str,
    /// For people; ends with a line break.
    pub(super) text: String,
    /// For programs.
    pub(super) data: Value,
    /// What the result was made of.
    pub(super) inputs: Inputs,
    /// What a user should know before using the numbers.
    notes: Vec<OutcomeNote>,
    /// Exit code under `--strict`; 0 otherwise.
    pub(super) strict_exit: u8,
    /// Exit code in any case: what was printed is whole, and states that something is not.
    pub(super) exit: u8,
    /// Whether what was examined failed: `ok` of JSON is false then.
    failed: bool,
    /// Whether the text stands alone, without the inputs before it.
    bare: bool,
    /// Whether JSON on standard output takes the place of a file that `--out -` asks for.
    displaces_file: bool,
    /// Whether all this has been printed already.
    printed: bool,
}

impl Outcome {
    /// A result without notes.
    #[must_use]
    pub fn new(kind: &'static str, text: impl Into<String>, data: impl Serialize) -> Self {
        Self {
            kind,
            text: text.into(),
            data: serde_json::to_value(data).unwrap_or_default(),
            ..Self::default()
        }
    }

    /// With what it was made of.
    #[must_use]
    pub fn with_inputs(mut self, inputs: Inputs) -> Self {
        self.inputs = inputs;
        self
    }

    /// The text alone, without its inputs before it: it is a file.
    #[must_use]
    pub fn without_heading(mut self) -> Self {
        self.bare = true;
        self
    }

    /// With a file in place of the text, where `--out -` wants it on standard output.
    #[must_use]
    pub(super) fn with_file(self, file: Option<String>) -> Self {
        match file {
            Some(text) => Self {
                text,
                displaces_file: true,
                ..self
            }
            .without_heading(),
            None => self,
        }
    }

    /// With remarks behind the notes that it has.
    #[must_use]
    pub fn with_warnings(mut self, warnings: impl IntoIterator<Item = String>) -> Self {
        let remarks = warnings.into_iter().map(OutcomeNote::Remark);
        self.notes.extend(remarks);
        self
    }

    /// With a note for each file that was written.
    #[must_use]
    pub fn with_written<'p>(mut self, files: impl IntoIterator<Item = &'p PathBuf>) -> Self {
        let files = files.into_iter().cloned();
        self.notes.extend(files.map(OutcomeNote::Written));
        self
    }

    /// With an exit code under `--strict`.
    #[must_use]
    pub fn with_strict_exit(mut self, exit: u8) -> Self {
        self.strict_exit = exit;
        self
    }

    /// With a warning for each overdue calibration, which `--strict` does not pass.
    #[must_use]
    pub fn with_overdue(mut self, overdue: Vec<String>) -> Self {
        if !overdue.is_empty() {
            self.strict_exit = OVERDUE;
        }
        self.notes.extend(overdue.into_iter().map(OutcomeNote::Act));
        self
    }

    /// Prints the result now, of a command that goes on; at its end nothing more is printed.
    #[cfg(unix)]
    pub(super) fn print_before_the_end(mut self, global: &Global) -> Result<Self, CliError> {
        self.write(global).map_err(|source| CliError::Write {
            path: "standard output".into(),
            source,
        })?;
        self.printed = true;
        Ok(self)
    }

    /// What is for programs, alone.
    pub(super) fn into_data(self) -> Value {
        self.data
    }

    /// With an exit code in any case.
    #[must_use]
    pub fn with_exit(mut self, exit: u8) -> Self {
        self.exit = exit;
        self
    }

    /// With `ok` false in JSON if what was examined failed.
    #[must_use]
    pub fn with_failed(mut self, failed: bool) -> Self {
        self.failed = failed;
        self
    }

    /// Prints the result: JSON or text on standard output, notes on standard error.
    #[must_use]
    pub fn print(mut self, global: &Global) -> ExitCode {
        let printed = if self.printed {
            Ok(())
        } else {
            self.write(global)
        };
        match printed {
            Ok(()) if self.exit != 0 => ExitCode::from(self.exit),
            Ok(()) => ExitCode::from(if global.strict { self.strict_exit } else { 0 }),
            Err(error) => not_printed(&error),
        }
    }

    /// The one object of `--json`.
    pub(super) fn json(&self) -> Value {
        let mut object = envelope(self.kind, !self.failed);
        object["inputs"] = json!(self.inputs);
        object["data"] = self.data.clone();
        let notes = self.notes.iter().map(ToString::to_string);
        object["warnings"] = json!(notes.collect::<Vec<_>>());
        object
    }

    /// What it is in files: text for people, and what `--json` prints.
    pub(super) fn texts(&self) -> [String; 2] {
        let text = format!("{}{}", self.inputs.text(), self.text);
        [text, format!("{:#}\n", self.json())]
    }

    fn write(&mut self, global: &Global) -> std::io::Result<()> {
        if global.json {
            if self.displaces_file {
                let note = "--out - with --json: this object alone is on standard output, the file was not written";
                self.notes.push(OutcomeNote::Remark(note.to_owned()));
            }
            return print_json(&self.json());
        }
        let heading = if self.bare {
            String::new()
        } else {
            self.inputs.text()
        };
        let text = format!("{heading}{}", self.text);
        print(&if self.bare {
            text.into()
        } else {
            printable(&text)
        })?;
        if !global.quiet {
            self.print_notes();
        }
        Ok(())
    }

    /// Notes on standard error: first what has to be done; all files in one line at the end.
    fn print_notes(&self) {
        let is_act = |note: &&OutcomeNote| matches!(note, OutcomeNote::Act(_));
        let is_remark = |note: &&OutcomeNote| matches!(note, OutcomeNote::Remark(_));
        let notes = || self.notes.iter();
        for note in notes().filter(is_act).chain(notes().filter(is_remark)) {
            print_error(&format!("note: {note}"));
        }
        let files = notes().filter_map(|note| match note {
            OutcomeNote::Written(path) => Some(path.display().to_string()),
            _ => None,
        });
        let files = files.collect::<Vec<_>>().join(", ");
        if !files.is_empty() {
            print_error(&format!("note: wrote {files}"));
        }
    }
}

/// The envelope of all JSON output.
#[must_use]
pub fn envelope(kind: &str, ok: bool) -> Value {
    json!({
        "schema": format!("stiffbench/{kind}/{}", schema_version(kind)),
        "tool": { "name": env!("CARGO_PKG_NAME"), "version": env!("CARGO_PKG_VERSION") },
        "kind": kind,
        "ok": ok,
    })
}

/// The object of `--json` for a failure.
pub(super) fn error_object(error: &ErrorReport, warnings: &[String]) -> Value {
    let mut object = envelope("error", false);
    object["error"] = json!(error);
    object["warnings"] = json!(warnings);
    object
}

/// The version of a kind's schema. In the second, `u` is the standard and `U` the expanded uncertainty; in the first `u` was the
/// expanded one. The second of a diagnosis has grades and shares.
fn schema_version(kind: &str) -> u32 {
    match kind {
        "compare" | "demo" | "diagnosis" | "map" | "stiffness" => 2,
        _ => 1,
    }
}

/// One JSON object and a line break.
pub(super) fn print_json(object: &Value) -> std::io::Result<()> {
    print(&format!("{object:#}\n"))
}

/// Text on standard output; a reader that went away (`| head`) is no failure of ours.
pub(super) fn print(text: &str) -> std::io::Result<()> {
    let mut output = std::io::stdout().lock();
    match output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush())
    {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

/// Text on standard output of a command that goes on; if nobody can read it, there is nobody left to tell.
#[cfg(unix)]
pub(super) fn print_now(text: &str) {
    let _ = print(text);
}

/// A line on standard error; if nobody can read that either, there is nobody left to tell.
pub(super) fn print_error(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", printable(line));
}

/// A text as a terminal shows it: in the characters of the locale, and without those that steer a terminal, which names in files of others
/// may hold. Colours stay.
fn printable(text: &str) -> Cow<'_, str> {
    in_locale(without_steering(text))
}

fn without_steering(text: &str) -> Cow<'_, str> {
    let steers = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    if !text.contains(steers) {
        return text.into();
    }
    let mut clean = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(steers) {
        clean.push_str(&rest[..at]);
        let colour = rest[at..]
            .strip_prefix("\u{1b}[")
            .and_then(|code| code.find(|c: char| !c.is_ascii_digit() && c != ';'))
            .map(|end| at + 2 + end)
            .filter(|end| rest[*end..].starts_with('m'));
        let end = if let Some(end) = colour {
            clean.push_str(&rest[at..=end]);
            end + 1
        } else {
            clean.push(char::REPLACEMENT_CHARACTER);
            at + rest[at..].chars().next().map_or(1, char::len_utf8)
        };
        rest = &rest[end..];
    }
    clean.push_str(rest);
    clean.into()
}

/// A word of a command, in quotes where a shell would take it apart.
pub(super) fn shell_word(word: &str) -> String {
    let is_special =
        |c: char| c.is_whitespace() || c.is_control() || "\"'`$\\!#~<>?[]{}();&|*".contains(c);
    if word.is_empty() || word.contains(is_special) {
        format!("'{}'", word.replace('\'', "'\\''"))
    } else {
        word.to_owned()
    }
}

/// A result that did not reach standard output, for example on a full disk.
pub(super) fn not_printed(error: &std::io::Error) -> ExitCode {
    print_error(&format!(
        "the result could not be written to standard output: {error}"
    ));
    ExitCode::from(exit_code_of("stiffbench::output"))
}

/// What clap says, and its exit code; with `--json` among the arguments also that is JSON.
#[must_use]
pub fn print_usage(error: &clap::Error, arguments: &[OsString], program: &str) -> ExitCode {
    let failed = error.use_stderr();
    if failed && arguments.iter().any(|argument| argument == "--json") {
        if let Err(error) = print_json(&usage_json(error, program)) {
            return not_printed(&error);
        }
    } else {
        let _ = error.print();
    }
    ExitCode::from(if failed { 2 } else { 0 })
}

/// The object of `--json` for what clap says.
pub(super) fn usage_json(error: &clap::Error, program: &str) -> Value {
    let everything = || {
        format!("{program} --help lists the subcommands, {program} SUBCOMMAND --help its options")
    };
    let error = ErrorReport {
        code: "stiffbench::usage".to_owned(),
        message: usage_message(error),
        help: Some(usage_tip(error).unwrap_or_else(everything)),
        exit_code: 2,
    };
    error_object(&error, &[])
}

/// The first paragraph of what clap says, in one line; what follows it there is the usage.
fn usage_message(error: &clap::Error) -> String {
    let text = error.to_string();
    let paragraph = text.split("\n\n").next().unwrap_or(&text);
    let words: Vec<&str> = paragraph.split_whitespace().collect();
    let line = words.join(" ");
    line.strip_prefix("error: ").unwrap_or(&line).to_owned()
}

/// What clap thinks was meant.
fn usage_tip(error: &clap::Error) -> Option<String> {
    let text = error.to_string();
    let tips = text
        .lines()
        .filter_map(|line| line.trim().strip_prefix("tip: "));
    let tips: Vec<&str> = tips.collect();
    (!tips.is_empty()).then(|| tips.join("; "))
}

/// Completions of a shell.
pub(super) fn completions(shell: clap_complete::Shell) -> Outcome {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut super::command(), "stiffbench", &mut text);
    let text = String::from_utf8_lossy(&text).into_owned();
    let script = text.clone();
    Outcome::new("completions", text, CompletionScript { script })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_colours_reach_the_terminal() {
        assert_eq!(printable("a\tb\nc µ"), "a\tb\nc µ");
        assert_eq!(
            printable("\u{1b}[31;1mred\u{1b}[0m"),
            "\u{1b}[31;1mred\u{1b}[0m"
        );
        assert_eq!(
            printable("a\u{1b}]0;title\u{7}b"),
            "a\u{fffd}]0;title\u{fffd}b"
        );
        assert_eq!(printable("\u{1b}[2Jx\u{9b}1m"), "\u{fffd}[2Jx\u{fffd}1m");
        assert_eq!(printable("\u{1b}["), "\u{fffd}[");
    }

    #[test]
    fn words_with_blanks_are_quoted() {
        assert_eq!(shell_word("a/b-1.csv"), "a/b-1.csv");
        assert_eq!(shell_word("all three"), "'all three'");
        assert_eq!(shell_word("it's"), "'it'\\''s'");
        assert_eq!(shell_word(""), "''");
    }
}
