//! What can be wrong with a procedure.

use std::borrow::Cow;
use std::fmt::Display;

use miette::Diagnostic;
use thiserror::Error;

use stiffbench_units_and_text::source_text::PlacedError;
use stiffbench_units_and_text::toml_text::TomlProblem;

/// Why a procedure file cannot be followed; shows the place in the file.
pub type ProcedureError = PlacedError<ProcedureProblem>;

/// Why a plan cannot be followed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct ProcedureProblem {
    /// The key to change, with its table and without its unit.
    pub key: &'static str,
    code: &'static str,
    message: String,
    help: Cow<'static, str>,
}

impl ProcedureProblem {
    pub(super) fn new(
        code: &'static str,
        key: &'static str,
        message: impl Into<String>,
        help: &'static str,
    ) -> Self {
        Self {
            key,
            code,
            message: message.into(),
            help: help.into(),
        }
    }

    /// A list with nothing in it.
    pub(super) fn empty(key: &'static str) -> Self {
        ProcedureProblem::new(
            "stiffbench::procedure::empty_list",
            key,
            format!("`{key}` lists nothing"),
            "list at least one, or leave the key out: that takes every pose of the robot, the directions x, y, z, loads to -70 N, loading",
        )
    }

    /// A number below zero.
    pub(super) fn negative(key: &'static str, value: f64) -> Self {
        ProcedureProblem::new(
            "stiffbench::procedure::negative",
            key,
            format!("`{key}` is {value} (SI), below zero"),
            "give 0 or more",
        )
    }
}

impl Diagnostic for ProcedureProblem {
    fn code<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new(self.code))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new(&self.help))
    }
}

/// Not TOML, not a procedure, or a value or unit of the wrong kind.
impl From<TomlProblem> for ProcedureProblem {
    fn from(problem: TomlProblem) -> Self {
        let help = problem.help().map(|help| help.to_string());
        Self {
            help: help.unwrap_or_default().into(),
            ..ProcedureProblem::new(
                "stiffbench::procedure::file",
                "schema",
                problem.to_string(),
                "",
            )
        }
    }
}
