//! `stiffbench part predict`: what the model of a part predicts for a table.

use std::path::PathBuf;

use clap::Args;

use crate::analysis::{
    Inputs, PartModelFile, check_predictable, is_dash, read_bytes, read_text, sha256, shown,
};
use crate::readings::TableError;
use crate::report::PredictionReport;
use crate::specimen::read_specimen;

use super::figure_files::write_again;
use super::{Failure, Outcome};

/// Arguments of `part predict`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench part diagnose ramps.csv --map force=torque_Nm,displacement=angle_mrad --out ramps\n  stiffbench part predict ramps/model.toml other-ramps.csv\n  stiffbench part predict ramps/model.toml planned.csv --out predicted.csv\n\nThe table needs the columns of the diagnosed table; the column of measured values may be absent. Runs may differ from those of the\nfit, configurations may not. Laws with memory follow the readings of a run in their order."
)]
pub(super) struct PredictArgs {
    /// Model of a part: the model.toml of `part diagnose --out`
    model: PathBuf,
    /// Table of set values to predict readings for
    #[arg(value_name = "TABLE")]
    input: PathBuf,
    /// Write a CSV file with a row for each reading: predicted, ends of the band, measured; - for standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Predicts, and compares where the table holds the answers.
pub(super) fn run(args: &PredictArgs) -> Result<Outcome, Failure> {
    let file = args.model.display().to_string();
    let text = read_text(&args.model)?;
    let stored = PartModelFile::parse(&file, &text)?;
    let model = stored.model(&file)?;
    let bytes = read_bytes(&args.input)?;
    let name = shown(&args.input);
    let mut columns = stored.columns.clone();
    columns.is_response_optional = true;
    let table = read_specimen(&[(&name, bytes.as_slice())], &columns).map_err(of_predictions)?;
    check_predictable(&model, &table, &name)?;
    let predicted = model.predict(&table)?;
    let report = PredictionReport::new(&model, &table, &predicted);
    let csv = match &args.out {
        Some(out) if is_dash(out) => Some(report.csv()),
        Some(out) => {
            write_again(out, report.csv().as_bytes())?;
            None
        }
        None => None,
    };
    let inputs = Inputs::default()
        .with_list(&file, &sha256(&text))
        .with_list(&name, &sha256(&bytes));
    let notes = table.assumptions.iter().cloned();
    let text = report.document();
    Ok(Outcome::new("prediction", text, report)
        .with_inputs(inputs)
        .with_warnings(notes)
        .with_file(csv))
}

/// The columns are those of the model, which no option of this command states.
fn of_predictions(error: TableError) -> TableError {
    let [column] = &error.missing[..] else {
        return error;
    };
    let help = format!(
        "add the column `{column}`: the table has the columns of the diagnosed one, but for the measured values"
    );
    error.with_help(help)
}
