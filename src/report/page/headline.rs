//! The answer of a report: stiffness, verdict, what to do.

use indexmap::{IndexMap, IndexSet};
use schemars::JsonSchema;
use serde::Serialize;

use crate::fit::PlannedLoadCase;
use crate::mismatch::{Verdict, VerdictGrade};
use crate::physics::{LawKind, PlaceKind};
use crate::report::fit::{joint_words, tool_words};
use crate::report::fit_report::stiffness_unit;
use crate::report::{
    Determination, DiagnosisResult, DiagnosisSummary, FactorChangeReport, ParameterReport,
    significant,
};

use super::ReportPage;
use super::results::PageCell;
use super::session::PageSession;

/// So many cells are named one by one.
const FEW_CELLS: usize = 3;

/// So many checks by hand are named.
const CHECKS: usize = 3;

/// What leads from stiffness alone to a fit.
const NAME_A_ROBOT: &str = "To fit a model and find what it leaves out, name the robot with --robot; stiffbench robot new writes a robot file.";

/// The answer of a report.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct PageHeadline {
    /// Stiffness with its expanded uncertainty and k.
    pub stiffness: Vec<String>,
    /// The verdict on the model, or of the comparison.
    pub verdict: Option<String>,
    /// Where nothing was found, what would have been.
    pub limit: Option<String>,
    /// By how much what is named improves the model in poses left out of the fit.
    pub improvement: Option<String>,
    /// How well the fitted model predicts.
    pub validation: Option<String>,
    /// The statement of conformity.
    pub conformity: Option<String>,
    /// What to do next.
    pub next: Vec<String>,
}

impl ReportPage {
    /// What the parts of the report answer.
    pub(super) fn answer(&self) -> PageHeadline {
        let (fit, diagnosis) = (self.fit.as_ref(), self.diagnosis.as_ref());
        let several = self.sessions.len() > 1;
        let of_cells =
            |session: &&PageSession| session.load_cases.is_none() || !session.results.is_empty();
        let stiffness = self.sessions.iter().filter(of_cells).map(|session| {
            let name = if several {
                format!("{}: ", session.name)
            } else {
                String::new()
            };
            name + &stiffness(&session.results)
        });
        let found = diagnosis.and_then(|one| named(&one.numbers));
        let springs = match (found, fit.map(|fit| &fit.numbers)) {
            (Some(found), _) => {
                let after = found.factors.iter().map(SpringLine::with_found);
                springs(after, " with what was found,")
            }
            (None, Some(fit)) => of_fit(&fit.parameters),
            (None, None) => Vec::new(),
        };
        let verdict = diagnosis.map(|diagnosis| diagnosis.headline.clone());
        let comparison = self.comparison.as_ref();
        PageHeadline {
            stiffness: stiffness.chain(springs).collect(),
            verdict: comparison
                .map(|comparison| comparison.verdict.clone())
                .or(verdict),
            limit: diagnosis.and_then(|one| limit(&one.numbers)),
            improvement: diagnosis.and_then(|one| improvement(&one.numbers)),
            validation: fit.and_then(|fit| fit.validation.clone()),
            conformity: (self.conformity.as_ref()).map(|one| one.sentence.clone()),
            next: self.next(),
        }
    }

    /// What to check by hand and to measure next; of a report without a robot to name one.
    fn next(&self) -> Vec<String> {
        let Some(diagnosis) = &self.diagnosis else {
            let may_name_one = self.model.is_none() && self.comparison.is_none();
            return may_name_one
                .then(|| NAME_A_ROBOT.to_owned())
                .into_iter()
                .collect();
        };
        let findings = match &diagnosis.numbers {
            DiagnosisResult::Session(summary) => &summary.findings[..],
            DiagnosisResult::Specimen(_) => &[],
        };
        let checks = findings.iter();
        let checks = checks.filter_map(|finding| finding.check.as_ref());
        let mut next: Vec<String> = Vec::new();
        let planned = self.fit.iter().flat_map(|fit| &fit.numbers.next);
        let planned: IndexSet<String> = planned.map(next_load_case).collect();
        next.extend(planned);
        for check in checks.map(|check| format!("To check by hand: {check}.")) {
            if !next.contains(&check) && next.len() < CHECKS {
                next.push(check);
            }
        }
        next.extend(diagnosis.next.iter().cloned());
        next.truncate(CHECKS + 2);
        next
    }
}

fn stiffness(cells: &[PageCell]) -> String {
    let known: Vec<&PageCell> = cells.iter().filter(|cell| value(cell).is_some()).collect();
    if known.is_empty() {
        return "No stiffness can be given.".to_owned();
    }
    let doubt = known.iter().find_map(|cell| {
        let reason = cell.reason.as_ref().filter(|_| cell.percent != "–")?;
        Some(format!(" {} {} is {reason}.", cell.pose, cell.direction))
    });
    let doubt = doubt.unwrap_or_default();
    if known.len() <= FEW_CELLS {
        let each: Vec<String> = known.iter().map(|cell| words(cell)).collect();
        return format!("K = {}.{doubt}", each.join("; K = "));
    }
    let by_value = |a: &&&PageCell, b: &&&PageCell| {
        let [a, b] = [a, b].map(|cell| value(cell).unwrap_or(f64::NAN));
        a.total_cmp(&b)
    };
    let ends = [known.iter().min_by(by_value), known.iter().max_by(by_value)];
    let [low, high] = ends.map(|cell| cell.map_or_else(String::new, |cell| words(cell)));
    format!(
        "{} poses and directions. Smallest: K = {low}. Largest: K = {high}.{doubt}",
        known.len()
    )
}

/// The springs that were determined, with the intervals of their stiffness, a line for each unit.
/// A diagnosis that names what is missing, if it can be relied on: what is named beside an open question, or weakly, is none.
fn named(diagnosis: &DiagnosisResult) -> Option<&DiagnosisSummary> {
    let DiagnosisResult::Session(one) = diagnosis else {
        return None;
    };
    let is_named = matches!(one.grade, VerdictGrade::Is | VerdictGrade::Mostly);
    (is_named && !one.findings.is_empty()).then_some(&**one)
}

/// A parameter as the headline states it if it is a spring.
struct SpringLine<'r> {
    name: &'r str,
    /// Of the compliance.
    unit: &'r str,
    compliance: Option<f64>,
    ci95: Option<[f64; 2]>,
}

impl<'r> SpringLine<'r> {
    fn of_fit(one: &'r ParameterReport) -> Self {
        Self {
            name: &one.name,
            unit: &one.unit,
            compliance: one.value,
            ci95: one.ci95,
        }
    }

    fn with_found(one: &'r FactorChangeReport) -> Self {
        Self {
            name: &one.name,
            unit: &one.after.unit,
            compliance: Some(one.after.value).filter(|_| one.status == Determination::Free),
            ci95: one.after.ci95,
        }
    }
}

fn of_fit(parameters: &[ParameterReport]) -> Vec<String> {
    springs(parameters.iter().map(SpringLine::of_fit), ",")
}

/// # Arguments
/// - `with`: what stands behind the unit.
fn springs<'r>(parameters: impl Iterator<Item = SpringLine<'r>>, with: &str) -> Vec<String> {
    let mut lines: IndexMap<&str, Vec<String>> = IndexMap::new();
    for SpringLine {
        name,
        unit,
        compliance,
        ci95,
    } in parameters
    {
        let (scale, unit) = match stiffness_unit(unit).as_str() {
            "N*m/rad" => (1e3, "kN·m/rad"),
            "N/m" => (1e6, "N/µm"),
            _ => continue,
        };
        let inverse = |compliance: f64| {
            (compliance > 0.0).then(|| significant(1.0 / (compliance * scale), 3))
        };
        let (Some(stiffness), Some([low, high])) = (compliance.and_then(inverse), ci95) else {
            continue;
        };
        let low_end = inverse(high).unwrap_or_else(|| "0".to_owned());
        let high_end = inverse(low).unwrap_or_else(|| "no upper limit".to_owned());
        let spring = format!("{name} {stiffness} ({low_end} to {high_end})");
        lines
            .entry(unit)
            .or_default()
            .push(spring.replace(' ', "\u{a0}"));
    }
    let lines = lines.iter();
    lines
        .map(|(unit, springs)| {
            format!(
                "K in {unit}{with} with 95 % intervals: {}.",
                springs.join("; ")
            )
        })
        .collect()
}

/// From what size on laws of joints and base would have been found, each where it is seen best; `None` where something was found.
fn limit(diagnosis: &DiagnosisResult) -> Option<String> {
    let DiagnosisResult::Session(one) = diagnosis else {
        return None;
    };
    if one.verdict != Verdict::NothingMissing {
        return None;
    }
    let mut best: IndexMap<&str, f64> = IndexMap::new();
    let of_robot = one.detection_limits.iter().filter(|limit| {
        let place = limit.physics.place_kind;
        limit.physics.kind == LawKind::Physics
            && matches!(place, PlaceKind::Joint | PlaceKind::Axis)
    });
    for limit in of_robot {
        let Some(end_um) = limit.seen.as_ref().and_then(|seen| seen.end_effect_um) else {
            continue;
        };
        let known = best.entry(limit.physics.row).or_insert(end_um);
        *known = known.min(end_um);
    }
    best.sort_by(|_, a, _, b| a.total_cmp(b));
    let words = |(law, um): (&&str, &f64)| format!("{law} {}\u{a0}µm", significant(*um, 2));
    let each: Vec<String> = best.iter().map(words).collect();
    (!each.is_empty()).then(|| {
        format!(
            "It would have shown effects of these sizes at the end of the robot, in four sessions of five: {}. Smaller ones may be there.",
            each.join(", ")
        )
    })
}

/// What is named against the model without it, in poses that neither was fitted to.
fn improvement(diagnosis: &DiagnosisResult) -> Option<String> {
    let one = named(diagnosis)?;
    let (before, after) = (
        one.before.held_out_rms_percent?,
        one.after.held_out_rms_percent?,
    );
    let falls = after < before;
    let [before, after] = [before, after].map(|rms| significant(rms, 3));
    // What is named by its part of the noise may leave the percentages of small displacements as they are.
    (falls && before != after).then(|| {
        format!(
            "With what is named the error in poses left out of the fit falls from {before} to {after} % of the root mean square of the displacements about their means."
        )
    })
}

fn next_load_case(next: &PlannedLoadCase) -> String {
    format!(
        "To measure next: {} N along {} in pose {} ({}; tool at {} mm).",
        significant(next.force_n, 3),
        next.direction,
        next.name,
        joint_words(next),
        tool_words(next.tool_m)
    )
}

fn value(cell: &PageCell) -> Option<f64> {
    cell.stiffness.parse().ok()
}

fn words(cell: &PageCell) -> String {
    let PageCell {
        pose,
        direction,
        stiffness,
        expanded,
        k,
        ..
    } = cell;
    if cell.percent == "–" {
        return format!("{stiffness} N/µm without an uncertainty ({pose} {direction})");
    }
    // No line ends between a number and its unit.
    format!("({stiffness} ± {expanded})\u{a0}N/µm, k\u{a0}=\u{a0}{k} ({pose} {direction})")
}
