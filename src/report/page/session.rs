//! One session of a report: results, budget, conditions, instruments and deviations.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::Serialize;
use stiffbench_document::{Document, NoteKind, Table, TableCell};

use crate::analysis::{
    Failure, LoadedLoadCases, LoadedSession, SessionHistory, SessionTable, doubts_about_stiffness,
};
use crate::procedure::Procedure;
use crate::quantity::METRES_PER_MICROMETRE;
use crate::readings::{InstrumentRecord, SessionHeader};
use crate::report::stiffness::{budget_document, flag_lines, loops_document};
use crate::report::{VectorStiffnessReport, significant};
use crate::session::{OmittedReadings, SessionPlan};
use crate::stiffness::{Branches, StiffnessTable, is_factor_of_limits};

use super::first_page::about;
use super::procedure::as_done;
use super::results::PageCell;
use crate::count::counted;

/// What stands where nothing is recorded.
const NOT_RECORDED: &str = "not recorded";

/// Names with their values.
pub(super) type NamedValues = Vec<(String, String)>;

/// A gauge of a session.
#[derive(Debug, Clone)]
pub struct PageGauge {
    /// What it is.
    pub name: String,
    /// What is recorded of it.
    pub record: InstrumentRecord,
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
    /// What is missing of a session that is not complete.
    #[serde(skip)]
    pub missing: Vec<String>,
    /// Whether a journal protects the readings.
    pub protected: bool,
    /// Days of the measurement.
    pub performed: Option<String>,
    /// The procedure as it was done.
    #[serde(skip)]
    pub procedure: Option<String>,
    /// How many readings or load cases there are, and of how many that were planned.
    #[serde(skip)]
    pub about: String,
    /// Number of readings that count.
    pub readings: usize,
    /// Number of load cases; `null` of readings along the load.
    pub load_cases: Option<usize>,
    /// Whether the readings come from another program.
    pub imported: bool,
    /// Stiffness of every cell.
    #[serde(skip)]
    pub results: Vec<PageCell>,
    /// Their uncertainty.
    #[serde(skip)]
    pub budget: Document,
    /// Further results: compliance along the axes of the base, loops between loading and unloading.
    #[serde(skip)]
    pub further: Document,
    /// Procedure, operator, place, environment.
    #[serde(skip)]
    pub conditions: NamedValues,
    /// The gauges.
    #[serde(skip)]
    pub gauges: Vec<PageGauge>,
    /// Gauges whose calibration had run out when they were used, with the day on which it did.
    pub overdue: Vec<String>,
    /// Cells left out, readings repeated, flags, and what else was not as planned.
    #[serde(skip)]
    pub deviations: Vec<String>,
    /// Name and SHA-256 of every file.
    pub files: NamedValues,
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
    pub fn new(session: &LoadedSession, table: StiffnessTable) -> Result<Self, Failure> {
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
            let report = VectorStiffnessReport::new(stiffness, session.procedure());
            page.results = report.cells.iter().map(PageCell::from).collect();
            page.further = report.document();
            page.vectors = Some(report);
            return Ok(page);
        }
        page.results = table.cells.iter().map(PageCell::from).collect();
        page.budget = budget_document(&table);
        page.further.section("Hysteresis", loops_document(&table));
        page.deviations = deviations(session, &table, history.as_ref());
        page.numbers = Some(table);
        Ok(page)
    }

    /// Load cases.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_load_cases(loaded: &LoadedLoadCases) -> Result<Self, Failure> {
        let (history, cases) = (loaded.history()?, loaded.table.cases.len());
        Ok(PageSession {
            load_cases: Some(cases),
            about: about([0, cases], planned(history.as_ref())),
            ..without_results(loaded, history.as_ref(), &[], &[])?
        })
    }

    /// The last day of the measurement.
    #[must_use]
    pub fn last_day(&self) -> Option<&str> {
        let performed = self.performed.as_deref()?;
        performed.rsplit(" to ").next()
    }

    /// The stiffness of a pose and direction.
    pub(super) fn cell(&self, pose: &str, direction: &str) -> Option<&PageCell> {
        let mut cells = self.results.iter();
        cells.find(|cell| cell.pose == pose && cell.direction == direction)
    }

    /// What is recorded under a name.
    pub(super) fn condition(&self, name: &str) -> Option<String> {
        let mut entries = self.conditions.iter();
        Some(entries.find(|(own, _)| own == name)?.1.clone())
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
) -> Result<PageSession, Failure> {
    let header = session.header.as_ref();
    let named = header.iter().flat_map(|one| one.instruments.named());
    let gauges = named.map(|(name, record)| PageGauge {
        name: name.to_owned(),
        record: record.clone(),
        overdue: session.overdue.iter().any(|one| one.gauge == name),
    });
    let gauges: Vec<PageGauge> = gauges.collect();
    let overdue = gauges.iter().filter(|gauge| gauge.overdue);
    let overdue = overdue.map(|gauge| format!("{} (due {})", gauge.name, gauge.due()));
    Ok(PageSession {
        name: session.short_name(),
        origin: session.origin.clone(),
        complete: history.map(SessionHistory::is_complete),
        missing: history.map_or_else(Vec::new, |history| {
            let record = header.and_then(|header| header.procedure.as_ref());
            let procedure = record.and_then(|record| Procedure::from_record(record).ok());
            let plan = procedure.map(|procedure| SessionPlan::new(&procedure, &[]));
            plan.map_or_else(Vec::new, |plan| plan.missing(&history.state))
        }),
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
        budget: Document::new(),
        further: Document::new(),
        conditions: conditions(header, history, temperatures_deg_c),
        overdue: overdue.collect(),
        gauges,
        deviations: of_history(history)
            .chain(session.warnings.iter().cloned())
            .collect(),
        files: session.file_hashes()?,
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
) -> NamedValues {
    let mut entries = Vec::new();
    let mut add = |name: &str, value: Option<String>| {
        entries.extend(value.map(|value| (name.to_owned(), value)));
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

impl PageGauge {
    /// The last day on which its calibration counts.
    fn due(&self) -> String {
        or_none(self.record.due.as_ref())
    }

    /// A length or a force in the unit of the gauge, with the digits that were stated.
    fn quantity(&self, value: Option<f64>) -> String {
        let (unit, scale) = self.unit();
        let words = value.map(|value| format!("{} {unit}", as_stated(value, scale)));
        or_none(words.as_ref())
    }

    fn unit(&self) -> (&'static str, f64) {
        match self.name.as_str() {
            "force gauge" => ("N", 1.0),
            _ => ("µm", METRES_PER_MICROMETRE),
        }
    }

    /// Expanded uncertainty of its certificate, with k.
    fn expanded(&self) -> String {
        let (record, (unit, scale)) = (&self.record, self.unit());
        let stated = self.quantity(record.expanded_uncertainty);
        match record.k.filter(|_| record.expanded_uncertainty.is_some()) {
            None => stated,
            Some(k) if is_factor_of_limits(k) => {
                let u = record
                    .standard_uncertainty()
                    .map(|u| significant(u / scale, 2));
                let u = or_none(u.as_ref());
                format!("limits ±{stated}, rectangular (u = {u} {unit})")
            }
            Some(k) => format!("{stated} (k = {k})"),
        }
    }

    /// Whether it was calibrated when it was used.
    fn calibration(&self) -> String {
        let record = &self.record;
        if record.expanded_uncertainty.is_none() {
            return "not stated".to_owned();
        }
        let certificate = record.certificate.as_ref().map_or_else(
            || "certificate without number".to_owned(),
            |number| format!("certificate {number}"),
        );
        match &record.due {
            Some(due) if self.overdue => format!("{certificate}, OVERDUE (due {due})"),
            Some(due) => format!("{certificate}, due {due}"),
            None => format!("{certificate}, due date not stated"),
        }
    }
}

fn or_none(value: Option<&impl ToString>) -> String {
    value.map_or_else(|| NOT_RECORDED.to_owned(), ToString::to_string)
}

impl PageSession {
    /// Procedure, operator, place and environment, and the gauges.
    pub(super) fn conditions_document(&self) -> Document {
        let mut document = Document::new();
        for (name, value) in &self.conditions {
            document.pair(name, value);
        }
        if self.gauges.is_empty() {
            document.note(NoteKind::Warning, "The gauges are not recorded.");
            return document;
        }
        let table = Table::of(&self.gauges)
            .words("gauge", |gauge| &gauge.name)
            .words("model", |gauge| or_none(gauge.record.model.as_ref()))
            .words("serial number", |gauge| {
                or_none(gauge.record.serial.as_ref())
            })
            .numbers("range", |gauge| gauge.quantity(gauge.record.range))
            .numbers("resolution", |gauge| {
                gauge.quantity(gauge.record.resolution)
            })
            .numbers("U of certificate", |gauge| gauge.expanded())
            .words("certificate", |gauge| {
                or_none(gauge.record.certificate.as_ref())
            })
            .words("calibrated", |gauge| {
                or_none(gauge.record.calibrated.as_ref())
            })
            .words("due", |gauge| {
                if gauge.overdue {
                    TableCell::marked(format!("{} overdue", gauge.due()))
                } else {
                    gauge.due().into()
                }
            });
        document.table(table);
        document
    }

    /// Whether the gauges were calibrated when they were used.
    pub(super) fn calibration(&self) -> String {
        let mut alike: IndexMap<String, Vec<&str>> = IndexMap::new();
        for gauge in &self.gauges {
            let names = alike.entry(gauge.calibration()).or_default();
            names.push(&gauge.name);
        }
        let each = alike.iter();
        let mut each: Vec<String> = each
            .map(|(state, names)| format!("{}: {state}", names.join(", ")))
            .collect();
        if each.is_empty() {
            each.push("the gauges are not recorded".to_owned());
        }
        let is_stated = |gauge: &PageGauge| gauge.record.expanded_uncertainty.is_some();
        if !self.results.is_empty() && !self.gauges.iter().any(is_stated) {
            each.push("U does not contain it".to_owned());
        }
        each.join("; ")
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
        // What spoils a stiffness stands beside it.
        let beside = cell.flags.iter().find(|flag| flag.spoils_stiffness());
        let beside = beside.map(ToString::to_string);
        let flags = flag_lines(cell).into_iter();
        let flags = flags.filter(|flag| beside.as_ref() != Some(flag));
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
