//! From sessions and settings to the data of a report.

use std::path::{Path, PathBuf};

use crate::analysis::{
    AnalysisError, Data, DiagnoseSettings, FitData, FitSettings, LoadedSession, ModelChoice,
    OpenSettings, SessionHistory, diagnose_together, open_together, resolve_together,
};
use crate::report::{ComparisonReport, FitReport};
use crate::stiffness::{Branches, Comparison, Method, StiffnessTable};

use super::conformity::conformity;
use super::details::{KnownItems, page_items};
use super::figures::{figures_of_diagnosis, figures_of_fit, readings_figure};
use super::headline::HeadlineParts;
use super::model::{PageComparison, PageDiagnosis, PageFit, PageModel};
use super::session::PageSession;
use super::{PageFigures, PageProgram, PageSettings, ReportPage};

/// The schema of the data of a report.
const SCHEMA: &str = "stiffbench/report/1";

/// The sessions of a report, opened.
#[derive(Debug)]
pub struct PageSource {
    /// The sessions, in the order in which they were named. Each is called by its identifier or file name, wherever it lies.
    pub sessions: Vec<LoadedSession>,
    tables: Vec<StiffnessTable>,
    histories: Vec<Option<SessionHistory>>,
    parts: Vec<PageSession>,
}

impl PageSource {
    /// Opens sessions and computes their stiffness.
    ///
    /// # Errors
    /// For data that are not there or cannot be read, and a table that differs from its journal.
    pub fn open(paths: &[PathBuf], options: &OpenSettings) -> Result<Self, AnalysisError> {
        let opened: Result<Vec<_>, _> = paths.iter().map(|path| open(path, options)).collect();
        Self::of(opened?)
    }

    /// Opens sessions of one robot that are fitted and diagnosed together.
    ///
    /// # Errors
    /// As [`open`](Self::open), and for sessions that do not go together.
    pub fn open_joined(paths: &[PathBuf], options: &OpenSettings) -> Result<Self, AnalysisError> {
        let Some((first, further)) = paths.split_first() else {
            return Self::of(Vec::new());
        };
        let first = LoadedSession::open(first, options)?;
        let opened = open_together(first, further, options)?;
        Self::of(opened.into_iter().map(called_by_short_name).collect())
    }

    fn of(sessions: Vec<LoadedSession>) -> Result<Self, AnalysisError> {
        let (mut tables, mut histories, mut parts) = (Vec::new(), Vec::new(), Vec::new());
        for session in &sessions {
            let table = session.stiffness(Branches::LoadingOnly)?;
            let history = session.history()?;
            let files = session.file_hashes()?;
            parts.push(PageSession::new(
                session,
                table.clone(),
                history.as_ref(),
                &files,
            ));
            tables.push(table);
            histories.push(history);
        }
        Ok(Self {
            sessions,
            tables,
            histories,
            parts,
        })
    }

    /// Gauges whose calibration had run out when they were used.
    #[must_use]
    pub fn overdue(&self) -> Vec<String> {
        let gauges = self.parts.iter().flat_map(|part| {
            let overdue = part.gauges.iter().filter(|gauge| gauge.overdue);
            overdue.map(|gauge| format!("{} of {} (due {})", gauge.name, part.name, gauge.due))
        });
        gauges.collect()
    }

    /// What a reader must not overlook, each with a sentence.
    fn marks(&self) -> Vec<(&'static str, &'static str)> {
        let origin = |word: &str| {
            let origins = self.sessions.iter().filter_map(LoadedSession::origin);
            origins.into_iter().any(|origin| origin.contains(word))
        };
        let partial = self.histories.iter().flatten();
        let partial = partial.into_iter().any(|history| !history.is_complete());
        let unprotected = self
            .parts
            .iter()
            .any(|part| !part.protected && part.origin.is_none());
        let mut headers = self
            .sessions
            .iter()
            .filter_map(|session| session.header.as_ref());
        let imported = headers.any(|header| header.import.is_some());
        let marks = [
            (
                partial,
                "PARTIAL",
                "The session is not complete: planned readings are missing.",
            ),
            (
                origin("emulated"),
                "EMULATED",
                "The readings come from emulated gauges; nothing was measured.",
            ),
            (
                origin("simulated"),
                "SIMULATED",
                "The readings were simulated; nothing was measured.",
            ),
            (
                imported,
                "IMPORTED, NOT PROTECTED",
                "The readings were imported from another program; no journal protects them.",
            ),
            (
                unprotected && !imported,
                "NOT PROTECTED",
                "No journal protects the readings: they may have been changed.",
            ),
        ];
        let true_ones = marks.into_iter().filter(|(is_true, ..)| *is_true);
        true_ones.map(|(_, mark, words)| (mark, words)).collect()
    }
}

fn open(path: &Path, options: &OpenSettings) -> Result<LoadedSession, AnalysisError> {
    LoadedSession::open(path, options).map(called_by_short_name)
}

/// The session called by its identifier, in its notes too, so that a report is the same wherever the session lies.
fn called_by_short_name(mut session: LoadedSession) -> LoadedSession {
    let short = session.short_name();
    let path = std::mem::replace(&mut session.name, short.clone());
    for warning in &mut session.warnings {
        *warning = renamed(warning, &path, &short);
    }
    session
}

/// A text with a path, where it stands as a word, put under another name.
fn renamed(text: &str, path: &str, name: &str) -> String {
    let is_edge = |c: Option<char>| !c.is_some_and(|c| c.is_alphanumeric() || "-_.".contains(c));
    let (mut renamed, mut rest) = (String::new(), text);
    while let Some(at) = rest.find(path).filter(|_| !path.is_empty()) {
        let (before, behind) = (&rest[..at], &rest[at + path.len()..]);
        let before_it = before.chars().last().or_else(|| renamed.chars().last());
        let is_word = is_edge(before_it) && is_edge(behind.chars().next());
        renamed.push_str(before);
        renamed.push_str(if is_word { name } else { path });
        rest = behind;
    }
    renamed + rest
}

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
    add_model(&mut page, source, choice, settings)?;
    Ok(finished(page, source))
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
    finished(page, source)
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
    let empty = HeadlineParts {
        sessions: &[],
        comparison: None,
        fit: None,
        diagnosis: None,
        conformity: None,
    };
    let names: Vec<&str> = named.iter().map(|(name, _)| *name).collect();
    let title = format!("Stiffness of {}", names.join(" and "));
    ReportPage {
        schema: SCHEMA,
        title: settings.details.title.clone().unwrap_or(title),
        number: String::new(),
        issued: settings.issued.clone(),
        replaces: settings.amends.clone(),
        marks: marks.iter().map(|(mark, _)| *mark).collect(),
        mark_sentences: marks.iter().map(|(_, words)| *words).collect(),
        headline: empty.headline(),
        items: Vec::new(),
        conformity: None,
        sessions: source.parts.clone(),
        comparison: None,
        model: None,
        fit: None,
        diagnosis: None,
        left_out: Vec::new(),
        figures: PageFigures {
            readings: vec![readings_figure(&named)],
            ..PageFigures::default()
        },
        settings: settings.clone(),
        program: PageProgram {
            name: env!("CARGO_PKG_NAME"),
            version: env!("CARGO_PKG_VERSION"),
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
) -> Result<(), AnalysisError> {
    let model = match resolve_together(&source.sessions, choice) {
        Ok(model) => model,
        Err(AnalysisError::NoRobot { .. }) => {
            let why = "Fit and diagnosis: no robot is named (--robot).";
            page.left_out.push(why.to_owned());
            return Ok(());
        }
        Err(error) => return Err(error),
    };
    page.model = Some(PageModel::from(&model));
    let fitted = fitted(source, choice, settings);
    match fitted {
        Ok((outcome, numbers)) => {
            let table = source.tables.first().filter(|_| source.tables.len() == 1);
            let range = crate::parameters::ParameterChoice::default().range;
            page.figures.fit = figures_of_fit(&outcome, table, range);
            page.fit = Some(PageFit::new(&outcome, numbers));
        }
        Err(AnalysisError::Argument(error)) => return Err(error.into()),
        Err(error) => page.left_out.push(format!("Fit: {}.", in_words(&error))),
    }
    if settings.no_diagnosis {
        page.left_out
            .push("Diagnosis: not asked for (--no-diagnosis).".to_owned());
        return Ok(());
    }
    let diagnose = DiagnoseSettings {
        seed: settings.seed,
        ..DiagnoseSettings::default()
    };
    match diagnose_together(&source.sessions, &model, diagnose, &|| ()) {
        Ok(report) => {
            page.figures.diagnosis = figures_of_diagnosis(&report);
            page.diagnosis = Some(PageDiagnosis::from(&report));
        }
        Err(error) => {
            let why = format!("Diagnosis: {}.", in_words(&error));
            page.left_out.push(why);
        }
    }
    Ok(())
}

fn fitted(
    source: &PageSource,
    choice: &ModelChoice,
    settings: &PageSettings,
) -> Result<(crate::fit::FitOutcome, FitReport), AnalysisError> {
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
    let numbers = FitReport::from(&outcome).of_sessions(&data.sessions);
    Ok((outcome, numbers))
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
fn finished(mut page: ReportPage, source: &PageSource) -> ReportPage {
    let details = &page.settings.details;
    if let ([table], None) = (source.tables.as_slice(), &page.comparison) {
        page.conformity = conformity(details.decision_rule, &details.requirements, table);
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
        number: String::new(),
        method: of_sessions(|session| {
            let method = session.method()?;
            Some(format!("procedure {method} of stiffbench"))
        }),
        performed: of_sessions(|session| session.performed.clone()),
        issued: page.issued.clone(),
        place: of_sessions(place),
    };
    page.items = page_items(&page.settings.details, &known);
    page.headline = HeadlineParts {
        sessions: &page.sessions,
        comparison: page.comparison.as_ref(),
        fit: page.fit.as_ref(),
        diagnosis: page.diagnosis.as_ref(),
        conformity: page.conformity.as_ref(),
    }
    .headline();
    page.numbered()
}

#[cfg(test)]
mod tests {
    use super::renamed;

    #[test]
    fn a_path_is_renamed_as_a_word_only() {
        let text = "e/readings.csv:3: the value e is held; see/e.toml";
        let expected = "id/readings.csv:3: the value id is held; see/e.toml";
        assert_eq!(renamed(text, "e", "id"), expected);
        assert_eq!(renamed("a b", "", "id"), "a b");
    }
}
