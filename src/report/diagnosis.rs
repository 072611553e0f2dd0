//! A diagnosis for programs, and what its page, appendix and figures are made from.

mod answer;
mod appendix;
mod limits_json;
mod noise;
mod open_questions;
mod page;
mod phrases;
mod tables;
mod testable;
mod where_json;

use serde_json::{Map, Value, json};

use crate::analysis::DiagnosisReport;
use crate::mismatch::{
    FactorChange, Finding, Impossible, LawCriticalValues, Location, NextMeasurement, Quality,
    ReadingTrace,
};
use crate::physics::{Law, SignConstraint};
use crate::quantity::METRES_PER_MICROMETRE;
use crate::search::constants::{LAW_LEVEL, NULL_SAMPLES};
use crate::test_point::Direction;

pub(super) use answer::DiagnosisAnswer;
pub use appendix::diagnosis_appendix;
use limits_json::{detection_limits_json, levels_json};
use noise::noise_json;
pub use page::diagnosis_page;
pub(super) use phrases::{listed, short_phrase};
use where_json::{components_json, location_json, strata_json, where_json};

/// The JSON contract's `data` of a diagnosis.
#[must_use]
pub fn diagnosis_json(report: &DiagnosisReport) -> Value {
    let diagnosis = &report.diagnosis;
    json!({
        "verdict": diagnosis.verdict.name(),
        "lacking": diagnosis.lacking,
        "where": where_json(report),
        "findings": diagnosis.findings.iter().map(finding_json).collect::<Vec<_>>(),
        "left_over": unexplained_json(&diagnosis.unexplained),
        "before": quality_json(report, &diagnosis.before, |reading| [reading.before_m, reading.before_within_run_m]),
        "after": quality_json(report, &diagnosis.after, |reading| [reading.after_m, reading.after_within_run_m]),
        "factors": report.factor_shifts().map(|(factor, status)| factor_json(factor, status)).collect::<Vec<_>>(),
        "strata": strata_json(report),
        "carriers": components_json(report),
        "impossible": report.impossible().map(|one| json!({
            "physics": one.law.name,
            "place": one.place.to_json(),
            "gain": finite(one.delta_chi2),
            "reason": phrases::impossible(one.law),
        })).collect::<Vec<_>>(),
        "next_measurement": report.next.iter().map(next_json).collect::<Vec<_>>(),
        "detection_limits": detection_limits_json(report),
        "noise": noise_json(report),
        "levels": levels_json(&report.critical),
        "robot": report.robot,
        "mechanism": report.mechanism,
        "start_factors": report.factors,
        "readings": report.observations.len(),
        "without": names(&report.without),
        "seed": report.seed,
        "version": env!("CARGO_PKG_VERSION"),
    })
}

/// A number, or null for one that JSON cannot hold.
fn finite(value: f64) -> Value {
    serde_json::Number::from_f64(value).map_or(Value::Null, Value::Number)
}

/// A length in µm.
fn um(value_m: f64) -> Value {
    finite(value_m / METRES_PER_MICROMETRE)
}

/// Names of laws, each once: the two drifts share one.
fn names(laws: &[Law]) -> Vec<&'static str> {
    let mut names: Vec<&'static str> = laws.iter().map(|law| law.name).collect();
    names.dedup();
    names
}

fn unexplained_json(left: &Location) -> Value {
    let mut value = location_json(left);
    value["p"] = value["p_family"].take();
    if let Some(object) = value.as_object_mut() {
        object.remove("p_family");
    }
    value
}

/// A quantity with its interval, or the reason why there is none.
fn quantity_json(value: f64, unit: &str, ci95: Option<[f64; 2]>, why_none: &str) -> Value {
    let ci95 = ci95.filter(|ends| ends.iter().all(|end| end.is_finite()));
    let mut quantity = json!({ "value": finite(value), "unit": unit, "ci95": ci95 });
    if ci95.is_none() {
        quantity["reason"] = json!(why_none);
    }
    quantity
}

/// Why a parameter has no interval.
const STEPPED: &str =
    "the readings change with this parameter by steps, so that no standard error can be given";

/// The 95 % interval of a parameter of a finding; where physics forbids negative values it ends at zero.
fn parameter_interval(finding: &Finding, place: usize) -> Option<[f64; 2]> {
    let [low, high] = finding.values.get(place)?.interval_95()?;
    let sign = finding.effect.law.parameters.get(place)?.sign;
    Some(match sign {
        SignConstraint::Positive | SignConstraint::AboveZero => [low.max(0.0), high.max(0.0)],
        SignConstraint::Either => [low, high],
    })
}

fn finding_json(finding: &Finding) -> Value {
    let law = finding.effect.law;
    let parameters: Map<String, Value> = law
        .parameters
        .iter()
        .enumerate()
        .zip(&finding.values)
        .map(|((place, spec), value)| {
            let interval = parameter_interval(finding, place);
            let quantity = quantity_json(value.value, spec.unit(), interval, STEPPED);
            (spec.name.to_owned(), quantity)
        })
        .collect();
    let rivals = finding.rivals.iter().map(|rival| {
        json!({
            "physics": rival.effect.law.name,
            "place": rival.effect.place.to_json(),
            "log_bayes_factor_to_winner": finite(rival.log_bayes_to_winner),
            "cosine": finite(rival.cosine),
        })
    });
    let mut value = json!({
        "physics": law.name,
        "place": finding.effect.place.to_json(),
        "parameters": parameters,
        "end_effect_um": um(finding.end_effect_m),
        "absorbed_share": finite(finding.absorbed_share),
        "log_bayes_factor": finite(finding.log_bayes),
        "standard_errors": finite(finding.standard_errors),
        "p_family": finite(finding.p_family),
        "rivals": rivals.collect::<Vec<_>>(),
    });
    if let Some(group) = finding.alternative_group {
        value["alternative_group"] = json!(group);
    }
    value
}

fn quality_json(
    report: &DiagnosisReport,
    quality: &Quality,
    residuals: impl Fn(&ReadingTrace) -> [f64; 2],
) -> Value {
    let by_direction: Map<String, Value> = report
        .directions()
        .map(|direction| {
            let [rms_m, _] = report.rms_m(&residuals, Some(direction));
            (direction.to_string(), um(rms_m))
        })
        .collect();
    let [_, within_runs_m] = report.rms_m(&residuals, None);
    let percent = |rms_m: f64| finite(100.0 * rms_m / report.trace.displacement_rms_m);
    json!({
        "rms_um": um(quality.rms_m),
        "rms_percent": percent(quality.rms_m),
        "rms_um_by_direction": by_direction,
        "within_runs_rms_um": um(within_runs_m),
        "held_out_rms_um": quality.held_out_rms_m.map(um),
        "held_out_rms_percent": quality.held_out_rms_m.map(percent),
        "noise_units": finite(quality.reduced_chi2.sqrt()),
        "held_out_noise_units": quality.held_out_noise_units.map(finite),
        "held_out": quality.held_out.iter().map(|(pose, rms_m)| json!({ "pose": pose.as_str(), "rms_um": um(*rms_m) })).collect::<Vec<_>>(),
        "reduced_chi2": finite(quality.reduced_chi2),
    })
}

/// Whether the readings determine a factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Determination {
    Free,
    AtBound,
    NotIdentified,
}

impl Determination {
    /// Word in files.
    fn word(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::AtBound => "at_bound",
            Self::NotIdentified => "not_identified",
        }
    }
}

impl DiagnosisReport {
    /// The factors with what became of them.
    fn factor_shifts(&self) -> impl Iterator<Item = (&FactorChange, Determination)> {
        /// As far from its bound as a factor may stand to count as on it, in logarithms.
        const ON_BOUND: f64 = 1e-6;
        let parameters = &self.parameters;
        self.diagnosis.factors.iter().map(move |factor| {
            let at_bound = parameters
                .iter()
                .find(|parameter| parameter.name == factor.name)
                .is_some_and(|parameter| {
                    factor.after.value - parameter.lower < ON_BOUND
                        || parameter.upper - factor.after.value < ON_BOUND
                });
            let status = match (at_bound, factor.identified) {
                (true, _) => Determination::AtBound,
                (false, true) => Determination::Free,
                (false, false) => Determination::NotIdentified,
            };
            (factor, status)
        })
    }

    /// Laws refused for an impossible value; a law that was found there with a possible one is none of them.
    pub(super) fn impossible(&self) -> impl Iterator<Item = &Impossible> {
        let findings = &self.diagnosis.findings;
        self.diagnosis.impossible.iter().filter(move |one| {
            findings
                .iter()
                .all(|found| (found.effect.law, &found.effect.place) != (one.law, &one.place))
        })
    }

    /// Directions of the readings.
    fn directions(&self) -> impl Iterator<Item = Direction> {
        let cells = &self.observations.cells;
        Direction::ALL
            .into_iter()
            .filter(|direction| cells.iter().any(|cell| cell.direction == *direction))
    }

    /// Root mean squares of two residuals over all readings, or over those of a direction, m.
    fn rms_m(
        &self,
        residuals: impl Fn(&ReadingTrace) -> [f64; 2],
        direction: Option<Direction>,
    ) -> [f64; 2] {
        let (mut squares, mut n) = ([0.0; 2], 0.0);
        let readings = self.trace.readings.iter();
        for reading in readings.filter(|r| direction.is_none_or(|d| d == r.cell.direction)) {
            for (square, residual) in squares.iter_mut().zip(residuals(reading)) {
                *square += residual * residual;
            }
            n += 1.0;
        }
        squares.map(|square| (square / f64::max(n, 1.0)).sqrt())
    }

    /// Root mean square that noise alone would leave, m.
    pub(super) fn noise_floor_m(&self) -> f64 {
        let slope_sd = self.diagnosis.noise.run_slope_sd;
        let readings = &self.trace.readings;
        let squares = readings
            .iter()
            .map(|r| r.reading_sd_m.powi(2) + (slope_sd * r.slope_m).powi(2));
        (squares.sum::<f64>() / readings.len().max(1) as f64).sqrt()
    }
}

/// Value of a parameter from its fitted one, with its interval.
pub(super) fn factor_value(
    factor: &FactorChange,
    fitted: &crate::mismatch::EstimatedValue,
) -> (f64, Option<[f64; 2]>) {
    let value = |fitted: f64| match factor.spring_rad_per_nm {
        None => fitted.exp(),
        Some(scale) => scale * fitted,
    };
    let interval = fitted.interval_95().map(|ends| ends.map(value));
    (value(fitted.value), interval)
}

fn factor_json(factor: &FactorChange, status: Determination) -> Value {
    let unit = if factor.spring_rad_per_nm.is_some() {
        "rad/(N*m)"
    } else {
        "1"
    };
    let quantity = |fitted: &crate::mismatch::EstimatedValue| {
        let (value, interval) = factor_value(factor, fitted);
        let reason = "the data do not determine this factor";
        quantity_json(value, unit, interval, reason)
    };
    let [before, after] = [&factor.before, &factor.after].map(|of| factor_value(factor, of).0);
    let change = match factor.spring_rad_per_nm {
        None => 100.0 * (factor.after.value - factor.before.value).exp_m1(),
        Some(_) => 100.0 * (after / before - 1.0),
    };
    json!({
        "name": factor.name,
        "before": quantity(&factor.before),
        "after": quantity(&factor.after),
        "change_percent": finite(change),
        "status": status.word(),
    })
}

fn next_json(next: &NextMeasurement) -> Value {
    let mut value = json!({
        "plan": next.plan,
        "separates": next.separates,
        "expected_log_lr": next.expected_log_lr.map(finite),
        "minutes": finite(next.minutes),
    });
    if let Some(file) = &next.file {
        value["file"] = json!(file);
    }
    value
}

/// The smallest chance that the draws of noise can show of a pattern.
fn least_unexplained_p() -> f64 {
    1.0 / (NULL_SAMPLES as f64 + 1.0)
}

/// The smallest chance that the draws of noise can show of a law, its share of the level taken into account.
fn least_law_p(critical: &LawCriticalValues, law: Law) -> f64 {
    let level = critical.laws.levels.get(&(law, false)).copied();
    least_unexplained_p() * LAW_LEVEL / level.unwrap_or(LAW_LEVEL)
}

/// Whether so many degrees of freedom stand for a standard deviation that was given.
fn is_known(dof: f64) -> bool {
    dof >= 1e6
}
