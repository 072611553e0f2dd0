//! From sessions and settings to the data of a report.

use stiffbench_document::Document;

use crate::analysis::{
    AnalysisError, ArgumentError, DiagnoseSettings, DiagnosisData, Failure, FitData, FitSettings,
    ModelChoice,
};
use crate::fit::PoseRules;
use crate::parameters::ParameterChoice;
use crate::report::{COMMIT, ComparisonReport, Fitted};
use crate::stiffness::{Comparison, Method, StiffnessTable};
use crate::test_point::Direction;

use super::conformity::conformity;
use super::details::{KnownItems, page_items};
use super::figures::{figures_of_diagnosis, figures_of_fit, readings_figure};
use super::map::{MappedModel, add_map};
use super::model::{PageComparison, PageDiagnosis, PageFit, PageModel};
use super::session::PageSession;
use super::source::PageSource;
use super::{PageFigures, PageProgram, PageSettings, ReportPage};

/// Why a report that was asked for without a diagnosis has none.
const NO_DIAGNOSIS: &str = "Diagnosis: not asked for (--no-diagnosis).";

/// Why a report of a session without a robot has neither fit nor diagnosis.
const NO_ROBOT: &str = "Fit, map and diagnosis: no robot is named (--robot).";

/// The schema of the data of a report.
pub(super) const SCHEMA: &str = "stiffbench/report/1";

/// The report of one session, or of several of one robot.
///
/// # Errors
/// For a model that cannot be resolved and training poses that the data do not have. A fit or diagnosis that the readings do not
/// allow is left out, and the report states why.
pub fn session_page(
    source: &PageSource,
    choice: &ModelChoice,
    settings: &PageSettings,
    template_sha256: &str,
) -> Result<ReportPage, Failure> {
    let mut page = bare_page(source, settings, template_sha256);
    match add_model(&mut page, source, choice, settings) {
        Ok(()) => {}
        Err(failure) if is_without_robot(&failure) => page.left_out.push(NO_ROBOT.to_owned()),
        Err(error) => return Err(error),
    }
    Ok(finished(page))
}

/// The report of the difference of two sessions.
#[must_use]
pub fn comparison_page(
    source: &PageSource,
    comparison: &Comparison,
    two_robots: bool,
    settings: &PageSettings,
    template_sha256: &str,
) -> ReportPage {
    let mut page = bare_page(source, settings, template_sha256);
    let numbers = ComparisonReport::new(comparison, two_robots);
    let name = |place: usize| {
        source
            .parts
            .get(place)
            .map_or("", |part| part.name.as_str())
    };
    page.comparison = Some(PageComparison::new(numbers, [name(0), name(1)]));
    finished(page)
}

/// All but model, comparison and headline.
fn bare_page(source: &PageSource, settings: &PageSettings, template_sha256: &str) -> ReportPage {
    let marks = source.marks();
    let named: Vec<(&str, &StiffnessTable)> = source
        .parts
        .iter()
        .zip(&source.tables)
        .map(|(part, table)| (part.name.as_str(), table))
        .collect();
    let names: Vec<&str> = source.parts.iter().map(|part| part.name.as_str()).collect();
    let title = format!("Stiffness of {}", names.join(" and "));
    let cells = match &source.parts[..] {
        [session] => &session.results[..],
        _ => &[],
    };
    ReportPage {
        schema: SCHEMA,
        title: settings.details.title.clone().unwrap_or(title),
        number: String::new(),
        issued: settings.issued.clone(),
        replaces: settings.amends.clone(),
        marks: marks.iter().map(|(mark, _)| *mark).collect(),
        mark_sentences: marks.into_iter().map(|(_, words)| words).collect(),
        answer: Document::new(),
        body: Document::new(),
        signatures: Vec::new(),
        items: Vec::new(),
        conformity: None,
        sessions: source.parts.clone(),
        comparison: None,
        model: None,
        fit: None,
        map: Document::new(),
        diagnosis: None,
        left_out: Vec::new(),
        figures: PageFigures {
            readings: (!named.is_empty())
                .then(|| readings_figure(&named, cells))
                .into_iter()
                .collect(),
            ..PageFigures::default()
        },
        settings: settings.clone(),
        program: PageProgram {
            name: env!("CARGO_PKG_NAME").to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: COMMIT.to_owned(),
            template_sha256: template_sha256.to_owned(),
        },
    }
}

/// Fit and diagnosis, or why there are none.
fn add_model(
    page: &mut ReportPage,
    source: &PageSource,
    choice: &ModelChoice,
    settings: &PageSettings,
) -> Result<(), Failure> {
    let mut data = DiagnosisData::new(&source.data, choice)?;
    let parameters = data.usual_choice()?;
    page.model = Some(PageModel::from(&data.model));
    match fitted(source, choice, &parameters, settings) {
        Ok((fitted, at_load_n)) => add_fit(page, fitted, &data, at_load_n),
        Err(failure) if failure.error().is::<ArgumentError>() => return Err(failure),
        Err(failure) => page.leave_out("Fit", &failure),
    }
    if settings.no_diagnosis {
        page.left_out.push(NO_DIAGNOSIS.to_owned());
        return Ok(());
    }
    let options = DiagnoseSettings {
        parameters: Some(parameters),
        seed: settings.seed,
        ..DiagnoseSettings::default()
    };
    match data.diagnose(options, &|| ()) {
        Ok(report) => {
            page.figures.diagnosis = figures_of_diagnosis(&report);
            page.diagnosis = Some(PageDiagnosis::from(&report));
        }
        Err(failure) => page.leave_out("Diagnosis", &failure),
    }
    Ok(())
}

/// A fit with its figures and the stiffness over the workspace.
fn add_fit(page: &mut ReportPage, fitted: Fitted, data: &DiagnosisData, at_load_n: f64) {
    let outcome = fitted.outcome;
    page.figures.fit = figures_of_fit(&fitted.figures);
    page.fit = Some(PageFit::new(&outcome, fitted.report));
    let mapped = MappedModel {
        robot: &data.model.robot,
        mechanism: &outcome.mechanism,
        factors: &outcome.factors,
        effects: &outcome.physics,
        estimates: &outcome.estimates,
        at_load_n,
    };
    let along = outcome.cells.iter().map(|cell| cell.cell.direction);
    let across = outcome.across.iter().map(|one| one.cell.direction);
    let components = outcome.components.iter().map(|one| one.axis);
    let axes: Vec<Direction> = along.chain(across).chain(components).collect();
    add_map(page, &mapped, &axes);
    // Of stiffness they say what the page shows.
    let failed_checks = fitted.failed_checks.into_iter();
    let failed_checks = failed_checks.filter(|_| !outcome.components.is_empty());
    if let Some(session) = page.sessions.first_mut() {
        session.deviations.extend(failed_checks);
    }
}

/// The largest load of sessions, N.
fn largest_load_n(tables: &[StiffnessTable]) -> f64 {
    let cells = tables.iter().flat_map(|table| &table.cells);
    let loads = cells.flat_map(|cell| &cell.loads);
    loads.map(|load| load.target_n.abs()).fold(0.0, f64::max)
}

/// A fit, and the load that is usual in its data, N.
fn fitted(
    source: &PageSource,
    choice: &ModelChoice,
    parameters: &ParameterChoice,
    settings: &PageSettings,
) -> Result<(Fitted, f64), Failure> {
    let data = FitData::new(source.data.clone(), choice, Method::Regression)?;
    let fit = FitSettings {
        train: settings.train.clone(),
        choice: Some(parameters.clone()),
        seed: settings.seed,
        ..FitSettings::default()
    };
    let outcome = data.fit(&fit, &|| ())?;
    let mut fitted = Fitted::new(&data, &fit, outcome)?;
    let mut estimates = fitted.outcome.estimates.iter();
    if data.posed.is_some()
        || estimates.any(|one| !one.parameter.is_factor() && one.status.why_open().is_some())
    {
        fitted
            .report
            .plan_next(data.plan(&fitted.outcome, &PoseRules::default())?.planned);
    }
    let of_cases = data.posed.map(|data| data.posed.usual_force_n());
    let at_load_n = of_cases.unwrap_or_else(|| largest_load_n(&source.tables));
    Ok((fitted, at_load_n))
}

/// Whether data need a model, and no robot is named.
fn is_without_robot(failure: &Failure) -> bool {
    let error = failure.error().downcast_ref();
    matches!(error, Some(AnalysisError::NoRobot { .. }))
}

impl ReportPage {
    /// States why a part is missing.
    pub(super) fn leave_out(&mut self, part: &str, failure: &Failure) {
        self.left_out
            .push(format!("{part}: {}.", in_words(failure.error())));
    }
}

/// An error with its causes in one sentence.
fn in_words(error: &dyn std::error::Error) -> String {
    let mut words = error.to_string();
    let mut cause = error.source();
    while let Some(next) = cause {
        let next_words = next.to_string();
        if !words.contains(&next_words) {
            words = format!("{words}: {next_words}");
        }
        cause = next.source();
    }
    words
}

/// With items, statement of conformity, headline and number.
fn finished(mut page: ReportPage) -> ReportPage {
    let details = &page.settings.details;
    if let ([session], None) = (page.sessions.as_slice(), &page.comparison) {
        page.conformity = conformity(details.decision_rule, &details.requirements, session);
    }
    let last_day = page.sessions.iter().filter_map(PageSession::last_day).max();
    page.issued = page.issued.clone().or_else(|| last_day.map(str::to_owned));
    let known = KnownItems {
        method: page.of_sessions(|session| {
            let method = session.condition("procedure")?;
            Some(format!("procedure {method} of stiffbench"))
        }),
        performed: page.of_sessions(|session| session.performed.clone()),
        issued: page.issued.clone(),
        place: page.of_sessions(|session| session.condition("place")),
        deviations: page
            .sessions
            .iter()
            .any(|session| !session.deviations.is_empty())
            .then(|| "listed under Deviations and remarks".to_owned()),
    };
    page.items = page_items(&page.settings.details, &known);
    page.answer = page.answer();
    page.signatures = page.signatures();
    page.numbered()
}
