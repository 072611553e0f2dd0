//! The numbers behind the verdict page, for readers who know statistics.

use stiffbench_document::{Document, Table};

use crate::mismatch::{
    DetectionLimit, EstimatedValue, ExplainedShare, Finding, Observations, Rival, Spot,
};
use crate::physics::{Law, ParameterSpec, Place};
use crate::report::text::{digits, open_interval, or_dash, significant};
use crate::search::{DESIGN_LENGTH, LAW_LEVEL, NULL_SAMPLES, UNEXPLAINED_LEVEL};

use super::noise::noise_text;
use super::phrases::listed;
use crate::analysis::{DiagnosisReport, Subject};
use crate::count::counted;

/// The technical appendix: all tables.
pub(super) fn appendix(report: &DiagnosisReport) -> Document {
    let diagnosis = &report.diagnosis;
    let mut section = Document::under("Appendix: the numbers");
    section.paragraph(provenance(report));
    section.append(noise_text(&report.into()));
    if !diagnosis.findings.is_empty() {
        section.paragraph("Findings. absorbed: share of the whitened effect that the fitted factors absorb; p: probability that noise alone produces evidence this strong for any law.");
        section.table(findings(report));
        section.paragraph("Candidates. log B: natural logarithm of the Bayes factor against the model without the finding they stand in for.");
        section.table(candidates(&diagnosis.findings));
    }
    section.paragraph("Strata of the model without effects, each against its own scatter: F with its degrees of freedom, p family-wise by Holm, share of the misfit beyond noise, largest deviation of a reading.");
    section.append(strata(report));
    if !report.is_of_part() {
        section.append(suspects(report));
    }
    section.append(quality(report));
    if report.impossible().next().is_some() {
        section.paragraph(
            "Rejected: the decrease of the weighted squares by a value with an impossible sign.",
        );
        section.table(
            Table::of(report.impossible())
                .words("law and place", |one| named(one.law, &one.place))
                .numbers("decrease of the squares", |one| {
                    significant(one.delta_chi2, 3)
                }),
        );
    }
    section.append(critical_values(report));
    section.append(detection_limits(report));
    section
}

/// A law and its place in one cell of a table.
fn named(law: Law, place: &Place) -> String {
    format!("{} at {place}", law.row)
}

fn provenance(report: &DiagnosisReport) -> String {
    let without: Vec<String> = report
        .without
        .iter()
        .map(|law| law.row.to_owned())
        .collect();
    let without = if without.is_empty() {
        "no law left out".to_owned()
    } else {
        format!("without {}", listed(&without, "and"))
    };
    let observations = &report.observations;
    let (of, cell) = match &report.subject {
        Subject::Robot(robot) => {
            let (name, mechanism) = (&robot.robot, &robot.mechanism);
            let from = &robot.start_factors;
            let of = format!("robot {name}, mechanism {mechanism}, factors from {from}");
            (of, "cell")
        }
        Subject::Part { .. } => ("a part without a robot file".to_owned(), "configuration"),
    };
    let sentence = format!(
        "stiffbench {}; data {}; {of}; {} in {} of {}; {without}; seed {}.",
        env!("CARGO_PKG_VERSION"),
        report.data,
        readings_of(observations),
        counted(observations.runs.len(), "run"),
        counted(observations.cells.len(), cell),
        report.seed
    );
    sentence
}

/// How many readings there are, and of how many gauges if of several.
fn readings_of(observations: &Observations) -> String {
    let readings = counted(observations.len(), "reading");
    match observations.gauges.len() {
        0 => readings,
        gauges => format!("{readings} by {gauges} gauges"),
    }
}

fn findings(report: &DiagnosisReport) -> Table {
    let (findings, subject) = (&report.diagnosis.findings, &report.subject);
    let parameter = |(spec, value): (ParameterSpec, &EstimatedValue)| {
        let (factor, unit) = subject.printed(&spec, value.value);
        let interval = value.interval_95().map(|e| e.map(|x| factor * x));
        [
            spec.name.to_owned(),
            significant(factor * value.value, 4),
            open_interval(interval, value.is_open(), 3),
            unit,
        ]
    };
    // What is said of a finding stands beside its first parameter.
    let rows = findings.iter().flat_map(|finding| {
        let mut parameters: Vec<[String; 4]> = finding.stated().map(parameter).collect();
        if parameters.is_empty() {
            parameters.push(["-"; 4].map(str::to_owned));
        }
        let once = std::iter::once(Some(finding)).chain(std::iter::repeat(None));
        once.zip(parameters)
    });
    let once = |finding: Option<&Finding>, words: &dyn Fn(&Finding) -> String| {
        finding.map_or_else(String::new, words)
    };
    Table::of(rows)
        .words("law and place", |(first, _)| {
            once(*first, &|one| named(one.effect.law, &one.effect.place))
        })
        .words("set", |(first, _)| {
            once(*first, &|one| {
                or_dash(one.alternative_group, |group| group.to_string())
            })
        })
        .words("parameter", |(_, [name, ..])| name.clone())
        .numbers("value", |(_, [_, value, ..])| value.clone())
        .numbers("95 % interval", |(_, [.., interval, _])| interval.clone())
        .words("unit", |(_, [.., unit])| unit.clone())
        .numbers("end effect", |(first, _)| {
            once(*first, &|one| subject.reading(one.end_effect_m))
        })
        .numbers("std errors", |(first, _)| {
            once(*first, &|one| significant(one.standard_errors, 3))
        })
        .numbers("absorbed", |(first, _)| {
            once(*first, &|one| significant(one.absorbed_share, 2))
        })
        .numbers("p", |(first, _)| {
            once(*first, &|one| significant(one.p_family, 2))
        })
        .into()
}

fn candidates(findings: &[Finding]) -> Table {
    let mut rows: Vec<(&Finding, Option<&Rival>)> = Vec::new();
    let mut seen: Vec<u32> = Vec::new();
    for finding in findings {
        rows.push((finding, None));
        // The members of a set share their rivals: these are told once, behind the last member.
        let is_last = match finding.alternative_group {
            None => true,
            Some(group) => {
                let members = findings
                    .iter()
                    .filter(|f| f.alternative_group == Some(group));
                seen.push(group);
                seen.iter().filter(|g| **g == group).count() == members.count()
            }
        };
        if is_last {
            rows.extend(finding.rivals.iter().map(|rival| (finding, Some(rival))));
        }
    }
    Table::of(rows)
        .words("law and place", |(finding, rival)| {
            let effect = rival.map_or(&finding.effect, |rival| &rival.effect);
            named(effect.law, &effect.place)
        })
        .numbers("log B", |(finding, rival)| {
            let behind = rival.map_or(0.0, |rival| rival.log_bayes_to_winner);
            format!("{:.1}", finding.log_bayes - behind)
        })
        .numbers("behind the winner", |(_, rival)| {
            rival.map_or_else(String::new, |one| format!("{:.1}", one.log_bayes_to_winner))
        })
        .numbers("cosine", |(_, rival)| {
            rival.map_or_else(String::new, |one| format!("{:.3}", one.cosine))
        })
        .words(
            "",
            |(_, rival)| if rival.is_some() { "rival" } else { "named" },
        )
        .into()
}

fn strata(report: &DiagnosisReport) -> Document {
    let dof = |[above, below]: [f64; 2]| {
        if below.is_finite() {
            format!("{above:.0}, {below:.0}")
        } else {
            format!("{above:.0}, known")
        }
    };
    // The draws for a coarse gauge can show no less.
    let less = |at_floor: bool| if at_floor { "<" } else { "" };
    let mut section = Document::new();
    section.table(
        Table::of(&report.located.tests)
            .words("contrast", |test| &test.contrast)
            .words("stratum", |test| &test.stratum)
            .numbers("F", |test| significant(test.statistic, 3))
            .numbers("dof", |test| dof(test.dof))
            .numbers("p family-wise", |test| {
                less(test.p_at_floor).to_owned() + &significant(test.p_family, 2)
            })
            .numbers("share", |test| format!("{:.0} %", 100.0 * test.share))
            .numbers("size", |test| report.subject.reading(test.size_m))
            .words("sits in", |test| or_dash(test.spots.first(), spot)),
    );
    for one in &report.located.untested {
        section.item(format!("{} was not tested: {}.", one.contrast, one.why));
    }
    let left = &report.diagnosis.unexplained;
    let of_pose = left.pose.as_ref().map_or_else(
        || format!("all {}s", report.subject.pose()),
        ToString::to_string,
    );
    let along = match (&report.subject, left.direction) {
        (Subject::Part { .. }, _) => String::new(),
        (_, Some(direction)) => format!(", {direction}"),
        (_, None) => ", all directions".to_owned(),
    };
    let sentence = format!(
        "Largest pattern in the residuals of the final model: {} in {of_pose}{along} (p {}).",
        left.stratum,
        significant(left.p_family, 2)
    );
    section.paragraph(sentence);
    section
}

/// The part that holds most of a contrast.
fn spot(spot: &Spot) -> String {
    let parts = [
        spot.pose.as_ref().map(ToString::to_string),
        spot.direction.map(|direction| direction.to_string()),
        spot.repeat
            .zip(spot.step)
            .map(|(repeat, step)| format!("repeat {repeat} step {step}")),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    let name = if parts.is_empty() {
        "all".to_owned()
    } else {
        parts.join(" ")
    };
    format!("{name} ({:.0} %)", 100.0 * spot.share)
}

/// Parts of the structure that would carry the misfit.
fn suspects(report: &DiagnosisReport) -> Document {
    /// Parts that are told.
    const PARTS: usize = 8;
    let mut section = Document::new();
    for (what, shares) in [
        ("slopes", &report.located.slope_components),
        ("shapes", &report.located.shape_components),
    ] {
        if shares.is_empty() {
            continue;
        }
        section.paragraph(format!(
            "Parts of the structure by the share of the misfit of {what} that each explains alone; p left: probability of the rest under noise alone."
        ));
        let alike = |one: &&ExplainedShare| {
            let alike: Vec<String> = one.alike.iter().take(3).map(ToString::to_string).collect();
            match one.alike.len().saturating_sub(alike.len()) {
                0 => alike.join("; "),
                more => format!("{} and {more} more", alike.join("; ")),
            }
        };
        let possible = |one: &&ExplainedShare| if one.possible { "yes" } else { "no" }.to_owned();
        section.table(
            Table::of(shares.iter().take(PARTS))
                .words("part", |one| &one.component)
                .numbers("share", |one| format!("{:.0} %", 100.0 * one.share))
                .numbers("p left", |one| significant(one.p_left, 2))
                .words("possible", possible)
                .words("alike", alike),
        );
    }
    section
}

fn quality(report: &DiagnosisReport) -> Document {
    let (before, after) = (&report.diagnosis.before, &report.diagnosis.after);
    let subject = &report.subject;
    let mut section = Document::new();
    let of_all = format!(
        "Reduced chi-squared {:.3} before, {:.3} after.",
        before.reduced_chi2, after.reduced_chi2
    );
    if report.is_of_part() {
        section.paragraph(of_all);
    } else if before.held_out.is_empty() {
        section.paragraph(format!(
            "{of_all} Only one pose was measured: none can be left out of the fit."
        ));
    } else {
        section.paragraph(format!("{of_all} Error in each pose left out of the fit:"));
        section.table(
            Table::of(before.held_out.iter().zip(&after.held_out))
                .words("pose left out", |(before, _)| before.pose.to_string())
                .numbers("before", |(before, _)| subject.reading(before.rms_m))
                .numbers("after", |(_, after)| subject.reading(after.rms_m)),
        );
    }
    section
}

fn critical_values(report: &DiagnosisReport) -> Document {
    let critical = &report.critical;
    let mut section = Document::new();
    let sentence = format!(
        "Limits. Noise alone leads to a law in {} % of sessions and to unexplained structure in {} %, from {NULL_SAMPLES} draws with seed {}. The \
         level of the laws is split between them so that most are found at {DESIGN_LENGTH} standard errors; the critical value is that of the decrease of the \
         weighted squares.",
        significant(100.0 * LAW_LEVEL, 2),
        significant(100.0 * UNEXPLAINED_LEVEL, 2),
        report.seed
    );
    section.paragraph(sentence);
    let laws = critical.laws.values.iter().map(|(family, limit)| {
        let (law, wide) = *family;
        let more = if wide { " (any period)" } else { "" };
        let level = critical.laws.levels.get(family).copied();
        let share = level.map(|level| level / LAW_LEVEL);
        (format!("{}{more}", law.row), share, level, *limit)
    });
    let unexplained = (
        "unexplained structure".to_owned(),
        None,
        Some(UNEXPLAINED_LEVEL),
        critical.of_unexplained(),
    );
    section.table(
        Table::of(laws.chain([unexplained]))
            .words("law", |(name, ..)| name.clone())
            .numbers("share of the level", |(_, share, ..)| {
                or_dash(*share, |share| format!("{share:.3}"))
            })
            .numbers("level, %", |(_, _, level, _)| {
                digits(level.map(|level| 100.0 * level), 2)
            })
            .numbers("critical value", |(.., limit)| format!("{limit:.1}")),
    );
    section
}

/// What would have been found of each law at each place.
fn detection_limits(report: &DiagnosisReport) -> Document {
    let subject = &report.subject;
    let mut critical: Vec<&DetectionLimit> = report.diagnosis.detection_limits.iter().collect();
    if critical.is_empty() {
        return Document::new();
    }
    // The sort is stable: places of a law stay in the order of the robot.
    critical.sort_by_key(|limit| limit.law);
    let printed = |limit: &DetectionLimit| {
        let spec = limit.law.parameters_at(&limit.place).next();
        let size = limit.size_80.or(limit.upper_95).unwrap_or(0.0);
        spec.map_or((1.0, "-".to_owned()), |spec| subject.printed(&spec, size))
    };
    let shown = |limit: &DetectionLimit, value: Option<f64>, none: &str| {
        let shown = value.map(|value| significant(printed(limit).0 * value, 3));
        shown.unwrap_or_else(|| none.to_owned())
    };
    let mut document = Document::of(
        "Smallest effect found in 80 % of such sessions (size and largest change of a reading), upper 95 % limit of the size where nothing was found.",
    );
    document.table(
        Table::of(critical)
            .words("law and place", |limit| named(limit.law, &limit.place))
            .numbers("size", |limit| shown(limit, limit.size_80, "not testable"))
            .numbers("upper 95 %", |limit| shown(limit, limit.upper_95, "-"))
            .words("unit", |limit| printed(limit).1)
            .numbers("at the end", |limit| {
                or_dash(limit.end_effect_m, |end_effect_m| {
                    subject.reading(end_effect_m)
                })
            }),
    );
    document
}
