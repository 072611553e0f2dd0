//! `stiffbench part`: a table of force against displacement without a robot.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use crate::analysis::{Inputs, PartModelFile, diagnose_part, read_bytes, sha256, shown};
use crate::mismatch::{MOST_READINGS_OF_A_PART, SearchOptions};
use crate::specimen::{SpecimenOptions, read_specimen};

use super::diagnose::{DIAGNOSIS_STEPS, ResultFolder, SearchArgs, report_of};
use super::predict::{self, PredictArgs};
use super::progress::progress;
use super::specimen_args::PartTableArgs;
use super::{Failure, Global, Outcome};

/// Arguments of `part`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench part diagnose cell.csv --map force=load,displacement=travel --force-unit kN\n  stiffbench part predict cell/model.toml planned.csv"
)]
pub(super) struct PartArgs {
    /// What to do.
    #[command(subcommand)]
    what: PartCommand,
}

/// Subcommands of `part`.
#[derive(Debug, Subcommand)]
enum PartCommand {
    /// Find what a straight line leaves out: which effect explains it, its size and the evidence
    Diagnose(Box<PartDiagnoseArgs>),
    /// Predict readings from a part model, with an uncertainty band
    Predict(PredictArgs),
}

/// Arguments of `part diagnose`.
#[derive(Debug, Args)]
#[command(
    after_help = "docs/parts.md explains the results.\n\nExamples:\n  stiffbench part diagnose messung.csv\n  stiffbench part diagnose cell.csv --map force=load,displacement=travel --force-unit kN --displacement-unit mm\n  stiffbench part diagnose ramps.csv --response force --map force=torque_Nm,displacement=angle_mrad,run=cycle --out ramps"
)]
struct PartDiagnoseArgs {
    /// Tables of force against displacement, or of any two quantities; several with the same columns are one table, and each is a run
    #[arg(value_name = "TABLE", required = true)]
    data: Vec<PathBuf>,
    /// Columns of quantities, WHAT=COLUMN,...: displacement, force, time, date, run, configuration, temperature, hold, order, branch; of runs and configurations several columns together identify one, further columns of the displacement are further runs [default: those that their names tell]
    #[arg(long, value_name = "WHAT=COLUMN")]
    map: Vec<String>,
    /// How it is searched, and what is written.
    #[command(flatten)]
    search: SearchArgs,
    /// Units and form.
    #[command(flatten)]
    table: PartTableArgs,
}

/// Diagnoses a part, or predicts it.
pub(super) fn run(args: &PartArgs, global: &Global) -> Result<Outcome, Failure> {
    match &args.what {
        PartCommand::Predict(args) => predict::run(args),
        PartCommand::Diagnose(args) => {
            let files = PartFiles::read(&args.data)?;
            let (options, note) = args.table.with_columns(&args.map, &files.named())?;
            let search = args.search.options()?;
            let results = args.search.results(&args.data[0])?;
            let notes: Vec<String> = note.into_iter().collect();
            diagnosed(&files, (&options, &notes), &search, (&results, global))
        }
    }
}

/// The files of the table of a part, by name, and what they hold.
pub(super) struct PartFiles(Vec<(String, Vec<u8>)>);

impl PartFiles {
    /// Reads them.
    pub(super) fn read<'a>(paths: impl IntoIterator<Item = &'a PathBuf>) -> Result<Self, Failure> {
        let file = |path: &PathBuf| read_bytes(path).map(|bytes| (shown(path), bytes));
        let files = paths.into_iter().map(file);
        Ok(Self(files.collect::<Result<_, _>>()?))
    }

    fn named(&self) -> Vec<(&str, &[u8])> {
        let files = self.0.iter();
        files.map(|(name, bytes)| (&**name, &**bytes)).collect()
    }
}

/// Reads the table and states what a straight line leaves out.
pub(super) fn diagnosed(
    files: &PartFiles,
    (options, notes): (&SpecimenOptions, &[String]),
    search: &SearchOptions,
    (results, global): (&ResultFolder, &Global),
) -> Result<Outcome, Failure> {
    let files = files.named();
    let table = read_specimen(&files, options)?.thinned(MOST_READINGS_OF_A_PART);
    let names: Vec<&str> = files.iter().map(|(name, _)| *name).collect();
    let hashes: Vec<String> = files.iter().map(|(_, bytes)| sha256(bytes)).collect();
    let named = names.iter().zip(&hashes);
    let inputs = named.fold(Inputs::default(), |all, (name, hash)| {
        all.with_list(name, hash)
    });
    let (name, hash) = (&names.join(", "), hashes.join(", "));
    let bar = progress(global, DIAGNOSIS_STEPS, 4);
    let (report, model) = diagnose_part(name, &table, search, &|| bar.inc(1))?;
    let verdict = report.diagnosis.verdict.to_string();
    let model = model.map(|model| PartModelFile::new(&model, options, (name, &hash), verdict));
    let model = |_: &Path| Ok(model.map(|model| model.to_toml()));
    let outcome = report_of(results, &report, (&inputs, notes), model)?;
    bar.inc(1);
    bar.finish_and_clear();
    Ok(outcome)
}
