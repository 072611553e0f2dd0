//! Readings that their repeats contradict.

use schemars::JsonSchema;
use serde::Serialize;

use crate::analysis::DiagnosisReport;
use crate::mismatch::{BadReading, BadReadingKind};
use crate::quantity::METRES_PER_MICROMETRE;
use crate::report::significant;
use crate::test_point::{Branch, Direction, PoseId};

use super::phrases::paragraph;

/// Bad readings that the page names; the JSON has all.
const NAMED: usize = 12;

/// What is wrong with a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DataFindingKind {
    /// Its value.
    BadReading,
    /// Its sign.
    Sign,
    /// Its decimal point.
    DecimalPoint,
}

/// A reading that its repeats contradict.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DataFindingReport {
    /// What is wrong.
    pub kind: DataFindingKind,
    /// The data.
    pub file: String,
    /// Lines of the file, from 1.
    pub lines: Vec<u32>,
    /// Where it stands in the session.
    pub place: DataPlace,
    /// What was read, in `unit`.
    pub value: f64,
    /// What the repeats of the same load let expect, in `unit`.
    pub expected: f64,
    /// Standard error of that difference, in `unit`.
    pub standard_error: f64,
    /// `um`.
    pub unit: &'static str,
    /// Chance that any good reading of the session is as far off.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p_family: f64,
    /// Whether the search went on without it.
    pub left_out: bool,
}

/// A place in a session.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DataPlace {
    /// A single reading.
    Reading {
        /// Its pose.
        pose: PoseId,
        /// Its direction.
        direction: Direction,
        /// Its repeat.
        repeat: u32,
        /// Its load step.
        step: u32,
        /// Its branch.
        branch: Branch,
    },
}

impl DataFindingReport {
    /// All of a diagnosis.
    pub(super) fn all(report: &DiagnosisReport) -> Vec<Self> {
        let bad = report.bad_readings.iter();
        bad.map(|one| Self::new(report, one)).collect()
    }

    fn new(report: &DiagnosisReport, bad: &BadReading) -> Self {
        let um = |metres: f64| metres / METRES_PER_MICROMETRE;
        Self {
            kind: match bad.kind {
                BadReadingKind::Any => DataFindingKind::BadReading,
                BadReadingKind::Sign => DataFindingKind::Sign,
                BadReadingKind::DecimalPoint(_) => DataFindingKind::DecimalPoint,
            },
            file: file_of(report, &bad.pose),
            lines: vec![bad.line],
            place: DataPlace::Reading {
                pose: bad.pose.clone(),
                direction: bad.direction,
                repeat: bad.repeat,
                step: bad.step,
                branch: bad.branch,
            },
            value: um(bad.value_m),
            expected: um(bad.expected_m),
            standard_error: um(bad.u_m),
            unit: "um",
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

/// The line above everything else; empty without bad readings.
pub(super) fn bad_readings_first(report: &DiagnosisReport) -> String {
    let bad = &report.bad_readings;
    let what = match &bad[..] {
        [] => return String::new(),
        [one] => format!(
            "One reading contradicts its repeats: line {}, {} {}",
            one.line, one.pose, one.direction
        ),
        _ => format!("{} readings contradict their repeats", bad.len()),
    };
    let done = match (report.outliers_kept, bad.len()) {
        (true, _) => "kept",
        (false, 1) => "left out",
        (false, _) => "all left out",
    };
    paragraph(&format!("{what}; {done}."), "", "")
}

/// The section of the page; empty without bad readings.
pub(super) fn bad_readings(report: &DiagnosisReport) -> String {
    let bad = &report.bad_readings;
    if bad.is_empty() {
        return String::new();
    }
    let mut text = super::page::head("Bad readings");
    for one in bad.iter().take(NAMED) {
        let um = |metres: f64| significant(metres / METRES_PER_MICROMETRE, 4);
        let slip = match one.kind {
            BadReadingKind::Any => String::new(),
            BadReadingKind::Sign => ": with the other sign it agrees".to_owned(),
            BadReadingKind::DecimalPoint(_) => {
                ": with its decimal point moved it agrees".to_owned()
            }
        };
        let said = format!(
            "line {}: {} {}, repeat {}, step {}, {}: {} um, where the other repeats let expect {} ± {} um{slip}.",
            one.line,
            one.pose,
            one.direction,
            one.repeat,
            one.step,
            one.branch,
            um(one.value_m),
            um(one.expected_m),
            significant(2.0 * one.u_m / METRES_PER_MICROMETRE, 2),
        );
        text.push_str(&paragraph(&said, "- ", "  "));
    }
    if bad.len() > NAMED {
        let more = format!("{} more are in the JSON output.", bad.len() - NAMED);
        text.push_str(&paragraph(&more, "- ", "  "));
    }
    let what = if report.outliers_kept {
        "They were kept, as --keep-outliers asks: what follows may be about them."
    } else {
        "What follows was found without them; nothing is deleted. --keep-outliers keeps them in."
    };
    text.push_str(&paragraph(what, "", ""));
    text
}
