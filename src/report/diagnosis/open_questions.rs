//! What the verdict page says of laws that could not be tested or were refused, and of what to measure next.

use stiffbench_document::Document;

use crate::mismatch::{Impossible, NextMeasurement};
use crate::physics::Law;
use crate::test_point::Branch;

use super::detection_limits::{DetectionLimitReport, UnseenReason};
use super::page::DiagnosisDetail;
use super::page::capital;
use super::phrases::{impossible, listed, phrase};
use crate::analysis::{DiagnosisReport, Subject};
use crate::count::hours_and_minutes;

/// Odds beyond which a plan decides, whatever they are: to 1.
const MOST_ODDS: f64 = 1000.0;

/// Places that one sentence names; the appendix has all.
const PLACES: usize = 8;

/// What could not be tested: laws that fail for one reason at the same places share a paragraph.
pub(super) fn not_tested(report: &DiagnosisReport) -> Document {
    let limits = report.detection_limits();
    let all: Vec<(&DetectionLimitReport, UnseenReason)> = limits
        .iter()
        .filter_map(|limit| Some((limit, limit.unseen.clone()?)))
        .collect();
    let mut readings = report.observations.readings.iter();
    let loading_only =
        report.observations.has_series() && readings.all(|r| r.branch == Branch::Loading);
    let is_timeless =
        matches!(&report.subject, Subject::Part { units, .. } if units.order_is_clock);
    if all.is_empty() && !loading_only && !is_timeless {
        return Document::new();
    }
    let mut section = Document::under("What could not be tested");
    if loading_only {
        section.item("There are no readings during unloading. With loading only, play and friction differ in sign alone, and creep and a nonlinear force gauge hardly differ. To distinguish them, also read while unloading.");
    }
    if is_timeless {
        section.item("There is no time column: laws with a time constant were not searched for. The order of the readings is the history of the part.");
    }
    let mut by_law: Vec<(Vec<Law>, Vec<String>, UnseenReason)> = Vec::new();
    for &law in Law::ALL {
        let own = || all.iter().filter(|(limit, _)| limit.physics == law);
        let Some((_, first)) = own().next() else {
            continue;
        };
        let places: Vec<String> = own()
            .filter_map(|(limit, _)| limit.place.as_ref().map(ToString::to_string))
            .collect();
        let same = by_law
            .iter_mut()
            .find(|(_, other, why)| *other == places && why.reason == first.reason);
        match same {
            Some((laws, ..)) => laws.push(law),
            None => by_law.push((vec![law], places, first.clone())),
        }
    }
    for (laws, places, why) in by_law {
        let laws: Vec<String> = laws.into_iter().map(|law| law.row.to_owned()).collect();
        let at = match places.len() {
            0 => String::new(),
            n if n > PLACES => format!(
                " at {} and {} further places",
                places[..PLACES].join(", "),
                n - PLACES
            ),
            _ => format!(" at {}", listed(&places, "and")),
        };
        let remedy = why
            .remedy
            .map_or_else(String::new, |remedy| format!(" To test it: {remedy}."));
        let sentence = format!(
            "{}{at}: {}.{remedy}",
            capital(&listed(&laws, "and")),
            why.reason
        );
        section.item(sentence);
    }
    section
}

/// Laws that would serve only with an impossible value.
pub(super) fn rejected(report: &DiagnosisReport, detail: DiagnosisDetail) -> Document {
    let refused: Vec<_> = report.impossible().collect();
    let sentence = |one: &&Impossible| {
        format!(
            "{}: {}.",
            capital(&phrase(one.law, &one.place, &[])),
            impossible(one.law)
        )
    };
    let first = refused.iter().take(PLACES).map(sentence);
    let mut section = Document::list_under("Rejected as impossible", first);
    if refused.len() > PLACES {
        let listed = match detail {
            DiagnosisDetail::Page | DiagnosisDetail::Whole => "listed in the appendix",
            DiagnosisDetail::Report => "which stiffbench diagnose lists",
        };
        section.item(format!("and {} more, {listed}.", refused.len() - PLACES));
    }
    section
}

/// The section on what to measure next.
pub(super) fn next(report: &DiagnosisReport, detail: DiagnosisDetail) -> Document {
    Document::list_under("What to measure next", next_plans(report, detail))
}

/// Plans that would separate what is open, each with all that it separates.
pub(in crate::report) fn next_plans(
    report: &DiagnosisReport,
    detail: DiagnosisDetail,
) -> Vec<String> {
    let mut plans = Vec::new();
    let written = match detail {
        DiagnosisDetail::Page | DiagnosisDetail::Whole => "Procedure",
        DiagnosisDetail::Report => "stiffbench diagnose SESSION writes its procedure",
    };
    // Nothing is known of the machine that loads a part.
    let by_hand = if report.is_of_part() { " by hand" } else { "" };
    let mut proposed: Vec<&NextMeasurement> = Vec::new();
    for plan in &report.next {
        if proposed.iter().any(|other| same_advice(other, plan)) {
            continue;
        }
        proposed.push(plan);
        let alike = report.next.iter().filter(|other| same_advice(other, plan));
        let pairs: Vec<String> = alike.map(|plan| pair(report, plan)).collect();
        let worth = if is_weak(plan) {
            "this will probably not suffice to decide"
        } else if confirms(plan) {
            "this should confirm or refute"
        } else {
            "this should distinguish"
        };
        let file = plan.file.as_ref();
        let sentence = format!(
            "{}. About {}{by_hand}; {worth} {}.{}",
            capital(&plan.plan),
            hours_and_minutes(plan.minutes),
            listed(&pairs, "and"),
            file.map_or_else(String::new, |file| format!(" {written}: {file}."))
        );
        plans.push(sentence);
    }
    plans
}

/// Whether two plans ask for the same and promise as much.
fn same_advice(one: &NextMeasurement, other: &NextMeasurement) -> bool {
    one.plan == other.plan
        && one.file == other.file
        && (is_weak(one), confirms(one)) == (is_weak(other), confirms(other))
}

/// Whether a plan does not settle its pair.
fn is_weak(plan: &NextMeasurement) -> bool {
    plan.expected_log_lr.is_some_and(|expected| expected < 3.0)
}

/// Whether a plan asks for one finding alone.
fn confirms(plan: &NextMeasurement) -> bool {
    plan.separates[1] == "nothing"
}

fn pair(report: &DiagnosisReport, plan: &NextMeasurement) -> String {
    let [a, b] = plan.separates.each_ref().map(|one| in_words(report, one));
    if confirms(plan) {
        return a;
    }
    let expected = plan.expected_log_lr.map_or_else(String::new, |j| {
        let odds = j.exp();
        if odds > MOST_ODDS {
            format!(" (expected odds for the right one above {MOST_ODDS:.0} to 1)")
        } else {
            format!(" (expected odds for the right one {odds:.0} to 1)")
        }
    });
    format!("{a} from {b}{expected}")
}

/// An explanation by its title, in the words that the page has for it.
fn in_words(report: &DiagnosisReport, title: &str) -> String {
    let findings = report.diagnosis.findings.iter();
    let mut effects = findings.flat_map(|finding| {
        let rivals = finding.rivals.iter().map(|rival| &rival.effect);
        std::iter::once(&finding.effect).chain(rivals)
    });
    let known = effects.find(|effect| effect.title() == title);
    known.map_or_else(
        || title.to_owned(),
        |effect| phrase(effect.law, &effect.place, &effect.values),
    )
}
