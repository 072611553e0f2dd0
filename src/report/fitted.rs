//! A fit with everything that is shown of it.

use crate::analysis::{
    Failure, FitData, FitSettings, doubts_about_fit, doubts_about_load_case_fit,
};
use crate::fit::FitOutcome;
use crate::parameters::ParameterChoice;
use crate::plot::Figure;

use super::component_figures::component_figures;
use super::data_checks::{bad_value_words, table_mistake_words};
use super::figures::{fit_figures, residuals_figure};
use super::fit_report::FitReport;

/// A fit with everything that is shown of it.
#[derive(Debug)]
pub struct Fitted {
    /// The fit.
    pub outcome: FitOutcome,
    /// Its numbers.
    pub report: FitReport,
    /// Its figures, each with the name of its file.
    pub figures: Vec<(&'static str, Figure)>,
    /// What is doubtful about data and fit: units that make an implausible robot, mistakes of a table, bad values.
    pub failed_checks: Vec<String>,
}

impl Fitted {
    /// Draws and judges a fit.
    ///
    /// # Errors
    /// As of the fit.
    pub fn new(
        data: &FitData,
        settings: &FitSettings,
        outcome: FitOutcome,
    ) -> Result<Self, Failure> {
        let (figures, mut failed_checks) = if let Some(posed) = &data.posed {
            (
                component_figures(&outcome, &posed.posed, &data.model.robot),
                doubts_about_load_case_fit(&posed.posed, &outcome),
            )
        } else {
            let table = data.session.as_ref().map(|(_, table)| table);
            let choice = settings.choice.as_ref();
            let range = choice.map_or(ParameterChoice::default().range, |choice| choice.range);
            let mut figures = fit_figures(&outcome, table, range);
            if let Some(table) = table {
                figures.push(("residuals", residuals_figure(data, &outcome, table)?));
            }
            (figures, doubts_about_fit(&outcome))
        };
        let (mistake, bad) = data.mistakes(settings, &outcome)?;
        failed_checks.extend(mistake.as_ref().map(table_mistake_words));
        failed_checks.extend(bad_value_words(&bad));
        Ok(Self {
            report: FitReport::from(&outcome).of_data(data),
            figures,
            failed_checks,
            outcome,
        })
    }
}
