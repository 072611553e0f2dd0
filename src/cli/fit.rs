//! `stiffbench fit`.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::analysis::{
    ArgumentError, BootstrapOver, Data, FitData, FitSettings, Inputs, PaperFitSettings, derive,
    doubts_about_fit, open_together, read_text,
};
use crate::fit::{FitOutcome, PaperFit};
use crate::report::{ComparedFit, FitReport, ModelComparison, fit_figures};
use crate::stiffness::Method as StiffnessMethod;

use super::args::{BootstrapUnit, FitArgs, Global, MethodArg};
use super::failure::{Failure, refuse_given};
use super::figure_files::{write, write_figures, wrote};
use super::fit_load_cases;
use super::outcome::Outcome;
use super::progress::progress;

/// Fits and reports.
pub(super) fn run(args: &FitArgs, global: &Global) -> Result<Outcome, Failure> {
    let method = match args.method {
        MethodArg::LeastSquares => StiffnessMethod::Regression,
        MethodArg::Paper => StiffnessMethod::PaperMean,
    };
    refuse_what_the_method_ignores(args)?;
    let settings = args.calibration.open_settings(global)?;
    let data = Data::open(&args.data, &settings)?;
    if let Data::LoadCases(loaded) = &data {
        return fit_load_cases::run(args, loaded, global);
    }
    let prepared = prepared(args, data, method, global)?;
    let fitted = match args.method {
        MethodArg::LeastSquares => least_squares(args, &prepared, global).map(|outcome| {
            let data = FitReport::from(&outcome).of_data(&prepared);
            (outcome, data)
        }),
        MethodArg::Paper => paper(args, &prepared, global).map(|fit| {
            let data = FitReport::from(&fit).of_data(&prepared);
            (fit.outcome, data)
        }),
    };
    let (outcome, mut data) =
        fitted.map_err(|failure| failure.with_warnings(&prepared.warnings))?;
    data.runs_tests = prepared.runs_tests(&outcome)?;
    data.derived = derive(
        &args.derive,
        &outcome.estimates,
        outcome.correlation.as_ref(),
    )?;
    if !args.against.is_empty() {
        data.comparison = Some(compared(&data, &prepared.inputs, &args.against)?);
    }
    let mut notes = Vec::new();
    let plan = prepared.plan(&outcome)?;
    if let Some(file) = &args.next {
        notes.push(fit_load_cases::write_next(file, &plan)?);
    }
    data.next = plan.planned;
    let text = data.text(&outcome.warnings);
    let mut warnings = prepared.warnings;
    warnings.extend(doubts_about_fit(&outcome));
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
        let table = prepared.session.as_ref().map(|(_, table)| table);
        let range = args.parameters.choice(&prepared.model)?.range;
        let figures = fit_figures(&outcome, table, range);
        written.extend(write_figures(folder, figures, &prepared.inputs)?);
    }
    warnings.extend(wrote(&written));
    warnings.extend(notes);
    let mut estimates = outcome.estimates.iter();
    let open = estimates.any(|one| one.status.why_open().is_some());
    Ok(Outcome::new("fit", text, data)
        .with_inputs(prepared.inputs)
        .with_warnings(warnings)
        .with_strict_exit(if open { 41 } else { 0 }))
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
        let whole: Value = serde_json::from_str(&read_text(path)?)
            .map_err(|error| refuse(path, format!("it is no JSON: {error}")))?;
        if whole["kind"] != "fit" || whole["ok"] != true {
            return Err(refuse(
                path,
                "it is not what stiffbench fit --json prints".to_owned(),
            )
            .into());
        }
        files.push((path, whole));
    }
    let (data, inputs) = (serde_json::json!(own), serde_json::json!(inputs));
    let first = ComparedFit::new("this fit", &data, &inputs)
        .map_err(|problem| refuse(Path::new("FIT.json"), format!("this fit: {problem}")))?;
    let mut fits = vec![first];
    for (path, whole) in &files {
        let name = path.display().to_string();
        let fit = ComparedFit::new(&name, &whole["data"], &whole["inputs"])
            .map_err(|problem| refuse(path, problem.to_owned()))?;
        if let Some(difference) = fit.differs_from(&fits[0]) {
            let problem = format!("{difference}: models of different data cannot be ranked");
            return Err(refuse(path, problem).into());
        }
        fits.push(fit);
    }
    Ok(ModelComparison::of(&fits))
}

/// What is to be fitted: one data file, or several sessions together.
fn prepared(
    args: &FitArgs,
    data: Data,
    method: StiffnessMethod,
    global: &Global,
) -> Result<FitData, Failure> {
    Ok(match data {
        Data::Readings(session) if !args.further.is_empty() => {
            if args.bootstrap > 0 && args.bootstrap_over == BootstrapUnit::Runs {
                return ArgumentError::refuse(
                    "--bootstrap",
                    "it draws the runs of one session again",
                    "add --bootstrap-over cells, or fit one session",
                );
            }
            let sessions = open_together(
                *session,
                &args.further,
                &args.calibration.open_settings(global)?,
            )?;
            FitData::together(&sessions, &args.model.choice()?, method)?
        }
        Data::Stiffness { .. } if !args.further.is_empty() => {
            return ArgumentError::refuse(
                args.data.display().to_string(),
                "it holds stiffness values, and several data are fitted together if all hold readings",
                "name sessions, or one list alone",
            );
        }
        data => FitData::new(data, &args.model.choice()?, method)?,
    })
}

/// Options without effect are a misunderstanding, and worth an error.
fn refuse_what_the_method_ignores(args: &FitArgs) -> Result<(), ArgumentError> {
    let of_paper = [
        ("--weights", args.weights.is_some()),
        ("--reference", args.reference.is_some()),
    ];
    let of_least_squares = [
        ("--free", !args.parameters.free.is_empty()),
        ("--fix", !args.parameters.fix.is_empty()),
        ("--tie", !args.parameters.tie.is_empty()),
        ("--bounds", !args.parameters.bounds.is_empty()),
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

fn least_squares(args: &FitArgs, data: &FitData, global: &Global) -> Result<FitOutcome, Failure> {
    let settings = FitSettings {
        train: args.train.clone(),
        choice: Some(args.parameters.choice(&data.model)?),
        sigma: args.sigma.map(Into::into),
        bootstrap: args.bootstrap,
        bootstrap_over: match args.bootstrap_over {
            BootstrapUnit::Runs => BootstrapOver::Runs,
            BootstrapUnit::Cells => BootstrapOver::Cells,
        },
        global_search: args.global_search,
        seed: args.seed,
    };
    if args.bootstrap == 0 {
        return Ok(data.fit(&settings, &|| ())?);
    }
    let bar = progress(global, "refits", args.bootstrap as u64);
    let outcome = data.fit(&settings, &|| bar.inc(1));
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
