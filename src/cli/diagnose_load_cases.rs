//! `stiffbench diagnose` of load cases.

use serde_json::json;

use crate::analysis::{
    ArgumentError, LoadCaseData, LoadCaseSettings, LoadedLoadCases, doubts_about_load_case_fit,
};
use crate::report::{
    DiagnosisResult, LoadCaseDiagnosisReport, bad_load_case_value_words, load_case_figures,
};

use super::args::Global;
use super::diagnose::{folder, outcome, write_diagnosis};
use super::diagnose_args::{DiagnoseArgs, NoiseChoice};
use super::failure::{Failure, refuse_given};
use super::figure_files::{write_figures, wrote};
use super::fit_load_cases::LOAD_CASES_WITHOUT_RUNS;
use super::outcome::Outcome;

/// Finds what the free parameters leave out.
pub(super) fn run(
    args: &DiagnoseArgs,
    loaded: &LoadedLoadCases,
    global: &Global,
) -> Result<Outcome, Failure> {
    refuse_what_needs_runs(args)?;
    let mut data = LoadCaseData::new(loaded, &args.model.choice()?)
        .map_err(|error| Failure::from(error).with_warnings(&loaded.warnings))?;
    data.join_at(&args.further, &global.open_settings())?;
    of_data(args, &data, global).map_err(|failure| failure.with_warnings(&data.warnings))
}

fn of_data(args: &DiagnoseArgs, data: &LoadCaseData, global: &Global) -> Result<Outcome, Failure> {
    let settings = LoadCaseSettings {
        train: None,
        choice: args
            .parameters
            .choice_beside(&data.model, data.usual_choice()?)?,
        sigma: None,
        keep_bad_values: args.keep_outliers,
    };
    let diagnosis = data.diagnose(&settings, args.seed)?;
    let report = LoadCaseDiagnosisReport::new(&diagnosis, args.seed);
    let text = report.text(&diagnosis);
    let mut warnings = data.warnings.clone();
    warnings.extend(doubts_about_load_case_fit(&data.posed, &diagnosis.baseline));
    let unknown = diagnosis.baseline.estimates.iter();
    let unknown = unknown.filter(|one| one.known_value().is_none());
    warnings.extend(
        unknown.filter_map(|one| Some(format!("{}: {}", one.name, one.status.why_open()?))),
    );
    if settings.keep_bad_values {
        let kept = data.bad_values(&settings, &diagnosis.baseline)?;
        warnings.extend(kept.iter().map(bad_load_case_value_words));
    }
    if global.json {
        warnings.extend(diagnosis.baseline.warnings.iter().cloned());
    }
    if let Some(folder) = folder(args)? {
        let fields = [("data", json!(report)), ("warnings", json!(warnings))];
        let mut written = write_diagnosis(&folder, &text, &data.inputs, fields)?;
        if !args.no_figures {
            let bad = diagnosis.bad_values.iter().map(|one| one.row);
            let posed = data.posed.without_rows(&bad.collect::<Vec<_>>());
            let figures = load_case_figures(&diagnosis.baseline, &posed, &data.model.robot);
            written.extend(write_figures(&folder, figures, &data.inputs)?);
        }
        warnings.extend(wrote(&written));
    }
    let result = DiagnosisResult::LoadCases(Box::new(report));
    Ok(outcome(text, result)
        .with_inputs(data.inputs.clone())
        .with_warnings(warnings))
}

/// Options without effect are a misunderstanding, and worth an error.
fn refuse_what_needs_runs(args: &DiagnoseArgs) -> Result<(), ArgumentError> {
    let of_runs = [
        ("--without", !args.without.is_empty()),
        ("--earlier", !args.earlier.is_empty()),
        ("--noise records", args.noise == NoiseChoice::Records),
    ];
    refuse_given(&of_runs, LOAD_CASES_WITHOUT_RUNS, |_| {
        "leave it out: the scatter of load cases comes from repeats or from the residuals over the poses".to_owned()
    })
}
