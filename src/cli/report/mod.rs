//! `stiffbench report` and `report verify`.

mod args;
mod make;
mod verify;

use std::path::Path;

use jiff::{Timestamp, tz::TimeZone};

use crate::analysis::{ArgumentError, CalibrationCheck, OpenSettings, is_dash, read_text};
use crate::report::page::{
    DETAILS_TEMPLATE, PageAmendment, PageDetails, PageFormat, PageSettings, PageTemplate,
};
use crate::source_text::SourceText;

use super::data_args::DataArgs;
use super::figure_files;
use super::global::today;
use super::{CliError, Failure, Global, Outcome};
use args::ReportCommand;

pub(super) use args::{PageArgs, ReportArgs};
pub(super) use make::write_comparison;

/// Makes a report, or verifies one.
pub(super) fn run(args: &ReportArgs, global: &Global) -> Result<Outcome, Failure> {
    if let Some(ReportCommand::Verify(args)) = &args.command {
        return verify::run(args, global);
    }
    let make = &args.make;
    let format = make.format()?;
    if make.details_template {
        return Ok(printed(DETAILS_TEMPLATE));
    }
    if make.print_template {
        return Ok(printed(&template(None, format)?.text));
    }
    make::run(make, global)
}

/// How the data of a report are opened: an overdue calibration stands on the page.
fn open_settings(reading: &DataArgs, global: &Global) -> Result<OpenSettings, Failure> {
    Ok(OpenSettings {
        calibration: CalibrationCheck::Name(today()),
        ..reading.open_settings(global)?
    })
}

/// A text as the whole output.
fn printed(text: &str) -> Outcome {
    let script = text.to_owned();
    Outcome::new(
        "report-text",
        text.to_owned(),
        crate::report::page::PrintedText { text: script },
    )
    .without_heading()
}

/// The template that is named, else the one that comes with the program.
fn template(path: Option<&Path>, format: PageFormat) -> Result<PageTemplate, Failure> {
    let Some(path) = path else {
        return Ok(format.template());
    };
    Ok(PageTemplate {
        name: path.display().to_string(),
        text: read_text(path)?,
        format,
    })
}

impl PageArgs {
    /// The options of every report in the settings of one.
    fn into_settings(self, mut settings: PageSettings) -> Result<PageSettings, Failure> {
        for path in &self.details {
            let source = SourceText::new(path.display().to_string(), read_text(path)?);
            settings.details = settings.details.with(PageDetails::parse(&source)?);
        }
        let issued = self.issued.map(|day| day.to_string());
        settings.issued = match issued {
            Some(day) => Some(day),
            None => source_date()?,
        };
        settings.amends = self
            .amends
            .zip(self.reason)
            .map(|(number, reason)| PageAmendment { number, reason });
        Ok(settings)
    }
}

/// The day of `SOURCE_DATE_EPOCH`, if it is set.
fn source_date() -> Result<Option<String>, ArgumentError> {
    let Ok(text) = std::env::var("SOURCE_DATE_EPOCH") else {
        return Ok(None);
    };
    let seconds = text.trim().parse().ok();
    let time = seconds.and_then(|seconds| Timestamp::from_second(seconds).ok());
    let Some(time) = time else {
        return Err(ArgumentError::new(
            format!("SOURCE_DATE_EPOCH {text}"),
            "it is not a number of seconds since 1970",
            "unset it, or name the day of issue with --issued",
        ));
    };
    Ok(Some(time.to_zoned(TimeZone::UTC).date().to_string()))
}

/// Writes a new file, and makes its folder if there is none.
///
/// # Errors
/// For a file that exists or cannot be written.
fn write_new(path: &Path, text: &str) -> Result<(), CliError> {
    if is_dash(path) {
        return Err(CliError::Dash);
    }
    let folder = path.parent();
    if let Some(folder) = folder.filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
    }
    figure_files::write_new(path, text)
}
