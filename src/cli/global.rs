//! The options of every subcommand.

use clap::{ArgAction, Args, ColorChoice, ValueEnum};
use jiff::civil::Date;
use jiff::{Timestamp, tz::TimeZone};

use crate::analysis::{CalibrationCheck, GivenCalibration, OpenSettings};

/// Options of every subcommand.
#[expect(clippy::struct_excessive_bools, reason = "one switch a flag")]
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Output")]
pub struct Global {
    /// One JSON object on standard output instead of text, also on failure
    #[arg(long, global = true)]
    pub json: bool,
    /// Findings (flags, missing physics, factors that the data do not determine, overdue calibration) make the exit code other than 0
    #[arg(long, global = true)]
    pub strict: bool,
    /// Use the readings.csv of a session folder though it differs from the journal; every result states it
    #[arg(long, global = true)]
    pub trust_csv: bool,
    /// Use neither configuration files nor STIFFBENCH_ variables
    #[arg(long, global = true)]
    pub no_config: bool,
    /// Never wait for an answer: a question without one is an error that names the option which would have answered it
    #[arg(long, global = true)]
    pub no_input: bool,
    /// Print the log of a session on standard error too; -vv: with every reading
    #[arg(long, short, global = true, action = ArgAction::Count)]
    pub verbose: u8,
    /// No notes and no progress on standard error
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Colour of help, errors and the view of a session; auto: on a terminal, as NO_COLOR and CLICOLOR_FORCE say
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t = ColorChoice::Auto)]
    pub color: ColorChoice,
    /// Progress on standard error
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
            gauge_log: None,
            gauges: GivenCalibration::default(),
        }
    }
}

/// The day it is now, UTC.
pub(super) fn today() -> Date {
    Timestamp::now().to_zoned(TimeZone::UTC).date()
}

/// How progress is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ProgressMode {
    /// A bar on a terminal, lines otherwise, nothing with --json
    Auto,
    /// A bar
    Bar,
    /// One line for each cell, stage or tenth of a long job
    Text,
    /// Nothing
    None,
}
