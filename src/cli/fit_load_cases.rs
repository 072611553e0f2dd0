//! `stiffbench fit` of load cases.

use crate::analysis::{ArgumentError, LoadCaseData, LoadCaseSettings, LoadedLoadCases};
use crate::fit::FactorStatus;
use crate::least_squares::SigmaMode;
use crate::load_cases::write_load_cases;
use crate::report::{
    FitResult, LoadCaseFitReport, load_case_figures, load_case_fit_text, next_load_cases_text,
};

use super::args::{FitArgs, Global, MethodArg, Sigma};
use super::failure::Failure;
use super::figure_files::{write, write_figure};
use super::outcome::Outcome;

/// Further load cases that are planned for what is open.
const FURTHER: usize = 3;

/// Fits and reports.
pub(super) fn run(
    args: &FitArgs,
    loaded: &LoadedLoadCases,
    global: &Global,
) -> Result<Outcome, Failure> {
    refuse_what_needs_cells(args)?;
    let data = LoadCaseData::new(loaded, &args.model.choice()?)
        .map_err(|error| Failure::from(error).with_warnings(&loaded.warnings))?;
    of_data(args, &data, global).map_err(|failure| failure.with_warnings(&data.warnings))
}

fn of_data(args: &FitArgs, data: &LoadCaseData, global: &Global) -> Result<Outcome, Failure> {
    let settings = LoadCaseSettings {
        train: args.train.clone(),
        choice: args
            .parameters
            .choice_beside(&data.model, data.usual_choice()?)?,
        sigma: args.sigma.map(|sigma| match sigma {
            Sigma::Known => SigmaMode::Known,
            Sigma::Estimated => SigmaMode::Estimated,
        }),
    };
    let fit = data.fit(&settings)?;
    let mut warnings = data.warnings.clone();
    // The text has them already.
    if global.json {
        warnings.extend(fit.warnings.iter().cloned());
    }
    if let Some(file) = &args.save_factors {
        write(file, fit.factors.to_toml().as_bytes())?;
        warnings.push(format!("wrote {}", file.display()));
    }
    if let Some(folder) = &args.figures {
        for (name, figure) in load_case_figures(&fit) {
            let written = write_figure(&folder.join(name), &figure, &data.inputs)?;
            warnings.extend(
                written
                    .iter()
                    .map(|path| format!("wrote {}", path.display())),
            );
        }
    }
    let open = fit.estimates.iter().any(|estimate| {
        matches!(
            estimate.status,
            FactorStatus::AtBound { .. } | FactorStatus::NotIdentified { .. }
        )
    });
    let (planned, table) = data.plan(&fit, FURTHER)?;
    if let Some(file) = &args.next {
        write(file, write_load_cases(&table).as_bytes())?;
        warnings.push(format!(
            "wrote {}: fill in the displacements",
            file.display()
        ));
    }
    let report = LoadCaseFitReport::from(&fit).with_next(&planned, &data.model.robot);
    let text = load_case_fit_text(&fit) + &next_load_cases_text(&report);
    let report = FitResult::LoadCases(Box::new(report));
    Ok(Outcome::new("fit", text, report)
        .with_inputs(data.inputs.clone())
        .with_warnings(warnings)
        .with_strict_exit(if open { 41 } else { 0 }))
}

/// Options without effect are a misunderstanding, and worth an error.
fn refuse_what_needs_cells(args: &FitArgs) -> Result<(), ArgumentError> {
    let of_cells = [
        ("--method paper", args.method == MethodArg::Paper),
        ("--bootstrap", args.bootstrap > 0),
        ("--global-search", args.global_search),
    ];
    match of_cells.iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => Err(ArgumentError::new(
            (*option).to_owned(),
            "the data are load cases: loads and displacements as vectors, without runs",
            "leave it out; load cases are fitted by least squares",
        )),
    }
}
