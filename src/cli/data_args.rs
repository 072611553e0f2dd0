//! How data are read: columns of other names, calibration of the gauges; options of every analysis.

use std::path::{Path, PathBuf};

use clap::{Args, Parser};

use crate::analysis::{
    ArgumentError, GaugeCalibration, GivenCalibration, OpenSettings, StatedError, read_bytes,
};
use crate::calibration::CalibrationCurve;
use crate::import::ImportMapping;
use crate::quantity::Kind;

use super::import::column_pairs;
use super::session::instrument_records;
use super::{Failure, Global};

/// How data are read.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Calibration of the gauges")]
pub(super) struct DataArgs {
    /// Expanded uncertainty of the force gauge for k = 2, common to all its readings, for example 0.3N; limit=0.3N for limits of error (rectangular distribution)
    #[arg(long, value_name = "U")]
    force_u: Option<String>,
    /// Expanded uncertainty of the displacement gauge for k = 2, for example 3um; limit=3um for limits of error
    #[arg(long, value_name = "U")]
    displacement_u: Option<String>,
    /// Calibration table of the force gauge with the columns applied, indicated, U and k: corrects the forces
    #[arg(long, value_name = "TABLE")]
    force_calibration: Option<PathBuf>,
    /// Calibration table of the displacement gauge: corrects the displacements
    #[arg(long, value_name = "TABLE")]
    displacement_calibration: Option<PathBuf>,
    /// Instrument records in the form of session.toml, instead of the session's
    #[arg(long, value_name = "FILE")]
    instrument_records: Option<PathBuf>,
    /// Columns of a table of another program, WHAT=COLUMN,...: force, displacement, pose, direction, repeat, joint.NAME; of vectors force_x, moment_x, displacement_x, rotation_x, position_x, and along y and z; give a column by name or number
    #[arg(long, value_name = "WHAT=COLUMN", help_heading = "Data")]
    map: Vec<String>,
    /// Pose of all rows of a table of another program, if no column states it
    #[arg(long, help_heading = "Data")]
    pose: Option<String>,
    /// Direction of all rows of a table of another program: x, y, z, or -x for loads counted along the negative axis
    #[arg(long, help_heading = "Data", allow_hyphen_values = true)]
    direction: Option<String>,
}

/// These options alone, as a report records them.
#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
struct RecordedOptions {
    #[command(flatten)]
    options: DataArgs,
}

impl DataArgs {
    /// The options as they are typed: names and values in turn.
    pub(super) fn words(&self) -> Vec<String> {
        let path = |path: &Option<PathBuf>| path.as_ref().map(|path| path.display().to_string());
        let options = [
            ("--force-u", self.force_u.clone()),
            ("--displacement-u", self.displacement_u.clone()),
            ("--force-calibration", path(&self.force_calibration)),
            (
                "--displacement-calibration",
                path(&self.displacement_calibration),
            ),
            ("--instrument-records", path(&self.instrument_records)),
            ("--pose", self.pose.clone()),
            ("--direction", self.direction.clone()),
        ];
        let map = self.map.iter().map(|map| ("--map", Some(map.clone())));
        let given = options
            .into_iter()
            .chain(map)
            .filter_map(|(name, value)| Some([name.to_owned(), value?]));
        given.flatten().collect()
    }

    /// The options from their words.
    pub(super) fn of_words(words: &[String]) -> Result<Self, ArgumentError> {
        let parsed = RecordedOptions::try_parse_from(words);
        parsed.map(|recorded| recorded.options).map_err(|error| {
            ArgumentError::new(
                "the options that the report records",
                error.to_string(),
                "make the report anew",
            )
        })
    }

    /// How data are opened, with what is known of the gauges.
    pub(super) fn open_settings(&self, global: &Global) -> Result<OpenSettings, Failure> {
        let mut columns = ImportMapping {
            pose: self.pose.clone(),
            direction: self.direction.clone(),
            ..ImportMapping::default()
        };
        for (role, column) in column_pairs(&self.map)? {
            columns.set(&role, &column)?;
        }
        Ok(OpenSettings {
            gauges: self.given()?,
            columns,
            ..global.open_settings()
        })
    }

    /// What is given, with files read.
    fn given(&self) -> Result<GivenCalibration, Failure> {
        let records = self.instrument_records.as_deref();
        let (instruments, _) = instrument_records(records)?;
        Ok(GivenCalibration {
            force: gauge(
                ("--force-u", self.force_u.as_deref()),
                ("--force-calibration", self.force_calibration.as_deref()),
                Kind::Force,
            )?,
            displacement: gauge(
                ("--displacement-u", self.displacement_u.as_deref()),
                (
                    "--displacement-calibration",
                    self.displacement_calibration.as_deref(),
                ),
                Kind::Displacement,
            )?,
            records: records.map(|path| (instruments, path.display().to_string())),
        })
    }
}

fn gauge(
    (u_option, u): (&str, Option<&str>),
    (table_option, table): (&str, Option<&Path>),
    kind: Kind,
) -> Result<GaugeCalibration, Failure> {
    let error = u
        .map(|text| stated_error(u_option, text, kind))
        .transpose()?;
    let curve = table.map(|path| -> Result<_, Failure> {
        let name = path.display().to_string();
        let curve = CalibrationCurve::read(&name, &read_bytes(path)?, kind)?;
        Ok((curve, format!("{table_option} {name}")))
    });
    Ok(GaugeCalibration {
        error: error.map(|error| (error, format!("{u_option} {}", u.unwrap_or_default()))),
        curve: curve.transpose()?,
    })
}

/// `0.3N`, or `limit=0.3N`: half the width of a rectangle.
fn stated_error(option: &str, text: &str, kind: Kind) -> Result<StatedError, ArgumentError> {
    let example = if kind == Kind::Force { "0.3N" } else { "3um" };
    let refused = |problem: &str| {
        ArgumentError::new(
            format!("{option} {text}"),
            problem,
            format!("{option} {example}, or {option} limit={example}"),
        )
    };
    let (stated, value): (fn(f64) -> StatedError, &str) = match text.strip_prefix("limit=") {
        Some(value) => (StatedError::LimitsOfError, value),
        None => (StatedError::Expanded, text),
    };
    let end = value
        .rfind(|c: char| c.is_ascii_digit())
        .map_or(0, |place| place + 1);
    let (number, unit) = value.split_at(end);
    let number: f64 = number
        .trim()
        .parse()
        .map_err(|_| refused("not a number with a unit"))?;
    let factor = kind.si_factor(unit.trim());
    let factor =
        factor.ok_or_else(|| refused(&format!("the unit must be one of {}", kind.units())))?;
    if !(number.is_finite() && number >= 0.0) {
        return Err(refused("an uncertainty is not below zero"));
    }
    Ok(stated(number * factor))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uncertainties_have_units() {
        let of = |text, kind| stated_error("--u", text, kind);
        assert_eq!(of("0.3N", Kind::Force).unwrap(), StatedError::Expanded(0.3));
        let StatedError::Expanded(three_um) = of("3 um", Kind::Displacement).unwrap() else {
            panic!("no limits are stated");
        };
        assert!((three_um - 3e-6).abs() < 1e-18);
        assert_eq!(
            of("limit=3N", Kind::Force).unwrap(),
            StatedError::LimitsOfError(3.0)
        );
        for text in ["0.3", "N", "-1N", "0.3mm", "", "limit="] {
            assert!(of(text, Kind::Force).is_err(), "{text}");
        }
    }
}
