//! From sessions and settings to the data of a report.

use crate::analysis::{
    AnalysisError, Data, DiagnoseSettings, DiagnosisReport, FitData, FitSettings, LoadCaseData,
    LoadedLoadCases, LoadedSession, ModelChoice, ResolvedModel, SessionObservations,
    diagnose_together, resolve_together,
};
use crate::fit::FitOutcome;
use crate::parameters::ParameterChoice;
use crate::plot::Figure;
use crate::report::{
    COMMIT, ComparisonReport, FitReport, component_figures, doubts_about_load_cases, fit_figures,
};
use crate::stiffness::{Comparison, Method, StiffnessTable};
use crate::test_point::Direction;

use super::conformity::conformity;
use super::details::{KnownItems, page_items};
use super::figures::{figures_of_diagnosis, figures_of_fit, readings_figure};
use super::headline::PageHeadline;
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
) -> Result<ReportPage, AnalysisError> {
    let mut page = bare_page(source, settings, template_sha256);
    let answered = match source.load_cases.split_first() {
        None => add_model(&mut page, source, choice, settings),
        Some((first, further)) => {
            add_load_case_model(&mut page, first, further, (choice, settings))
        }
    };
    match answered {
        Ok(()) => {}
        Err(AnalysisError::NoRobot { .. }) => {
            page.left_out.push(NO_ROBOT.to_owned());
        }
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
    ReportPage {
        schema: SCHEMA,
        title: settings.details.title.clone().unwrap_or(title),
        number: String::new(),
        issued: settings.issued.clone(),
        replaces: settings.amends.clone(),
        marks: marks.iter().map(|(mark, _)| *mark).collect(),
        mark_sentences: marks.iter().map(|(_, words)| *words).collect(),
        headline: PageHeadline::default(),
        items: Vec::new(),
        conformity: None,
        sessions: source.parts.clone(),
        comparison: None,
        model: None,
        fit: None,
        map: None,
        diagnosis: None,
        left_out: Vec::new(),
        figures: PageFigures {
            readings: (!named.is_empty())
                .then(|| readings_figure(&named))
                .into_iter()
                .collect(),
            ..PageFigures::default()
        },
        settings: settings.clone(),
        program: PageProgram {
            name: env!("CARGO_PKG_NAME"),
            version: env!("CARGO_PKG_VERSION"),
            commit: COMMIT.to_owned(),
            template_sha256: template_sha256.to_owned(),
        },
    }
}

/// Fit and diagnosis of sessions, or why there are none.
fn add_model(
    page: &mut ReportPage,
    source: &PageSource,
    choice: &ModelChoice,
    settings: &PageSettings,
) -> Result<(), AnalysisError> {
    let model = resolve_together(&source.sessions, choice)?;
    let fitted = fitted(source, choice, settings);
    add_fit(page, fitted, &model, largest_load_n(&source.tables))?;
    add_diagnosis(page, settings, |options| {
        let sessions = source.sessions.iter().map(LoadedSession::observed);
        let sessions: Vec<SessionObservations> = sessions.collect();
        diagnose_together(&sessions, &model, options, &|| ())
    });
    Ok(())
}

/// The same of load cases.
fn add_load_case_model(
    page: &mut ReportPage,
    first: &LoadedLoadCases,
    further: &[LoadedLoadCases],
    (choice, settings): (&ModelChoice, &PageSettings),
) -> Result<(), AnalysisError> {
    let mut data = LoadCaseData::new(first, choice)?;
    for one in further {
        data.join(one)?;
    }
    let choice = data.usual_choice()?;
    let options = FitSettings {
        train: settings.train.clone(),
        choice: Some(choice.clone()),
        ..FitSettings::default()
    };
    let fitted = data.fit(&options).and_then(|outcome| {
        let warnings = doubts_about_load_cases(&data, &options, &outcome)?;
        Ok(ShownFit {
            numbers: FitReport::from(&outcome).with_next(data.plan(&outcome)?.planned),
            figures: component_figures(&outcome, &data.posed, &data.model.robot),
            warnings,
            outcome,
        })
    });
    add_fit(page, fitted, &data.model, data.posed.usual_force_n())?;
    add_diagnosis(page, settings, |diagnose| {
        let diagnose = DiagnoseSettings {
            parameters: Some(choice),
            ..diagnose
        };
        data.diagnose(first, diagnose, &|| ())
    });
    Ok(())
}

/// A fit with what a page has of it.
struct ShownFit {
    outcome: FitOutcome,
    numbers: FitReport,
    figures: Vec<(&'static str, Figure)>,
    /// What is doubtful about the data.
    warnings: Vec<String>,
}

/// A fit with its figures and the stiffness over the workspace, or why there is none.
fn add_fit(
    page: &mut ReportPage,
    fitted: Result<ShownFit, AnalysisError>,
    model: &ResolvedModel,
    at_load_n: f64,
) -> Result<(), AnalysisError> {
    page.model = Some(PageModel::from(model));
    let fitted = match fitted {
        Ok(fitted) => fitted,
        Err(AnalysisError::Argument(error)) => return Err(error.into()),
        Err(error) => {
            page.leave_out("Fit", &error);
            return Ok(());
        }
    };
    let outcome = fitted.outcome;
    page.figures.fit = figures_of_fit(&fitted.figures);
    page.fit = Some(PageFit::new(&outcome, fitted.numbers));
    let mapped = MappedModel {
        robot: &model.robot,
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
    if let Some(session) = page.sessions.first_mut() {
        session.deviations.extend(fitted.warnings);
    }
    Ok(())
}

/// A diagnosis with its figures, or why there is none.
fn add_diagnosis(
    page: &mut ReportPage,
    settings: &PageSettings,
    diagnose: impl FnOnce(DiagnoseSettings) -> Result<DiagnosisReport, AnalysisError>,
) {
    if settings.no_diagnosis {
        page.left_out.push(NO_DIAGNOSIS.to_owned());
        return;
    }
    let options = DiagnoseSettings {
        seed: settings.seed,
        ..DiagnoseSettings::default()
    };
    match diagnose(options) {
        Ok(report) => {
            page.figures.diagnosis = figures_of_diagnosis(&report);
            page.diagnosis = Some(PageDiagnosis::from(&report));
        }
        Err(error) => page.leave_out("Diagnosis", &error),
    }
}

/// The largest load of sessions, N.
fn largest_load_n(tables: &[StiffnessTable]) -> f64 {
    let cells = tables.iter().flat_map(|table| &table.cells);
    let loads = cells.flat_map(|cell| &cell.loads);
    loads.map(|load| load.target_n.abs()).fold(0.0, f64::max)
}

fn fitted(
    source: &PageSource,
    choice: &ModelChoice,
    settings: &PageSettings,
) -> Result<ShownFit, AnalysisError> {
    let data = match source.sessions.as_slice() {
        [one] => FitData::new(
            Data::Readings(Box::new(one.clone())),
            choice,
            Method::Regression,
        )?,
        several => FitData::together(several, choice, Method::Regression)?,
    };
    let fit = FitSettings {
        train: settings.train.clone(),
        seed: settings.seed,
        ..FitSettings::default()
    };
    let outcome = data.fit(&fit, &|| ())?;
    let mut numbers = FitReport::from(&outcome).of_data(&data);
    let mut estimates = outcome.estimates.iter();
    if estimates.any(|one| !one.parameter.is_factor() && one.status.why_open().is_some()) {
        numbers = numbers.with_next(data.plan(&outcome)?.planned);
    }
    let table = source.tables.first().filter(|_| source.tables.len() == 1);
    let range = ParameterChoice::default().range;
    Ok(ShownFit {
        figures: fit_figures(&outcome, table, range),
        numbers,
        warnings: Vec::new(),
        outcome,
    })
}

impl ReportPage {
    /// States why a part is missing.
    pub(super) fn leave_out(&mut self, part: &str, error: &dyn std::error::Error) {
        self.left_out.push(format!("{part}: {}.", in_words(error)));
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
    let of_sessions = |value: fn(&PageSession) -> Option<String>| {
        let mut values: Vec<String> = page.sessions.iter().filter_map(value).collect();
        values.dedup();
        (!values.is_empty()).then(|| values.join("; "))
    };
    let place = |session: &PageSession| {
        let own = session.conditions.iter();
        let mut own = own.filter(|entry| entry.name == "place");
        own.next().map(|entry| entry.value.clone())
    };
    let known = KnownItems {
        method: of_sessions(|session| {
            let method = session.method()?;
            Some(format!("procedure {method} of stiffbench"))
        }),
        performed: of_sessions(|session| session.performed.clone()),
        issued: page.issued.clone(),
        place: of_sessions(place),
        deviations: page
            .sessions
            .iter()
            .any(|session| !session.deviations.is_empty())
            .then(|| "listed under Deviations and remarks".to_owned()),
    };
    page.items = page_items(&page.settings.details, &known);
    page.headline = page.answer();
    page.numbered()
}
