//! Answers that are known beforehand: from a file, schema `stiffbench/answers/1`, or from the command line.

use std::collections::BTreeMap;

use miette::Diagnostic;
use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use thiserror::Error;
use toml::de::DeValue;

use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::{TomlDocument, TomlError, TomlTable};

use super::operator::{Answer, Prompt};
use super::plan::SessionPlan;

/// The schema of an answers file.
pub const ANSWERS_SCHEMA: &str = "stiffbench/answers/1";

/// A question that a session can ask.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Question {
    /// Its name in an answers file and in `--answer NAME=VALUE`.
    pub id: &'static str,
    /// What kind of answer it takes.
    #[serde(skip)]
    pub form: AnswerForm,
    /// What an answer looks like and means, for people.
    pub answer: &'static str,
}

/// By its name.
impl<'de> Deserialize<'de> for Question {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        struct NamedQuestion {
            id: String,
        }
        let NamedQuestion { id } = NamedQuestion::deserialize(deserializer)?;
        let found = QUESTIONS.iter().find(|known| known.id == id);
        found
            .copied()
            .ok_or_else(|| D::Error::custom(format!("no session asks a question `{id}`")))
    }
}

/// What kind of answer a question takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnswerForm {
    /// True or false.
    Yes,
    /// A number; nothing where it may be left out.
    Number {
        /// Its unit.
        unit: &'static str,
        /// Smallest and largest that are taken.
        range: [f64; 2],
    },
    /// A text.
    Text,
    /// One of these words.
    Words(&'static [&'static str]),
}

impl AnswerForm {
    /// Why no question of this form takes an answer; `None` if one may.
    fn complaint(self, answer: &Answer) -> Option<String> {
        match (self, answer) {
            (Self::Yes, Answer::Yes(_)) | (Self::Text, Answer::Text(_)) => None,
            (Self::Number { range, .. }, Answer::Number(value))
                if range[0] <= *value && *value <= range[1] =>
            {
                None
            }
            (Self::Number { .. }, Answer::Text(text)) if text.is_empty() => None,
            (Self::Words(words), Answer::Text(word)) if words.contains(&word.as_str()) => None,
            (Self::Yes, _) => Some("true or false is expected".to_owned()),
            (Self::Number { unit, range }, _) => Some(format!(
                "a number from {} to {} {unit} is expected, without its unit",
                range[0], range[1]
            )),
            (Self::Text, _) => Some("a text is expected".to_owned()),
            (Self::Words(words), _) => Some(format!("one of {} is expected", words.join(", "))),
        }
    }
}

/// Temperatures that a bench may have, degC.
pub(crate) const TEMPERATURES_DEG_C: [f64; 2] = [-40.0, 80.0];

/// Relative humidities, %.
pub(crate) const HUMIDITIES_PERCENT: [f64; 2] = [0.0, 100.0];

const TEMPERATURE: AnswerForm = AnswerForm::Number {
    unit: "degC",
    range: TEMPERATURES_DEG_C,
};

const HUMIDITY: AnswerForm = AnswerForm::Number {
    unit: "%",
    range: HUMIDITIES_PERCENT,
};

/// Every question a session can ask.
pub const QUESTIONS: [Question; 29] = [
    Question {
        id: "ready",
        form: AnswerForm::Yes,
        answer: "true: the bench is ready",
    },
    Question {
        id: "temperature",
        form: TEMPERATURE,
        answer: "a number, degC",
    },
    Question {
        id: "humidity",
        form: HUMIDITY,
        answer: "a number, %",
    },
    Question {
        id: "bench-note",
        form: AnswerForm::Text,
        answer: "a text",
    },
    Question {
        id: "temperature-end",
        form: TEMPERATURE,
        answer: "a number, degC",
    },
    Question {
        id: "humidity-end",
        form: HUMIDITY,
        answer: "a number, %",
    },
    Question {
        id: "bench-note-end",
        form: AnswerForm::Text,
        answer: "a text",
    },
    Question {
        id: "setup",
        form: AnswerForm::Yes,
        answer: "true: pose and gauges are set up; setup.P1.x for one of them",
    },
    Question {
        id: "other-gauge",
        form: AnswerForm::Yes,
        answer: "true: continue with a gauge of another identity",
    },
    Question {
        id: "sign-check",
        form: AnswerForm::Words(&["minus", "plus", "again"]),
        answer: "\"minus\" or \"plus\": which way the push by hand went, \"again\"",
    },
    Question {
        id: "sign-differs",
        form: AnswerForm::Words(&["use", "again"]),
        answer: "\"use\" the sign that was seen, or \"again\"",
    },
    Question {
        id: "zero-not-shown",
        form: AnswerForm::Words(&["again", "subtract"]),
        answer: "zero a gauge \"again\" that does not show its zero, or \"subtract\" what it shows",
    },
    Question {
        id: "force-offset",
        form: AnswerForm::Words(&["zero", "wait"]),
        answer: "\"zero\" a steady force that hangs free, or \"wait\"",
    },
    Question {
        id: "force-sign",
        form: AnswerForm::Words(&["flip", "wait"]),
        answer: "\"flip\" the sign of the force gauge, or \"wait\"",
    },
    Question {
        id: "frozen",
        form: AnswerForm::Words(&["accept", "again", "skip"]),
        answer: "\"accept\", \"again\" or \"skip\" a displacement that does not move",
    },
    Question {
        id: "displacement-sign",
        form: AnswerForm::Words(&["accept", "again", "skip", "flip"]),
        answer: "\"accept\", \"again\", \"skip\" or \"flip\" a displacement that moves against the force",
    },
    Question {
        id: "force-steps",
        form: AnswerForm::Words(&["again", "accept", "skip"]),
        answer: "\"again\", \"accept\" or \"skip\" while the force gauge counts in coarse steps",
    },
    Question {
        id: "displacement-steps",
        form: AnswerForm::Words(&["again", "accept", "skip"]),
        answer: "the same for the displacement gauge",
    },
    Question {
        id: "changed",
        form: AnswerForm::Words(&["again", "flag"]),
        answer: "\"again\" or \"flag\" a load that gives another displacement than before an interruption",
    },
    Question {
        id: "unit",
        form: AnswerForm::Words(&["same", "other"]),
        answer: "\"same\" if the display of a gauge that sends no unit shows the configured one",
    },
    Question {
        id: "implausible",
        form: AnswerForm::Words(&["accept", "again", "skip"]),
        answer: "\"accept\", \"again\" or \"skip\" a reading far from its neighbours",
    },
    Question {
        id: "not-settled",
        form: AnswerForm::Words(&["wait", "take"]),
        answer: "\"wait\", or \"take\" a reading that has not settled",
    },
    Question {
        id: "drift",
        form: AnswerForm::Words(&["keep", "redo"]),
        answer: "\"keep\" or \"redo\" readings whose zero moved",
    },
    Question {
        id: "bad-reading",
        form: AnswerForm::Words(&["redo", "keep"]),
        answer: "\"redo\" the run of a reading that its repeats contradict, or \"keep\" it",
    },
    Question {
        id: "redo-cause",
        form: AnswerForm::Text,
        answer: "a text: why a run differed that is taken again, or nothing",
    },
    Question {
        id: "limit",
        form: AnswerForm::Words(&["again", "accept", "skip"]),
        answer: "\"again\", \"accept\" or \"skip\"",
    },
    Question {
        id: "skip-reason",
        form: AnswerForm::Text,
        answer: "a text that begins with instrument, specimen, unreachable, time or other",
    },
    Question {
        id: "note",
        form: AnswerForm::Text,
        answer: "a text",
    },
    Question {
        id: "redo-cell",
        form: AnswerForm::Yes,
        answer: "true: measure a complete cell once more",
    },
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
    /// The question takes no such answer.
    #[error("{file}: the answer to {name}: {problem}")]
    #[diagnostic(
        code(stiffbench::session::answer_value),
        help("stiffbench session plan lists every question with the form of its answer")
    )]
    Value {
        /// The file with line and column, or the argument.
        file: String,
        /// The name.
        name: String,
        /// What was expected.
        problem: String,
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
pub fn check_question(file: &str, name: &str) -> Result<&'static Question, AnswersError> {
    let id = name.split('.').next().unwrap_or(name);
    if let Some(question) = QUESTIONS.iter().find(|known| known.id == id) {
        return Ok(question);
    }
    let meant = nearest(id, QUESTIONS.iter().map(|known| known.id));
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
        let document = TomlDocument::parse(&source)?;
        document.root().check_schema(ANSWERS_SCHEMA, true)?;
        let mut answers = Self::default();
        answers.take("", &document.root())?;
        Ok(answers)
    }

    fn take(&mut self, above: &str, table: &TomlTable<'_>) -> Result<(), AnswersError> {
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
        let question = check_question(file, name)?;
        if let Some(problem) = question.form.complaint(&answer) {
            return Err(AnswersError::Value {
                file: file.to_owned(),
                name: name.to_owned(),
                problem,
            });
        }
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

    /// Answers to questions at a pose and direction, or at a gauge, that a plan does not have: nothing asks for them.
    #[must_use]
    pub fn never_asked(&self, plan: &SessionPlan) -> Vec<&str> {
        let cells = plan.cells.iter();
        let cells = cells.map(|cell| format!("{}.{}", cell.pose, cell.direction));
        let channels = plan.channels().into_iter().map(|gauge| gauge.to_string());
        let keys: Vec<String> = cells.chain(channels).collect();
        let has_unknown_key = |name: &&str| {
            let key = name.split_once('.').map(|(_, key)| key);
            key.is_some_and(|key| keys.iter().all(|known| known != key))
        };
        let names = self.by_name.keys().map(String::as_str);
        names.filter(has_unknown_key).collect()
    }

    /// The answer to a question, if there is one.
    #[must_use]
    pub fn find(&self, prompt: &Prompt) -> Option<&Answer> {
        let keyed = self.by_name.get(&prompt.name());
        keyed.or_else(|| self.by_name.get(&prompt.id))
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
        for (answer, expected) in [
            ("setup=perhaps", "true or false"),
            ("temperature=warm", "a number from -40 to 80 degC"),
            ("temperature=2150", "a number from -40 to 80 degC"),
            ("temperature.P1=yes", "a number"),
            ("bench-note=5", "a text"),
            ("drift=yes", "one of keep, redo"),
        ] {
            let error = answers.take_argument(answer).unwrap_err().to_string();
            assert!(error.contains(expected), "{answer}: {error}");
        }
        for answer in ["temperature=", "bench-note=", "drift=keep"] {
            answers.take_argument(answer).unwrap();
        }
    }
}
