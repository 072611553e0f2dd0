//! What older names of commands and options are now called, and names that are kept for commands to come.
//!
//! The one place where an older name is known: the words of the command line are put into today's names before clap sees them, and one
//! line a name on standard error states it.

use std::ffi::OsString;

use clap::Command;

use super::failure::{CliError, Failure};

/// A command that has another name now.
#[derive(Debug, Clone, Copy)]
pub struct RenamedCommand {
    /// Its older words after `stiffbench`.
    pub old: &'static str,
    /// Its words now; some commands are now an option of another.
    pub now: &'static str,
}

/// An option that has another name now.
#[derive(Debug, Clone, Copy)]
pub struct RenamedOption {
    /// The command, by the name it has now.
    pub command: &'static str,
    /// The older name.
    pub old: &'static str,
    /// The name now; without dashes: its value is an argument.
    pub now: &'static str,
}

/// A name that is kept for a command to come.
#[derive(Debug, Clone, Copy)]
pub struct Reserved {
    /// Its words after `stiffbench`.
    pub command: &'static str,
    /// What it will do.
    pub purpose: &'static str,
    /// What does that, or most of it, today.
    pub today: &'static str,
}

const fn command(old: &'static str, now: &'static str) -> RenamedCommand {
    RenamedCommand { old, now }
}

const fn option(command: &'static str, old: &'static str, now: &'static str) -> RenamedOption {
    RenamedOption { command, old, now }
}

/// Commands that have another name now.
pub const RENAMED_COMMANDS: &[RenamedCommand] = &[
    command("emulate", "instrument emulate"),
    command("instrument schema", "instrument show --schema"),
    command("robot mobility", "robot show --mobility"),
    command("robot schema", "robot show --schema"),
];

/// Options that have another name now.
pub const RENAMED_OPTIONS: &[RenamedOption] = &[
    option("instrument emulate", "--force", "--force-instrument"),
    option(
        "instrument emulate",
        "--displacement",
        "--displacement-instrument",
    ),
    option("map", "--poses", "--samples"),
    option("map", "--mechanism", "--mechanisms"),
    option("map", "--direction", "--directions"),
    option("map", "--design", "--sensitivity"),
    option("map", "--figures", "--with-figures"),
    option("map merge", "--figures", "--with-figures"),
    option("plot", "--data", "DATA"),
    option("plot", "--force", "--load"),
    option("plot", "--poses", "--samples"),
    option("robot compliance", "--robot", "ROBOT"),
    option("robot compliance", "--force", "--load"),
    option("robot workspace", "--poses", "--samples"),
    option("session resume", "--answers", "--answer-file"),
    option("session run", "--answers", "--answer-file"),
    option("session run", "--instruments", "--instrument-records"),
    option("simulate", "--noise", "--noise-distribution"),
];

/// Options whose two numbers, `LOW HIGH`, are one value now, `LOW..HIGH`: command and option.
const RANGES: &[(&str, &str)] = &[("fit", "--bounds")];

/// Names that are kept for commands to come.
pub const RESERVED: &[Reserved] = &[Reserved {
    command: "procedure",
    purpose: "lists, shows and checks procedures",
    today: "stiffbench session plan --procedure NAME|FILE",
}];

/// Options of every command that may stand before its name.
const LEADING: &[&str] = &[
    "--json",
    "--strict",
    "--trust-csv",
    "--quiet",
    "-q",
    "--no-config",
    "--verbose",
    "-v",
    "-vv",
];

/// Those of them that take a value.
const LEADING_WITH_VALUE: [&str; 2] = ["--progress", "--color"];

/// The command that tells of the one named after it.
const HELP: &str = "help";

/// A command line in today's names.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Settled {
    /// The words, the first is the program's name.
    pub(super) arguments: Vec<OsString>,
    /// What the user should know of the older names among them.
    pub(super) notes: Vec<String>,
}

/// A command line in today's names.
///
/// # Errors
/// If the command is one to come.
pub(super) fn replace_older_names(
    arguments: &[OsString],
    tree: &Command,
) -> Result<Settled, Failure> {
    let (mut words, at) = command_words(arguments, tree);
    let mut notes = Vec::new();
    if let Some(reserved) = longest(RESERVED, &words, |row| row.command) {
        return Err(CliError::Planned {
            command: reserved.command,
            purpose: reserved.purpose,
            today: format!("today: {}", reserved.today),
        }
        .into());
    }
    let mut inserted: Vec<OsString> = words.iter().map(Into::into).collect();
    if let Some(renamed) = longest(RENAMED_COMMANDS, &words, |row| row.old) {
        notes.push(format!(
            "stiffbench {} is now called stiffbench {}",
            renamed.old, renamed.now
        ));
        inserted = renamed.now.split(' ').map(OsString::from).collect();
        if arguments.get(1).is_some_and(|word| word == HELP) {
            inserted.retain(|word| !word.to_string_lossy().starts_with('-'));
        }
        let plain = renamed.now.split(' ').filter(|word| !word.starts_with('-'));
        words = plain.map(str::to_owned).collect();
    }
    let first = at.first().copied().unwrap_or(arguments.len());
    let end = at.last().map_or(arguments.len(), |last| last + 1);
    let mut settled: Vec<OsString> = arguments[..first].to_vec();
    let between = (first..end).filter(|place| !at.contains(place));
    settled.extend(between.map(|place| arguments[place].clone()));
    settled.extend(inserted);
    settled.extend(options(&words.join(" "), &arguments[end..], &mut notes));
    Ok(Settled {
        arguments: settled,
        notes,
    })
}

/// The row with the most words that begin a command line.
fn longest<'a, T>(rows: &'a [T], words: &[String], name: impl Fn(&T) -> &str) -> Option<&'a T> {
    let words = words.join(" ") + " ";
    let begun = rows
        .iter()
        .filter(|row| words.starts_with(&format!("{} ", name(row))));
    begun.max_by_key(|row| name(row).len())
}

/// The words that name the command, and where they stand.
pub(super) fn command_words(arguments: &[OsString], tree: &Command) -> (Vec<String>, Vec<usize>) {
    let (mut words, mut at) = (Vec::<String>::new(), Vec::new());
    let mut now = Some(tree);
    let mut place = 1;
    while let Some(word) = arguments.get(place).and_then(|word| word.to_str()) {
        if LEADING_WITH_VALUE.contains(&word) {
            place += 1;
        } else if word.starts_with('-') {
            let name = word.split('=').next().unwrap_or(word);
            let of_all = LEADING.contains(&word) || LEADING_WITH_VALUE.contains(&name);
            if !of_all {
                break;
            }
        } else if !(place == 1 && word == HELP) {
            let below = now.and_then(|tree| tree.find_subcommand(word));
            let mut longer = words.clone();
            longer.push(word.to_owned());
            if below.is_none() && !is_older_or_reserved(&longer) {
                break;
            }
            (now, words) = (below, longer);
            at.push(place);
        }
        place += 1;
    }
    (words, at)
}

/// Whether these words begin the name of a command that is not in the tree.
fn is_older_or_reserved(words: &[String]) -> bool {
    let words = words.join(" ");
    let older = RENAMED_COMMANDS.iter().map(|row| row.old);
    let mut names = older.chain(RESERVED.iter().map(|row| row.command));
    names.any(|name| name == words)
}

/// Whether both words are numbers.
fn are_numbers(words: &[OsString; 2]) -> bool {
    let is_number = |word: &OsString| {
        word.to_str()
            .is_some_and(|text| text.parse::<f64>().is_ok())
    };
    words.iter().all(is_number)
}

/// The words after the command with today's names of options; values that are arguments now come last.
fn options(command: &str, words: &[OsString], notes: &mut Vec<String>) -> Vec<OsString> {
    let rows = RENAMED_OPTIONS.iter().filter(|row| row.command == command);
    let rows: Vec<&RenamedOption> = rows.collect();
    let (mut kept, mut last) = (Vec::new(), Vec::new());
    let mut words = words.iter();
    let mut ended = false;
    while let Some(word) = words.next() {
        ended |= word == "--";
        let text = word.to_str().unwrap_or_default();
        let (name, value) = text
            .split_once('=')
            .map_or((text, None), |(name, value)| (name, Some(value)));
        let Some(row) = rows.iter().find(|row| !ended && row.old == name) else {
            let rest = words.as_slice();
            match rest.first_chunk().filter(|_| !ended && value.is_none()) {
                Some(ends) if RANGES.contains(&(command, name)) && are_numbers(ends) => {
                    let [low, high] = ends.each_ref().map(|end| end.to_string_lossy());
                    kept.push(format!("{name}={low}..{high}").into());
                    notes.push(format!("{name} {low} {high} is now {name} {low}..{high}"));
                    words = rest[2..].iter();
                }
                _ => kept.push(word.clone()),
            }
            continue;
        };
        let note = if row.now.starts_with('-') {
            kept.push(value.map_or_else(
                || row.now.into(),
                |value| format!("{}={value}", row.now).into(),
            ));
            format!("{} is now called {}", row.old, row.now)
        } else {
            last.extend(value.map(OsString::from).or_else(|| words.next().cloned()));
            format!("{0} {1} is now the argument {1}", row.old, row.now)
        };
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    if !last.is_empty() && !ended {
        kept.push("--".into());
    }
    kept.append(&mut last);
    kept
}
