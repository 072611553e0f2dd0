//! The layers of the configuration: files and environment variables.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Deserialize;

use crate::analysis::{ReadError, read_text};
use crate::nearest::nearest;
use crate::readings::SessionHeader;
use crate::report::{ConfigFileReport, SettingOrigin};
use crate::shipped::shipped_robot;
use crate::source_text::SourceText;
use crate::toml_text::{TomlDocument, TomlError, read};

/// Name of the file of a folder.
const FOLDER_FILE: &str = "stiffbench.toml";

/// The file of the computer, for all who use it.
const SYSTEM_FILE: &str = "/etc/stiffbench/config.toml";

/// The variable that names another file, or `none`.
const CONFIG_VARIABLE: &str = "STIFFBENCH_CONFIG";

/// What the variables of settings begin with.
const PREFIX: &str = "STIFFBENCH_";

/// What is wrong with the configuration.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub(in crate::cli) enum ConfigError {
    /// A file that cannot be read.
    #[error("{path} cannot be read")]
    #[diagnostic(code(stiffbench::config::read))]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
        /// What to do about it.
        #[help]
        advice: String,
    },
    /// A file that is no TOML, or a value of another kind.
    #[error("{place}: {problem}")]
    #[diagnostic(
        code(stiffbench::config::syntax),
        help("a setting is a line like robot = \"arm.toml\"; --no-config ignores the file")
    )]
    Syntax {
        /// File, line and column.
        place: String,
        /// What is wrong.
        problem: String,
    },
    /// A setting that there is not.
    #[error("{place}: there is no setting `{key}`")]
    #[diagnostic(code(stiffbench::config::unknown_key))]
    UnknownKey {
        /// File, line and column.
        place: String,
        /// The key.
        key: String,
        /// What could be meant.
        #[help]
        advice: String,
    },
    /// A value that a setting cannot have.
    #[error("{place}: {name} is `{value}`, expected {expected}")]
    #[diagnostic(
        code(stiffbench::config::value),
        help("correct the value, or leave the setting out")
    )]
    Value {
        /// File, line and column, or the variable.
        place: String,
        /// The setting.
        name: &'static str,
        /// Its value.
        value: String,
        /// What is expected.
        expected: &'static str,
    },
}

impl From<ReadError> for ConfigError {
    fn from(error: ReadError) -> Self {
        Self::Read {
            path: error.path,
            source: error.source,
            advice: error.advice,
        }
    }
}

/// A setting: what it is called and what it sets.
#[derive(Debug, Clone, Copy)]
pub(in crate::cli) struct ConfigSetting {
    /// Its name in files; in variables in upper case behind `STIFFBENCH_`.
    pub(in crate::cli) name: &'static str,
    /// The option that takes its value.
    pub(in crate::cli) option: &'static str,
    /// The value without any configuration.
    pub(in crate::cli) default: Option<&'static str>,
    /// What it does.
    pub(in crate::cli) purpose: &'static str,
    /// Whether its value is a path, relative to the file that holds it.
    is_path: bool,
    /// The values that it can have; empty for any.
    values: &'static [&'static str],
}

/// All settings, in alphabetical order.
#[rustfmt::skip]
pub(in crate::cli) const SETTINGS: [ConfigSetting; 6] = [
    ConfigSetting { name: "bindings", option: "bindings", default: Some(crate::cli::gauge::open::BINDINGS_FILE), purpose: "bindings file: which gauge is on which adapter", is_path: true, values: &[] },
    ConfigSetting { name: "operator", option: "operator", default: None, purpose: "operator of new sessions", is_path: false, values: &[] },
    ConfigSetting { name: "place", option: "place", default: None, purpose: "place of new sessions", is_path: false, values: &[] },
    ConfigSetting { name: "progress", option: "progress", default: Some("auto"), purpose: "progress on standard error", is_path: false, values: &["auto", "bar", "text", "none"] },
    ConfigSetting { name: "protocols", option: "protocols", default: None, purpose: "folder with gauge descriptions of your own", is_path: true, values: &[] },
    ConfigSetting { name: "robot", option: "default-robot", default: None, purpose: "robot of data that name none", is_path: true, values: &[] },
];

/// The value of a setting and where it comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::cli) struct SetValue {
    /// The value.
    pub(in crate::cli) value: String,
    /// The kind of place.
    pub(in crate::cli) origin: SettingOrigin,
    /// The file or variable.
    pub(in crate::cli) place: String,
}

/// The configuration.
#[derive(Debug, Clone, Default)]
pub(in crate::cli) struct Config {
    /// Values by the place of the setting in [`SETTINGS`]; `None` for the default.
    values: [Option<SetValue>; SETTINGS.len()],
    /// The places of files.
    pub(in crate::cli) files: Vec<ConfigFileReport>,
    /// Whether files and variables were left aside.
    pub(in crate::cli) ignored: bool,
}

/// Settings of stiffbench, docs/configuration.md. A path is relative to the file that holds it.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields, title = "stiffbench.toml")]
struct ConfigFile {
    /// Bindings file: which gauge is on which adapter.
    bindings: Option<String>,
    /// Operator of new sessions.
    operator: Option<String>,
    /// Place of new sessions.
    place: Option<String>,
    /// How to show progress on standard error: auto, bar, text or none.
    progress: Option<String>,
    /// Folder with gauge descriptions of your own.
    protocols: Option<String>,
    /// Robot of data that name none: a shipped one, or a robot file.
    robot: Option<String>,
}

/// The JSON Schema of configuration files.
pub(in crate::cli) fn json_schema() -> schemars::Schema {
    schemars::schema_for!(ConfigFile)
}

impl ConfigFile {
    fn take(&mut self, name: &str) -> Option<String> {
        match name {
            "bindings" => self.bindings.take(),
            "operator" => self.operator.take(),
            "place" => self.place.take(),
            "progress" => self.progress.take(),
            "protocols" => self.protocols.take(),
            "robot" => self.robot.take(),
            _ => None,
        }
    }
}

impl Config {
    /// Where files are looked for, without what they hold.
    pub(in crate::cli) fn places(is_ignored: bool) -> Self {
        let variable = variable(CONFIG_VARIABLE);
        Self {
            ignored: is_ignored || variable.as_deref() == Some("none"),
            files: files(variable.as_deref()),
            ..Self::default()
        }
    }

    /// The configuration of this process.
    ///
    /// # Arguments
    /// - `is_ignored`: files and variables are left aside (`--no-config`).
    ///
    /// # Errors
    /// For a file that cannot be read, and a setting or value that there is not.
    pub(in crate::cli) fn load(is_ignored: bool) -> Result<Self, ConfigError> {
        let mut config = Self::places(is_ignored);
        if config.ignored {
            return Ok(config);
        }
        // The layers that count least come first.
        for file in config.files.clone().iter().rev() {
            let is_named = variable(CONFIG_VARIABLE).is_some();
            if file.exists || is_named {
                config.take_file(&file.path, file.layer)?;
            }
        }
        config.take_variables()?;
        Ok(config)
    }

    /// Settings that name a file or folder that is not there, each with the setting.
    pub(in crate::cli) fn absent_files(&self) -> impl Iterator<Item = (&ConfigSetting, &SetValue)> {
        let set = SETTINGS.iter().zip(&self.values);
        let set = set.filter_map(|(setting, value)| Some((setting, value.as_ref()?)));
        set.filter(|(setting, set)| {
            let is_shipped = setting.name == "robot" && shipped_robot(&set.value).is_some();
            setting.is_path && !is_shipped && !Path::new(&set.value).exists()
        })
    }

    /// The value of a setting; `None` for the default.
    pub(in crate::cli) fn value(&self, name: &str) -> Option<&SetValue> {
        let place = SETTINGS.iter().position(|setting| setting.name == name)?;
        self.values[place].as_ref()
    }

    /// Takes what a session states of its own.
    pub(super) fn take_session(&mut self, folder: &Path, header: &SessionHeader) {
        let own = [
            ("operator", &header.operator),
            ("place", &header.place),
            ("robot", &header.robot),
        ];
        for (name, value) in own {
            let place = SETTINGS.iter().position(|setting| setting.name == name);
            if let (Some(place), Some(value)) = (place, value) {
                self.values[place] = Some(SetValue {
                    value: value.clone(),
                    origin: SettingOrigin::Session,
                    place: folder.join("session.toml").display().to_string(),
                });
            }
        }
    }

    fn take_file(&mut self, path: &Path, layer: SettingOrigin) -> Result<(), ConfigError> {
        let name = path.display().to_string();
        let source = SourceText::new(name.clone(), read_text(path)?);
        let read = read::<ConfigFile>(&source);
        let (mut file, unknown) = read.map_err(|TomlError(error)| ConfigError::Syntax {
            place: error.place(),
            problem: error.problem.to_string(),
        })?;
        if let Some(key) = unknown.first() {
            return Err(ConfigError::UnknownKey {
                place: format!("{name}:{}:{}", key.line, key.column),
                key: key.key.clone(),
                advice: advice(&key.key),
            });
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let document = TomlDocument::parse(&source).ok();
        for (place, setting) in SETTINGS.iter().enumerate() {
            let Some(value) = file.take(setting.name) else {
                continue;
            };
            let entry = document
                .as_ref()
                .and_then(|text| text.root().get(setting.name));
            let (line, column) =
                source.line_and_column(entry.map_or(0, |entry| entry.span().start));
            setting.check(&value, &format!("{name}:{line}:{column}"))?;
            self.values[place] = Some(SetValue {
                value: setting.beside(folder, value),
                origin: layer,
                place: name.clone(),
            });
        }
        Ok(())
    }

    fn take_variables(&mut self) -> Result<(), ConfigError> {
        for (place, setting) in SETTINGS.iter().enumerate() {
            let name = setting.variable();
            let Some(value) = variable(&name) else {
                continue;
            };
            setting.check(&value, &name)?;
            self.values[place] = Some(SetValue {
                value,
                origin: SettingOrigin::Environment,
                place: name,
            });
        }
        Ok(())
    }
}

impl ConfigSetting {
    /// Its environment variable.
    pub(in crate::cli) fn variable(&self) -> String {
        format!("{PREFIX}{}", self.name.to_uppercase())
    }

    fn check(&self, value: &str, place: &str) -> Result<(), ConfigError> {
        let expected = if value.trim().is_empty() {
            "a text that is not empty"
        } else if !self.values.is_empty() && !self.values.contains(&value) {
            "one of auto, bar, text and none"
        } else {
            return Ok(());
        };
        Err(ConfigError::Value {
            place: place.to_owned(),
            name: self.name,
            value: value.to_owned(),
            expected,
        })
    }

    /// A path of a file is relative to that file; a robot may also be the name of a shipped one.
    fn beside(&self, folder: &Path, value: String) -> String {
        let path = folder.join(&value);
        let is_shipped = self.name == "robot" && !path.exists();
        if self.is_path && !is_shipped {
            path.display().to_string()
        } else {
            value
        }
    }
}

fn advice(key: &str) -> String {
    let names: Vec<&str> = SETTINGS.iter().map(|setting| setting.name).collect();
    let list = names.join(", ");
    match nearest(key, names) {
        Some(near) => format!("did you mean {near}? The settings are {list}"),
        None => format!("the settings are {list}"),
    }
}

/// Environment variables that begin like those of the settings and set nothing, each with what could be meant.
pub(in crate::cli) fn unknown_variables() -> Vec<String> {
    let mut known: Vec<String> = SETTINGS.iter().map(ConfigSetting::variable).collect();
    known.push(CONFIG_VARIABLE.to_owned());
    let names = std::env::vars_os().filter_map(|(name, _)| name.into_string().ok());
    let mut unknown: Vec<String> = names
        .filter(|name| name.starts_with(PREFIX) && !known.contains(name))
        .map(|name| {
            let short = name.trim_start_matches(PREFIX);
            let shorts = known.iter().map(|name| name.trim_start_matches(PREFIX));
            match nearest(short, shorts) {
                Some(near) => format!("{name} sets nothing; did you mean {PREFIX}{near}?"),
                None => format!(
                    "{name} sets nothing; stiffbench config show --json lists the variables"
                ),
            }
        })
        .collect();
    unknown.sort();
    unknown
}

/// An environment variable that is not empty.
fn variable(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|value| !value.is_empty())
}

/// Where files are looked for, the one that counts most first.
fn files(named: Option<&str>) -> Vec<ConfigFileReport> {
    let place = |path: PathBuf, layer| ConfigFileReport {
        exists: path.is_file(),
        path,
        layer,
    };
    if let Some(named) = named.filter(|named| *named != "none") {
        return vec![place(PathBuf::from(named), SettingOrigin::Folder)];
    }
    let here = std::env::current_dir().unwrap_or_default();
    let mut folders = here.ancestors().map(|folder| folder.join(FOLDER_FILE));
    let of_folder = folders.find(|path| path.is_file());
    let of_folder = of_folder.unwrap_or_else(|| here.join(FOLDER_FILE));
    let mut found = vec![place(of_folder, SettingOrigin::Folder)];
    let base = variable("XDG_CONFIG_HOME").map(PathBuf::from);
    let base = base.or_else(|| Some(PathBuf::from(variable("HOME")?).join(".config")));
    let of_user = base.map(|base| base.join("stiffbench").join("config.toml"));
    found.extend(of_user.map(|path| place(path, SettingOrigin::User)));
    if cfg!(unix) {
        found.push(place(PathBuf::from(SYSTEM_FILE), SettingOrigin::System));
    }
    found
}
