//! Readings and runs that their repeats contradict.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_document::{Document, sign_of};

use crate::analysis::DiagnosisReport;
use crate::mismatch::{BadReading, BadRun};
use crate::report::{
    factor_words, micro, reading_shown, significant, table_mistake_words, usual_unit,
};
use crate::test_point::{Branch, Cell, Direction, DirectionName, PoseId};

/// Bad readings that the page names; the JSON has all.
const NAMED: usize = 12;

/// What is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DataFindingKind {
    /// The value of a reading.
    BadReading,
    /// The displacement per force of a run.
    BadRun,
    /// The names of two cells.
    Exchanged,
    /// A sign.
    Sign,
    /// A decimal point.
    DecimalPoint,
    /// A unit.
    Unit,
}

impl DataFindingKind {
    /// What values have wrong that agree once they are multiplied by a usual factor.
    pub(in crate::report) fn of_factor(factor: f64) -> Self {
        let is_power_of_ten = (factor.log10() - factor.log10().round()).abs() < 1e-9;
        match factor {
            _ if factor < 0.0 => Self::Sign,
            _ if is_power_of_ten => Self::DecimalPoint,
            _ => Self::Unit,
        }
    }
}

/// A reading or run that its repeats contradict, or a cell that yields against its load or has the name of another.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct DataFindingReport {
    /// What is wrong.
    pub kind: DataFindingKind,
    /// The data.
    pub file: String,
    /// Lines of the file, from 1.
    pub lines: Vec<u32>,
    /// Where it stands in the session.
    pub place: DataPlace,
    /// By what it must be multiplied to agree, if that is usual: -1, a power of ten, a factor between units.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
    /// The cell whose readings it has, and that has its own; only of the kind `exchanged`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exchanged_with: Option<DataPlace>,
    /// What was read, in `unit`: of a run or cell its displacement per force.
    pub value: f64,
    /// What the repeats of the same load, or of a cell all other cells, predict, in `unit`.
    pub expected: f64,
    /// Standard error of that difference, in `unit`.
    pub standard_error: f64,
    /// `um`, or `um/N` for runs and cells.
    pub unit: Cow<'static, str>,
    /// Chance that any good reading, or run, of the session is as far off.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p_family: f64,
    /// Whether the search went on without it.
    pub left_out: bool,
}

/// A place in a session.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DataPlace {
    /// A single reading.
    Reading {
        /// Its pose.
        pose: PoseId,
        /// Its direction.
        direction: Direction,
        /// The direction of its load, if it is another.
        #[serde(skip_serializing_if = "Option::is_none")]
        load: Option<DirectionName>,
        /// Its repeat.
        repeat: u32,
        /// Its load step.
        step: u32,
        /// Its branch.
        branch: Branch,
    },
    /// All readings of a run.
    Run {
        /// Its pose.
        pose: PoseId,
        /// Its direction.
        direction: Direction,
        /// Its repeat.
        repeat: u32,
    },
    /// All readings of a pose and direction.
    Cell {
        /// The pose.
        pose: PoseId,
        /// The direction.
        direction: Direction,
    },
}

impl DataFindingReport {
    /// All of a diagnosis.
    pub(super) fn all(report: &DiagnosisReport) -> Vec<Self> {
        let runs = report.bad_runs.iter().map(|one| Self::of_run(report, one));
        let readings = report.bad_readings.iter();
        let readings = readings.map(|one| Self::new(report, one));
        runs.chain(readings).collect()
    }

    fn of_run(report: &DiagnosisReport, bad: &BadRun) -> Self {
        let (pose, direction) = (bad.pose.clone(), bad.direction);
        Self {
            kind: if bad.exchanged_with.is_some() {
                DataFindingKind::Exchanged
            } else {
                bad.factor
                    .map_or(DataFindingKind::BadRun, DataFindingKind::of_factor)
            },
            file: file_of(report, &bad.pose),
            lines: bad.lines.clone(),
            place: match bad.repeat {
                Some(repeat) => DataPlace::Run {
                    pose,
                    direction,
                    repeat,
                },
                None => DataPlace::Cell { pose, direction },
            },
            factor: bad.factor,
            exchanged_with: bad
                .exchanged_with
                .clone()
                .map(|(pose, direction)| DataPlace::Cell { pose, direction }),
            value: micro(bad.compliance),
            expected: micro(bad.expected),
            standard_error: micro(bad.u),
            unit: "um/N".into(),
            p_family: bad.p_family,
            left_out: !report.outliers_kept,
        }
    }

    fn new(report: &DiagnosisReport, bad: &BadReading) -> Self {
        Self {
            kind: bad
                .factor
                .map_or(DataFindingKind::BadReading, DataFindingKind::of_factor),
            file: file_of(report, &bad.pose),
            lines: vec![bad.line],
            place: DataPlace::Reading {
                pose: bad.pose.clone(),
                direction: bad.direction,
                load: bad.load.clone(),
                repeat: bad.repeat,
                step: bad.step,
                branch: bad.branch,
            },
            factor: bad.factor,
            exchanged_with: None,
            value: micro(bad.value_m),
            expected: micro(bad.expected_m),
            standard_error: micro(bad.u_m),
            unit: bad.quantity.micro_unit().into(),
            p_family: bad.p_family,
            left_out: !report.outliers_kept,
        }
    }
}

/// The data that have a pose: of several sessions the one whose name the pose carries.
fn file_of(report: &DiagnosisReport, pose: &PoseId) -> String {
    let is_of = |name: &str| {
        let rest = pose.as_str().strip_prefix(name);
        rest.is_some_and(|rest| rest.starts_with('/'))
    };
    let own = report.sessions.iter().find(|one| is_of(&one.name));
    own.map_or_else(|| report.data.clone(), |own| own.data.clone())
}

/// The lines above everything else; empty where nothing is bad.
pub(super) fn bad_readings_first(report: &DiagnosisReport) -> Document {
    let runs = report.bad_runs.iter();
    let (exchanged, runs): (Vec<&BadRun>, Vec<&BadRun>) =
        runs.partition(|one| one.exchanged_with.is_some());
    let exchanged = match pairs(&exchanged)[..] {
        [] => None,
        [(one, other)] => Some(format!("{} and {}", cell_name(one), cell_name(other))),
        [(one, other), ..] if one.direction == other.direction => {
            Some(format!("the poses {} and {}", one.pose, other.pose))
        }
        [(one, other), ..] => Some(format!(
            "the directions {} and {}",
            one.direction, other.direction
        )),
    };
    let exchanged = exchanged.map(|what| (format!("Data: {what} look exchanged"), 2));
    let runs = match &runs[..] {
        [] => None,
        [one] => Some((format!("Data: {} cannot be right", run_name(one)), 1)),
        [one, ..] => {
            let more = runs.len() - 1;
            let several = || format!("{} and {more} more cannot be right", run_name(one));
            let what = cells_of_one_factor(&runs).unwrap_or_else(several);
            Some((format!("Data: {what}"), 2))
        }
    };
    let bad = &report.bad_readings;
    let without_repeats = bad.iter().any(|one| one.repeats.is_empty());
    let what = match &bad[..] {
        [] => None,
        [one] if without_repeats => Some(format!(
            "One reading contradicts the fit to all other readings: line {}, {}",
            one.line,
            cell_of(one)
        )),
        [one] => Some(format!(
            "One reading contradicts its repeats: line {}, {}",
            one.line,
            cell_of(one)
        )),
        _ if without_repeats => Some(format!(
            "{} readings contradict the fit to all other readings",
            bad.len()
        )),
        _ => Some(format!("{} readings contradict their repeats", bad.len())),
    };
    let readings = what.map(|what| (what, bad.len()));
    let mut document = Document::new();
    let mistake = report.table_mistake.as_ref();
    document.paragraphs(mistake.map(|one| format!("Data: {}", table_mistake_words(one))));
    let found = [exchanged, runs, readings].into_iter().flatten();
    document.paragraphs(found.map(|(what, count)| first_line(report, &what, count)));
    document
}

fn first_line(report: &DiagnosisReport, what: &str, count: usize) -> String {
    let done = match (report.outliers_kept, count) {
        (true, _) => "kept",
        (false, 1) => "left out",
        (false, _) => "all left out",
    };
    format!("{what}; {done}.")
}

/// Cells that would agree by one factor, in words; `None` of others.
fn cells_of_one_factor(cells: &[&BadRun]) -> Option<String> {
    let first = cells.first()?;
    let factor = first.factor?;
    let is_alike = |one: &&BadRun| one.repeat.is_none() && one.factor == first.factor;
    let common = |is: &dyn Fn(&BadRun) -> bool| cells.iter().all(|one| is(one));
    let place = if common(&|one| one.direction == first.direction) {
        format!(" along {}", first.direction)
    } else if common(&|one| one.pose == first.pose) {
        format!(" of pose {}", first.pose)
    } else {
        String::new()
    };
    let unit = usual_unit(factor).map_or_else(String::new, |words| format!(" ({words}?)"));
    cells.iter().all(is_alike).then(|| {
        let (count, how) = (cells.len(), factor_words(factor));
        format!("{count} cells{place} agree with all others only {how}{unit}")
    })
}

/// Exchanged cells, each pair once.
fn pairs<'r>(exchanged: &[&'r BadRun]) -> Vec<(&'r BadRun, &'r BadRun)> {
    let with = |one: &BadRun| exchanged.iter().position(|other| is_with(one, other));
    let pairs = exchanged.iter().enumerate().filter_map(|(place, one)| {
        let other = with(one).filter(|other| *other > place)?;
        Some((*one, exchanged[other]))
    });
    pairs.collect()
}

fn is_with(one: &BadRun, other: &BadRun) -> bool {
    one.exchanged_with
        .as_ref()
        .is_some_and(|(pose, direction)| (pose, direction) == (&other.pose, &other.direction))
}

/// The cell of a reading.
fn cell_of(bad: &BadReading) -> Cell {
    Cell {
        load: bad.load.clone(),
        ..Cell::new(bad.pose.clone(), bad.direction)
    }
}

fn cell_name(bad: &BadRun) -> String {
    format!("{} {}", bad.pose, bad.direction)
}

fn run_name(bad: &BadRun) -> String {
    let lines = match &bad.lines[..] {
        [first, .., last] => format!("lines {first} to {last}"),
        [only] => format!("line {only}"),
        [] => String::new(),
    };
    let (pose, direction) = (&bad.pose, bad.direction);
    bad.repeat.map_or_else(
        || format!("{pose} {direction} ({lines})"),
        |repeat| format!("{pose} {direction}, repeat {repeat} ({lines})"),
    )
}

/// What a usual factor would explain.
fn put_right(factor: Option<f64>) -> String {
    factor.map_or_else(String::new, |factor| {
        let unit = usual_unit(factor).map_or_else(String::new, |words| format!(" ({words}?)"));
        format!(": {} it agrees{unit}", factor_words(factor))
    })
}

fn bad_run(bad: &BadRun) -> String {
    let um_per_n = |compliance: f64| significant(micro(compliance), 4);
    let of_cells = || {
        format!(
            "where all other cells predict {} ± {} µm/N (k = 2)",
            um_per_n(bad.expected),
            significant(micro(2.0 * bad.u), 2),
        )
    };
    let expected = match (bad.repeat, &bad.exchanged_with) {
        (None, Some((pose, direction))) => {
            format!("{}: with the readings of {pose} {direction} it agrees", of_cells())
        }
        // Of a cell that yields against its load no other cell was asked.
        (None, None) if bad.expected == -bad.compliance => {
            "against its load, which no structure does: check the sign of force and displacement there".to_owned()
        }
        (None, None) => format!("{}{}", of_cells(), put_right(bad.factor)),
        (Some(_), _) => format!(
            "where the other repeats predict {} ± {} µm/N (k = 2){}",
            um_per_n(bad.expected),
            significant(micro(2.0 * bad.u), 2),
            put_right(bad.factor)
        ),
    };
    format!(
        "{}: it yields by {} µm/N, {expected}.",
        run_name(bad),
        um_per_n(bad.compliance)
    )
}

/// The section of the page; empty where nothing is bad.
pub(super) fn bad_readings(report: &DiagnosisReport) -> Document {
    let bad = &report.bad_readings;
    if bad.is_empty() && report.bad_runs.is_empty() {
        return Document::new();
    }
    let mut section = Document::under("Bad readings");
    section.items(report.bad_runs.iter().take(NAMED).map(bad_run));
    for one in bad.iter().take(NAMED) {
        let (value, unit) = reading_shown(one.value_m, one.quantity, 4);
        let unit = sign_of(unit);
        let (expected, _) = reading_shown(one.expected_m, one.quantity, 4);
        let (twice_u, _) = reading_shown(2.0 * one.u_m, one.quantity, 2);
        let slip = put_right(one.factor);
        let is_of_run = report.observations.has_series();
        let others = match (&one.repeats[..], is_of_run) {
            ([], true) => "its neighbours",
            ([], false) => "the fit to all others",
            _ => "the other repeats",
        };
        let step = if is_of_run {
            format!(", step {}, {}", one.step, one.branch)
        } else {
            String::new()
        };
        let last = if one.is_last {
            " It is the last of its run: a jump just before it would look the same."
        } else {
            ""
        };
        let said = format!(
            "line {}: {}, repeat {}{step}: {value} {unit}, where {others} predict {expected} ± {twice_u} {unit} (k = 2){slip}.{last}",
            one.line,
            cell_of(one),
            one.repeat,
        );
        section.item(said);
    }
    let more: usize = [bad.len(), report.bad_runs.len()]
        .map(|count| count.saturating_sub(NAMED))
        .iter()
        .sum();
    if more > 0 {
        section.item(format!("{more} more are in the JSON output."));
    }
    let what = if report.outliers_kept {
        "They were kept because of --keep-outliers: the results below may describe them."
    } else {
        "The results below were found without them; nothing is deleted. --keep-outliers keeps them in."
    };
    section.paragraph(what);
    section
}
