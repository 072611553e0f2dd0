//! Recordings by others, with the answers that are known for them.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_diagnosis::mismatch::{
    Diagnosis, MismatchError, SearchOptions, Verdict, diagnose, laws_that_need_a_robot,
    specimen_bench,
};
use stiffbench_measurement::specimen::{SpecimenOptions, SpecimenTable};
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::read_types;

use super::answer_text::diagnosis_words;
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

/// A recording and what was said of it.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingScore {
    /// Its name.
    pub name: String,
    /// Readings.
    pub readings: usize,
    /// What is right, and what is too.
    pub expected: Vec<String>,
    /// What was said.
    pub verdict: String,
    /// The same in words.
    pub words: String,
    /// Whether the verdict is one of the right ones.
    pub verdict_is_right: bool,
    /// Laws that were named and would be false names.
    pub false_names: Vec<String>,
    /// Why that is the right answer.
    pub why: String,
    /// Known figures beside ours, where ours has the same meaning.
    pub figures: Vec<ComparedFigure>,
}

/// A known figure and ours.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ComparedFigure {
    /// What it is.
    pub name: String,
    /// As known.
    pub known: Option<f64>,
    /// Ours.
    pub ours: Option<f64>,
}

impl RecordingScore {
    /// Whether all is right.
    #[must_use]
    pub fn is_right(&self) -> bool {
        self.verdict_is_right && self.false_names.is_empty()
    }
}

/// Diagnoses a table without a robot and holds the verdict against the known answer.
///
/// # Errors
/// [`ProveError::Mismatch`].
pub fn score_recording(
    recording: &Recording,
    table: &SpecimenTable,
    seed: u64,
) -> Result<RecordingScore, ProveError> {
    let (observations, baseline, scale) = specimen_bench(table)?;
    let options = SearchOptions {
        without: laws_that_need_a_robot(),
        seed,
        ..SearchOptions::default()
    };
    let readings = table.readings.len();
    let diagnosis = match diagnose(&baseline, &observations, &options, None) {
        Ok((diagnosis, _)) => diagnosis,
        Err(error) => return Ok(failed(recording, readings, &error)),
    };
    // Each gauge zero and each slope was fitted.
    let count = table.readings.len() as f64;
    let fitted = (table.runs.len() + table.configurations.len()) as f64;
    let spread = scale.answer * (count / (count - fitted).max(1.0)).sqrt();
    let with_effects: usize = diagnosis.effects.iter().map(|e| e.values.len()).sum();
    let spread_after =
        scale.answer * (count / (count - fitted - with_effects as f64).max(1.0)).sqrt();
    let mut figures = vec![
        ComparedFigure {
            name: "residual sd of a line (ours: a zero for each run)".to_owned(),
            known: recording.line_residual_sd,
            ours: Some(spread * diagnosis.before.rms_m),
        },
        ComparedFigure {
            name: format!(
                "residual sd of the answer ({})",
                answer_figure(recording).map_or("none known", |(name, _)| name)
            ),
            known: answer_figure(recording).map(|(_, value)| value),
            ours: Some(spread_after * diagnosis.after.rms_m),
        },
    ];
    figures.retain(|figure| figure.known.is_some() || figure.ours.is_some());
    Ok(assess(recording, readings, &diagnosis, figures))
}

/// The known residual standard deviation of the best model that the recording's answer knows.
fn answer_figure(recording: &Recording) -> Option<(&str, f64)> {
    recording
        .figures
        .iter()
        .filter(|(name, _)| name.contains("residual-sd"))
        .map(|(name, value)| (name.as_str(), *value))
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The score of a recording without a diagnosis.
fn failed(recording: &Recording, readings: usize, error: &MismatchError) -> RecordingScore {
    RecordingScore {
        name: recording.name.clone(),
        readings,
        expected: vec![recording.verdict.clone()],
        verdict: "no diagnosis".to_owned(),
        words: error.to_string(),
        verdict_is_right: false,
        false_names: Vec::new(),
        why: recording.why.clone(),
        figures: Vec::new(),
    }
}

/// Holds a diagnosis against the known answer.
#[must_use]
pub fn assess(
    recording: &Recording,
    readings: usize,
    diagnosis: &Diagnosis,
    figures: Vec<ComparedFigure>,
) -> RecordingScore {
    let said = diagnosis.verdict.to_string();
    let mut expected = vec![recording.verdict.clone()];
    expected.extend(recording.also_right.iter().cloned());
    let mut false_names: Vec<String> = Vec::new();
    for finding in &diagnosis.findings {
        let name = finding.effect.law.name;
        let listed = |names: &[String]| names.iter().any(|known| known == name);
        // With the verdict unknown, what explains a part may be any law that is not excluded.
        let whole = diagnosis.verdict != Verdict::Unknown;
        let is_false = listed(&recording.not) || (whole && !listed(&recording.physics));
        if is_false && !false_names.iter().any(|known| known == name) {
            false_names.push(name.to_owned());
        }
    }
    RecordingScore {
        name: recording.name.clone(),
        readings,
        verdict_is_right: expected.contains(&said),
        expected,
        verdict: said,
        words: diagnosis_words(diagnosis),
        false_names,
        why: recording.why.clone(),
        figures,
    }
}
