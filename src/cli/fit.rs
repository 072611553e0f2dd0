//! `stiffbench fit`.

use std::path::{Path, PathBuf};

use crate::analysis::{
    ArgumentError, BootstrapOver, Data, FitData, FitSettings, Inputs, PaperFitSettings, PlannedFit,
    StoredResult, derive, read_text,
};
use crate::fit::{FitOutcome, PaperFit};
use crate::load_cases::write_load_cases;
use crate::report::{ComparedFit, FitReport, Fitted, ModelComparison, PaperSteps};
use crate::stiffness::Method as StiffnessMethod;

use super::args::{FitArgs, Global, MethodArg};
use super::failure::{Failure, refuse_given};
use super::figure_files::{write, write_figures};
use super::outcome::Outcome;
use super::progress::progress;

/// Fits and reports.
pub(super) fn run(args: &FitArgs, global: &Global) -> Result<Outcome, Failure> {
    let method = match args.method {
        MethodArg::LeastSquares => StiffnessMethod::Regression,
        MethodArg::Paper => StiffnessMethod::PaperMean,
    };
    refuse_what_the_method_ignores(args)?;
    let settings = args.reading.open_settings(global)?;
    let data = Data::open(&args.data, &settings)?;
    match &data {
        Data::LoadCases(_) => refuse_what_needs_cells(args)?,
        Data::Readings(_)
            if !args.further.is_empty()
                && args.bootstrap > 0
                && args.bootstrap_over == BootstrapOver::Runs =>
        {
            return ArgumentError::refuse(
                "--bootstrap",
                "it resamples the runs of one session",
                "add --bootstrap-over cells, or fit one session",
            );
        }
        Data::Readings(_) | Data::Stiffness { .. } => {}
    }
    let data = data.with(&args.further, &settings)?;
    let notes = match &data {
        Data::LoadCases(_) => data.warnings(),
        Data::Readings(_) | Data::Stiffness { .. } => Vec::new(),
    };
    let data = FitData::new(data, &args.model.choice()?, method)
        .map_err(|error| Failure::from(error).with_warnings(&notes))?;
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
        return Ok(data.fit(settings, &|| ())?);
    }
    let bar = progress(global, "refits", settings.bootstrap as u64);
    let outcome = data.fit(settings, &|| bar.inc(1));
    bar.finish_and_clear();
    Ok(outcome?)
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
    Ok(data.fit_as_paper(&settings)?)
}
