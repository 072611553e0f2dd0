//! From a diagnosis to the inputs of its figures.

mod law;
mod load_displacement;
mod map;

use crate::mismatch::{Finding, Impossible, LawCriticalValues, ReadingTrace, VerdictGrade};
use crate::physics::{Effect, title};
use crate::plot::{
    BeforeAfterPoint, CandidateDecision, DetectionLimitBar, DetectionLimits, EvidenceBars,
    EvidenceCandidate, FactorShift, FactorValue, Figure, HeldOutError, HeldOutPose,
    MisfitWaterfall, ResidualMeasure, ResidualPoint, Residuals, ResidualsAgainst,
    ResidualsBeforeAfter, ShiftedFactor, WaterfallStep, detection_limits, evidence_bars,
    factor_shift, found_law, held_out_error, misfit_waterfall, mismatch_map, residuals,
    residuals_before_after,
};
use crate::search::DISTINGUISHABLE;

use super::diagnosis::{DiagnosedModel, DiagnosisAnswer, FittedParameter, listed, short_phrase};
use crate::analysis::DiagnosisReport;

/// All figures of a diagnosis with the names of their files; those that compare with a finding only where there is one.
#[must_use]
pub fn diagnosis_figures(report: &DiagnosisReport) -> Vec<(String, Figure)> {
    /// What was done to the residuals of a figure.
    const WITHIN_RUNS: &str =
        " Zero and slope of each run, as the final model finds them, are taken off.";
    const STEPS_WITHIN_RUNS: &str =
        " Zero and slope of each run are taken off before the means of load steps.";
    let noted = |mut figure: Figure, note: &str| {
        if report.observations.has_series() {
            figure.caption.push_str(note);
        }
        figure
    };
    let diagnosis = &report.diagnosis;
    let known = diagnosis.known_effects.len();
    let effects = diagnosis.effects.get(known..).unwrap_or_default();
    let mut figures: Vec<(String, Figure)> = Vec::new();
    let mut add = |name: &str, figure: Figure| figures.push((name.to_owned(), figure));
    // A part is loaded continuously: a map of its load steps would have a column a reading.
    if report.observations.has_series() && !report.is_of_part() {
        let map = |model| noted(mismatch_map(&map::map(report, model)), STEPS_WITHIN_RUNS);
        add("mismatch_map", map(DiagnosedModel::Before));
        if !effects.is_empty() {
            add("mismatch_map_after", map(DiagnosedModel::After));
        }
    } else if effects.is_empty() {
        add("residuals", residuals(&left(report)));
    }
    if !effects.is_empty() {
        let found = found(effects);
        let before_after = residuals_before_after(&before_after(report, &found));
        add("residuals_before_after", noted(before_after, WITHIN_RUNS));
        for (place, effect) in report.trace.effects.iter().skip(known).enumerate() {
            let figure = noted(found_law(&law::law(report, effect)), WITHIN_RUNS);
            add(&numbered("found_law", place), figure);
        }
        for (place, answer) in DiagnosisAnswer::all(&diagnosis.findings).iter().enumerate() {
            // What is impossible was assessed against the model without effects, as the first finding was.
            let impossible: Vec<&Impossible> = report.impossible().filter(|_| place == 0).collect();
            let figure = evidence_bars(&evidence(answer, &impossible, &report.critical));
            add(&numbered("evidence_bars", place), figure);
        }
        if let Some(figure) = waterfall(report) {
            add("misfit_shares", figure);
        }
        let shift = shift(report, &found);
        if !shift.factors.is_empty() {
            add("factor_shift", factor_shift(&shift));
        }
        if !diagnosis.before.held_out.is_empty() && !report.is_of_part() {
            let held_out = held_out_error(&held_out(report, &found));
            add("held_out_error", held_out);
        }
    }
    if let Some(input) = load_displacement::load_displacement(report) {
        add("load_displacement", crate::plot::load_displacement(&input));
    }
    add("detection_limits", detection_limits(&limits(report)));
    figures
}

/// `name`, then `name_2`, `name_3` …
fn numbered(name: &str, place: usize) -> String {
    if place == 0 {
        name.to_owned()
    } else {
        format!("{name}_{}", place + 1)
    }
}

/// What was found, for headings.
fn found(effects: &[Effect]) -> String {
    if effects.len() > 2 {
        return format!("the {} effects found", effects.len());
    }
    let names: Vec<String> = effects.iter().map(short_phrase).collect();
    listed(&names, "and")
}

/// What the final model leaves of a reading, m, without zero and slope of its run, where these can be told from it.
fn left_m(report: &DiagnosisReport, reading: &ReadingTrace) -> f64 {
    if report.observations.has_series() {
        reading.after_within_run_m
    } else {
        reading.after_m
    }
}

/// Readings with their places in the session: lines of the file stand in its order.
fn in_order(report: &DiagnosisReport) -> impl Iterator<Item = (&ReadingTrace, usize)> {
    let readings = &report.trace.readings;
    let mut order: Vec<usize> = (0..readings.len()).collect();
    order.sort_by_key(|place| readings[*place].line);
    let mut sequence = vec![0; readings.len()];
    for (number, place) in order.into_iter().enumerate() {
        sequence[place] = number;
    }
    readings.iter().zip(sequence)
}

/// What the final model leaves of loads one by one.
fn left(report: &DiagnosisReport) -> Residuals {
    let points = in_order(report).map(|(reading, sequence)| ResidualPoint {
        cell: reading.cell.clone(),
        force_n: reading.force_n,
        residual_m: reading.after_m,
        standard_uncertainty_m: Some(reading.reading_sd_m),
        sequence,
        time_s: None,
        flagged: reading.flagged,
    });
    Residuals {
        quantities: report.subject.quantities(),
        prediction: report
            .subject
            .words("fitted structure", "straight line")
            .to_owned(),
        measure: ResidualMeasure::StandardUncertainties,
        points: points.collect(),
    }
}

fn before_after(report: &DiagnosisReport, found: &str) -> ResidualsBeforeAfter {
    let points = in_order(report).map(|(reading, sequence)| BeforeAfterPoint {
        direction: reading.cell.direction,
        target_n: reading.target_n,
        force_n: reading.force_n,
        sequence,
        // Zeros and slopes of runs are those that the final model finds, in both: what differs is what was found.
        before_m: left_m(report, reading) + reading.model_change_m,
        after_m: left_m(report, reading),
        noise_sd_m: Some(reading.reading_sd_m),
        flagged: reading.flagged,
    });
    ResidualsBeforeAfter {
        found: found.to_owned(),
        against: if report
            .observations
            .loads
            .iter()
            .all(|load| load.force_n == 0.0)
        {
            ResidualsAgainst::Order
        } else {
            ResidualsAgainst::Force
        },
        quantities: report.subject.quantities(),
        points: points.collect(),
    }
}

fn evidence(
    answer: &DiagnosisAnswer<'_>,
    impossible: &[&Impossible],
    limits: &LawCriticalValues,
) -> EvidenceBars {
    let members = answer.members();
    let named = members.iter().map(|finding| EvidenceCandidate {
        name: title(finding.effect.law, &finding.effect.place),
        log_bayes_factor: finding.log_bayes,
        standing: match finding.grade {
            VerdictGrade::Weak => CandidateDecision::Tentative,
            _ => CandidateDecision::Named,
        },
    });
    let rivals = members
        .first()
        .into_iter()
        .flat_map(|best: &&Finding| best.rivals.iter().map(move |rival| (*best, rival)))
        .map(|(best, rival)| EvidenceCandidate {
            name: title(rival.effect.law, &rival.effect.place),
            log_bayes_factor: best.log_bayes - rival.log_bayes_to_winner,
            standing: CandidateDecision::Rival,
        })
        // What explains nothing is no rival to be drawn.
        .filter(|rival| rival.log_bayes_factor > 0.5);
    let refused = impossible.iter().map(|one| {
        let parameter = one.law.parameters.first();
        EvidenceCandidate {
            name: title(one.law, &one.place),
            // What physics excludes has no Bayes factor: the best it could have had.
            log_bayes_factor: 0.5 * (one.delta_chi2 - limits.laws.of((one.law, false))),
            standing: CandidateDecision::Impossible {
                reason: format!("{} < 0", parameter.map_or("size", |p| p.name)),
            },
        }
    });
    EvidenceBars {
        candidates: named.chain(rivals).chain(refused).collect(),
        alike_within: DISTINGUISHABLE,
    }
}

/// The misfit divided between the findings; none where it is too small for that.
fn waterfall(report: &DiagnosisReport) -> Option<Figure> {
    let steps = report.diagnosis.misfit_steps.as_ref()?;
    let answers = DiagnosisAnswer::all(&report.diagnosis.findings);
    let found = answers.iter().zip(&steps.explained).map(|(answer, share)| {
        let members = answer.members();
        let first = title(members[0].effect.law, &members[0].effect.place);
        WaterfallStep {
            name: match members.len() {
                1 => first,
                count => format!("one of {count}: {first}"),
            },
            explained: *share,
            tentative: members[0].grade == VerdictGrade::Weak,
        }
    });
    Some(misfit_waterfall(&MisfitWaterfall {
        found: found.collect(),
        left: steps.left,
        noise: steps.noise,
    }))
}

fn shift(report: &DiagnosisReport, found: &str) -> FactorShift {
    let value = |fitted: &FittedParameter| FactorValue {
        value: fitted.value,
        ci95: fitted.ci95,
    };
    // Springs have another unit, and their axis another scale.
    let factors = report.factor_changes();
    let factors = factors.filter(|factor| factor.after.unit == "1");
    let factors = factors.map(|factor| ShiftedFactor {
        name: factor.name.replace('.', " "),
        before: value(&factor.before),
        after: value(&factor.after),
    });
    FactorShift {
        found: found.to_owned(),
        factors: factors.collect(),
    }
}

fn held_out(report: &DiagnosisReport, found: &str) -> HeldOutError {
    let diagnosis = &report.diagnosis;
    let pairs = diagnosis
        .before
        .held_out
        .iter()
        .zip(&diagnosis.after.held_out);
    let poses = pairs.map(|(before, after)| {
        let readings = report.trace.readings.iter();
        HeldOutPose {
            pose: before.pose.clone(),
            before: before.noise_units,
            after: after.noise_units,
            n: readings
                .filter(|reading| reading.cell.pose == before.pose)
                .count(),
        }
    });
    HeldOutError {
        found: found.to_owned(),
        poses: poses.collect(),
    }
}

fn limits(report: &DiagnosisReport) -> DetectionLimits {
    let limits = report.diagnosis.detection_limits.iter();
    DetectionLimits {
        limits: limits
            .map(|limit| DetectionLimitBar {
                law: limit.law.row.to_owned(),
                place: limit.place.to_string(),
                end_effect_m: limit.end_effect_m,
            })
            .collect(),
        reading_sd_m: Some(report.diagnosis.noise.reading_sd_m),
        reading: report.subject.quantities().reading,
    }
}
