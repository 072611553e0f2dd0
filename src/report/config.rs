//! The settings in force, and where each comes from.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_document::{Document, Table};

use super::text::or_dash;

/// The settings in force.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ConfigReport {
    /// The settings, in alphabetical order.
    pub settings: Vec<SettingReport>,
    /// The places where configuration files are looked for, the first counts most.
    pub files: Vec<ConfigFileReport>,
    /// Whether files and variables were left aside.
    pub ignored: bool,
}

/// One setting.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SettingReport {
    /// Its name.
    pub name: String,
    /// The value in force; `null` if there is none.
    pub value: Option<String>,
    /// The kind of place that it comes from.
    pub origin: SettingOrigin,
    /// The file or variable that it comes from.
    pub place: Option<String>,
    /// The environment variable that sets it.
    pub variable: String,
    /// What it does.
    pub purpose: String,
}

/// The kind of place that a setting comes from, the first counts least.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SettingOrigin {
    /// The program.
    Default,
    /// The file of the computer.
    System,
    /// The file of the user.
    User,
    /// The file of the folder, or of a folder above it.
    Folder,
    /// An environment variable.
    Environment,
    /// What a session states of its own.
    Session,
    /// An option of the command line.
    Option,
}

/// A place of a configuration file.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ConfigFileReport {
    /// Its path.
    pub path: PathBuf,
    /// Whose settings it holds.
    pub layer: SettingOrigin,
    /// Whether there is such a file.
    pub exists: bool,
}

impl ConfigReport {
    /// The settings in words.
    #[must_use]
    pub fn document(&self, with_origin: bool) -> Document {
        let mut document = Document::new();
        let table = Table::of(&self.settings)
            .words("setting", |one| &one.name)
            .words("value", |one| or_dash(one.value.clone(), |value| value))
            .when(with_origin, |table| table.words("from", |one| one.from()));
        document.table(table);
        if self.ignored {
            document.paragraph("Configuration files and variables are ignored.");
        }
        document
    }

    /// The places of files in words.
    #[must_use]
    pub fn places(&self) -> Document {
        let mut document = Document::new();
        for file in &self.files {
            let state = if file.exists { "exists" } else { "not there" };
            document.lines(format!("{} ({state})", file.path.display()));
        }
        document
    }
}

impl SettingReport {
    /// Where it comes from, in words.
    #[must_use]
    pub fn from(&self) -> String {
        let kind = match self.origin {
            SettingOrigin::Default => "default",
            SettingOrigin::Option => "option",
            SettingOrigin::System | SettingOrigin::User | SettingOrigin::Folder => "file",
            SettingOrigin::Environment => "variable",
            SettingOrigin::Session => "session",
        };
        match &self.place {
            Some(place) => format!("{kind} {place}"),
            None => kind.to_owned(),
        }
    }
}
