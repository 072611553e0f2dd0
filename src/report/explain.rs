//! Explanations of error codes, exit codes, laws and verdicts.

use schemars::JsonSchema;
use serde::Serialize;
use stiffbench_document::Document;

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
    pub fn document(&self) -> Document {
        let kind = match self.kind {
            TopicKind::Error => "error",
            TopicKind::Law => "law",
            TopicKind::Verdict => "verdict",
            TopicKind::ExitCode => "exit code",
        };
        let exit = match (self.kind, self.exit_code) {
            (TopicKind::Error, Some(exit)) => format!(", exit code {exit}"),
            _ => String::new(),
        };
        let mut document = Document::of(format!("{kind} {}{exit}", self.name));
        document.paragraph(&self.cause);
        for form in &self.forms {
            document.paragraph(&form.name);
            document.pair("equation", &form.equation);
            document.pair("place", &form.place);
            let parameters = form.parameters.join("; ");
            let none = parameters.is_empty().then(|| "none".to_owned());
            document.pair("parameters", none.unwrap_or(parameters));
        }
        document.paragraph(format!("What to do: {}", self.remedy));
        document.paragraph("Example:");
        document.lines(format!("  {}", self.example));
        document
    }
}

impl TopicList {
    /// The list in words.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut document = Document::new();
        for (head, names) in [
            ("Verdicts of a diagnosis", &self.verdicts),
            ("Laws", &self.laws),
            ("Error codes", &self.errors),
        ] {
            document.paragraph(format!("{head}:"));
            for name in names {
                document.lines(format!("  {name}"));
            }
        }
        document.paragraph("Next: stiffbench explain NAME");
        document
    }
}
