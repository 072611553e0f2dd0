//! The answer of a report: stiffness, verdict, what to do.

use indexmap::{IndexMap, IndexSet};
use stiffbench_document::{Document, NoteKind};

use crate::count::counted;
use crate::fit::PlannedLoadCase;
use crate::mismatch::{Verdict, VerdictGrade};
use crate::physics::{LawKind, PlaceKind};
use crate::report::fit::{joint_words, tool_words};
use crate::report::fit_report::stiffness_unit;
use crate::report::{
    Determination, DiagnosisSummary, FactorChangeReport, ParameterReport, significant,
};

use super::results::PageCell;
use super::session::PageSession;
use super::{PageFit, ReportPage};

/// So many cells are named one by one.
const FEW_CELLS: usize = 3;

/// So many checks by hand are named.
const CHECKS: usize = 3;

/// What leads from stiffness alone to a fit.
const NAME_A_ROBOT: &str = "To fit a model and find what it leaves out, name the robot with --robot; stiffbench robot new writes a robot file.";

impl ReportPage {
    /// What the parts of the report answer.
    pub(super) fn answer(&self) -> Document {
        let (fit, diagnosis) = (self.fit.as_ref(), self.diagnosis.as_ref());
        let found = diagnosis.map(|one| &one.numbers);
        let mut answer = Document::new();
        let mut add = |note: Option<NoteKind>, text: Option<String>| match (note, text) {
            (Some(note), Some(text)) => answer.note(note, text),
            (None, Some(text)) => answer.paragraph(text),
            (_, None) => {}
        };
        let named_as = |session: &PageSession, words: String| match self.sessions.len() {
            1 => words,
            _ => format!("{}: {words}", session.name),
        };
        for session in &self.sessions {
            if session.load_cases.is_none() || !session.results.is_empty() {
                let words = named_as(session, stiffness_words(&session.results));
                add(Some(NoteKind::Answer), Some(words));
            }
        }
        for line in self.springs() {
            add(Some(NoteKind::Answer), Some(line));
        }
        for session in &self.sessions {
            let doubt = doubt(&session.results);
            add(None, doubt.map(|words| named_as(session, words)));
        }
        let conformity = self.conformity.as_ref();
        add(
            Some(NoteKind::Verdict),
            conformity.map(|one| one.sentence.clone()),
        );
        let comparison = self.comparison.as_ref().map(|one| one.verdict.clone());
        let verdict = comparison.or_else(|| Some(diagnosis?.headline.clone()));
        add(Some(NoteKind::Verdict), verdict);
        add(None, found.and_then(limit));
        add(None, found.and_then(improvement));
        let is_found = found.and_then(named).is_some();
        let validation = fit.and_then(validation);
        add(
            None,
            validation.map(|sentence| {
                let lacks = if is_found {
                    " It does not contain what was found."
                } else {
                    ""
                };
                sentence + lacks
            }),
        );
        let next = self.next();
        if !next.is_empty() {
            answer.paragraph("What to do next:");
        }
        answer.items(next);
        answer
    }

    /// The springs that were fitted, with what was found where something was.
    fn springs(&self) -> Vec<String> {
        let diagnosis = self.diagnosis.as_ref();
        let fit = self.fit.as_ref().map(|fit| &fit.numbers);
        match (diagnosis.and_then(|one| named(&one.numbers)), fit) {
            (Some(found), _) => {
                let after = found.factors.iter().map(SpringLine::with_found);
                springs(after, " with what was found,")
            }
            (None, Some(fit)) => springs(fit.parameters.iter().map(SpringLine::of_fit), ","),
            (None, None) => Vec::new(),
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
        let plans = &diagnosis.numbers.next_measurement;
        let checks = diagnosis.numbers.findings.iter();
        let checks = checks.filter_map(|finding| finding.check.as_ref());
        // A check that separates two explanations stands among the plans.
        let checks = checks.filter(|check| plans.iter().all(|plan| plan.plan != **check));
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

fn stiffness_words(cells: &[PageCell]) -> String {
    let known = cells.iter();
    let known = known.filter_map(|cell| Some((cell.stiffness.value?, cell)));
    let known: Vec<(f64, &PageCell)> = known.collect();
    let by_value = |a: &&(f64, _), b: &&(f64, _)| a.0.total_cmp(&b.0);
    let ends = known
        .iter()
        .min_by(by_value)
        .zip(known.iter().max_by(by_value));
    match ends {
        None => "No stiffness can be given.".to_owned(),
        Some(_) if known.len() <= FEW_CELLS => {
            let each: Vec<String> = known.iter().map(|(_, cell)| cell.named_words()).collect();
            format!("K = {}.", each.join("; K = "))
        }
        Some(((_, low), (_, high))) => format!(
            "{} poses and directions. Smallest: K = {}. Largest: K = {}.",
            known.len(),
            low.named_words(),
            high.named_words()
        ),
    }
}

/// The first cell whose stiffness is in doubt, with the reason, and how many others are.
fn doubt(cells: &[PageCell]) -> Option<String> {
    let doubtful = || {
        cells
            .iter()
            .filter(|cell| cell.stiffness.value.is_some() && cell.reason.is_some())
    };
    let first = doubtful().next()?;
    let reason = first.reason.as_deref().unwrap_or_default();
    let others = match doubtful().count() - 1 {
        0 => String::new(),
        1 => " So is one other: the results name it.".to_owned(),
        others => format!(" So are {others} others: the results name them."),
    };
    Some(format!(
        "{} {} is {reason}.{others}",
        first.pose, first.direction
    ))
}

/// How well the fitted model predicts; of a fit with as many parameters as values nothing is known of that.
fn validation(fit: &PageFit) -> Option<String> {
    if fit.numbers.dof == Some(0)
        && fit
            .numbers
            .cells
            .iter()
            .all(|cell| !cell.held_out && cell.predicted_without_its_pose.is_none())
    {
        return Some("The fit has as many parameters as measured values: it meets them all, and how well the model predicts is not known.".to_owned());
    }
    fit.validation.clone()
}

/// A diagnosis that names what is missing, if it can be relied on: what is named beside an open question, or weakly, is none.
fn named(one: &DiagnosisSummary) -> Option<&DiagnosisSummary> {
    let is_named = matches!(one.grade, VerdictGrade::Is | VerdictGrade::Mostly);
    (is_named && !one.findings.is_empty()).then_some(one)
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

/// The springs that were determined, with the intervals of their stiffness, a line for each unit, and the names of the others.
///
/// # Arguments
/// - `with`: what stands behind the unit.
fn springs<'r>(parameters: impl Iterator<Item = SpringLine<'r>>, with: &str) -> Vec<String> {
    let mut lines: IndexMap<&str, Vec<String>> = IndexMap::new();
    let mut open = Vec::new();
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
            open.push(name);
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
    let lines = lines.iter().map(|(unit, springs)| {
        format!(
            "Springs in {unit}{with} with 95 % intervals: {}.",
            springs.join("; ")
        )
    });
    let open = (!open.is_empty()).then(|| {
        format!(
            "Springs that the readings do not determine: {}.",
            open.join(", ")
        )
    });
    lines.chain(open).collect()
}

/// Sizes at which laws of joints and base would have been found, from the best to the worst place; `None` where something was found.
fn limit(one: &DiagnosisSummary) -> Option<String> {
    if one.verdict != Verdict::NothingMissing {
        return None;
    }
    let of_robot = one.detection_limits.iter().filter(|limit| {
        let place = limit.physics.place_kind;
        limit.physics.kind == LawKind::Physics
            && matches!(place, PlaceKind::Joint | PlaceKind::Axis)
    });
    let mut laws: IndexMap<&str, (Vec<f64>, usize)> = IndexMap::new();
    for limit in of_robot {
        let (found, untested) = laws.entry(limit.physics.row).or_default();
        match limit.seen.as_ref().and_then(|seen| seen.end_effect_um) {
            Some(um) => found.push(um),
            None => *untested += 1,
        }
    }
    let ends = |(law, (found, untested)): (&'static str, (Vec<f64>, usize))| {
        let end = |of: fn(f64, f64) -> f64| found.iter().copied().reduce(of);
        Some((end(f64::min)?, end(f64::max)?, law, untested))
    };
    let mut laws: Vec<_> = laws.into_iter().filter_map(ends).collect();
    laws.sort_by(|a, b| a.0.total_cmp(&b.0));
    let each: Vec<String> = laws.into_iter().map(limit_words).collect();
    (!each.is_empty()).then(|| {
        format!(
            "Effects of these sizes at the end of the robot would have been detected in four of five such sessions, from the best place to the worst: {}. Smaller effects may be present.",
            each.join("; ")
        )
    })
}

/// Sizes from the best place to the worst, and places that could not be tested.
fn limit_words((best, worst, law, untested): (f64, f64, &str, usize)) -> String {
    let [best, worst] = [best, worst].map(|um| significant(um, 2));
    let sizes = if best == worst {
        best
    } else {
        format!("{best} to {worst}")
    };
    let untested = match untested {
        0 => String::new(),
        count => format!(" ({} could not be tested)", counted(count, "place")),
    };
    format!("{law} {sizes}\u{a0}µm{untested}")
}

/// What is named against the model without it, in poses that neither was fitted to.
fn improvement(diagnosis: &DiagnosisSummary) -> Option<String> {
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
            "With the named effects, the RMS error in left-out poses falls from {before} % to {after} % of the RMS displacement."
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
