//! Verdicts as they are written down before any answer is opened.

use serde_json::{Value, json};

use crate::prove::{BlindVerdict, diagnosis_words};
use stiffbench::mismatch::{Diagnosis, Finding, Quality};

/// All verdicts, in the order of the sessions.
#[must_use]
pub fn verdicts_json(verdicts: &[BlindVerdict], seed: u64) -> Value {
    let sessions: serde_json::Map<String, Value> = verdicts
        .iter()
        .map(|verdict| (verdict.session.clone(), verdict_json(verdict)))
        .collect();
    json!({
        "schema": "stiffbench/blind-verdicts/1",
        "tool": { "name": env!("CARGO_PKG_NAME"), "version": env!("CARGO_PKG_VERSION") },
        "seed": seed,
        "sessions": sessions,
    })
}

fn verdict_json(verdict: &BlindVerdict) -> Value {
    match &verdict.diagnosis {
        Err(error) => json!({ "bench": verdict.bench, "error": error.to_string() }),
        Ok(diagnosis) => json!({
            "bench": verdict.bench,
            "verdict": diagnosis.verdict,
            "words": diagnosis_words(diagnosis),
            "lacking": diagnosis.lacking,
            "findings": diagnosis.findings.iter().map(finding_json).collect::<Vec<_>>(),
            "left_over": {
                "stratum": diagnosis.unexplained.stratum,
                "pose": diagnosis.unexplained.pose,
                "direction": diagnosis.unexplained.direction,
                "p": diagnosis.unexplained.p_family,
            },
            "before": quality_json(&diagnosis.before),
            "after": quality_json(&diagnosis.after),
            "noise": noise_json(diagnosis),
            "ln_factors": diagnosis.factors.iter().map(|factor| json!({
                "name": factor.name,
                "value": factor.after.value,
                "ci95": factor.after.interval_95(),
                "identified": factor.identified,
            })).collect::<Vec<_>>(),
        }),
    }
}

fn noise_json(diagnosis: &Diagnosis) -> Value {
    json!({
        "reading_sd_um": 1e6 * diagnosis.noise.reading_sd_m,
        "zero_sd_um": 1e6 * diagnosis.noise.zero_sd_m,
        "run_slope_sd": diagnosis.noise.run_slope_sd,
    })
}

fn quality_json(quality: &Quality) -> Value {
    json!({
        "rms_um": 1e6 * quality.rms_m,
        "held_out_rms_um": quality.held_out_rms_m.map(|rms_m| 1e6 * rms_m),
        "reduced_chi2": quality.reduced_chi2,
    })
}

fn finding_json(finding: &Finding) -> Value {
    let parameters: serde_json::Map<String, Value> = finding
        .effect
        .law
        .parameters
        .iter()
        .zip(&finding.values)
        .map(|(parameter, value)| {
            let entry = json!({
                "value": value.value,
                "unit": parameter.unit(),
                "ci95": value.interval_95(),
            });
            (parameter.name.to_owned(), entry)
        })
        .collect();
    json!({
        "physics": finding.effect.law.name,
        "place": finding.effect.place,
        "parameters": parameters,
        "alternative_group": finding.alternative_group,
        "standard_errors": finding.standard_errors,
        "log_bayes_factor": finding.log_bayes,
        "p_family": finding.p_family,
        "end_effect_um": 1e6 * finding.end_effect_m,
        "absorbed_share": finding.absorbed_share,
    })
}
