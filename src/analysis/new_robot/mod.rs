//! Robot files from what a user has: a URDF, a Denavit-Hartenberg table, a template.

mod dh;
mod dh_csv;
mod draft;
mod positions;
mod templates;
mod urdf;
mod urdf_chain;
mod urdf_meshes;
mod urdf_mimic;
mod urdf_tree;

use crate::robot::RobotProblem;
use crate::source_text::{PlacedError, SourceText};

pub use dh::{Controller, DhSettings, robot_from_dh};
pub use positions::{StatedPosition, check_positions};
pub use templates::{TEMPLATES, template};
pub use urdf_tree::{UrdfSettings, robot_from_urdf};

/// A robot file that was made, and what its user should know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewRobot {
    /// The text, in format `stiffbench/robot/2`.
    pub text: String,
    /// What was left out or assumed.
    pub notes: Vec<String>,
}

impl NewRobot {
    /// An error of the text, at the element of what it was made from: the text is in no file yet.
    #[must_use]
    pub fn error(&self, source: &SourceText, error: &PlacedError<RobotProblem>) -> ImportError {
        let lines: Vec<&str> = self.text.lines().take(error.line).collect();
        let row = lines.last().copied().unwrap_or_default();
        let name = row
            .split(" = ")
            .next()
            .unwrap_or_default()
            .trim_matches('"');
        let table = lines.iter().rev().find(|line| line.starts_with('['));
        let element = match table.copied() {
            Some("[joints]") => format!("joint `{name}`"),
            Some("[masses]") => format!("link `{name}`"),
            other => format!("{name} in {}", other.unwrap_or("the head")),
        };
        let quoted = source.text.find(&format!("\"{name}\""));
        let at = quoted.or_else(|| source.text.find(name)).unwrap_or(0);
        let help = error.help.clone();
        let message = format!("{element}: {}", error.problem);
        let problem = ImportProblem {
            message,
            help: help.or_else(|| Some(format!("the robot file would have: {row}"))),
        };
        ImportError::new(source, at..at, problem)
    }
}

/// What is wrong with a URDF or a Denavit-Hartenberg table.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("{message}")]
#[diagnostic(code(stiffbench::robot::import))]
pub struct ImportProblem {
    /// The element by name, and what is wrong with it.
    pub message: String,
    /// What to do about it.
    #[help]
    pub help: Option<String>,
}

impl ImportProblem {
    fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            help: Some(help.into()),
        }
    }
}

impl From<crate::toml_text::TomlProblem> for ImportProblem {
    fn from(problem: crate::toml_text::TomlProblem) -> Self {
        Self {
            help: miette::Diagnostic::help(&problem).map(|help| help.to_string()),
            message: problem.to_string(),
        }
    }
}

/// A problem at its place in the file.
pub type ImportError = PlacedError<ImportProblem>;
