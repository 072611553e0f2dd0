//! Layered configuration: defaults, files, environment variables, options; and `stiffbench config`, which shows them.
//!
//! A setting acts as if its option stood on the command line, where the command has that option and the user did not give it.

mod layers;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Arg, Args, Command, Subcommand};
use serde_json::json;

use crate::analysis::session_header;
use crate::report::{ConfigReport, SettingOrigin, SettingReport};

use super::args::ProgressMode;
use super::{Failure, Global, Outcome};

pub(super) use layers::{Config, ConfigError, unknown_variables};
use layers::{ConfigSetting, SETTINGS, SetValue, json_schema};

/// Arguments of `config`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench config show --origin                  each value in force, and where it comes from\n  stiffbench config show --origin my-session       with the settings of this session\n  stiffbench config path                           where files are searched\n  stiffbench config show --schema > stiffbench.schema.json"
)]
pub(super) struct ConfigArgs {
    /// What to do.
    #[command(subcommand)]
    what: ConfigCommand,
}

/// Subcommands of `config`.
#[derive(Debug, Subcommand)]
enum ConfigCommand {
    /// Print each setting with the value in force
    Show {
        /// Session folder: its own settings take precedence over variables and files
        #[arg(conflicts_with = "schema")]
        session: Option<PathBuf>,
        /// Also print where each value comes from: default, file, variable, session or option
        #[arg(long)]
        origin: bool,
        /// Print the JSON Schema of configuration files instead
        #[arg(long, conflicts_with = "origin")]
        schema: bool,
    },
    /// Print where configuration files are searched; the first takes precedence
    Path,
}

/// The option that leaves the configuration aside.
const NO_CONFIG: &str = "--no-config";

/// Commands that show, check or explain: no setting changes them.
const UNCHANGED: [&str; 6] = ["config", "doctor", "explain", "completions", "man", "help"];

/// Shows settings and where they come from.
pub(super) fn run(args: &ConfigArgs, global: &Global) -> Result<Outcome, Failure> {
    if let ConfigCommand::Show { schema: true, .. } = args.what {
        let schema = json_schema();
        return Ok(Outcome::new(
            "config-schema",
            format!("{:#}\n", json!(schema)),
            schema,
        ));
    }
    let loaded = Config::load(global.no_config);
    let is_path = matches!(args.what, ConfigCommand::Path);
    let mut notes = Vec::new();
    let mut config = match loaded {
        // Where a file lies is asked for when it is wrong, too.
        Err(error) if is_path => {
            notes.push(Failure::from(error).message());
            Config::places(global.no_config)
        }
        loaded => loaded?,
    };
    if let ConfigCommand::Show {
        session: Some(folder),
        ..
    } = &args.what
    {
        match session_header(folder, &mut notes)? {
            Some(header) => config.take_session(folder, &header),
            None => notes.push(format!("{} has no session.toml", folder.display())),
        }
    }
    let report = report(&config, global.progress);
    let document = match args.what {
        ConfigCommand::Show { origin, .. } => report.document(origin),
        ConfigCommand::Path => report.places(),
    };
    Ok(Outcome::new("config", document, report).with_warnings(notes))
}

/// The settings in force.
pub(super) fn report(config: &Config, progress: ProgressMode) -> ConfigReport {
    let settings = SETTINGS.iter().map(|setting| {
        let value = config.value(setting.name);
        let option = (setting.name == "progress").then(|| progress_word(progress));
        in_force(setting, value, option.flatten())
    });
    ConfigReport {
        settings: settings.collect(),
        files: config.files.clone(),
        ignored: config.ignored,
    }
}

fn in_force(
    setting: &ConfigSetting,
    value: Option<&SetValue>,
    option: Option<&str>,
) -> SettingReport {
    let (value, origin, place) = match (option, value) {
        (Some(word), _) => (Some(word.to_owned()), SettingOrigin::Option, None),
        (None, Some(set)) => (Some(set.value.clone()), set.origin, Some(set.place.clone())),
        (None, None) => {
            let default = setting.default.map(str::to_owned);
            (default, SettingOrigin::Default, None)
        }
    };
    SettingReport {
        name: setting.name.to_owned(),
        value,
        origin,
        place,
        variable: setting.variable(),
        purpose: setting.purpose.to_owned(),
    }
}

/// What the command line says of progress; `None` if nothing.
fn progress_word(mode: ProgressMode) -> Option<&'static str> {
    match mode {
        ProgressMode::Auto => None,
        ProgressMode::Bar => Some("bar"),
        ProgressMode::Text => Some("text"),
        ProgressMode::None => Some("none"),
    }
}

/// A command line with what the configuration adds to it.
#[derive(Debug, Default)]
pub(super) struct Settled {
    /// The words, the first is the program's name.
    pub(super) arguments: Vec<OsString>,
    /// What the user should know of the settings among them.
    pub(super) notes: Vec<String>,
}

/// A command line with the options that the configuration adds, and a note for each that a result does not print itself.
///
/// # Errors
/// For a configuration that cannot be read, of commands that it could change.
pub(super) fn with_settings(
    arguments: Vec<OsString>,
    tree: &Command,
) -> Result<Settled, ConfigError> {
    let mut notes = Vec::new();
    let is_ignored = arguments.iter().any(|word| word == NO_CONFIG);
    if !is_ignored {
        notes.extend(unknown_variables());
    }
    let (words, at) = command_words(&arguments, tree);
    let is_unchanged = words
        .first()
        .is_none_or(|first| UNCHANGED.contains(&first.as_str()));
    let (Some(command), Some(last), false) = (find(tree, &words), at.last(), is_unchanged) else {
        return Ok(Settled { arguments, notes });
    };
    let config = Config::load(is_ignored)?;
    let mut added = Vec::new();
    for setting in &SETTINGS {
        let Some(set) = config.value(setting.name) else {
            continue;
        };
        if !has_option(command, tree, setting.option) || is_given(&arguments, setting.option) {
            continue;
        }
        added.push(OsString::from(format!("--{}", setting.option)));
        added.push(set.value.clone().into());
        match setting.name {
            // It stands in the inputs of the result where it is used.
            "robot" => added.push(set.place.clone().into()),
            "progress" => {}
            name => notes.push(format!("{name} {} from {}", set.value, set.place)),
        }
    }
    let mut all = arguments;
    let behind = last + 1;
    all.splice(behind..behind, added);
    Ok(Settled {
        arguments: all,
        notes,
    })
}

/// The words that name the command, and where they stand.
fn command_words(arguments: &[OsString], tree: &Command) -> (Vec<String>, Vec<usize>) {
    let (mut words, mut at) = (Vec::<String>::new(), Vec::new());
    let mut now = tree;
    let mut place = 1;
    while let Some(word) = arguments.get(place).and_then(|word| word.to_str()) {
        if word.starts_with('-') {
            let (name, value) = word
                .split_once('=')
                .map_or((word, None), |(name, value)| (name, Some(value)));
            // What every command takes may stand before its name.
            let of_all = of_all(tree).find(|argument| match name.strip_prefix("--") {
                Some(long) => argument.get_long() == Some(long),
                None => argument
                    .get_short()
                    .is_some_and(|short| is_repeated(name, short)),
            });
            let Some(of_all) = of_all else {
                break;
            };
            place += usize::from(value.is_none() && of_all.get_action().takes_values());
        } else {
            let Some(below) = now.find_subcommand(word) else {
                break;
            };
            now = below;
            words.push(word.to_owned());
            at.push(place);
        }
        place += 1;
    }
    (words, at)
}

/// The command of these words.
fn find<'a>(tree: &'a Command, words: &[String]) -> Option<&'a Command> {
    let mut words = words.iter();
    words.try_fold(tree, |command, word| command.find_subcommand(word))
}

/// Options that every command takes.
fn of_all(tree: &Command) -> impl Iterator<Item = &Arg> {
    tree.get_arguments()
        .filter(|argument| argument.is_global_set())
}

/// Whether a word is a short option, once or several times, as `-vv`.
fn is_repeated(word: &str, short: char) -> bool {
    let letters = word.trim_start_matches('-');
    !letters.is_empty() && letters.chars().all(|letter| letter == short)
}

/// Whether a command takes an option, of its own or as every command.
fn has_option(command: &Command, tree: &Command, option: &str) -> bool {
    let own = command.get_arguments();
    own.chain(of_all(tree))
        .any(|argument| argument.get_long() == Some(option))
}

/// Whether the user gave an option.
fn is_given(arguments: &[OsString], option: &str) -> bool {
    let words = arguments.iter().filter_map(|word| word.to_str());
    let mut words = words.take_while(|word| *word != "--");
    words.any(|word| {
        let name = word.strip_prefix("--");
        name.is_some_and(|name| name.split('=').next() == Some(option))
    })
}
