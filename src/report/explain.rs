//! Explanations of error codes, exit codes, laws and verdicts.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;
use stiffbench_document::wrapped;

/// An explanation, or the list of what can be explained.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum ExplainResult {
    /// One explanation.
    Topic(TopicReport),
    /// All names.
    Topics(TopicList),
}

/// What can be explained.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct TopicList {
    /// Error codes without `stiffbench::`.
    pub errors: Vec<String>,
    /// Names of laws.
    pub laws: Vec<String>,
    /// Verdicts of a diagnosis.
    pub verdicts: Vec<String>,
}

/// What a name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TopicKind {
    /// An error code.
    Error,
    /// A law of the library of physics.
    Law,
    /// A verdict of a diagnosis.
    Verdict,
    /// An exit code.
    ExitCode,
}

/// One explanation.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct TopicReport {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: TopicKind,
    /// Exit code of an error, or the one that is explained.
    pub exit_code: Option<u8>,
    /// Why the error occurs, what the law does, what the verdict means.
    pub cause: String,
    /// What to do.
    pub remedy: String,
    /// A command, or a line of a file.
    pub example: String,
    /// Forms of a law: equation, place and parameters of each.
    pub forms: Vec<LawForm>,
}

/// One form of a law.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LawForm {
    /// Its name in tables.
    pub name: String,
    /// The equation.
    pub equation: String,
    /// The kind of place where it acts.
    pub place: String,
    /// Its parameters with units.
    pub parameters: Vec<String>,
}

impl TopicReport {
    /// The explanation in words.
    #[must_use]
    pub fn text(&self) -> String {
        let head = match (self.kind, self.exit_code) {
            (TopicKind::Error, Some(exit)) => format!("error {}, exit code {exit}", self.name),
            (TopicKind::Error, None) => format!("error {}", self.name),
            (TopicKind::Law, _) => format!("law {}", self.name),
            (TopicKind::Verdict, _) => format!("verdict {}", self.name),
            (TopicKind::ExitCode, _) => format!("exit code {}", self.name),
        };
        let mut text = format!("{head}\n\n{}\n", wrapped(&self.cause, 100, "", ""));
        for form in &self.forms {
            let parameters = if form.parameters.is_empty() {
                "none".to_owned()
            } else {
                form.parameters.join("; ")
            };
            let _ = write!(
                text,
                "\n{}\n  equation    {}\n  place       {}\n  parameters  {parameters}\n",
                form.name, form.equation, form.place
            );
        }
        let _ = write!(
            text,
            "\nWhat to do: {}\n\nExample:\n  {}\n",
            wrapped(&self.remedy, 88, "", ""),
            self.example
        );
        text
    }
}

impl TopicList {
    /// The list in words.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        for (head, names) in [
            ("Verdicts of a diagnosis", &self.verdicts),
            ("Laws", &self.laws),
            ("Error codes", &self.errors),
        ] {
            let _ = writeln!(text, "{head}:");
            for name in names {
                let _ = writeln!(text, "  {name}");
            }
            text.push('\n');
        }
        text.push_str("Next: stiffbench explain NAME\n");
        text
    }
}
