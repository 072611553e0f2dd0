//! `stiffbench fit`.

use std::path::{Path, PathBuf};

use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};

use crate::analysis::{
    ArgumentError, BootstrapOver, Data, FitData, FitSettings, Inputs, PaperFitSettings, PlannedFit,
    StoredResult, derive, read_text,
};
use crate::fit::{FitOutcome, PaperFit};
use crate::least_squares::SigmaMode;
use crate::load_cases::write_load_cases;
use crate::report::{ComparedFit, FitReport, Fitted, ModelComparison, PaperSteps};
use crate::stiffness::Method as StiffnessMethod;

use super::args::ModelArgs;
use super::data_args::DataArgs;
use super::failure::refuse_given;
use super::figure_files::{write, write_figures};
use super::numbers::MOST_REPLICATES;
use super::option_values::{OptionValue, one_of};
use super::parameter_args::ParameterArgs;
use super::pose_args::PoseRulesArgs;
use super::progress::progress;
use super::{Failure, Global, Outcome};

/// Fitting method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum MethodArg {
    /// All training cells at once, with intervals
    LeastSquares,
    /// The paper's nine steps
    Paper,
}

/// Where the standard deviation of the residuals comes from.
const SIGMAS: [OptionValue<SigmaMode>; 2] = [
    (
        "known",
        "The stated or pooled uncertainties of the stiffnesses",
        SigmaMode::Known,
    ),
    (
        "estimated",
        "The scatter about the fit",
        SigmaMode::Estimated,
    ),
];

/// Arguments of `fit`.
#[derive(Debug, Args)]
#[command(
    after_help = "DATA may also be a list of stiffness values (columns pose, direction, stiffness_N_per_um and, if known, u_N_per_um), a list of\ncomputed displacements (pose, direction, force_N, displacement_um), or one of the shipped names paper-experiment (Table VI) and\npaper-reference (Table V, finite elements).\n\nExamples:\n  stiffbench fit my-session --train P1,P3\n  stiffbench fit my-session --method paper --train P1,P3 --reference paper-reference\n  stiffbench fit my-session --parameter beam.J=fixed,link.A=free --bootstrap 1000 --seed 1\n  stiffbench fit my-session --parameter joint.A3,base.rx=free,joint.A3=0..1e-4\n  stiffbench fit my-session --model my-session/diagnosis/model.toml\n  stiffbench fit positions.csv --robot my-robot.toml   (elastic calibration: position_x_mm, position_y_mm, position_z_mm, joint_J1_deg ...)"
)]
pub(super) struct FitArgs {
    /// Session folder, readings file, load cases (docs/joint-stiffness.md), list of stiffness values, or a shipped name
    data: PathBuf,
    /// Further sessions or load cases of the same robot, fitted together with the first
    #[arg(value_name = "DATA")]
    further: Vec<PathBuf>,
    /// Robot, mechanism and factors.
    #[command(flatten)]
    model: ModelArgs,
    /// Fitting method
    #[arg(long, value_enum, default_value_t = MethodArg::LeastSquares)]
    method: MethodArg,
    /// Poses to fit, comma-separated; the others are held out [default: all, validated by leaving each out in turn]
    #[arg(long, value_delimiter = ',')]
    train: Option<Vec<String>>,
    /// Weights of the training poses in the paper's combination [default: equal]
    #[arg(long, value_delimiter = ',', allow_negative_numbers = true)]
    weights: Option<Vec<f64>>,
    /// Reference displacements or stiffness for the single-source steps of the paper's method
    #[arg(long, value_name = "NAME|FILE")]
    reference: Option<PathBuf>,
    /// Which parameters of the model are free.
    #[command(flatten)]
    parameters: ParameterArgs,
    /// Source of the standard deviation of the residuals [default: known if the data state it]
    #[arg(long, value_parser = one_of(SIGMAS))]
    sigma: Option<SigmaMode>,
    /// Number of bootstrap replicates
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(0..=MOST_REPLICATES))]
    bootstrap: usize,
    /// What the bootstrap resamples
    #[arg(long, value_enum, default_value_t = BootstrapOver::Runs, requires = "bootstrap")]
    bootstrap_over: BootstrapOver,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Search for a lower minimum with a particle swarm and a simplex
    #[arg(long)]
    global_search: bool,
    /// Quantity derived from the parameters, with its uncertainty, for example ratio=beam.Iy/beam.Iz or k=1/joint.J2; repeatable
    #[arg(long, value_name = "NAME=EXPRESSION")]
    derive: Vec<String>,
    /// Output of fit --json for another model of the same data: compares AICc, F test and errors in unseen poses; repeatable
    #[arg(long, value_name = "FIT.json")]
    against: Vec<PathBuf>,
    /// Write the fitted factors as a TOML file for --factors
    #[arg(long, value_name = "FILE")]
    save_factors: Option<PathBuf>,
    /// Write the loads that would best determine the open parameters: a procedure (FILE.toml) or a table of load cases to fill in (FILE.csv)
    #[arg(long, value_name = "FILE")]
    next: Option<PathBuf>,
    /// Which poses may be planned.
    #[command(flatten)]
    rules: PoseRulesArgs,
    /// Write the figures of the fit into this folder
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
    /// How the data are read.
    #[command(flatten)]
    reading: DataArgs,
}

/// Fits and reports.
pub(super) fn run(args: &FitArgs, global: &Global) -> Result<Outcome, Failure> {
    let method = match args.method {
        MethodArg::LeastSquares => StiffnessMethod::Regression,
        MethodArg::Paper => StiffnessMethod::PaperMean,
    };
    refuse_what_the_method_ignores(args)?;
    let settings = args.reading.open_settings(global)?;
    let data = Data::open(&args.data, &settings)?;
    let is_of_cases = matches!(data, Data::LoadCases(_));
    if is_of_cases {
        refuse_what_needs_cells(args)?;
    }
    let resamples_runs = args.bootstrap > 0 && args.bootstrap_over == BootstrapOver::Runs;
    if matches!(data, Data::Readings(_)) && !args.further.is_empty() && resamples_runs {
        return ArgumentError::refuse(
            "--bootstrap",
            "it resamples the runs of one session",
            "add --bootstrap-over cells, or fit one session",
        );
    }
    let data = data.with(&args.further, &settings)?;
    let notes = if is_of_cases {
        data.warnings()
    } else {
        Vec::new()
    };
    let data = FitData::new(data, &args.model.choice()?, method)
        .map_err(|error| error.with_warnings(&notes))?;
    let fitted = fitted(args, &data, global);
    finished(args, global, fitted, (data.inputs, data.warnings))
}

/// The fit, and what is to be measured next.
fn fitted(
    args: &FitArgs,
    data: &FitData,
    global: &Global,
) -> Result<(Fitted, PlannedFit), Failure> {
    let usual = data.usual_choice()?;
    let settings = FitSettings {
        train: args.train.clone(),
        choice: Some(args.parameters.choice_beside(&data.model, usual)?),
        sigma: args.sigma,
        bootstrap: args.bootstrap,
        bootstrap_over: args.bootstrap_over,
        global_search: args.global_search,
        seed: args.seed,
    };
    let (outcome, steps) = match args.method {
        MethodArg::LeastSquares => (least_squares(data, &settings, global)?, None),
        MethodArg::Paper => {
            let fit = paper(args, data, global)?;
            let steps = PaperSteps::from(&fit);
            (fit.outcome, Some(steps))
        }
    };
    if args.next.is_some() && outcome.frames.is_some() {
        return ArgumentError::refuse(
            "--next",
            "the data are absolute positions, and load cases are planned from displacements",
            "leave it out; what is open is printed with the force that would determine it",
        );
    }
    let mut fitted = Fitted::new(data, &settings, outcome)?;
    let report = &mut fitted.report;
    report.steps = steps;
    report.runs_tests = data.runs_tests(&fitted.outcome)?;
    if !args.against.is_empty() {
        report.comparison = Some(compared(report, &data.inputs, &args.against)?);
    }
    let plan = data.plan(&fitted.outcome, &args.rules.rules())?;
    Ok((fitted, plan))
}

/// Derives what was asked for, writes files, and prints.
fn finished(
    args: &FitArgs,
    global: &Global,
    fitted: Result<(Fitted, PlannedFit), Failure>,
    (inputs, mut warnings): (Inputs, Vec<String>),
) -> Result<Outcome, Failure> {
    let (fitted, plan) = fitted.map_err(|failure| failure.with_warnings(&warnings))?;
    let outcome = &fitted.outcome;
    let mut report = fitted.report;
    report.derived = derive(
        &args.derive,
        &outcome.estimates,
        outcome.correlation.as_ref(),
    )?;
    let note = args.next.as_ref().map(|file| write_next(file, &plan));
    let note = note.transpose()?;
    report.plan_next(plan.planned);
    let text = report.document(outcome).text();
    warnings.extend(fitted.failed_checks);
    // The text has them already.
    if global.json {
        warnings.extend(outcome.warnings.iter().cloned());
    }
    let mut written = Vec::new();
    if let Some(file) = &args.save_factors {
        write(file, outcome.factors.to_toml().as_bytes())?;
        written.push(file.clone());
    }
    if let Some(folder) = &args.figures {
        written.extend(write_figures(folder, fitted.figures, &inputs)?);
    }
    let mut estimates = outcome.estimates.iter();
    let open = estimates.any(|one| one.status.why_open().is_some());
    Ok(Outcome::new("fit", text, report)
        .with_inputs(inputs)
        .with_warnings(warnings)
        .with_written(&written)
        .with_warnings(note)
        .with_strict_exit(if open { 41 } else { 0 }))
}

/// Writes what is to be measured next: a procedure if the file is TOML, else a table to be filled in. Gives what to say of it.
fn write_next(file: &Path, plan: &PlannedFit) -> Result<String, Failure> {
    let ending = file.extension().and_then(|ending| ending.to_str());
    let name = file.display();
    if plan.planned.planned.is_empty() {
        return Ok(format!(
            "{name} was not written: no parameter is open, or no further force at the tool would determine it better"
        ));
    }
    match ending {
        Some("toml") => {
            write(file, plan.procedure.to_toml().as_bytes())?;
            let text = plan.procedure.text.as_deref().unwrap_or_default();
            Ok(format!(
                "wrote {name}: {text}; measure it with stiffbench session run NEW --procedure {name}"
            ))
        }
        Some("csv") => {
            write(file, write_load_cases(&plan.table).as_bytes())?;
            Ok(format!("wrote {name}: fill in the displacements"))
        }
        _ => ArgumentError::refuse(
            format!("--next {name}"),
            "the extension of the file decides what is written, and this one is neither .toml nor .csv",
            "--next next.toml for a procedure, --next next.csv for a table to be filled in",
        ),
    }
}

/// This fit beside those of other models, which must be of the same cells.
fn compared(
    own: &FitReport,
    inputs: &Inputs,
    against: &[PathBuf],
) -> Result<ModelComparison, Failure> {
    let refuse = |path: &Path, problem: String| {
        ArgumentError::new(
            format!("--against {}", path.display()),
            problem,
            "fit both models to the same data, poses and weights: stiffbench fit DATA --json > other.json",
        )
    };
    let mut files = Vec::with_capacity(against.len());
    for path in against {
        let stored = StoredResult::<FitReport>::read("fit", &read_text(path)?);
        let stored = stored.map_err(|problem| refuse(path, problem))?;
        files.push((path, stored));
    }
    let first = ComparedFit::new("this fit", own, inputs.hashes_of_data().collect())
        .map_err(|problem| refuse(Path::new("FIT.json"), format!("this fit: {problem}")))?;
    let mut fits = vec![first];
    for (path, stored) in &files {
        let name = path.display().to_string();
        let hashes = stored.inputs.hashes_of_data().collect();
        let fit = ComparedFit::new(&name, &stored.data, hashes)
            .map_err(|problem| refuse(path, problem.to_owned()))?;
        if let Some(difference) = fit.differs_from(&fits[0]) {
            let problem = format!("{difference}: models of different data cannot be ranked");
            return Err(refuse(path, problem).into());
        }
        fits.push(fit);
    }
    Ok(ModelComparison::of(&fits))
}

/// Options without effect are a misunderstanding, and worth an error.
fn refuse_what_the_method_ignores(args: &FitArgs) -> Result<(), ArgumentError> {
    let of_paper = [
        ("--weights", args.weights.is_some()),
        ("--reference", args.reference.is_some()),
    ];
    let of_least_squares = [
        ("--parameter", !args.parameters.is_default()),
        ("--sigma", args.sigma.is_some()),
        ("--bootstrap", args.bootstrap > 0),
        ("--global-search", args.global_search),
    ];
    let (ignored, method): (&[(&str, bool)], _) = match args.method {
        MethodArg::LeastSquares => (&of_paper, "paper"),
        MethodArg::Paper => (&of_least_squares, "least-squares"),
    };
    refuse_given(
        ignored,
        &format!("it belongs to --method {method}"),
        |option| format!("add --method {method}, or leave {option} out"),
    )
}

/// Options without effect are a misunderstanding, and worth an error.
fn refuse_what_needs_cells(args: &FitArgs) -> Result<(), ArgumentError> {
    let of_cells = [
        ("--method paper", args.method == MethodArg::Paper),
        ("--bootstrap", args.bootstrap > 0),
        ("--global-search", args.global_search),
        ("--against", !args.against.is_empty()),
    ];
    refuse_given(
        &of_cells,
        "the data are load cases: loads and displacements as vectors, without runs",
        |_| "leave it out; load cases are fitted by least squares".to_owned(),
    )
}

fn least_squares(
    data: &FitData,
    settings: &FitSettings,
    global: &Global,
) -> Result<FitOutcome, Failure> {
    if settings.bootstrap == 0 {
        return data.fit(settings, &|| ());
    }
    let bar = progress(global, "refits", settings.bootstrap as u64);
    let outcome = data.fit(settings, &|| bar.inc(1));
    bar.finish_and_clear();
    outcome
}

fn paper(args: &FitArgs, data: &FitData, global: &Global) -> Result<PaperFit, Failure> {
    let reference = args.reference.as_ref().map(|path| {
        let reference = Data::open(path, &global.open_settings())?;
        reference.measured()
    });
    let settings = PaperFitSettings {
        train: args.train.clone(),
        weights: args.weights.clone(),
        reference: reference.transpose()?,
        seed: args.seed,
    };
    data.fit_as_paper(&settings)
}
