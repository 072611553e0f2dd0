//! `stiffbench diagnose --specimen`: a table of force against displacement without a robot.

use crate::analysis::{Inputs, PartModelFile, diagnose_part, read_bytes, sha256, shown};
use crate::mismatch::{MOST_READINGS_OF_A_PART, SearchOptions};
use crate::physics::Law;
use crate::specimen::{SpecimenOptions, read_specimen};

use super::args::Global;
use super::diagnose::{DIAGNOSIS_STEPS, data, report_of};
use super::diagnose_args::DiagnoseArgs;
use super::failure::Failure;
use super::outcome::Outcome;
use super::progress::progress;

/// Reads the table and states what a straight line leaves out.
pub(super) fn run(
    args: &DiagnoseArgs,
    options: &SpecimenOptions,
    without: Vec<Law>,
    global: &Global,
) -> Result<Outcome, Failure> {
    let path = data(args)?;
    let bytes = read_bytes(path)?;
    let (name, hash) = (shown(path), sha256(&bytes));
    let inputs = Inputs::default().with_list(&name, &hash);
    let table = read_specimen(&name, bytes.as_slice(), options)?.thinned(MOST_READINGS_OF_A_PART);
    let search = SearchOptions {
        without,
        seed: args.seed,
        ..SearchOptions::default()
    };
    let bar = progress(global, DIAGNOSIS_STEPS, 4);
    let (report, model) = diagnose_part(&name, &table, &search, &|| bar.inc(1))?;
    let verdict = report.diagnosis.verdict.to_string();
    let model = model.map(|model| PartModelFile::new(&model, options, (&name, &hash), verdict));
    let model = |_: &std::path::Path| Ok(model.map(|model| model.to_toml()));
    let outcome = report_of(args, &report, (&inputs, &[]), model)?;
    bar.finish_and_clear();
    Ok(outcome)
}
