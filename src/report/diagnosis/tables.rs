//! The tables of the verdict page: factors, errors, and what would have been found.

use stiffbench_document::{Document, Table};

use crate::mismatch::Quality;
use crate::physics::{Law, Place};
use crate::report::text::{significant, with_unit};

use super::page::capital;
use super::{Determination, DiagnosedModel, FactorChangeReport};
use crate::analysis::{DiagnosisReport, Subject};

/// The factors, and how they move back once what was missing is there.
pub(super) fn factors(report: &DiagnosisReport) -> Document {
    if report.parameters.is_empty() {
        return Document::new();
    }
    let found = !report.diagnosis.findings.is_empty();
    let factor = report.subject.factor();
    let mut section = Document::under(if found {
        format!("How the fitted {factor}s change")
    } else {
        format!("{}s fitted in the diagnosis", capital(factor))
    });
    if found {
        let why = format!(
            "Without the effect, the fitted {factor}s partly absorbed it. The table shows the {factor}s without it and with it."
        );
        section.paragraph(why);
    }
    let change = |one: &FactorChangeReport| {
        // Adding zero makes a change that rounds to nothing +0.0.
        let rounded = |percent: f64| (10.0 * percent).round() / 10.0 + 0.0;
        let change = one.change_percent.map(rounded);
        change.map_or_else(
            || "from zero".to_owned(),
            |percent| format!("{percent:+.1} %"),
        )
    };
    let determined = |one: &FactorChangeReport| match one.status {
        Determination::Free => "yes",
        Determination::AtBound => "no, at its bound",
        Determination::NotIdentified => "no",
    };
    let table = Table::of(report.factor_changes())
        .words(factor, |one| with_unit(&one.name, &one.after.unit))
        .when(found, |table| {
            table.numbers("without", |one| significant(one.before.value, 4))
        })
        .numbers(if found { "with" } else { "value" }, |one| {
            significant(one.after.value, 4)
        })
        .when(found, |table| table.numbers("change", change))
        .numbers("95 % interval", |one| one.after.interval_in_words(4))
        .words("determined", determined);
    section.table(table);
    section
}

/// How far the model misses the readings, without and with what was found.
pub(super) fn errors(report: &DiagnosisReport) -> Document {
    let (diagnosis, subject) = (&report.diagnosis, &report.subject);
    let found = !diagnosis.findings.is_empty();
    let mut section = Document::under(format!(
        "How far the {} misses the readings",
        subject.model()
    ));
    let shown = |rms_m: f64| {
        format!(
            "{} ({} %)",
            subject.reading(rms_m),
            significant(100.0 * rms_m / report.trace.displacement_rms_m, 2)
        )
    };
    let mut rows: Vec<[String; 3]> = Vec::new();
    let mut add = |name: &str, before, after| rows.push([name.to_owned(), before, after]);
    let models = [DiagnosedModel::Before, DiagnosedModel::After];
    let mut both = |name: &str, of: &dyn Fn(&Quality) -> String| {
        let [before, after] = models.map(|model| of(report.quality(model)));
        add(name, before, after);
    };
    both("all readings", &|quality| shown(quality.rms_m));
    // Each configuration of a part has a slope of its own: one that was left out would have none.
    let is_of_robot = !report.is_of_part();
    let only_one = || "only one pose".to_owned();
    if is_of_robot {
        both("poses left out of the fit", &|quality| {
            quality.held_out_rms_m.map_or_else(only_one, &shown)
        });
    }
    both("all readings, in units of the noise", &|quality| {
        format!("{:.2}", quality.reduced_chi2.sqrt())
    });
    if is_of_robot {
        both("poses left out, in units of the noise", &|quality| {
            let units = quality.held_out_noise_units;
            units.map_or_else(only_one, |units| format!("{units:.2}"))
        });
    }
    // Of one load in each run zero and slope are all there is.
    let (place, off) = if report.observations.has_series() {
        (1, ", without zero and slope of each run")
    } else {
        (0, "")
    };
    for direction in report.directions() {
        let along = match subject {
            Subject::Robot(_) => format!("along {direction}"),
            Subject::Part { .. } => "of all runs".to_owned(),
        };
        let [before, after] =
            models.map(|model| subject.reading(report.rms_m(model, Some(direction))[place]));
        add(&format!("readings {along}{off}"), before, after);
    }
    let table = Table::of(rows)
        .words("root mean square", |[name, ..]| name.clone())
        .when(found, |table| {
            table.numbers("without", |[_, before, _]| before.clone())
        })
        .numbers(if found { "with" } else { "model" }, |[.., after]| {
            after.clone()
        });
    section.table(table);
    let of = match (
        &report.observations.tracker,
        report.observations.has_series(),
    ) {
        _ if report.is_of_part() => "readings about the mean of their run",
        (Some(_), _) => "positions from where the rigid robot stands",
        (None, true) => "displacements about the mean of their gauge zero",
        (None, false) => "displacements",
    };
    let softest = subject.words(
        " Micrometre values are dominated by the softest direction; noise-normalised values weight all readings equally.",
        "",
    );
    let floor = format!(
        "Percentages refer to the RMS of the {of}, {}. Noise alone gives about {} over all readings, or 1.00 in units of the noise; a fit leaves somewhat less, because zeros and {}s follow the noise.{softest}",
        subject.reading(report.trace.displacement_rms_m),
        subject.reading(report.noise_floor_m()),
        subject.factor()
    );
    section.paragraph(floor);
    section
}

/// For each law the effect that would have been found, where it is seen best and worst.
pub(super) fn upper_limits(report: &DiagnosisReport) -> Document {
    let (critical, subject) = (&report.diagnosis.detection_limits, &report.subject);
    let mut section = Document::new();
    if critical.is_empty() {
        return section;
    }
    section.heading("What would have been found");
    let at = subject.words("at the end of the robot", "on a reading");
    let promise = format!(
        "Smaller effects may be present. An effect of this size {at} would have been detected in four of five such sessions; the table lists the places where each law is detected best and worst, and at how many of its places no size could have been detected."
    );
    section.paragraph(promise);
    let rows = Law::ALL.iter().filter_map(|&law| {
        let places: Vec<_> = critical.iter().filter(|limit| limit.law == law).collect();
        let known = places.iter();
        let known = known.filter_map(|limit| Some((limit.end_effect_m?, &limit.place)));
        let mut known: Vec<(f64, &Place)> = known.collect();
        known.sort_by(|a, b| a.0.total_cmp(&b.0));
        let worst = known.last().filter(|_| known.len() > 1).copied();
        let ends = [known.first().copied(), worst];
        let [all, untested] = [places.len(), places.len() - known.len()];
        (all > 0).then_some((law, ends, all, untested))
    });
    let size = |end: Option<(f64, &Place)>| {
        end.map_or_else(String::new, |(size_m, _)| subject.reading(size_m))
    };
    let place =
        |end: Option<(f64, &Place)>| end.map_or_else(String::new, |(_, place)| place.to_string());
    let table = Table::of(rows)
        .words("law", |(law, ..)| law.row)
        .numbers("detected best", |(_, [best, _], ..)| size(*best))
        .words("at", |(_, [best, _], ..)| place(*best))
        .numbers("detected worst", |(_, [_, worst], ..)| size(*worst))
        .words("at", |(_, [_, worst], ..)| place(*worst))
        .numbers("not testable", |(.., all, untested)| match untested {
            0 => "-".to_owned(),
            untested => format!("{untested} of {all}"),
        });
    section.table(table);
    section
}
