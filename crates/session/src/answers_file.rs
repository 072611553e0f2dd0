//! Answers that are known beforehand: from a file, schema `stiffbench/answers/1`, or from the command line.

use std::collections::BTreeMap;

use miette::Diagnostic;
use thiserror::Error;
use toml::de::DeValue;

use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::{Document, Table, TomlError};

use super::operator::{Answer, Prompt};

/// The schema of an answers file.
pub const ANSWERS_SCHEMA: &str = "stiffbench/answers/1";

/// Every question a session can ask, with what an answer looks like.
pub const PROMPTS: [(&str, &str); 28] = [
    ("ready", "true: the bench is ready"),
    ("temperature", "a number, degC"),
    ("humidity", "a number, %"),
    ("bench-note", "a text"),
    ("temperature-end", "a number, degC"),
    ("humidity-end", "a number, %"),
    ("bench-note-end", "a text"),
    (
        "setup",
        "true: pose and gauges are set up; setup.P1.x for one of them",
    ),
    (
        "other-gauge",
        "true: continue with a gauge of another identity",
    ),
    (
        "sign-check",
        "\"minus\" or \"plus\": which way the push by hand went, \"again\"",
    ),
    (
        "sign-differs",
        "\"use\" the sign that was seen, or \"again\"",
    ),
    (
        "zero-not-shown",
        "zero a gauge \"again\" that does not show its zero, or \"subtract\" what it shows",
    ),
    (
        "force-offset",
        "\"zero\" a steady force that hangs free, or \"wait\"",
    ),
    (
        "force-sign",
        "\"flip\" the sign of the force gauge, or \"wait\"",
    ),
    (
        "frozen",
        "\"accept\", \"again\" or \"skip\" a displacement that does not move",
    ),
    (
        "displacement-sign",
        "\"accept\", \"again\", \"skip\" or \"flip\" one that moves against the force",
    ),
    (
        "force-steps",
        "\"again\", \"accept\" or \"skip\" while the force gauge counts in coarse steps",
    ),
    ("displacement-steps", "the same for the displacement gauge"),
    (
        "changed",
        "\"again\" or \"flag\" a load that gives another displacement than before an interruption",
    ),
    (
        "unit",
        "\"same\" if the display of a gauge that sends no unit shows the configured one",
    ),
    (
        "implausible",
        "\"accept\", \"again\" or \"skip\" one far from its neighbours",
    ),
    (
        "not-settled",
        "\"wait\", or \"take\" a reading that has not settled",
    ),
    ("drift", "\"keep\" or \"redo\" readings whose zero moved"),
    (
        "bad-reading",
        "\"redo\" the run of a reading that its repeats contradict, or \"keep\" it",
    ),
    ("limit", "\"again\", \"accept\" or \"skip\""),
    (
        "skip-reason",
        "a text that begins with instrument, specimen, unreachable, time or other",
    ),
    ("note", "a text"),
    ("redo-cell", "true: measure a complete cell once more"),
];

/// Answers by the name of the prompt, or by its name and key (`setup.P1.x`).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Answers {
    /// The answers.
    pub by_name: BTreeMap<String, Answer>,
    /// Whether no operator can be asked: a question without an answer ends the session.
    pub no_input: bool,
}

/// Why answers cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
pub enum AnswersError {
    /// Not an answers file.
    #[error("{file}: {problem}")]
    #[diagnostic(
        code(stiffbench::session::answers_file),
        help(
            "the first line is schema = \"stiffbench/answers/1\", then lines like setup = true or sign-check = \"minus\""
        )
    )]
    File {
        /// The file, with line and column.
        file: String,
        /// What is wrong.
        problem: String,
    },
    /// No such question.
    #[error("{file}: no question is called `{name}`")]
    #[diagnostic(code(stiffbench::session::answer_name))]
    Unknown {
        /// The file, or the argument.
        file: String,
        /// The name.
        name: String,
        /// The nearest, and where all are.
        #[help]
        help: String,
    },
    /// Not `NAME=VALUE`.
    #[error("`{text}` is not an answer: write NAME=VALUE")]
    #[diagnostic(
        code(stiffbench::session::answer_form),
        help("for example --answer sign-check=minus or --answer setup=true")
    )]
    Form {
        /// What was given.
        text: String,
    },
}

impl From<TomlError> for AnswersError {
    fn from(TomlError(error): TomlError) -> Self {
        Self::File {
            file: error.place(),
            problem: error.problem.to_string(),
        }
    }
}

/// Checks that a question is one that sessions ask; pose and direction may stand behind it.
///
/// # Errors
/// [`AnswersError::Unknown`], with the nearest there is; `file` is where the name stands.
pub fn check_question(file: &str, name: &str) -> Result<(), AnswersError> {
    let id = name.split('.').next().unwrap_or(name);
    let names = || PROMPTS.iter().map(|(name, _)| *name);
    if names().any(|known| known == id) {
        return Ok(());
    }
    let meant = nearest(id, names());
    let meant = meant.map_or_else(String::new, |near| format!("did you mean {near}? "));
    Err(AnswersError::Unknown {
        file: file.to_owned(),
        name: name.to_owned(),
        help: format!("{meant}stiffbench session plan lists every question"),
    })
}

impl Answers {
    /// Reads an answers file. Tables count as names with a point: `[setup]` with `"P1.x" = true` answers `setup.P1.x`.
    ///
    /// # Errors
    /// [`AnswersError`].
    pub fn parse(file: &str, text: &str) -> Result<Self, AnswersError> {
        let source = SourceText::new(file, text);
        let document = Document::parse(&source)?;
        document.root().check_schema(ANSWERS_SCHEMA, true)?;
        let mut answers = Self::default();
        answers.take("", &document.root())?;
        Ok(answers)
    }

    fn take(&mut self, above: &str, table: &Table<'_>) -> Result<(), AnswersError> {
        for (key, span, value) in table.entries() {
            let name = format!("{above}{key}");
            let answer = match value.parsed() {
                _ if name == "schema" => continue,
                DeValue::Table(_) => {
                    self.take(&format!("{name}."), &value.table()?)?;
                    continue;
                }
                DeValue::Boolean(yes) => Answer::Yes(*yes),
                DeValue::Integer(_) | DeValue::Float(_) => Answer::Number(value.number()?),
                DeValue::String(text) => Answer::Text(text.to_string()),
                _ => return Err(value.wrong("a text, a number, true or false").into()),
            };
            let (line, column) = table.source().line_and_column(span.start);
            let place = format!("{}:{line}:{column}", table.source().name);
            self.insert(&place, &name, answer)?;
        }
        Ok(())
    }

    /// Takes `NAME=VALUE`; it goes before what is there already.
    ///
    /// # Errors
    /// [`AnswersError`].
    pub fn take_argument(&mut self, text: &str) -> Result<(), AnswersError> {
        let (name, value) = text.split_once('=').ok_or_else(|| AnswersError::Form {
            text: text.to_owned(),
        })?;
        let answer = match value {
            "true" | "yes" => Answer::Yes(true),
            "false" | "no" => Answer::Yes(false),
            value => match value.parse::<f64>() {
                Ok(number) if number.is_finite() => Answer::Number(number),
                _ => Answer::Text(value.to_owned()),
            },
        };
        self.insert("--answer", name, answer)
    }

    fn insert(&mut self, file: &str, name: &str, answer: Answer) -> Result<(), AnswersError> {
        check_question(file, name)?;
        self.by_name.insert(name.to_owned(), answer);
        Ok(())
    }

    /// Takes further answers; those that are there already go before them.
    #[must_use]
    pub fn or(mut self, others: Self) -> Self {
        for (name, answer) in others.by_name {
            self.by_name.entry(name).or_insert(answer);
        }
        self
    }

    /// The answer to a question, if there is one.
    #[must_use]
    pub fn find(&self, prompt: &Prompt) -> Option<&Answer> {
        let keyed = prompt
            .key
            .as_ref()
            .map(|key| format!("{}.{key}", prompt.id));
        keyed
            .and_then(|name| self.by_name.get(&name))
            .or_else(|| self.by_name.get(&prompt.id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_with_the_key_goes_first() {
        let text = "schema = \"stiffbench/answers/1\"\ntemperature = 21\nsetup = true\n\"setup.P2.x\" = false\n[sign-check]\n\"P1.x\" = \"plus\"\n";
        let mut answers = Answers::parse("a.toml", text).unwrap();
        let mut prompt = Prompt::confirm("setup", "?");
        for (key, expected) in [("P1.x", true), ("P2.x", false)] {
            prompt.key = Some(key.to_owned());
            assert_eq!(answers.find(&prompt), Some(&Answer::Yes(expected)));
        }
        let mut way = Prompt::choice("sign-check", "?", &[("plus", "")]);
        assert_eq!(answers.find(&way), None);
        way.key = Some("P1.x".to_owned());
        assert_eq!(answers.find(&way), Some(&Answer::Text("plus".to_owned())));
        answers.take_argument("setup.P2.x=yes").unwrap();
        assert_eq!(answers.find(&prompt), Some(&Answer::Yes(true)));
    }

    #[test]
    fn unknown_names_and_forms_are_reported() {
        let schema = "schema = \"stiffbench/answers/1\"\n";
        let error = |text: &str| Answers::parse("a.toml", text).unwrap_err();
        let unknown = error(&format!("{schema}sing-check = \"plus\"\n"));
        assert!(
            matches!(&unknown, AnswersError::Unknown { help, .. } if help.contains("sign-check"))
        );
        assert!(matches!(error("setup = true\n"), AnswersError::File { .. }));
        assert!(matches!(
            error(&format!("{schema}setup = [1]\n")),
            AnswersError::File { .. }
        ));
        let mut answers = Answers::default();
        assert!(matches!(
            answers.take_argument("setup"),
            Err(AnswersError::Form { .. })
        ));
    }
}
