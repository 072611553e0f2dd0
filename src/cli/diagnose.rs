//! `stiffbench diagnose`.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use stiffbench_document::Document;

use crate::analysis::{
    ArgumentError, Data, DiagnoseSettings, DiagnosisData, DiagnosisReport, Inputs, LoadedSession,
    NoiseSource, ResolvedModel, Subject, laws, noise_of, sha256,
};
use crate::mismatch::{MismatchError, SearchOptions, Verdict};
use crate::physics::Law;
use crate::report::{
    Determination, DiagnosisDetail, DiagnosisSummary, FactorChangeReport, diagnosis_document,
    diagnosis_figures,
};
use crate::session::inside;

use super::args::ModelArgs;
use super::data_args::DataArgs;
use super::failure::refuse_given;
use super::figure_files::{write_figures, write_result, write_texts};
use super::parameter_args::ParameterArgs;
use super::part::{self, PartFiles};
use super::pose_args::PoseRulesArgs;
use super::progress::progress;
use super::specimen_args::SpecimenArgs;
use super::{CliError, Failure, Global, Outcome};

/// What the bar of a diagnosis shows.
pub(super) const DIAGNOSIS_STEPS: &str = "diagnosis (read, search, judge, draw)";

/// Arguments of `diagnose`.
#[derive(Debug, Args)]
#[command(
    after_help = "Writes verdict.txt, diagnosis.json and figures to SESSION/diagnosis. docs/diagnosis.md explains them.\n\nExamples:\n  stiffbench diagnose my-session\n  stiffbench diagnose readings.csv --robot my-robot.toml --out diagnosis --json\n  stiffbench diagnose my-session --earlier last-week --earlier yesterday\n  stiffbench diagnose my-session --without slip,gauge-periodic --no-figures\n  stiffbench diagnose my-session --parameter joint.A3,base.rx=free\n  stiffbench part diagnose cell.csv --map force=load,displacement=travel        a part, without a robot"
)]
pub(super) struct DiagnoseArgs {
    /// Session folder, readings file or load cases (docs/joint-stiffness.md)
    data: PathBuf,
    /// Further sessions or load cases of the same robot, diagnosed together with the first
    #[arg(value_name = "DATA")]
    further: Vec<PathBuf>,
    /// Robot, mechanism and factors.
    #[command(flatten)]
    model: ModelArgs,
    /// Which parameters of the model are free beside every candidate.
    #[command(flatten)]
    parameters: ParameterArgs,
    /// How it is searched, and what is written.
    #[command(flatten)]
    search: SearchArgs,
    /// Keep readings that contradict their repeats; they are still listed
    #[arg(long)]
    keep_outliers: bool,
    /// Source of the scatter of single readings
    #[arg(long, value_enum, default_value_t = NoiseChoice::Estimated)]
    noise: NoiseChoice,
    /// Earlier session on the same bench (folder or readings file), used to estimate the noise; repeatable
    #[arg(long, value_name = "SESSION", conflicts_with = "specimen")]
    earlier: Vec<PathBuf>,
    /// How the data are read.
    #[command(flatten)]
    reading: DataArgs,
    /// Which poses may be proposed.
    #[command(flatten)]
    rules: PoseRulesArgs,
    /// Tables without a robot.
    #[command(flatten)]
    specimen: SpecimenArgs,
}

/// What every diagnosis takes, of a robot or a part.
#[derive(Debug, Args)]
pub(super) struct SearchArgs {
    /// Laws to exclude from the search, comma-separated
    #[arg(long, value_delimiter = ',', value_name = "LAW")]
    without: Vec<String>,
    /// Seed of the noise simulations that set the critical values
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Folder for the results [default: diagnosis in the session folder; for a bare file nothing is written]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Write no figures
    #[arg(long)]
    no_figures: bool,
}

/// Source of the scatter of single readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum NoiseChoice {
    /// The readings: restricted likelihood of the differences between repeats
    Estimated,
    /// The instrument records of session.toml: step of the displacement gauge and spread when settled; zeros and runs as the readings show
    Records,
}

/// Finds what the model leaves out.
pub(super) fn run(args: &DiagnoseArgs, global: &Global) -> Result<Outcome, Failure> {
    if let Some(options) = args.specimen.options()? {
        if !args.parameters.is_default() || !args.model.is_default() {
            return ArgumentError::refuse(
                "--robot, --mechanism, --factors, --model, --effect, --parameter",
                "they are of a robot, and a specimen has none",
                "leave them out",
            );
        }
        let files = PartFiles::read(std::iter::once(&args.data).chain(&args.further))?;
        let results = (&args.search.results(&args.data)?, global);
        let search = args.search.options()?;
        return part::diagnosed(&files, (&options, &[]), &search, results);
    }
    let settings = args.reading.open_settings(global)?;
    let first = Data::open(&args.data, &settings)?;
    if !matches!(first, Data::Readings(_)) {
        let of_runs = [("--earlier", !args.earlier.is_empty())];
        refuse_given(
            &of_runs,
            "load cases and stiffness values are no session",
            |_| {
                "leave it out: the scatter of load cases comes from repeats, from the fit, from --displacement-u and --force-u, or from the records of the instruments".to_owned()
            },
        )?;
    }
    let data = first.with(&args.further, &settings)?;
    let mut prepared = DiagnosisData::new(&data, &args.model.choice()?)
        .map_err(|error| error.with_warnings(&data.warnings()))?;
    let warnings = prepared.warnings.clone();
    let without = laws(&args.search.without)?;
    let noise = noise(args, &without, global)?;
    diagnosed(args, &mut prepared, (noise, without), global)
        .map_err(|failure| failure.with_warnings(&warnings))
}

fn diagnosed(
    args: &DiagnoseArgs,
    data: &mut DiagnosisData,
    (noise, without): (NoiseSource, Vec<Law>),
    global: &Global,
) -> Result<Outcome, Failure> {
    let bar = progress(global, DIAGNOSIS_STEPS, 4);
    let usual = data.usual_choice()?;
    let options = DiagnoseSettings {
        parameters: Some(args.parameters.choice_beside(&data.model, usual)?),
        noise,
        seed: args.search.seed,
        without,
        keep_outliers: args.keep_outliers,
        rules: args.rules.rules(),
    };
    let report = data.diagnose(options, &|| bar.inc(1))?;
    let model = &data.model;
    let model = |folder: &Path| model_file(&report, model, folder);
    let last = args.further.last().unwrap_or(&args.data);
    let outcome = report_of(
        &args.search.results(last)?,
        &report,
        (&data.inputs, &data.warnings),
        model,
    )?;
    bar.inc(1);
    bar.finish_and_clear();
    Ok(outcome)
}

/// Page, JSON and files of a diagnosis.
///
/// # Arguments
/// - `inputs`, `warnings`: of the data.
/// - `model`: the text of `model.toml` for a folder; none where the readings cannot decide.
pub(super) fn report_of(
    results: &ResultFolder,
    report: &DiagnosisReport,
    (inputs, warnings): (&Inputs, &[String]),
    model: impl FnOnce(&Path) -> Result<Option<String>, CliError>,
) -> Result<Outcome, Failure> {
    let mut warnings = [warnings, &report.warnings].concat();
    let mut page = diagnosis_document(report, DiagnosisDetail::Page);
    let whole = diagnosis_document(report, DiagnosisDetail::Whole);
    let mut data = DiagnosisSummary::from(report);
    if let Some(folder) = results.folder.clone() {
        let write = || -> Result<Vec<PathBuf>, Failure> {
            let model = model(&folder)?.map(|model| ("model.toml", model));
            let result = Outcome::new("diagnosis", whole.clone(), &data)
                .with_inputs(inputs.clone())
                .with_warnings(warnings.clone());
            let mut written = write_result(&folder, ["verdict.txt", "diagnosis.json"], &result)?;
            let procedures = report.procedures.iter();
            let procedures = procedures.map(|(name, text)| (name.as_str(), text.clone()));
            written.extend(write_texts(&folder, model.into_iter().chain(procedures))?);
            if results.with_figures {
                let figures = diagnosis_figures(report);
                written.extend(write_figures(&folder, figures, inputs)?);
            }
            Ok(written)
        };
        match write() {
            Ok(written) => {
                page.lines(format!(
                    "This page with all numbers behind it, the data and the figures: {}",
                    folder.display()
                ));
                data.files = Some(written);
            }
            Err(failure) if results.is_named => return Err(failure),
            // A verdict is not withheld because the session may only be read.
            Err(failure) => {
                page = whole;
                warnings.push(format!(
                    "page and figures were not written: {}; --out FOLDER puts them elsewhere",
                    failure.message()
                ));
            }
        }
    } else {
        page = whole;
    }
    Ok(outcome(page, data)
        .with_inputs(inputs.clone())
        .with_warnings(warnings))
}

/// The model with what was found in it, for a file in `folder`; where the readings cannot decide there is none to give back.
fn model_file(
    report: &DiagnosisReport,
    resolved: &ResolvedModel,
    folder: &Path,
) -> Result<Option<String>, CliError> {
    let Subject::Robot(robot) = &report.subject else {
        return Ok(None);
    };
    if report.diagnosis.verdict == Verdict::InsufficientData {
        return Ok(None);
    }
    let mut model = report
        .diagnosis
        .model_file(Some(robot.fitted_factors.clone()));
    model.robot = Some(robot_seen_from(resolved, folder)?);
    model.robot_sha256 = Some(sha256(&resolved.source.text));
    model.mechanism = Some(resolved.mechanism.clone());
    model.provenance.session = Some(report.data.clone());
    model.provenance.software = Some(concat!("stiffbench ", env!("CARGO_PKG_VERSION")).to_owned());
    Ok(Some(model.to_toml()))
}

/// The robot as a file in `folder` names it: a shipped robot by its name, a file by its path from there.
fn robot_seen_from(resolved: &ResolvedModel, folder: &Path) -> Result<String, CliError> {
    let file = Path::new(&resolved.source.name);
    if !file.is_file() {
        return Ok(resolved.source.name.clone());
    }
    let whole = |path: &Path| {
        std::fs::create_dir_all(folder)
            .and_then(|()| path.canonicalize())
            .map_err(CliError::write(path))
    };
    let (file, folder) = (whole(file)?, whole(folder)?);
    let common = file
        .components()
        .zip(folder.components())
        .take_while(|(a, b)| a == b)
        .count();
    let up = folder.components().skip(common).map(|_| "..".to_owned());
    let down = file
        .components()
        .skip(common)
        .map(|part| part.as_os_str().to_string_lossy().into_owned());
    Ok(up.chain(down).collect::<Vec<_>>().join("/"))
}

/// Where the noise of single readings comes from.
fn noise(args: &DiagnoseArgs, without: &[Law], global: &Global) -> Result<NoiseSource, Failure> {
    if args.noise == NoiseChoice::Records {
        if !args.earlier.is_empty() {
            return ArgumentError::refuse(
                "--earlier",
                "the records of the instruments give the scatter of readings already",
                "leave out --noise records, or --earlier",
            );
        }
        return Ok(NoiseSource::Records);
    }
    if args.earlier.is_empty() {
        return Ok(NoiseSource::Readings);
    }
    let sessions = args.earlier.len() as u64;
    let bar = progress(global, "scatter of earlier sessions", sessions);
    let mut earlier = Vec::new();
    for path in &args.earlier {
        let session = LoadedSession::open_series(path, &global.open_settings())?;
        let model = args.model.resolve_for(&session)?;
        earlier.push(noise_of(
            session,
            &model,
            &args.parameters.choice(&model)?,
            without,
            args.search.seed,
        )?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(NoiseSource::EarlierSessions(earlier))
}

/// Where the results of a diagnosis go.
pub(super) struct ResultFolder {
    /// The folder; `None` if nothing is written.
    pub(super) folder: Option<PathBuf>,
    /// Whether the user named it.
    pub(super) is_named: bool,
    /// Whether figures are drawn.
    pub(super) with_figures: bool,
}

impl SearchArgs {
    /// How to search.
    pub(super) fn options(&self) -> Result<SearchOptions, MismatchError> {
        Ok(SearchOptions {
            without: laws(&self.without)?,
            seed: self.seed,
            ..SearchOptions::default()
        })
    }

    /// Where the results go: where the user says, else into the folder of the session.
    pub(super) fn results(&self, data: &Path) -> Result<ResultFolder, CliError> {
        let folder = match &self.out {
            Some(folder) => Some(folder.clone()),
            None if data.is_dir() => {
                let folder = inside(data, "diagnosis");
                Some(folder.map_err(CliError::write(&data.join("diagnosis")))?)
            }
            None => None,
        };
        Ok(ResultFolder {
            folder,
            is_named: self.out.is_some(),
            with_figures: !self.no_figures,
        })
    }
}

/// The outcome of a diagnosis. Under `--strict` 1 for something that is missing, or a question that the readings cannot answer; 41 for a factor
/// that they do not determine.
fn outcome(page: Document, result: DiagnosisSummary) -> Outcome {
    let is_open = |factor: &FactorChangeReport| factor.status != Determination::Free;
    let open = result.factors.iter().any(is_open);
    let exit = match result.verdict {
        Verdict::NothingMissing if open => 41,
        Verdict::NothingMissing => 0,
        _ => 1,
    };
    Outcome::new("diagnosis", page, result).with_strict_exit(exit)
}
