//! Checks of the computer before a session.

use crate::count::counted;
use schemars::JsonSchema;
use serde::Serialize;
use stiffbench_document::{Document, Table};

/// Checks of the computer.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DoctorReport {
    /// The checks, in order.
    pub checks: Vec<CheckReport>,
    /// How many ended as a warning.
    pub warnings: usize,
    /// How many failed.
    pub failed: usize,
}

/// How a check ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum CheckState {
    /// As it should be.
    Ok,
    /// A session is possible; something is missing or slow.
    Warning,
    /// A session is not possible, or not with gauges.
    Failed,
}

/// One check.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CheckReport {
    /// What was checked.
    pub name: String,
    /// How it ended.
    pub state: CheckState,
    /// What was found.
    pub found: String,
    /// What to do; `null` if all is well.
    pub remedy: Option<String>,
}

impl CheckReport {
    /// A check that ended well.
    #[must_use]
    pub fn ok(name: &str, found: impl Into<String>) -> Self {
        Self::ended(name, CheckState::Ok, found, None)
    }

    /// A check that ended as a warning.
    #[must_use]
    pub fn warning(name: &str, found: impl Into<String>, remedy: &str) -> Self {
        Self::ended(name, CheckState::Warning, found, Some(remedy))
    }

    /// A check that failed.
    #[must_use]
    pub fn failed(name: &str, found: impl Into<String>, remedy: &str) -> Self {
        Self::ended(name, CheckState::Failed, found, Some(remedy))
    }

    fn ended(
        name: &str,
        state: CheckState,
        found: impl Into<String>,
        remedy: Option<&str>,
    ) -> Self {
        Self {
            name: name.to_owned(),
            state,
            found: found.into(),
            remedy: remedy.map(str::to_owned),
        }
    }
}

impl DoctorReport {
    /// The report on these checks.
    #[must_use]
    pub fn new(checks: Vec<CheckReport>) -> Self {
        let count = |state| checks.iter().filter(|check| check.state == state).count();
        Self {
            warnings: count(CheckState::Warning),
            failed: count(CheckState::Failed),
            checks,
        }
    }

    /// The checks in words.
    #[must_use]
    pub fn document(&self) -> Document {
        let state = |check: &&CheckReport| match check.state {
            CheckState::Ok => "ok".to_owned(),
            CheckState::Warning => "warning".to_owned(),
            CheckState::Failed => "FAILED".to_owned(),
        };
        let mut document = Document::new();
        document.table(
            Table::of(&self.checks)
                .words("state", state)
                .words("check", |check| &check.name)
                .words("found", |check| &check.found),
        );
        for check in &self.checks {
            if let Some(remedy) = &check.remedy {
                document.item(format!("{}: {remedy}", check.name));
            }
        }
        document.paragraph(format!(
            "{}, {}, {} failed",
            counted(self.checks.len(), "check"),
            counted(self.warnings, "warning"),
            self.failed
        ));
        document
    }
}
