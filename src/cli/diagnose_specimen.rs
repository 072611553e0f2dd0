//! `stiffbench diagnose --specimen`: a table of force against displacement without a robot.

use serde_json::json;

use crate::analysis::{Inputs, PartModelFile, read_bytes, sha256, shown};
use crate::mismatch::{Line, MOST_READINGS_OF_A_PART, PartModel, SearchOptions, diagnose};
use crate::physics::Law;
use crate::report::{DiagnosisResult, SpecimenSummary};
use crate::specimen::{SpecimenOptions, read_specimen};

use super::diagnose::{data, outcome, write_diagnosis};
use super::diagnose_args::DiagnoseArgs;
use super::failure::Failure;
use super::figure_files::write_again;
use super::outcome::Outcome;

/// Reads the table and states what a straight line leaves out.
pub(super) fn run(
    args: &DiagnoseArgs,
    options: &SpecimenOptions,
    without: Vec<Law>,
) -> Result<Outcome, Failure> {
    let path = data(args)?;
    let bytes = read_bytes(path)?;
    let name = shown(path);
    let inputs = Inputs::default().with_list(&name, &sha256(&bytes));
    let table = read_specimen(&name, bytes.as_slice(), options)?.thinned(MOST_READINGS_OF_A_PART);
    let (line, observations) = Line::of_table(&table)?;
    let search = SearchOptions {
        without,
        seed: args.seed,
        ..SearchOptions::default()
    };
    let (diagnosis, _) = diagnose(&line, &observations, &search, None)?;
    let summary = SpecimenSummary::new(&table, &diagnosis, args.seed);
    let text = summary.text();
    let data = DiagnosisResult::Specimen(Box::new(summary));
    if let Some(folder) = &args.out {
        write_diagnosis(folder, &text, &inputs, [("data", json!(data))])?;
        let model = PartModel::new(&table, (&line, &observations), &diagnosis)?;
        if let Some(model) = model {
            let verdict = diagnosis.verdict.to_string();
            let file = PartModelFile::new(&model, options, (&name, &sha256(&bytes)), verdict);
            write_again(&folder.join("model.toml"), file.to_toml().as_bytes())?;
        }
    }
    let mut notes: Vec<String> = table.assumptions.iter().map(ToString::to_string).collect();
    let excluded = table.excluded.to_string();
    if !excluded.is_empty() {
        notes.push(excluded);
    }
    Ok(outcome(text, data).with_inputs(inputs).with_warnings(notes))
}
