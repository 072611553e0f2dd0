//! The operator: what a screen shows, what is asked, what comes back.
//!
//! A session never prints and never reads a key: it hands a [`SessionView`] to an [`Operator`], asks [`Prompt`]s of it, and takes
//! [`OperatorEvent`]s from it. Full-screen view, line mode, answers file, emulated and scripted operators are implementations.

use std::fmt;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::journal::Record;
use super::view::SessionView;

/// The operator at the bench. No method waits longer than its timeout.
pub trait Operator {
    /// The operator behind this one, who gets what this one does not take.
    fn behind(&mut self) -> Option<&mut dyn Operator> {
        None
    }

    /// Shows where the session stands; called several times a second, so an implementation draws what has changed.
    fn show(&mut self, view: &SessionView) {
        if let Some(behind) = self.behind() {
            behind.show(view);
        }
    }

    /// Asks something. Returns at once; the answer comes as [`OperatorEvent::Answer`]. There is one open prompt at most, and
    /// [`SessionView::prompt`] repeats it until it is answered.
    fn prompt(&mut self, prompt: &Prompt) {
        if let Some(behind) = self.behind() {
            behind.prompt(prompt);
        }
    }

    /// What the operator did, waiting no longer than `wait` of real time.
    fn poll(&mut self, wait: Duration) -> Option<OperatorEvent> {
        self.behind()?.poll(wait)
    }

    /// A sound, or what stands for it.
    fn bell(&mut self, bell: Bell) {
        if let Some(behind) = self.behind() {
            behind.bell(bell);
        }
    }

    /// A line for the log on the screen.
    fn notify(&mut self, line: &str) {
        if let Some(behind) = self.behind() {
            behind.notify(line);
        }
    }

    /// An event that the journal has kept, for those who write it down elsewhere too.
    fn recorded(&mut self, record: &Record) {
        if let Some(behind) = self.behind() {
            behind.recorded(record);
        }
    }
}

/// A sound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bell {
    /// A reading is safely stored.
    Captured,
    /// The operator is needed: a question, a new pose, a gauge that fell silent.
    Attention,
    /// The session is over.
    Done,
}

impl Bell {
    /// What makes a terminal ring: once for a reading, twice for the rest.
    #[must_use]
    pub fn rings(self) -> &'static [u8] {
        match self {
            Self::Captured => b"\x07",
            Self::Attention | Self::Done => b"\x07\x07",
        }
    }
}

/// What an operator did.
#[derive(Debug, Clone, PartialEq)]
pub enum OperatorEvent {
    /// Take the reading now. Any key without another meaning, and so every foot pedal, which types a key.
    Capture,
    /// Take the last reading once more; the old one stays, superseded.
    Redo,
    /// Go on with another cell.
    Goto {
        /// Place of the cell in the plan, from 0.
        cell: usize,
    },
    /// Leave something out; without a reason one is asked for.
    Skip {
        /// What.
        what: SkipScope,
        /// Why.
        reason: Option<String>,
    },
    /// A note on where the session stands; without a text it is asked for.
    Note {
        /// What to keep.
        text: Option<String>,
    },
    /// Stop for a while, or go on.
    Pause,
    /// The answer to a prompt.
    Answer {
        /// [`Prompt::id`].
        id: String,
        /// The answer.
        answer: Answer,
    },
    /// Nobody can answer any more: a question that is open ends the session as partial.
    NoInput,
    /// First Ctrl-C: finish what is being taken, store it, end as partial.
    Interrupt,
    /// Second Ctrl-C: stop now.
    Abort,
}

/// What is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SkipScope {
    /// The reading that is being taken.
    Reading,
    /// What is still open in the cell.
    Cell,
}

/// A question.
#[derive(Debug, Clone, PartialEq)]
pub struct Prompt {
    /// What it is called in an answers file and in `--answer ID=VALUE`, for example `setup`.
    pub id: String,
    /// What it is about, for answers to one of several alike: with the key `P1.x` the answer under `setup.P1.x` goes before `setup`.
    pub key: Option<String>,
    /// The question, one sentence.
    pub text: String,
    /// Further lines: why it is asked, what happens then.
    pub details: Vec<String>,
    /// What kind of answer is wanted.
    pub kind: PromptKind,
    /// The answer of an operator who just confirms, and of `--no-input` without an answer; `None` if the question cannot be passed over.
    pub default: Option<Answer>,
}

/// What kind of answer is wanted.
#[derive(Debug, Clone, PartialEq)]
pub enum PromptKind {
    /// A line of text.
    Text,
    /// A number.
    Number {
        /// Its unit.
        unit: &'static str,
        /// Smallest and largest that are taken.
        range: [f64; 2],
    },
    /// One of several.
    Choice(Vec<Choice>),
    /// Yes or no.
    Confirm,
    /// Every item is to be ticked.
    Checklist(Vec<String>),
}

/// One of several answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Choice {
    /// The word for it in an answers file.
    pub word: &'static str,
    /// What it means.
    pub text: String,
    /// Its key on a screen: the first letter of the word that no choice before it has.
    pub key: char,
    /// Whether it can be taken back or does no harm; the others need Enter behind their key, or its capital.
    pub harmless: bool,
}

/// Choices that can be taken back, or only wait.
const HARMLESS: [&str; 4] = ["again", "wait", "other", "same"];

/// An answer. In an answers file: a string, a number, `true` or `false`; the word of a choice is a string, `true` ticks a whole checklist.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Answer {
    /// Yes or no; a checklist that is ticked.
    Yes(bool),
    /// A number in the unit of the prompt.
    Number(f64),
    /// A text, or the word of a choice.
    Text(String),
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Yes(true) => f.pad("yes"),
            Self::Yes(false) => f.pad("no"),
            Self::Number(number) => write!(f, "{number}"),
            Self::Text(text) if text.is_empty() => f.pad("nothing"),
            Self::Text(text) => f.pad(text),
        }
    }
}

impl Prompt {
    /// A yes or no question without a default.
    #[must_use]
    pub fn confirm(id: &str, text: impl Into<String>) -> Self {
        Self::new(id, text, PromptKind::Confirm)
    }

    /// A question without details and default.
    #[must_use]
    pub fn new(id: &str, text: impl Into<String>, kind: PromptKind) -> Self {
        Self {
            id: id.to_owned(),
            key: None,
            text: text.into(),
            details: Vec::new(),
            kind,
            default: None,
        }
    }

    /// One of several answers.
    #[must_use]
    pub fn choice(id: &str, text: impl Into<String>, choices: &[(&'static str, &str)]) -> Self {
        let mut list: Vec<Choice> = Vec::with_capacity(choices.len());
        for (word, text) in choices {
            let free = |key: &char| list.iter().all(|choice| choice.key != *key);
            list.push(Choice {
                word,
                text: (*text).to_owned(),
                key: word.chars().find(free).unwrap_or(' '),
                harmless: HARMLESS.contains(word),
            });
        }
        Self::new(id, text, PromptKind::Choice(list))
    }

    /// What it is called, with what it is about: `setup.P1.x`.
    #[must_use]
    pub fn name(&self) -> String {
        match &self.key {
            Some(key) => format!("{}.{key}", self.id),
            None => self.id.clone(),
        }
    }

    /// Why an answer is none to this question; `None` if it is one.
    #[must_use]
    pub fn complaint(&self, answer: &Answer) -> Option<String> {
        match (&self.kind, answer) {
            (PromptKind::Text, Answer::Text(_)) | (PromptKind::Confirm, Answer::Yes(_)) => None,
            (PromptKind::Checklist(_), Answer::Yes(true)) => None,
            (PromptKind::Checklist(_), _) => {
                Some("every item of the list must be ticked: true".to_owned())
            }
            (PromptKind::Number { unit, range }, answer) => match answer {
                Answer::Number(value) if range[0] <= *value && *value <= range[1] => None,
                // Left blank where it may be.
                Answer::Text(text) if text.is_empty() && self.default.is_some() => None,
                _ => Some(format!(
                    "a number from {} to {} {unit} is expected",
                    range[0], range[1]
                )),
            },
            (PromptKind::Choice(choices), Answer::Text(word))
                if choices.iter().any(|choice| choice.word == word) =>
            {
                None
            }
            (PromptKind::Choice(choices), _) => {
                let words: Vec<&str> = choices.iter().map(|choice| choice.word).collect();
                Some(format!("one of {} is expected", words.join(", ")))
            }
            (PromptKind::Text, _) => Some("a text is expected".to_owned()),
            (PromptKind::Confirm, _) => Some("true or false is expected".to_owned()),
        }
    }

    /// What a typed line means as an answer to this question.
    ///
    /// # Errors
    /// What was expected.
    pub fn read_line(&self, line: &str) -> Result<Answer, String> {
        let line = line.trim();
        if line.is_empty()
            && let Some(default) = &self.default
        {
            return Ok(default.clone());
        }
        let answer = match &self.kind {
            PromptKind::Text => Answer::Text(line.to_owned()),
            PromptKind::Number { .. } => match line.replacen(',', ".", 1).parse() {
                Ok(value) => Answer::Number(value),
                Err(_) => Answer::Text(line.to_owned()),
            },
            PromptKind::Confirm | PromptKind::Checklist(_) => {
                match line.to_ascii_lowercase().as_str() {
                    "y" | "yes" | "true" | "" => Answer::Yes(true),
                    "n" | "no" | "false" => Answer::Yes(false),
                    _ => return Err("yes or no is expected".to_owned()),
                }
            }
            PromptKind::Choice(choices) => {
                let mut letters = line.chars();
                let key = letters.next().filter(|_| letters.next().is_none());
                let meant = choices
                    .iter()
                    .find(|choice| choice.word == line || Some(choice.key) == key);
                Answer::Text(meant.map_or(line, |choice| choice.word).to_owned())
            }
        };
        match self.complaint(&answer) {
            None => Ok(answer),
            Some(complaint) => Err(complaint),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_answers_of_the_kind_that_is_asked() {
        let choice = Prompt::choice("way", "Which?", &[("with", "with"), ("against", "against")]);
        assert_eq!(
            choice.read_line("a"),
            Ok(Answer::Text("against".to_owned()))
        );
        // Two words with one first letter have two keys.
        let doubt = Prompt::choice("frozen", "Hold?", &[("again", ""), ("accept", "")]);
        assert_eq!(doubt.read_line("a"), Ok(Answer::Text("again".to_owned())));
        assert_eq!(doubt.read_line("c"), Ok(Answer::Text("accept".to_owned())));
        assert_eq!(
            choice.read_line("with"),
            Ok(Answer::Text("with".to_owned()))
        );
        assert!(choice.read_line("x").unwrap_err().contains("with, against"));
        let confirm = Prompt::confirm("setup", "Ready?");
        assert_eq!(confirm.read_line("y"), Ok(Answer::Yes(true)));
        assert!(confirm.read_line("perhaps").is_err());
        let range = [-20.0, 60.0];
        let mut number = Prompt::new(
            "t",
            "Warm?",
            PromptKind::Number {
                unit: "degC",
                range,
            },
        );
        assert_eq!(number.read_line("21.5"), Ok(Answer::Number(21.5)));
        assert_eq!(number.read_line("21,5"), Ok(Answer::Number(21.5)));
        assert!(
            number
                .read_line("99")
                .unwrap_err()
                .contains("-20 to 60 degC")
        );
        assert!(number.read_line("").is_err());
        number.default = Some(Answer::Text(String::new()));
        assert_eq!(number.read_line(""), Ok(Answer::Text(String::new())));
    }

    #[test]
    fn a_checklist_is_not_passed_half_ticked() {
        let list = PromptKind::Checklist(vec!["brakes on".to_owned()]);
        let list = Prompt::new("ready", "Ready?", list);
        assert!(list.complaint(&Answer::Yes(false)).is_some());
        assert!(list.complaint(&Answer::Text("yes".to_owned())).is_some());
        assert_eq!(list.complaint(&Answer::Yes(true)), None);
    }
}
