//! `stiffbench fit` of load cases.

use std::path::Path;

use crate::analysis::{
    ArgumentError, LoadCaseData, LoadCaseSettings, LoadedLoadCases, PlannedFit, derive,
};
use crate::load_cases::write_load_cases;
use crate::report::{
    FitResult, LoadCaseFitReport, derived_text, doubts_about_load_cases, load_case_figures,
    load_case_fit_text, next_load_cases_text,
};

use super::args::{FitArgs, Global, MethodArg};
use super::failure::{Failure, refuse_given};
use super::figure_files::{write, write_figures, wrote};
use super::outcome::Outcome;

/// Why options that need runs are refused.
pub(super) const LOAD_CASES_WITHOUT_RUNS: &str =
    "the data are load cases: loads and displacements as vectors, without runs";

/// Fits and reports.
pub(super) fn run(
    args: &FitArgs,
    loaded: &LoadedLoadCases,
    global: &Global,
) -> Result<Outcome, Failure> {
    refuse_what_needs_cells(args)?;
    let mut data = LoadCaseData::new(loaded, &args.model.choice()?)
        .map_err(|error| Failure::from(error).with_warnings(&loaded.warnings))?;
    data.join_at(&args.further, &global.open_settings())?;
    of_data(args, &data, global).map_err(|failure| failure.with_warnings(&data.warnings))
}

fn of_data(args: &FitArgs, data: &LoadCaseData, global: &Global) -> Result<Outcome, Failure> {
    let settings = LoadCaseSettings {
        train: args.train.clone(),
        choice: args
            .parameters
            .choice_beside(&data.model, data.usual_choice()?)?,
        sigma: args.sigma.map(Into::into),
        keep_bad_values: true,
    };
    let fit = data.fit(&settings)?;
    let mut warnings = data.warnings.clone();
    warnings.extend(doubts_about_load_cases(data, &settings, &fit)?);
    // The text has them already.
    if global.json {
        warnings.extend(fit.warnings.iter().cloned());
    }
    if let Some(file) = &args.save_factors {
        write(file, fit.factors.to_toml().as_bytes())?;
        warnings.extend(wrote(std::slice::from_ref(file)));
    }
    if let Some(folder) = &args.figures {
        let figures = load_case_figures(&fit, &data.posed, &data.model.robot);
        warnings.extend(wrote(&write_figures(folder, figures, &data.inputs)?));
    }
    let mut estimates = fit.estimates.iter();
    let open = estimates.any(|one| one.status.why_open().is_some());
    if args.next.is_some() && fit.frames.is_some() {
        return ArgumentError::refuse(
            "--next",
            "the data are absolute positions, and load cases are planned from displacements",
            "leave it out; what is open is printed with the force that would determine it",
        );
    }
    let plan = data.plan(&fit)?;
    if let Some(file) = &args.next {
        warnings.push(write_next(file, &plan)?);
    }
    let mut report = LoadCaseFitReport::new(&fit, plan.planned);
    report.derived = derive(&args.derive, &fit.estimates, fit.correlation.as_ref())?;
    let text =
        load_case_fit_text(&fit) + &derived_text(&report.derived) + &next_load_cases_text(&report);
    let report = FitResult::LoadCases(Box::new(report));
    Ok(Outcome::new("fit", text, report)
        .with_inputs(data.inputs.clone())
        .with_warnings(warnings)
        .with_strict_exit(if open { 41 } else { 0 }))
}

/// Writes what is to be measured next: a procedure if the file is TOML, else a table to be filled in. Gives what to say of it.
pub(super) fn write_next(file: &Path, plan: &PlannedFit) -> Result<String, Failure> {
    let ending = file.extension().and_then(|ending| ending.to_str());
    let name = file.display();
    if plan.planned.is_empty() {
        return Ok(format!(
            "{name} was not written: no parameter is open, or no further force at the tool would narrow it"
        ));
    }
    match ending {
        Some("toml") => {
            write(file, plan.procedure.to_toml().as_bytes())?;
            let text = plan.procedure.text.as_deref().unwrap_or_default();
            Ok(format!(
                "wrote {name}: {text}; measure it by stiffbench session run NEW --procedure {name}"
            ))
        }
        Some("csv") => {
            write(file, write_load_cases(&plan.table).as_bytes())?;
            Ok(format!("wrote {name}: fill in the displacements"))
        }
        _ => ArgumentError::refuse(
            format!("--next {name}"),
            "the ending decides what is written, and this one is neither .toml nor .csv",
            "--next next.toml for a procedure, --next next.csv for a table to be filled in",
        ),
    }
}

/// Options without effect are a misunderstanding, and worth an error.
fn refuse_what_needs_cells(args: &FitArgs) -> Result<(), ArgumentError> {
    let of_cells = [
        ("--method paper", args.method == MethodArg::Paper),
        ("--bootstrap", args.bootstrap > 0),
        ("--global-search", args.global_search),
        ("--against", !args.against.is_empty()),
    ];
    refuse_given(&of_cells, LOAD_CASES_WITHOUT_RUNS, |_| {
        "leave it out; load cases are fitted by least squares".to_owned()
    })
}
