//! Fit and diagnosis of load cases for a report.

use crate::analysis::{
    AnalysisError, DiagnoseSettings, LoadCaseData, LoadCaseSettings, ModelChoice,
};
use crate::report::{LoadCaseFitReport, doubts_about_load_cases, load_case_figures};

use super::build::{NO_DIAGNOSIS, show_diagnosis};
use super::figures::page_figure;
use super::map::{MappedModel, add_map};
use super::model::{PageFit, PageModel};
use super::source::PageSource;
use super::{PageSettings, ReportPage};

/// Fit and diagnosis of load cases of one robot, or why there are none.
///
/// # Errors
/// For a model that cannot be resolved, training poses that the data do not have, and data of another robot.
pub(super) fn add_load_case_model(
    page: &mut ReportPage,
    source: &PageSource,
    choice: &ModelChoice,
    settings: &PageSettings,
) -> Result<(), AnalysisError> {
    let Some((first, further)) = source.load_cases.split_first() else {
        return Ok(());
    };
    let mut data = LoadCaseData::new(first, choice)?;
    for one in further {
        data.join(one)?;
    }
    page.model = Some(PageModel::from(&data.model));
    let fit_settings = LoadCaseSettings {
        train: settings.train.clone(),
        choice: data.usual_choice()?,
        ..LoadCaseSettings::default()
    };
    let fit = match data.fit(&fit_settings) {
        Ok(fit) => fit,
        Err(error @ AnalysisError::Argument(_)) => return Err(error),
        Err(error) => {
            page.leave_out("Fit", &error);
            return Ok(());
        }
    };
    let plan = data.plan(&fit)?;
    let numbers = LoadCaseFitReport::new(&fit, plan.planned);
    let figures = load_case_figures(&fit, &data.posed, &data.model.robot);
    page.figures.fit = figures
        .iter()
        .map(|(name, figure)| page_figure(*name, figure))
        .collect();
    page.fit = Some(PageFit::of_load_cases(&fit, numbers));
    let fitted = MappedModel {
        robot: &data.model.robot,
        mechanism: &fit.mechanism,
        factors: &fit.factors,
        effects: &[],
        estimates: &fit.estimates,
        at_load_n: 0.0,
    };
    let axes = fit.components.iter().map(|component| component.axis);
    add_map(page, &fitted, &axes.collect::<Vec<_>>());
    let warnings = doubts_about_load_cases(&data, &fit_settings, &fit)?;
    if let Some(session) = page.sessions.first_mut() {
        session.deviations.extend(warnings);
    }
    if settings.no_diagnosis {
        page.left_out.push(NO_DIAGNOSIS.to_owned());
        return Ok(());
    }
    let all_poses = LoadCaseSettings {
        train: None,
        ..fit_settings
    };
    let options = DiagnoseSettings {
        parameters: Some(all_poses.choice.clone()),
        seed: settings.seed,
        ..DiagnoseSettings::default()
    };
    let diagnosed = data.diagnose(first, &all_poses, options, &|| ());
    show_diagnosis(page, diagnosed);
    Ok(())
}
