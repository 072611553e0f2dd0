//! The settings in force, and where each comes from.

use std::fmt::Write;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_document::Table;

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
    pub fn text(&self, with_origin: bool) -> String {
        let heads: &[&str] = if with_origin {
            &["setting", "value", "from"]
        } else {
            &["setting", "value"]
        };
        let mut rows = Table::new(heads);
        for setting in &self.settings {
            let value = setting.value.clone().unwrap_or_else(|| "-".to_owned());
            let mut row = vec![setting.name.clone(), value];
            if with_origin {
                row.push(setting.from());
            }
            rows.row(row);
        }
        let mut text = rows.text();
        if self.ignored {
            text.push_str("\nConfiguration files and variables are ignored.\n");
        }
        text
    }

    /// The places of files in words.
    #[must_use]
    pub fn paths_text(&self) -> String {
        let mut text = String::new();
        for file in &self.files {
            let state = if file.exists { "exists" } else { "not there" };
            let _ = writeln!(text, "{} ({state})", file.path.display());
        }
        text
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
