//! The options of every subcommand.

use clap::{ArgAction, Args, ColorChoice, ValueEnum};
use jiff::civil::Date;
use jiff::{Timestamp, tz::TimeZone};

use crate::analysis::{CalibrationCheck, OpenSettings};

/// Options of every subcommand.
#[expect(clippy::struct_excessive_bools, reason = "one switch a flag")]
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Output")]
pub struct Global {
    /// Print one JSON object on standard output instead of text, also on failure
    #[arg(long, global = true)]
    pub json: bool,
    /// Exit with a code other than 0 on findings: flags, missing physics, factors that the data do not determine, overdue calibration
    #[arg(long, global = true)]
    pub strict: bool,
    /// Use the readings.csv of a session folder even if it differs from the journal; every result states it
    #[arg(long, global = true)]
    pub trust_csv: bool,
    /// Ignore configuration files and STIFFBENCH_ variables
    #[arg(long, global = true)]
    pub no_config: bool,
    /// Never wait for an answer: an unanswered question is an error that names the option to answer it
    #[arg(long, global = true)]
    pub no_input: bool,
    /// Also print the session log on standard error; -vv adds every reading
    #[arg(long, short, global = true, action = ArgAction::Count)]
    pub verbose: u8,
    /// Print no notes and no progress on standard error
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// When to colour help, errors and the session screen; auto: on a terminal, unless NO_COLOR or CLICOLOR_FORCE is set
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t = ColorChoice::Auto)]
    pub color: ColorChoice,
    /// How to show progress on standard error
    #[arg(long, global = true, value_enum, default_value_t = ProgressMode::Auto)]
    pub progress: ProgressMode,
}

impl Global {
    /// How data are opened: an overdue calibration is a warning, under `--strict` an error.
    pub(super) fn open_settings(&self) -> OpenSettings {
        OpenSettings {
            trust_csv: self.trust_csv,
            calibration: if self.strict {
                CalibrationCheck::Refuse(today())
            } else {
                CalibrationCheck::Warn(today())
            },
            ..OpenSettings::default()
        }
    }
}

/// The day it is now, UTC.
pub(super) fn today() -> Date {
    Timestamp::now().to_zoned(TimeZone::UTC).date()
}

/// How progress is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum ProgressMode {
    /// A bar on a terminal, lines otherwise, nothing with --json
    #[default]
    Auto,
    /// A bar
    Bar,
    /// One line for each cell, stage or tenth of a long job
    Text,
    /// Nothing
    None,
}
