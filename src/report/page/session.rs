//! One session of a report: results, budget, conditions, instruments and deviations.

use schemars::JsonSchema;
use serde::Serialize;
use stiffbench_document::Document;

use crate::analysis::{
    AnalysisError, LoadedLoadCases, LoadedSession, SessionHistory, SessionTable,
    doubts_about_stiffness,
};
use crate::quantity::{
    METRES_PER_MICROMETRE, NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM,
};
use crate::readings::{InstrumentRecord, OverdueGauge, SessionHeader};
use crate::report::stiffness::flag_lines;
use crate::report::{VectorStiffnessReport, significant};
use crate::session::OmittedReadings;
use crate::stiffness::{Branches, Method, StiffnessTable, is_factor_of_limits};

use super::first_page::about;
use super::procedure::as_done;
use super::results::{PageBudget, PageCell};
use crate::count::counted;

/// What stands where nothing is recorded.
pub(super) const NOT_RECORDED: &str = "not recorded";

/// A word with its value.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageEntry {
    /// What it is.
    pub name: String,
    /// Its value with its unit.
    pub value: String,
}

impl PageEntry {
    pub(super) fn new(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            value: value.into(),
        }
    }
}

/// A gauge as printed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageGauge {
    /// What it is.
    pub name: String,
    /// Its model.
    pub model: String,
    /// Its serial number.
    pub serial: String,
    /// Its range.
    pub range: String,
    /// Its resolution.
    pub resolution: String,
    /// Expanded uncertainty of its certificate, with k.
    pub expanded: String,
    /// Number of the certificate.
    pub certificate: String,
    /// Day of the calibration.
    pub calibrated: String,
    /// Last day on which it counts.
    pub due: String,
    /// Whether the calibration had run out when it was used.
    pub overdue: bool,
}

/// One session of a report.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PageSession {
    /// What it is called.
    pub name: String,
    /// How the readings came about if they were not measured.
    pub origin: Option<String>,
    /// Whether every planned reading was taken; `null` without a journal.
    pub complete: Option<bool>,
    /// Whether a journal protects the readings.
    pub protected: bool,
    /// Days of the measurement.
    pub performed: Option<String>,
    /// The procedure as it was done.
    pub procedure: Option<String>,
    /// How many readings or load cases there are, and of how many that were planned.
    pub about: String,
    /// Number of readings that count.
    pub readings: usize,
    /// Number of load cases; `null` of readings along the load.
    pub load_cases: Option<usize>,
    /// Whether the readings come from another program.
    pub imported: bool,
    /// Stiffness of every cell.
    pub results: Vec<PageCell>,
    /// Their uncertainty.
    pub budget: PageBudget,
    /// Further results: compliance along the axes of the base.
    pub further: Document,
    /// Procedure, operator, place, environment.
    pub conditions: Vec<PageEntry>,
    /// The gauges.
    pub gauges: Vec<PageGauge>,
    /// Cells left out, readings repeated, flags, and what else was not as planned.
    pub deviations: Vec<String>,
    /// Name and SHA-256 of every file.
    pub files: Vec<PageEntry>,
    /// All numbers of the stiffness; `null` of load cases.
    pub numbers: Option<StiffnessTable>,
    /// All numbers of the compliance along the axes of the base; `null` of readings along the load.
    pub vectors: Option<VectorStiffnessReport>,
}

impl PageSession {
    /// A session with its stiffness, of several gauges with its compliances, and, if it has one, what its journal tells.
    ///
    /// # Errors
    /// For a journal or a file that cannot be read.
    pub fn new(session: &LoadedSession, table: StiffnessTable) -> Result<Self, AnalysisError> {
        let readings = || session.table.one_of_each_load();
        let texts = readings().filter_map(|reading| reading.text.as_ref());
        let utc: Vec<&str> = texts.map(|text| &*text.utc).collect();
        let temperatures = readings().filter_map(|one| one.temperature_deg_c);
        let temperatures: Vec<f64> = temperatures.collect();
        let history = session.history()?;
        let mut page = without_results(session, history.as_ref(), &utc, &temperatures)?;
        page.readings = readings().filter(|one| one.is_accepted()).count();
        let record = session
            .header
            .as_ref()
            .and_then(|one| one.procedure.as_ref());
        page.procedure = as_done(record, &session.table);
        page.about = about([page.readings, 0], planned(history.as_ref()));
        if session.table.is_of_vectors() && !session.table.is_of_one_gauge() {
            let stiffness = session.compliances(Branches::LoadingOnly);
            let report = VectorStiffnessReport::new(&stiffness, session.procedure());
            page.results = report.cells.iter().map(PageCell::from).collect();
            page.further = report.document();
            page.vectors = Some(report);
            return Ok(page);
        }
        page.results = table.cells.iter().map(PageCell::from).collect();
        page.budget = PageBudget::from(&table);
        page.deviations = deviations(session, &table, history.as_ref());
        page.numbers = Some(table);
        Ok(page)
    }

    /// Load cases.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_load_cases(loaded: &LoadedLoadCases) -> Result<Self, AnalysisError> {
        let (history, cases) = (loaded.history()?, loaded.table.cases.len());
        Ok(PageSession {
            load_cases: Some(cases),
            about: about([0, cases], planned(history.as_ref())),
            ..without_results(loaded, history.as_ref(), &[], &[])?
        })
    }

    /// Stiffness and expanded uncertainty of a pose and direction, N/µm, as far as they are known.
    #[must_use]
    pub fn stiffness_n_per_um(&self, pose: &str, direction: &str) -> [Option<f64>; 2] {
        if let Some(report) = &self.vectors {
            let mut cells = report.cells.iter();
            let cell = cells.find(|one| one.pose.as_str() == pose && one.direction == direction);
            return cell.map_or([None; 2], |cell| {
                [cell.stiffness.value, cell.stiffness.expanded_uncertainty]
            });
        }
        let mut cells = self.numbers.iter().flat_map(|table| &table.cells);
        let cell = cells.find(|row| {
            row.cell.pose.as_str() == pose && row.cell.direction.to_string() == direction
        });
        let found = cell.and_then(|row| row.by(Method::Regression).ok());
        found.map_or([None; 2], |found| {
            let expanded = found.estimate.expanded_95();
            [Some(found.estimate.value), expanded].map(|value| Some(value? / N_PER_UM))
        })
    }

    /// The last day of the measurement.
    #[must_use]
    pub fn last_day(&self) -> Option<&str> {
        let performed = self.performed.as_deref()?;
        performed.rsplit(" to ").next()
    }

    /// The stiffness of a pose and direction as printed.
    pub(super) fn cell(&self, pose: &str, direction: &str) -> Option<&PageCell> {
        let mut cells = self.results.iter();
        cells.find(|cell| cell.pose == pose && cell.direction == direction)
    }

    /// What is recorded under a name.
    pub(super) fn condition(&self, name: &str) -> Option<String> {
        let mut entries = self.conditions.iter();
        let entry = entries.find(|entry| entry.name == name)?;
        Some(entry.value.clone())
    }
}

/// A session of any form without results.
///
/// # Arguments
/// - `utc`, `temperatures_deg_c`: of its readings.
fn without_results<T>(
    session: &SessionTable<T>,
    history: Option<&SessionHistory>,
    utc: &[&str],
    temperatures_deg_c: &[f64],
) -> Result<PageSession, AnalysisError> {
    let header = session.header.as_ref();
    let named = header.iter().flat_map(|one| one.instruments.named());
    let files = session.file_hashes()?;
    Ok(PageSession {
        name: session.short_name(),
        origin: session.origin.clone(),
        complete: history.map(SessionHistory::is_complete),
        protected: history.is_some() && !session.differs_from_journal,
        performed: days(history, utc).map(|[first, last]| {
            if first == last {
                first
            } else {
                format!("{first} to {last}")
            }
        }),
        procedure: None,
        about: String::new(),
        readings: 0,
        load_cases: None,
        imported: header.is_some_and(|header| header.import.is_some()),
        results: Vec::new(),
        budget: PageBudget::default(),
        further: Document::new(),
        conditions: conditions(header, history, temperatures_deg_c),
        gauges: named
            .map(|(name, record)| page_gauge(name, record, &session.overdue))
            .collect(),
        deviations: of_history(history)
            .chain(session.warnings.iter().cloned())
            .collect(),
        files: files
            .iter()
            .map(|(name, hash)| PageEntry::new(name, hash))
            .collect(),
        numbers: None,
        vectors: None,
    })
}

/// First and last day of the measurement.
fn days(history: Option<&SessionHistory>, utc: &[&str]) -> Option<[String; 2]> {
    if let Some(history) = history {
        let [began, ended] = [history.began?, history.state.last_utc?];
        return Some([began, ended].map(|time| time.strftime("%Y-%m-%d").to_string()));
    }
    let days = || utc.iter().filter_map(|utc| utc.get(..10));
    Some([days().min()?, days().max()?].map(str::to_owned))
}

fn conditions(
    header: Option<&SessionHeader>,
    history: Option<&SessionHistory>,
    temperatures_deg_c: &[f64],
) -> Vec<PageEntry> {
    let mut entries = Vec::new();
    let mut add = |name: &str, value: Option<String>| {
        entries.extend(value.map(|value| PageEntry::new(name, value)));
    };
    if let Some(header) = header {
        let procedure = header.procedure.as_ref();
        add("procedure", procedure.and_then(|one| one.name.clone()));
        add(
            "text of the procedure",
            procedure.and_then(|one| one.text.clone()),
        );
        let started = history.and_then(|history| history.state.started.as_ref());
        add(
            "SHA-256 of the procedure",
            started.map(|started| started.procedure_sha256.clone()),
        );
        add("specimen", header.specimen.clone());
        add("operator", header.operator.clone());
        add("place", header.place.clone());
        let import = header.import.as_ref();
        add(
            if import.is_some() {
                "imported by"
            } else {
                "recorded by"
            },
            header.software.clone(),
        );
        add("imported from", import.and_then(|one| one.source.clone()));
        add(
            "SHA-256 of the imported file",
            import.and_then(|one| one.source_sha256.clone()),
        );
        add(
            "SHA-256 of the mapping",
            import.and_then(|one| one.mapping_sha256.clone()),
        );
        let environment = header.environment.as_ref();
        let humidity = environment.and_then(|one| one.humidity_percent);
        add("relative humidity", humidity.map(|one| format!("{one} %")));
        add("surroundings", environment.and_then(|one| one.text.clone()));
        let start = environment.and_then(|one| one.temperature_deg_c);
        add(
            "temperature at the start",
            start.map(|one| format!("{one} °C")),
        );
    }
    let entered = history
        .iter()
        .flat_map(|history| &history.state.surroundings);
    for surroundings in entered.filter(|one| one.occasion.is_some()) {
        add(
            "entered at the bench",
            Some(surroundings.to_string().replace("degC", "°C")),
        );
    }
    let ends = (temperatures_deg_c.iter()).fold(None, |ends: Option<[f64; 2]>, next| {
        Some(ends.map_or([*next; 2], |[low, high]| [low.min(*next), high.max(*next)]))
    });
    add(
        "temperature during the readings",
        ends.map(|[low, high]| {
            if low < high {
                format!("{low} °C to {high} °C")
            } else {
                format!("{low} °C")
            }
        }),
    );
    entries
}

/// Readings that were taken, and that were planned, as a journal has them.
fn planned(history: Option<&SessionHistory>) -> Option<(u32, u32)> {
    let ended = history?.state.ended.as_ref()?;
    Some((ended.accepted, ended.planned))
}

/// A number in its unit with the digits that somebody stated.
pub(super) fn as_stated(si: f64, unit: f64) -> String {
    // What was stated in another unit is off in its last binary digits.
    let rounded = format!("{:.12e}", si / unit).parse::<f64>();
    rounded.unwrap_or(si / unit).to_string()
}

fn page_gauge(name: &str, record: &InstrumentRecord, overdue: &[OverdueGauge]) -> PageGauge {
    let none = || NOT_RECORDED.to_owned();
    let (unit, scale) = if name == "force gauge" {
        ("N", 1.0)
    } else {
        ("µm", METRES_PER_MICROMETRE)
    };
    let quantity = |value: Option<f64>| {
        value.map_or_else(none, |value| format!("{} {unit}", as_stated(value, scale)))
    };
    let text = |value: Option<&String>| value.cloned().unwrap_or_else(none);
    let date = |value: Option<jiff::civil::Date>| value.map_or_else(none, |date| date.to_string());
    PageGauge {
        name: name.to_owned(),
        model: text(record.model.as_ref()),
        serial: text(record.serial.as_ref()),
        range: quantity(record.range),
        resolution: quantity(record.resolution),
        expanded: match (record.expanded_uncertainty, record.k) {
            (None, _) => none(),
            (stated, None) => quantity(stated),
            (stated, Some(k)) if is_factor_of_limits(k) => {
                let limits = quantity(stated);
                let u = record.standard_uncertainty();
                let u = u.map_or_else(none, |u| significant(u / scale, 2));
                format!("limits ±{limits}, rectangular (u = {u} {unit})")
            }
            (stated, Some(k)) => format!("{} (k = {k})", quantity(stated)),
        },
        certificate: text(record.certificate.as_ref()),
        calibrated: date(record.calibrated),
        due: date(record.due),
        overdue: overdue.iter().any(|one| one.gauge == name),
    }
}

fn deviations(
    session: &LoadedSession,
    table: &StiffnessTable,
    history: Option<&SessionHistory>,
) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for skipped in &table.skipped {
        all.push(format!(
            "{} is not in the table: {}",
            skipped.cell, skipped.reason
        ));
    }
    for cell in &table.cells {
        let flags = flag_lines(cell).into_iter();
        all.extend(flags.map(|flag| format!("{}: {flag}", cell.cell)));
    }
    let excluded = &session.table.excluded;
    let (superseded, rejected) = (excluded.superseded.len(), excluded.rejected.len());
    if superseded + rejected > 0 {
        all.push(format!(
            "not counted: {} superseded, {rejected} rejected",
            counted(superseded, "reading")
        ));
    }
    all.extend(of_history(history));
    all.extend(doubts_about_stiffness(table));
    all.extend(session.warnings.iter().cloned());
    all
}

/// What a journal tells that was not as planned.
fn of_history(history: Option<&SessionHistory>) -> impl Iterator<Item = String> {
    let mut all = Vec::new();
    if let Some(history) = history {
        if let Some(ended) = history
            .state
            .ended
            .as_ref()
            .filter(|_| !history.is_complete())
        {
            all.push(format!(
                "the session is not complete ({} of {}): {}",
                ended.accepted,
                counted(ended.planned, "reading"),
                ended.reason
            ));
        }
        let left_out = OmittedReadings::of(history.state.skipped.values());
        all.extend(left_out.iter().map(ToString::to_string));
        let notes = history.state.notes.iter();
        all.extend(notes.map(|(_, note)| format!("note of the operator: {}", note.text)));
        all.extend(history.incidents.iter().cloned());
    }
    all.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_certificate_keeps_its_digits() {
        assert_eq!(as_stated(0.15, 1.0), "0.15");
        assert_eq!(as_stated(100.0, 1.0), "100");
        assert_eq!(
            as_stated(1.2 * METRES_PER_MICROMETRE, METRES_PER_MICROMETRE),
            "1.2"
        );
        assert_eq!(as_stated(0.0099, 1.0), "0.0099");
    }
}
