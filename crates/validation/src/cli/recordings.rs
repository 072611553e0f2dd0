//! `stiffbench-validate recordings`.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use stiffbench::analysis::{ArgumentError, ReadError, read_text, sha256};
use stiffbench::cli::args::Global;
use stiffbench::cli::failure::Failure;
use stiffbench::cli::outcome::Outcome;
use stiffbench::cli::progress::progress;
use stiffbench::mismatch::MOST_READINGS_OF_A_PART;
use stiffbench::specimen::read_specimen;

use crate::prove::{Recording, RecordingScore, Recordings, score_pose_errors, score_recording};
use crate::report::{RecordingTotals, RecordingVerdict, RecordingsReport, recordings_text};

use super::error::ValidationError;

/// What is known of the recordings.
const KNOWN: &str = include_str!("../../../../data/recordings/recordings.toml");

/// Arguments of `recordings`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench-validate recordings --from my-recordings\n  stiffbench-validate recordings --from my-recordings --only nist --json\n\nFiles, sources and known answers: data/recordings/recordings.toml. With --strict a wrong verdict makes the exit code 1."
)]
pub(crate) struct RecordingsArgs {
    /// Folder that holds the recordings
    #[arg(long, value_name = "FOLDER")]
    from: PathBuf,
    /// Only recordings whose name contains this
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// Diagnoses the recordings that are there and compares the verdicts with the known answers.
pub(crate) fn run(args: &RecordingsArgs, global: &Global) -> Result<Outcome, Failure> {
    let known = Recordings::parse("recordings.toml", KNOWN)?;
    let asked = |recording: &&Recording| {
        let part = args.only.as_deref().unwrap_or("");
        recording.name.contains(part)
    };
    let asked: Vec<&Recording> = known.recording.iter().filter(asked).collect();
    let bar = progress(global, "recordings", asked.len() as u64);
    let (mut scores, mut absent, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
    for recording in asked {
        match texts(recording, &args.from, &mut warnings)? {
            Some(texts) => {
                let began = Instant::now();
                let score = scored(recording, &texts, args.seed)?;
                scores.push(RecordingVerdict {
                    is_right: score.is_right(),
                    seconds: began.elapsed().as_secs_f64(),
                    score,
                });
            }
            None => absent.push(recording),
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    if scores.is_empty() {
        let folder = args.from.clone();
        return Err(ValidationError::NoRecordings { folder }.into());
    }
    let mut text = recordings_text(&scores);
    for recording in &absent {
        let _ = writeln!(
            text,
            "- {} is not there: {}",
            recording.name, recording.source
        );
    }
    let wrong = scores.iter().any(|one| !one.is_right);
    let data = RecordingsReport {
        folder: args.from.clone(),
        seed: args.seed,
        totals: RecordingTotals::new(&scores),
        recordings: scores,
        absent: absent
            .into_iter()
            .map(|recording| recording.name.clone())
            .collect(),
    };
    Ok(Outcome::new("recordings", text, data)
        .with_warnings(warnings)
        .with_strict_exit(u8::from(wrong)))
}

/// The texts of a recording's files; `None` if one is not there.
fn texts(
    recording: &Recording,
    folder: &Path,
    warnings: &mut Vec<String>,
) -> Result<Option<Vec<String>>, ReadError> {
    let mut texts = Vec::new();
    for file in &recording.files {
        let path = folder.join(&file.path);
        if !path.is_file() {
            return Ok(None);
        }
        let text = read_text(&path)?;
        if sha256(&text) != file.sha256 {
            warnings.push(format!(
                "{} is not the file that the answer was computed for: its SHA-256 differs",
                path.display()
            ));
        }
        texts.push(text);
    }
    Ok(Some(texts))
}

/// The score of a recording.
fn scored(recording: &Recording, texts: &[String], seed: u64) -> Result<RecordingScore, Failure> {
    let Some(options) = &recording.specimen else {
        // Columns to regress on, and the poses they were made from.
        let [columns, poses] = texts else {
            return Err(ArgumentError {
                argument: recording.name.clone(),
                problem: "poses need two files: regressors and angles".to_owned(),
                help: None,
            }
            .into());
        };
        return Ok(score_pose_errors(recording, columns, poses, seed)?);
    };
    let joined = recording.table(texts)?;
    let table = read_specimen(&[(&recording.name, joined.as_bytes())], options)?;
    let table = table.thinned(MOST_READINGS_OF_A_PART);
    score_recording(recording, &table, seed)
}
