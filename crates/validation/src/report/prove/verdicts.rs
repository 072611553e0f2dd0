//! Verdicts as they are written down before any answer is opened.

use indexmap::IndexMap;
use serde_json::{Map, Value, json};

use crate::prove::{BlindVerdict, diagnosis_words};
use stiffbench::mismatch::{Diagnosis, Finding, Quality};
use stiffbench::report::FittedParameter;

/// All verdicts, in the order of the sessions.
#[must_use]
pub fn blind_verdicts(verdicts: &[BlindVerdict], seed: u64) -> Value {
    let sessions = verdicts.iter().map(|one| {
        let words = match &one.diagnosis {
            Err(error) => json!({ "bench": one.bench, "error": error.to_string() }),
            Ok(diagnosis) => diagnosed(&one.bench, diagnosis),
        };
        (one.session.clone(), words)
    });
    json!({
        "schema": "stiffbench/blind-verdicts/1",
        "tool": { "name": env!("CARGO_PKG_NAME"), "version": env!("CARGO_PKG_VERSION") },
        "seed": seed,
        "sessions": sessions.collect::<Map<_, _>>(),
    })
}

fn um(length_m: f64) -> f64 {
    1e6 * length_m
}

fn diagnosed(bench: &str, diagnosis: &Diagnosis) -> Value {
    let (left, noise) = (&diagnosis.unexplained, &diagnosis.noise);
    let findings: Vec<Value> = diagnosis.findings.iter().map(named).collect();
    let ln_factors = diagnosis.factors.iter().map(|factor| {
        json!({
            "name": factor.name,
            "value": factor.after.value,
            "ci95": factor.after.interval_95(),
            "identified": factor.identified,
        })
    });
    json!({
        "bench": bench,
        "verdict": diagnosis.verdict,
        "grade": diagnosis.grade,
        "words": diagnosis_words(diagnosis),
        "lacking": diagnosis.lacking,
        "findings": findings,
        "left_over": {
            "stratum": left.stratum,
            "pose": left.pose,
            "direction": left.direction,
            "p": left.p_family,
        },
        "before": quality(&diagnosis.before),
        "after": quality(&diagnosis.after),
        "noise": {
            "reading_sd_um": um(noise.reading_sd_m),
            "zero_sd_um": um(noise.zero_sd_m),
            "run_slope_sd": noise.run_slope_sd,
        },
        "ln_factors": ln_factors.collect::<Vec<_>>(),
    })
}

fn quality(quality: &Quality) -> Value {
    json!({
        "rms_um": um(quality.rms_m),
        "held_out_rms_um": quality.held_out_rms_m.map(um),
        "reduced_chi2": quality.reduced_chi2,
    })
}

fn named(finding: &Finding) -> Value {
    let law = finding.effect.law;
    let parameters = law.parameters.iter().zip(&finding.values);
    let parameters =
        parameters.map(|(spec, value)| (spec.name, FittedParameter::of_law(spec, value)));
    json!({
        "physics": law,
        "place": finding.effect.place,
        "parameters": parameters.collect::<IndexMap<_, _>>(),
        "alternative_group": finding.alternative_group,
        "standard_errors": finding.standard_errors,
        "log_bayes_factor": finding.log_bayes,
        "p_family": finding.p_family,
        "end_effect_um": um(finding.end_effect_m),
        "absorbed_share": finding.absorbed_share,
    })
}
