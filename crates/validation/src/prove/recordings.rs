//! Recordings by others, with the answers that are known for them.

use std::collections::BTreeMap;

use serde::Deserialize;

use stiffbench_measurement::specimen::SpecimenOptions;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::read_types;

use super::error::ProveError;
use super::recording_table::{ChosenRows, ComputedColumn};

const SCHEMA: &str = "stiffbench/recordings/1";

/// `recordings.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recordings {
    schema: String,
    /// The recordings.
    pub recording: Vec<Recording>,
}

/// A recording with its right answer.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Recording {
    /// Its name.
    pub name: String,
    /// Its files, below the folder that holds recordings; tables with the same columns, read as one.
    pub files: Vec<RecordingFile>,
    /// Name of a column that numbers the files from 1, if one is to be added.
    pub file_column: Option<String>,
    /// The rows that belong to it; `None` for all.
    pub rows: Option<ChosenRows>,
    /// A column to be computed.
    pub computed: Option<ComputedColumn>,
    /// Where the measurements come from, and what was changed.
    pub source: String,
    /// Its licence.
    pub licence: String,
    /// Readings it has.
    pub readings: Option<usize>,
    /// Runs it has.
    pub runs: Option<usize>,
    /// The right verdict.
    pub verdict: String,
    /// Verdicts that are right too, and laws that may stand beside those of `physics`.
    pub also_right: Vec<String>,
    /// Laws one of which must lead the headline.
    pub physics: Vec<String>,
    /// Laws that are right as members of a set that holds one of `physics`, and false alone.
    #[serde(default)]
    pub only_in_sets: Vec<String>,
    /// Laws that would be false names.
    pub not: Vec<String>,
    /// Why.
    pub why: String,
    /// Residual standard deviation of one straight line through all readings.
    pub line_residual_sd: Option<f64>,
    /// How its columns are read; `None` where it is no table of force against displacement.
    pub specimen: Option<SpecimenOptions>,
    /// Known figures.
    pub figures: BTreeMap<String, f64>,
}

/// A file of a recording.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordingFile {
    /// Path below the folder.
    pub path: String,
    /// SHA-256 of the file that the answer was computed for, in hexadecimal.
    pub sha256: String,
}

impl Recordings {
    /// Reads the list.
    ///
    /// # Errors
    /// [`ProveError::Form`].
    pub fn parse(file: &str, text: &str) -> Result<Self, ProveError> {
        let found: Self = read_types(&SourceText::new(file, text))?;
        if found.schema != SCHEMA {
            return Err(ProveError::Form {
                file: file.to_owned(),
                problem: format!("its schema is {}", found.schema),
            });
        }
        Ok(found)
    }
}
