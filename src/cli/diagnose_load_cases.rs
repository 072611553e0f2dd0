//! `stiffbench diagnose` of load cases.

use crate::analysis::{
    ArgumentError, DiagnoseSettings, LoadCaseData, LoadedLoadCases, OpenSettings,
};
use crate::physics::Law;

use super::args::Global;
use super::diagnose::{noise, report_of};
use super::diagnose_args::DiagnoseArgs;
use super::failure::{Failure, refuse_given};
use super::outcome::Outcome;
use super::progress::progress;

/// Finds what the free parameters leave out.
pub(super) fn run(
    args: &DiagnoseArgs,
    loaded: &LoadedLoadCases,
    (settings, without): (&OpenSettings, Vec<Law>),
    global: &Global,
) -> Result<Outcome, Failure> {
    refuse_what_needs_runs(args)?;
    let mut data = LoadCaseData::new(loaded, &args.model.choice()?)
        .map_err(|error| Failure::from(error).with_warnings(&loaded.warnings))?;
    data.join_at(&args.further, settings)?;
    let warnings = data.warnings.clone();
    of_data(args, loaded, data, without, global).map_err(|failure| failure.with_warnings(&warnings))
}

fn of_data(
    args: &DiagnoseArgs,
    loaded: &LoadedLoadCases,
    mut data: LoadCaseData,
    without: Vec<Law>,
    global: &Global,
) -> Result<Outcome, Failure> {
    let bar = progress(global, "diagnosis (read, search, judge, draw)", 4);
    let choice = data.usual_choice()?;
    let choice = args.parameters.choice_beside(&data.model, choice)?;
    let options = DiagnoseSettings {
        parameters: Some(choice),
        noise: noise(args, &without, global)?,
        seed: args.seed,
        without,
        keep_outliers: args.keep_outliers,
    };
    let report = data.diagnose(loaded, options, &|| bar.inc(1))?;
    let mut warnings = data.warnings.clone();
    warnings.extend(report.warnings.iter().cloned());
    let outcome = report_of(args, &report, &data.model, (data.inputs.clone(), warnings))?;
    bar.finish_and_clear();
    Ok(outcome)
}

/// Options without effect are a misunderstanding, and worth an error.
fn refuse_what_needs_runs(args: &DiagnoseArgs) -> Result<(), ArgumentError> {
    let of_runs = [("--earlier", !args.earlier.is_empty())];
    refuse_given(&of_runs, "load cases are no session", |_| {
        "leave it out: the scatter of load cases comes from repeats, from the fit, or from the records of the instruments".to_owned()
    })
}
