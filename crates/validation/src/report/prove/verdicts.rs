//! Verdicts as they are written down before any answer is opened.

use indexmap::IndexMap;
use serde::Serialize;

use crate::prove::{BlindVerdict, diagnosis_words};
use stiffbench::mismatch::{
    Diagnosis, FactorChange, Finding, Location, Quality, Stratum, Verdict, VerdictGrade,
};
use stiffbench::physics::{Law, Place};
use stiffbench::report::FittedParameter;
use stiffbench::test_point::{Direction, PoseId};

/// All verdicts.
#[derive(Debug, Clone, Serialize)]
pub struct BlindVerdicts {
    schema: &'static str,
    tool: ToolVersion,
    seed: u64,
    /// In the order of the sessions.
    sessions: IndexMap<String, SessionVerdict>,
}

#[derive(Debug, Clone, Serialize)]
struct ToolVersion {
    name: &'static str,
    version: &'static str,
}

/// The verdict on one session.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
enum SessionVerdict {
    Failed { bench: String, error: String },
    Diagnosed(Box<DiagnosedSession>),
}

#[derive(Debug, Clone, Serialize)]
struct DiagnosedSession {
    bench: String,
    verdict: Verdict,
    grade: VerdictGrade,
    words: String,
    lacking: Vec<String>,
    findings: Vec<NamedFinding>,
    #[serde(rename = "left_over")]
    unexplained: UnexplainedPattern,
    before: ModelQuality,
    after: ModelQuality,
    noise: NoiseOfSession,
    ln_factors: Vec<LnFactor>,
}

#[derive(Debug, Clone, Serialize)]
struct UnexplainedPattern {
    stratum: Stratum,
    pose: Option<PoseId>,
    direction: Option<Direction>,
    p: f64,
}

#[derive(Debug, Clone, Serialize)]
struct NoiseOfSession {
    reading_sd_um: f64,
    zero_sd_um: f64,
    run_slope_sd: f64,
}

#[derive(Debug, Clone, Serialize)]
struct LnFactor {
    name: String,
    value: f64,
    ci95: Option<[f64; 2]>,
    identified: bool,
}

#[derive(Debug, Clone, Serialize)]
struct ModelQuality {
    rms_um: f64,
    held_out_rms_um: Option<f64>,
    reduced_chi2: f64,
}

#[derive(Debug, Clone, Serialize)]
struct NamedFinding {
    physics: Law,
    place: Place,
    parameters: IndexMap<&'static str, FittedParameter>,
    alternative_group: Option<u32>,
    standard_errors: f64,
    log_bayes_factor: f64,
    p_family: f64,
    end_effect_um: f64,
    absorbed_share: f64,
}

impl BlindVerdicts {
    /// Verdicts of a search with this seed.
    #[must_use]
    pub fn new(verdicts: &[BlindVerdict], seed: u64) -> Self {
        let of = |verdict: &BlindVerdict| (verdict.session.clone(), verdict.into());
        Self {
            schema: "stiffbench/blind-verdicts/1",
            tool: ToolVersion {
                name: env!("CARGO_PKG_NAME"),
                version: env!("CARGO_PKG_VERSION"),
            },
            seed,
            sessions: verdicts.iter().map(of).collect(),
        }
    }
}

impl From<&BlindVerdict> for SessionVerdict {
    fn from(verdict: &BlindVerdict) -> Self {
        let bench = verdict.bench.clone();
        match &verdict.diagnosis {
            Err(error) => Self::Failed {
                bench,
                error: error.to_string(),
            },
            Ok(diagnosis) => Self::Diagnosed(Box::new(DiagnosedSession::of(bench, diagnosis))),
        }
    }
}

impl DiagnosedSession {
    fn of(bench: String, diagnosis: &Diagnosis) -> Self {
        Self {
            bench,
            verdict: diagnosis.verdict,
            grade: diagnosis.grade,
            words: diagnosis_words(diagnosis),
            lacking: diagnosis.lacking.clone(),
            findings: diagnosis.findings.iter().map(NamedFinding::from).collect(),
            unexplained: (&diagnosis.unexplained).into(),
            before: (&diagnosis.before).into(),
            after: (&diagnosis.after).into(),
            noise: NoiseOfSession {
                reading_sd_um: 1e6 * diagnosis.noise.reading_sd_m,
                zero_sd_um: 1e6 * diagnosis.noise.zero_sd_m,
                run_slope_sd: diagnosis.noise.run_slope_sd,
            },
            ln_factors: diagnosis.factors.iter().map(LnFactor::from).collect(),
        }
    }
}

impl From<&Location> for UnexplainedPattern {
    fn from(location: &Location) -> Self {
        Self {
            stratum: location.stratum,
            pose: location.pose.clone(),
            direction: location.direction,
            p: location.p_family,
        }
    }
}

impl From<&FactorChange> for LnFactor {
    fn from(factor: &FactorChange) -> Self {
        Self {
            name: factor.name.clone(),
            value: factor.after.value,
            ci95: factor.after.interval_95(),
            identified: factor.identified,
        }
    }
}

impl From<&Quality> for ModelQuality {
    fn from(quality: &Quality) -> Self {
        Self {
            rms_um: 1e6 * quality.rms_m,
            held_out_rms_um: quality.held_out_rms_m.map(|rms_m| 1e6 * rms_m),
            reduced_chi2: quality.reduced_chi2,
        }
    }
}

impl From<&Finding> for NamedFinding {
    fn from(finding: &Finding) -> Self {
        let law = finding.effect.law;
        let parameters = law.parameters.iter().zip(&finding.values);
        let parameters =
            parameters.map(|(spec, value)| (spec.name, FittedParameter::of_law(spec, value)));
        Self {
            physics: law,
            place: finding.effect.place.clone(),
            parameters: parameters.collect(),
            alternative_group: finding.alternative_group,
            standard_errors: finding.standard_errors,
            log_bayes_factor: finding.log_bayes,
            p_family: finding.p_family,
            end_effect_um: 1e6 * finding.end_effect_m,
            absorbed_share: finding.absorbed_share,
        }
    }
}
