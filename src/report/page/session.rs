//! One session of a report: results, budget, conditions, instruments and deviations.

use schemars::JsonSchema;
use serde::Serialize;

use crate::analysis::{LoadedSession, SessionHistory, doubts_about_stiffness};
use crate::quantity::{
    METRES_PER_MICROMETRE, NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM,
};
use crate::readings::InstrumentRecord;
use crate::report::significant;
use crate::stiffness::{CellStiffness, Method, RowUse, StiffnessTable, format_value_uncertainty};

/// A word with its value.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageEntry {
    /// What it is.
    pub name: String,
    /// Its value with its unit.
    pub value: String,
}

impl PageEntry {
    fn new(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            value: value.into(),
        }
    }
}

/// The stiffness of a cell as printed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageCell {
    /// The pose.
    pub pose: String,
    /// The direction.
    pub direction: String,
    /// The direction in a word.
    pub direction_word: String,
    /// Number of runs.
    pub runs: usize,
    /// Stiffness, N/µm; a dash where there is none.
    pub stiffness: String,
    /// Expanded uncertainty, N/µm; a dash where there is none.
    pub expanded: String,
    /// Coverage factor for 95 %.
    pub k: String,
    /// Effective degrees of freedom.
    pub dof: String,
    /// Expanded uncertainty in percent of the stiffness.
    pub percent: String,
    /// Why there is no stiffness or no uncertainty.
    pub reason: Option<String>,
}

/// The uncertainty budget of a cell as printed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageBudget {
    /// Pose and direction.
    pub cell: String,
    /// Its rows: source, type, distribution, contribution in N/µm, degrees of freedom, share in percent.
    pub rows: Vec<[String; 6]>,
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
    /// Number of readings that count.
    pub readings: usize,
    /// Stiffness of every cell.
    pub results: Vec<PageCell>,
    /// Uncertainty of every cell.
    pub budgets: Vec<PageBudget>,
    /// Procedure, operator, place, environment.
    pub conditions: Vec<PageEntry>,
    /// The gauges.
    pub gauges: Vec<PageGauge>,
    /// Cells left out, readings repeated, flags, and what else was not as planned.
    pub deviations: Vec<String>,
    /// Name and SHA-256 of every file.
    pub files: Vec<PageEntry>,
    /// All numbers of the stiffness.
    pub numbers: StiffnessTable,
}

impl PageSession {
    /// A session with its stiffness and, if it has one, what its journal tells.
    #[must_use]
    pub fn new(
        session: &LoadedSession,
        table: StiffnessTable,
        history: Option<&SessionHistory>,
        files: &[(String, String)],
    ) -> Self {
        let days = days(session, history);
        let last_day = days.as_ref().map(|[_, last]| last.clone());
        Self {
            name: session.short_name(),
            origin: session.origin(),
            complete: history.map(SessionHistory::is_complete),
            protected: history.is_some(),
            performed: days.map(|[first, last]| {
                if first == last {
                    first
                } else {
                    format!("{first} to {last}")
                }
            }),
            readings: session
                .table
                .readings
                .iter()
                .filter(|r| r.is_accepted())
                .count(),
            results: table.cells.iter().map(page_cell).collect(),
            budgets: table.cells.iter().filter_map(page_budget).collect(),
            conditions: conditions(session, history),
            gauges: gauges(session, last_day.as_deref()),
            deviations: deviations(session, &table, history),
            files: files
                .iter()
                .map(|(name, hash)| PageEntry::new(name, hash))
                .collect(),
            numbers: table,
        }
    }

    /// The last day of the measurement.
    #[must_use]
    pub fn last_day(&self) -> Option<&str> {
        let performed = self.performed.as_deref()?;
        performed.rsplit(" to ").next()
    }

    /// The procedure that was followed.
    #[must_use]
    pub fn method(&self) -> Option<String> {
        let procedure = self
            .conditions
            .iter()
            .find(|entry| entry.name == "procedure");
        procedure.map(|entry| entry.value.clone())
    }
}

/// First and last day of the measurement.
fn days(session: &LoadedSession, history: Option<&SessionHistory>) -> Option<[String; 2]> {
    if let Some(history) = history {
        let [began, ended] = [history.began?, history.state.last_utc?];
        return Some([began, ended].map(|time| time.strftime("%Y-%m-%d").to_string()));
    }
    let texts = session
        .table
        .readings
        .iter()
        .filter_map(|r| r.text.as_ref());
    let mut days: Vec<String> = texts
        .filter_map(|text| text.utc.get(..10).map(str::to_owned))
        .collect();
    days.sort_unstable();
    Some([days.first()?.clone(), days.last()?.clone()])
}

/// Stiffness with its uncertainty in N/µm, both rounded to the digits that count.
fn rounded(cell: &CellStiffness) -> Option<[String; 2]> {
    let found = cell.by(Method::Regression).ok()?;
    let expanded = found.estimate.expanded_95()? / N_PER_UM;
    let both = format_value_uncertainty(found.estimate.value / N_PER_UM, expanded)?;
    Some([both.value, both.uncertainty])
}

/// The stiffness of a cell in words: `0.01049 ± 0.00012`.
pub(super) fn stiffness_words(cell: &CellStiffness) -> String {
    match (rounded(cell), cell.by(Method::Regression)) {
        (Some([value, expanded]), _) => format!("{value} ± {expanded}"),
        (None, Ok(found)) => significant(found.estimate.value / N_PER_UM, 5),
        (None, Err(_)) => "no stiffness".to_owned(),
    }
}

fn page_cell(cell: &CellStiffness) -> PageCell {
    let none = || "–".to_owned();
    let found = cell.by(Method::Regression);
    let estimate = found.as_ref().ok().map(|found| found.estimate);
    let [stiffness, expanded] = rounded(cell).unwrap_or_else(|| {
        let value = estimate.map(|one| significant(one.value / N_PER_UM, 5));
        [value.unwrap_or_else(none), none()]
    });
    let known = estimate.filter(|one| one.expanded_95().is_some());
    PageCell {
        pose: cell.cell.pose.to_string(),
        direction: cell.cell.direction.to_string(),
        direction_word: cell.cell.direction.word().to_owned(),
        runs: cell.n_runs,
        stiffness,
        expanded,
        k: known
            .and_then(|one| one.coverage_factor_95())
            .map_or_else(none, |k| format!("{k:.2}")),
        dof: known.map_or_else(none, |one| dof_words(one.dof.floor())),
        percent: known
            .and_then(|one| Some(100.0 * one.expanded_95()? / one.value.abs()))
            .map_or_else(none, |percent| significant(percent, 2)),
        reason: match found {
            Err(reason) => Some(reason.to_string()),
            Ok(found) if known.is_none() => Some(format!("no uncertainty: {}", found.basis)),
            Ok(_) => None,
        },
    }
}

fn dof_words(dof: f64) -> String {
    if dof.is_finite() {
        format!("{dof:.0}")
    } else {
        "∞".to_owned()
    }
}

fn page_budget(cell: &CellStiffness) -> Option<PageBudget> {
    let found = cell.by(Method::Regression).ok()?;
    let rows = found.budget.rows.iter().map(|row| {
        [
            row.source.to_string(),
            format!("{:?}", row.evaluation),
            format!("{:?}", row.distribution).to_lowercase(),
            match row.standing {
                RowUse::Counted => significant(row.contribution_n_per_m / N_PER_UM, 3),
                RowUse::InRepeatability => "in repeatability".to_owned(),
                RowUse::NotStated => "not stated".to_owned(),
                RowUse::NoEffect => "no effect".to_owned(),
            },
            dof_words(row.dof),
            format!("{:.1}", row.share_percent),
        ]
    });
    Some(PageBudget {
        cell: cell.cell.to_string(),
        rows: rows.collect(),
    })
}

fn conditions(session: &LoadedSession, history: Option<&SessionHistory>) -> Vec<PageEntry> {
    let mut entries = Vec::new();
    let mut add = |name: &str, value: Option<String>| {
        entries.extend(value.map(|value| PageEntry::new(name, value)));
    };
    if let Some(header) = &session.header {
        let procedure = header.procedure.as_ref();
        add("procedure", procedure.and_then(|one| one.name.clone()));
        add("what it does", procedure.and_then(|one| one.text.clone()));
        let started = history.and_then(|history| history.state.started.as_ref());
        add(
            "SHA-256 of the procedure",
            started.map(|started| started.procedure_sha256.clone()),
        );
        add("operator", header.operator.clone());
        add("place", header.place.clone());
        add("recorded by", header.software.clone());
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
    let temperatures = session.table.readings.iter();
    let temperatures = temperatures.filter_map(|reading| reading.temperature_deg_c);
    let ends = temperatures.fold(None, |ends: Option<[f64; 2]>, next| {
        Some(ends.map_or([next; 2], |[low, high]| [low.min(next), high.max(next)]))
    });
    add(
        "temperature during the readings",
        ends.map(|[low, high]| format!("{low} °C to {high} °C")),
    );
    entries
}

fn gauges(session: &LoadedSession, day: Option<&str>) -> Vec<PageGauge> {
    let header = session.header.iter();
    let named = header.flat_map(|header| header.instruments.named());
    named
        .map(|(name, record)| page_gauge(name, record, day))
        .collect()
}

fn page_gauge(name: &str, record: &InstrumentRecord, day: Option<&str>) -> PageGauge {
    let none = || "not recorded".to_owned();
    let (unit, scale) = if name == "force gauge" {
        ("N", 1.0)
    } else {
        ("µm", METRES_PER_MICROMETRE)
    };
    let quantity = |value: Option<f64>| {
        value.map_or_else(none, |value| {
            format!("{} {unit}", significant(value / scale, 4))
        })
    };
    let text = |value: Option<&String>| value.cloned().unwrap_or_else(none);
    let date = |value: Option<jiff::civil::Date>| value.map_or_else(none, |date| date.to_string());
    let day: Option<jiff::civil::Date> = day.and_then(|day| day.parse().ok());
    let k = record.k.map_or_else(String::new, |k| format!(" (k = {k})"));
    PageGauge {
        name: name.to_owned(),
        model: text(record.model.as_ref()),
        serial: text(record.serial.as_ref()),
        range: quantity(record.range),
        resolution: quantity(record.resolution),
        expanded: match record.expanded_uncertainty {
            Some(_) => quantity(record.expanded_uncertainty) + &k,
            None => none(),
        },
        certificate: text(record.certificate.as_ref()),
        calibrated: date(record.calibrated),
        due: date(record.due),
        overdue: day.and_then(|day| record.calibration_overdue(day)) == Some(true),
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
        all.extend(
            cell.flags
                .iter()
                .map(|flag| format!("{}: {flag}", cell.cell)),
        );
    }
    let excluded = &session.table.excluded;
    let (superseded, rejected) = (excluded.superseded.len(), excluded.rejected.len());
    if superseded + rejected > 0 {
        all.push(format!(
            "{superseded} reading(s) superseded and {rejected} rejected do not count"
        ));
    }
    if let Some(history) = history {
        if let Some(ended) = history
            .state
            .ended
            .as_ref()
            .filter(|_| !history.is_complete())
        {
            all.push(format!(
                "the session is not complete ({} of {} readings): {}",
                ended.accepted, ended.planned, ended.reason
            ));
        }
        let mut reasons: Vec<&String> = history.state.skipped.values().collect();
        reasons.sort_unstable();
        reasons.dedup();
        for reason in reasons {
            let same = history.state.skipped.values().filter(|one| *one == reason);
            all.push(format!(
                "{} planned reading(s) left out: {reason}",
                same.count()
            ));
        }
        let notes = history.state.notes.iter();
        all.extend(notes.map(|(_, note)| format!("note of the operator: {}", note.text)));
        all.extend(history.incidents.iter().cloned());
    }
    all.extend(doubts_about_stiffness(table));
    all.extend(session.warnings.iter().cloned());
    all
}
