//! The verdict on one page, for a reader who knows no statistics.

use std::fmt::Write;

use stiffbench_document::{Document, ascii_units};

use crate::mismatch::{
    ConfigurationSizes, ExplainedShare, Finding, Location, MisfitShares, NoiseBasis, Verdict,
    VerdictGrade,
};
use crate::physics::{FileLine, Law, ParameterSpec, Place};
use crate::report::text::{open_interval, significant, unit_behind};

use super::answer::{Accused, DiagnosisAnswer, phrase_of};
use super::appendix::appendix;
use super::data_findings::{bad_readings, bad_readings_first};
use super::known_effects::known_effects;
use super::loops::loop_words;
use super::open_questions::{next, not_tested, rejected};
use super::phrases::{likelier, listed, location, one_in, phrase, strength};
use super::sessions::sessions;
use super::tables::{errors, factors, upper_limits};
use super::{check, least_law_p};
use crate::analysis::{DiagnosisReport, Subject};

/// Parts of the structure that look alike and are named beside the first.
const ALIKE: usize = 3;

/// What answers accuse, in the order of the page.
const ACCUSED: [Accused; 3] = [Accused::Physics, Accused::Either, Accused::Setup];

/// Chance of what a part leaves above which the part suffices.
const ENOUGH: f64 = 0.05;

/// Patterns of the residuals that the page names; the appendix has all.
const PATTERNS: usize = 3;

/// How much of a diagnosis its document says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DiagnosisDetail {
    /// The page of `diagnose`: appendix and proposed procedures stand beside it.
    Page,
    /// The page and its appendix.
    Whole,
    /// What a report says, whose first page states what to measure next: of each law the range of sizes that would have been found.
    Report,
}

/// A diagnosis as a document.
#[must_use]
pub fn diagnosis_document(report: &DiagnosisReport, detail: DiagnosisDetail) -> Document {
    let diagnosis = &report.diagnosis;
    let answers = DiagnosisAnswer::all(&diagnosis.findings);
    let decided = diagnosis.verdict != Verdict::InsufficientData;
    let mut document = bad_readings_first(report);
    document.paragraph(headline_words(report));
    let when = |shown: bool, section: &dyn Fn() -> Document| {
        if shown { section() } else { Document::new() }
    };
    let in_report = detail == DiagnosisDetail::Report;
    let with_limits = diagnosis.verdict == Verdict::NothingMissing || in_report;
    let sections = [
        sessions(report),
        bad_readings(report),
        lacking(report, &answers),
        when(decided, &|| missing(report, &answers)),
        when(decided, &|| sure(report, &answers)),
        when(decided, &|| else_(&answers)),
        when(decided, &|| where_(report)),
        when(decided, &|| known_effects(report)),
        when(decided, &|| factors(report)),
        when(decided, &|| errors(report)),
        when(with_limits, &|| upper_limits(report)),
        not_tested(report),
        when(decided, &|| rejected(report, detail)),
        when(!in_report, &|| next(report, detail)),
        when(detail == DiagnosisDetail::Whole, &|| appendix(report)),
    ];
    for section in sections {
        document.append(section);
    }
    document
}

/// Size of a finding at its place, and at the end.
fn size(subject: &Subject, finding: &Finding) -> String {
    let law = finding.effect.law;
    let made = law.combination.as_ref().zip(finding.combination);
    let first = law
        .parameters_at(&finding.effect.place)
        .zip(&finding.values)
        .next();
    // Where another term grows with it the first alone is no size.
    let is_size = !law.parameters.iter().any(ParameterSpec::is_ratio) && !finding.spans_range;
    let at_place = match (made, first) {
        (Some((combination, value)), _) => {
            let spec = combination.spec.at(&finding.effect.place);
            let value = subject.with_unit(&spec, value.value);
            Some(format!("{} {value}, ", spec.word))
        }
        (None, Some((spec, value))) if is_size => {
            Some(format!("{}, ", subject.with_unit(&spec, value.value)))
        }
        _ => None,
    };
    let at_end = subject.words(" at the end", "");
    format!(
        "{}up to {}{at_end}",
        at_place.unwrap_or_default(),
        subject.reading(finding.end_effect_m)
    )
}

/// The verdict in a sentence with ASCII units, for programs.
pub(in crate::report) fn headline(report: &DiagnosisReport) -> String {
    ascii_units(&headline_words(report))
}

/// The verdict in a sentence.
pub(in crate::report) fn headline_words(report: &DiagnosisReport) -> String {
    let (diagnosis, subject) = (&report.diagnosis, &report.subject);
    let answers = DiagnosisAnswer::all(&diagnosis.findings);
    let sized = |answer: &&DiagnosisAnswer<'_>| match answer {
        DiagnosisAnswer::Single(one) => format!("{} ({})", phrase_of(one), size(subject, one)),
        DiagnosisAnswer::OneOf(_) => answer.open_question(),
    };
    let of_grade = |grade: VerdictGrade| {
        let own = answers.iter();
        own.filter(move |answer| answer.members()[0].grade == grade)
    };
    let graded = |grade: VerdictGrade, accused: Accused| -> Vec<String> {
        let own = of_grade(grade).filter(|answer| answer.accuses() == accused);
        own.map(|answer| sized(&answer)).collect()
    };
    let accusations = |grade: VerdictGrade| -> Vec<String> {
        let each = ACCUSED
            .into_iter()
            .map(|accused| (accused, graded(grade, accused)));
        let each = each.filter(|(_, names)| !names.is_empty());
        each.map(|(accused, names)| {
            accused.sentence(
                subject.model(),
                &listed(&names, "and"),
                grade == VerdictGrade::Mostly,
            )
        })
        .collect()
    };
    let from_fit = diagnosis.noise_basis == NoiseBasis::Fit;
    let weak: Vec<String> = of_grade(VerdictGrade::Weak)
        .map(|answer| sized(&answer))
        .collect();
    let mut sentences = Vec::new();
    match diagnosis.grade {
        VerdictGrade::Is => sentences.extend(accusations(VerdictGrade::Is)),
        VerdictGrade::Mostly => {
            sentences.extend(accusations(VerdictGrade::Mostly));
            let percent = |share: f64| significant(100.0 * share, 2);
            let unseen = percent(diagnosis.shares.share_unseen.unwrap_or_default());
            sentences.push(match diagnosis.shares.share_of_misfit {
                Some(share) => format!(
                    "That explains {} % of the misfit, and {unseen} % in readings left out of the fit. The rest is {}.",
                    percent(share),
                    location(subject, &report.unexplained())
                ),
                None => format!("That explains {unseen} % of the error in readings left out of the fit."),
            });
        }
        VerdictGrade::Weak => {}
        VerdictGrade::Unknown => sentences.push(format!(
            "Something is missing from the {}, and no law of the library explains it: it shows {}.",
            subject.model(),
            location(subject, &report.unexplained())
        )),
        VerdictGrade::Nothing => {
            sentences.push("No missing physics was detected.".to_owned());
        }
        VerdictGrade::Undecided => sentences.push(format!(
            "These readings cannot decide whether the {} leaves something out.",
            subject.model()
        )),
    }
    if !weak.is_empty() {
        let why = if from_fit {
            "it was tested only against the residuals of the fit"
        } else {
            "chance may produce as much"
        };
        sentences.push(format!(
            "There is a weak sign of {}: {why}.",
            listed(&weak, "and of")
        ));
    }
    if from_fit {
        sentences.push(format!(
            "Nothing was repeated: the scatter of {} is estimated from the residuals of the fit. If your gauge repeats better, something is missing.",
            subject.reading(diagnosis.noise.reading_sd_m)
        ));
    }
    sentences.join(" ")
}

fn lacking(report: &DiagnosisReport, answers: &[DiagnosisAnswer<'_>]) -> Document {
    let lacking = &report.diagnosis.lacking;
    if lacking.is_empty() {
        return Document::new();
    }
    let mut section = Document::under("What is lacking");
    section.items(lacking);
    if !answers.is_empty() {
        let all: Vec<String> = answers.iter().map(DiagnosisAnswer::phrase).collect();
        let hint = format!(
            "The search pointed at {}. That is not a finding: scatter and missing physics cannot be distinguished here.",
            listed(&all, "and at")
        );
        section.paragraph(hint);
    }
    section
}

/// Each finding with what it is and how large, physics before mistakes of the robot file and the set-up.
fn missing(report: &DiagnosisReport, answers: &[DiagnosisAnswer<'_>]) -> Document {
    if answers.is_empty() {
        return Document::new();
    }
    let mut section = Document::new();
    let is_unknown = report.diagnosis.verdict == Verdict::Unknown;
    if is_unknown {
        section.heading("What explains a part of it");
        section.paragraph("The following improves the model but does not explain what the readings show. Do not take it for the cause: a cause outside \
             the library can make laws of the library look right.");
    }
    let is_weak = |answer: &&DiagnosisAnswer<'_>| answer.members()[0].grade == VerdictGrade::Weak;
    let mut part = |heading: &str, answers: Vec<&DiagnosisAnswer<'_>>| {
        for (place, answer) in answers.into_iter().enumerate() {
            if place == 0 && !is_unknown {
                section.heading(heading);
            }
            section.append(answer_section(report, answer));
        }
    };
    for accused in ACCUSED {
        let own = answers.iter().filter(|answer| answer.accuses() == accused);
        part(
            accused.heading(),
            own.filter(|answer| !is_weak(answer)).collect(),
        );
    }
    part(
        "Weak signs, which chance may have made",
        answers.iter().filter(is_weak).collect(),
    );
    section.paragraphs(loop_words(report));
    let beginnings = &report.diagnosis.beginnings;
    section.paragraphs(beginnings.in_words(|load| report.subject.load(load)));
    let sizes = report.diagnosis.sizes;
    if sizes != ConfigurationSizes::Common {
        let follow = format!(
            "Sizes are means over the configurations; from one to the next they go {}.",
            sizes.in_words()
        );
        section.paragraph(follow);
    }
    section
}

/// The findings of an answer.
fn answer_section(report: &DiagnosisReport, answer: &DiagnosisAnswer<'_>) -> Document {
    let mut section = Document::new();
    if let DiagnosisAnswer::OneOf(members) = answer {
        let several = format!(
            "One of these {}; the readings do not decide which; the first explains them as well as any.",
            members.len()
        );
        section.paragraph(several);
    }
    let mut explained: Vec<Law> = Vec::new();
    for finding in answer.members() {
        let law = finding.effect.law;
        let mut sentence = described(report, finding, !explained.contains(&law));
        if let Some(line) = report.file_line(&finding.effect) {
            let FileLine { file, line, text } = line;
            let _ = write!(sentence, " Line {line} of {file}: `{text}`.");
        }
        explained.push(law);
        section.item(sentence);
    }
    section
}

/// A finding with its sizes, and what its law does if that is to be said.
fn described(report: &DiagnosisReport, finding: &Finding, with_law: bool) -> String {
    let (law, subject) = (finding.effect.law, &report.subject);
    let mut text = capital(&format!("{} ({law}).", phrase_of(finding)));
    if with_law {
        let _ = write!(text, " {}", law.words.explanation);
    }
    for (spec, value) in finding.stated() {
        let (factor, unit) = subject.printed(&spec, value.value);
        let interval = value.interval_95().map(|ends| ends.map(|end| factor * end));
        let is_open = value.is_open();
        let digits = interval.map_or(3, |ends| digits_in(factor * value.value, ends));
        let words = open_interval(interval, is_open, digits);
        let interval = match (interval, is_open) {
            (None, _) => "no interval can be given".to_owned(),
            (Some(_), [false, false]) => format!("95 % interval {words}"),
            (Some(_), _) => format!("95 %: {words}"),
        };
        let _ = write!(
            text,
            " {}: {}{} ({interval}).",
            capital(spec.word),
            significant(factor * value.value, digits),
            unit_behind(&unit)
        );
    }
    if finding.at_bound
        && let Some(size) = law.parameters.first()
    {
        let _ = write!(
            text,
            " This is the bound of the plausible range ({}): doubt the finding.",
            size.plausible.reason
        );
    }
    let _ = write!(
        text,
        " It changes readings by up to {}; the fitted {}s had absorbed {:.0} % of it.",
        subject.reading(finding.end_effect_m),
        subject.factor(),
        100.0 * finding.absorbed_share.clamp(0.0, 1.0)
    );
    if let Some(check) = check(&finding.effect).filter(|_| !report.is_of_part()) {
        let _ = write!(text, " To check it by hand: {check}.");
    }
    text
}

/// Digits of a value and the ends of its interval: two of the half-width are seen (JCGM 100:2008, 7.2.6), and three of the value.
fn digits_in(value: f64, [low, high]: [f64; 2]) -> usize {
    let half = 0.5 * (high - low);
    let places = (value.abs() / half).log10().floor();
    if places.is_finite() {
        (places + 2.0).clamp(3.0, 9.0) as usize
    } else {
        3
    }
}

/// A sentence with a capital at its start.
pub(super) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

fn sure(report: &DiagnosisReport, answers: &[DiagnosisAnswer<'_>]) -> Document {
    let sentence = |answer: &DiagnosisAnswer<'_>| {
        let best = answer.members()[0];
        let name = match answer {
            DiagnosisAnswer::Single(_) => capital(&phrase_of(best)),
            DiagnosisAnswer::OneOf(members) => format!("One of the {}", members.len()),
        };
        let sentence = format!(
            "{name}: the readings are {} with it than without (log Bayes factor {:.1}; {}). Noise alone would produce evidence this strong {}. After removing what the fitted {}s can absorb, the effect is {:.1} standard errors above the noise.",
            likelier(best.log_bayes),
            best.log_bayes,
            strength(best.log_bayes),
            one_in(
                best.p_family,
                least_law_p(&report.critical, best.effect.law)
            ),
            report.subject.factor(),
            best.standard_errors
        );
        sentence + &shares_text(&best.shares)
    };
    Document::list_under("How sure", answers.iter().map(sentence))
}

/// What a finding explains of the misfit, as a sentence behind another; empty where the misfit is too small to be divided.
fn shares_text(shares: &MisfitShares) -> String {
    let Some(share) = shares.share_of_misfit else {
        return String::new();
    };
    let unseen = shares.share_unseen.map_or_else(String::new, |unseen| {
        format!(
            ", and {:.0} % in readings left out of the fit",
            100.0 * unseen
        )
    });
    format!(" It explains {:.0} % of the misfit{unseen}.", 100.0 * share)
}

/// The nearest rivals.
fn else_(answers: &[DiagnosisAnswer<'_>]) -> Document {
    let sentence = |answer: &DiagnosisAnswer<'_>| {
        let best = answer.members()[0];
        match (best.rivals.first(), answer) {
            (None, DiagnosisAnswer::Single(_)) => format!(
                "{}: no other law of the library explains the readings nearly as well{}.",
                capital(&phrase_of(best)),
                match best.effect.place {
                    Place::JointAngle { pose: Some(_), .. } => {
                        "; a mistake in the data, such as two cells exchanged, is not a law: check the labels of that pose too"
                    }
                    _ => "",
                }
            ),
            (None, DiagnosisAnswer::OneOf(_)) => {
                "No other law of the library explains the readings nearly as well.".to_owned()
            }
            (Some(rival), _) => {
                let own = phrase_of(best);
                let other = phrase(rival.effect.law, &rival.effect.place, &rival.effect.values);
                let equation = |law: Law| format!("the equation {}", law.equation);
                let (other, with) = if own == other {
                    let of_rival = equation(rival.effect.law);
                    (format!("the same by {of_rival}"), equation(best.effect.law))
                } else {
                    (other, own.clone())
                };
                let subject = match answer {
                    DiagnosisAnswer::Single(_) => format!("Instead of {own}"),
                    DiagnosisAnswer::OneOf(_) => "Besides those above".to_owned(),
                };
                format!(
                    "{subject} the next best is {other}; the readings are {} with {with} (log Bayes factor {:.1}).",
                    likelier(rival.log_bayes_to_winner),
                    rival.log_bayes_to_winner
                )
            }
        }
    };
    Document::list_under("What else it could be", answers.iter().map(sentence))
}

fn where_(report: &DiagnosisReport) -> Document {
    let locations = report.locations();
    if locations.is_empty() {
        return Document::new();
    }
    let model = report.subject.model();
    let mut section = Document::under(match report.diagnosis.verdict {
        Verdict::NothingMissing => "Largest deviations, within chance".to_owned(),
        Verdict::Unknown => format!("Where the {model} fails"),
        _ => format!("Where the {model} without it fails"),
    });
    let line = |one: &Location| {
        let least = if one.p_at_floor { one.p_family } else { 0.0 };
        format!(
            "{}; by chance alone this would occur somewhere {}.",
            capital(&location(&report.subject, one)),
            one_in(one.p_family, least)
        )
    };
    section.items(locations.iter().take(PATTERNS).map(line));
    let suspects = [
        ("the stiffness", &report.located.slope_components),
        ("the shape of the curves", &report.located.shape_components),
    ];
    // A part has no parts of a structure.
    for (what, shares) in suspects.into_iter().filter(|_| !report.is_of_part()) {
        // A part that leaves something unexplained is no pointer for this page; the appendix has it.
        let enough = |one: &&ExplainedShare| one.possible && one.p_left > ENOUGH;
        if let Some(best) = shares.iter().find(enough) {
            section.item(carried(what, best));
        }
    }
    section
}

/// Which part of the structure would carry a misfit.
fn carried(what: &str, best: &ExplainedShare) -> String {
    let alike: Vec<String> = best.alike.iter().map(ToString::to_string).collect();
    let also = match alike.len() {
        0 => String::new(),
        n if n > ALIKE => format!(
            " (or {}, or {} further parts)",
            alike[..ALIKE].join(", "),
            n - ALIKE
        ),
        _ => format!(" (or {}, which look alike)", listed(&alike, "or")),
    };
    format!(
        "A compliance of {}{also} alone would explain the misfit of {what}.",
        best.component
    )
}

#[cfg(test)]
mod tests {
    use insta::assert_snapshot;

    use super::*;
    use crate::analysis::diagnose_part;
    use crate::mismatch::SearchOptions;
    use crate::specimen::{ResponseVariable, SpecimenOptions, read_specimen};

    /// What is found in a table of a part.
    fn diagnosed(file: &str, options: &SpecimenOptions) -> DiagnosisReport {
        let table = stiffbench_test_files::text(file);
        let table = read_specimen(&[("table.csv", table.as_bytes())], options).unwrap();
        let search = SearchOptions::default();
        diagnose_part("table.csv", &table, &search, &|| ())
            .unwrap()
            .0
    }

    /// The true friction of the two sliders is 1.9 and 1.5 kN, the spring beside them 0.6 kN/mm.
    #[test]
    fn what_is_found_stands_in_the_headline_and_beside_what_it_changes() {
        let options = SpecimenOptions {
            force_column: Some("force_kN".to_owned()),
            displacement_column: "disp_mm".to_owned(),
            response: Some(ResponseVariable::Force),
            ..SpecimenOptions::default()
        };
        let report = diagnosed("fixtures/cases/two-sliders/two_sliders.csv", &options);
        assert_snapshot!(headline(&report), @"The straight line leaves out friction in the part (1.90 kN, up to 1.90 kN) and friction in the part (1.50 kN, up to 1.50 kN).");
        assert_snapshot!(factors(&report).text(), @r"
        HOW THE FITTED SLOPES CHANGE
        Without the effect, the fitted slopes partly absorbed it. The table shows the slopes without it and
        with it.

        | slope                    | without |   with |  change |    95 % interval | determined |
        |--------------------------|---------|--------|---------|------------------|------------|
        | slope of specimen, kN/mm |   1.791 | 0.6020 | -66.4 % | 0.5933 to 0.6065 | yes        |
        ");
    }

    #[test]
    fn where_readings_do_not_decide_the_page_asks_for_those_that_would() {
        let one = || Some("1".to_owned());
        let options = SpecimenOptions {
            force_column: Some("load".to_owned()),
            displacement_column: "deflection".to_owned(),
            force_unit: one(),
            displacement_unit: one(),
            run_column: vec!["run".to_owned()],
            order_column: Some("order".to_owned()),
            ..SpecimenOptions::default()
        };
        let report = diagnosed("fixtures/goldens/inputs/softening.csv", &options);
        assert_snapshot!(headline(&report), @"The straight line leaves out a nonlinear force gauge, a part that grows stiffer under load or a part whose response grows more slowly than its load; these readings do not decide which.");
        assert_snapshot!(next(&report, DiagnosisDetail::Report).text(), @r"
        WHAT TO MEASURE NEXT
        - The same part, the same plan again. About 45 min by hand; this should distinguish a part that
          grows stiffer under load from a part whose response grows more slowly than its load (expected odds
          for the right one above 1000 to 1) and a nonlinear force gauge from a part whose response grows
          more slowly than its load (expected odds for the right one above 1000 to 1).
        ");
    }
}
