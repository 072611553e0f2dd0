//! A diagnosis of a table without a robot, in the units of the table.

use std::path::PathBuf;

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::Serialize;

use crate::analysis::DiagnosisReport;
use crate::mismatch::{
    ConfigurationSizes, EstimatedValue, FactorChange, Finding, LawAtPlace, MisfitShares,
    NextMeasurement, Omnibus, PartUnit, PartUnits, Quality, Stratum, Verdict, VerdictGrade,
};
use crate::physics::ParameterSpec;
use crate::table_files::FileLayout;

use super::diagnosis::{FittedParameter, RivalReport, headline};

/// A diagnosis of a table without a robot.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SpecimenSummary {
    /// What in the file was taken for what.
    pub table: FileLayout,
    /// The verdict.
    pub verdict: Verdict,
    /// How far it may be relied on.
    pub grade: VerdictGrade,
    /// The verdict in a sentence.
    pub headline: String,
    /// What the readings lack, where they cannot decide.
    pub lacking: Vec<String>,
    /// What is missing; with the verdict `unknown` what explains part of it.
    pub findings: Vec<SpecimenFinding>,
    /// What the sizes of the findings follow from configuration to configuration.
    pub sizes_follow: ConfigurationSizes,
    /// Shares of the misfit that all findings explain together.
    #[serde(flatten)]
    pub shares: MisfitShares,
    /// Whether the final model leaves more than noise does.
    pub omnibus: Omnibus,
    /// What the final model leaves.
    #[serde(rename = "left_over")]
    pub unexplained: SpecimenUnexplained,
    /// The straight lines.
    pub before: SpecimenQuality,
    /// The final model.
    pub after: SpecimenQuality,
    /// The slope of each configuration.
    pub slopes: Vec<SpecimenSlope>,
    /// The noise of the final model.
    pub noise: SpecimenNoise,
    /// Plans that would separate what is open.
    pub next_measurement: Vec<NextMeasurement>,
    /// Number of readings.
    pub readings: usize,
    /// Whether there is no clock, and the order of the readings stands for the history of the part.
    pub order_is_clock: bool,
    /// Seed of the simulated noise.
    pub seed: u64,
    /// Version of the program.
    pub version: &'static str,
    /// Files that were written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub files: Option<Vec<PathBuf>>,
}

/// An effect found in a table.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SpecimenFinding {
    /// The law and its place.
    #[serde(flatten)]
    pub law: LawAtPlace,
    /// How far its name may be relied on.
    pub grade: VerdictGrade,
    /// Shares of the misfit that it explains beside the other findings.
    #[serde(flatten)]
    pub shares: MisfitShares,
    /// Its parameters by name.
    pub parameters: IndexMap<&'static str, SpecimenParameter>,
    /// By its name what readings determine where they do not tell the parameters apart, if the law has such a number.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub combination: IndexMap<&'static str, SpecimenParameter>,
    /// Findings of one group exclude each other and are indistinguishable; `null` of one that stands alone.
    pub alternative_group: Option<u32>,
    /// Largest change of a reading, in the unit of `rms`.
    pub end_effect: f64,
    /// The same in the SI unit of `rms`.
    pub end_effect_si: f64,
    /// Share of the effect that the slopes had absorbed.
    pub absorbed_share: f64,
    /// Natural logarithm of the Bayes factor against the model without it.
    pub log_bayes_factor: f64,
    /// Chance that noise alone gives any law as much.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p_family: f64,
    /// Rivals that are distinguished, the nearest first.
    pub rivals: Vec<RivalReport>,
}

/// What a model of a table leaves.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SpecimenUnexplained {
    /// The stratum that shows most.
    pub stratum: Stratum,
    /// Chance that noise alone shows as much anywhere.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p: f64,
}

/// How well a model of a table serves.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SpecimenQuality {
    /// Root mean square of the residuals.
    pub rms: SpecimenValue,
    /// Weighted squares over degrees of freedom.
    pub reduced_chi2: f64,
}

/// A value in the unit of the table, and in SI.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SpecimenValue {
    /// The value in `unit`.
    pub value: f64,
    /// Unit of the table.
    pub unit: String,
    /// The same in SI; as in the file where the table has no units.
    pub si: SiValue,
}

/// A value in SI.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SiValue {
    /// The value in `unit`.
    pub value: f64,
    /// ASCII unit.
    pub unit: String,
    /// 95 % interval in `unit`, of a parameter that has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ci95: Option<[f64; 2]>,
}

/// A fitted parameter of a law, in the units of the table and in SI.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SpecimenParameter {
    /// In the units of the table.
    #[serde(flatten)]
    pub fitted: FittedParameter,
    /// The same in SI; as in the file where the table has no units.
    pub si: SiValue,
}

/// The slope of a configuration.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SpecimenSlope {
    /// Its name.
    pub name: String,
    /// In the straight line.
    pub before: f64,
    /// In the final model.
    pub after: f64,
    /// Unit of both.
    pub unit: String,
    /// The final model's in SI.
    pub si: SiValue,
}

/// The noise of a table.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SpecimenNoise {
    /// Standard deviation of a reading.
    pub reading_sd: SpecimenValue,
    /// Standard deviation of the slope of a run, relative.
    pub run_slope_sd: f64,
}

impl SiValue {
    fn new(unit: &PartUnit, value: f64, ci95: Option<[f64; 2]>) -> Self {
        Self {
            value,
            unit: unit.si_name.clone(),
            ci95,
        }
    }
}

fn answer(units: &PartUnits, scaled: f64) -> SpecimenValue {
    let unit = units.of_answer();
    SpecimenValue {
        value: unit.in_table(scaled),
        si: SiValue::new(&unit, scaled, None),
        unit: unit.name,
    }
}

fn quality(units: &PartUnits, quality: &Quality) -> SpecimenQuality {
    SpecimenQuality {
        rms: answer(units, quality.rms_m),
        reduced_chi2: quality.reduced_chi2,
    }
}

/// The slope of a configuration.
fn slope(units: &PartUnits, slope: &FactorChange) -> SpecimenSlope {
    let unit = units.of_slope();
    SpecimenSlope {
        name: slope.name.clone(),
        before: unit.in_table(slope.before.value),
        after: unit.in_table(slope.after.value),
        si: SiValue::new(&unit, slope.after.value, slope.after.interval_95()),
        unit: unit.name,
    }
}

/// A fitted parameter of a law.
fn parameter(
    (report, units): (&DiagnosisReport, &PartUnits),
    spec: &ParameterSpec,
    value: &EstimatedValue,
) -> SpecimenParameter {
    SpecimenParameter {
        fitted: report.subject.fitted(spec, value),
        si: SiValue::new(&units.of(spec), value.value, value.interval_95()),
    }
}

fn finding(report: &DiagnosisReport, units: &PartUnits, finding: &Finding) -> SpecimenFinding {
    let stated = finding.stated();
    let mut stated =
        stated.map(|(spec, value)| (spec.name, parameter((report, units), spec, value)));
    let parameters = stated.by_ref().take(finding.values.len()).collect();
    let end_effect = answer(units, finding.end_effect_m);
    SpecimenFinding {
        law: (&finding.effect).into(),
        grade: finding.grade,
        shares: finding.shares,
        parameters,
        combination: stated.collect(),
        alternative_group: finding.alternative_group,
        end_effect: end_effect.value,
        end_effect_si: end_effect.si.value,
        absorbed_share: finding.absorbed_share,
        log_bayes_factor: finding.log_bayes,
        p_family: finding.p_family,
        rivals: finding.rivals.iter().map(Into::into).collect(),
    }
}

impl SpecimenSummary {
    /// # Arguments
    /// - `units`, `layout`: of the table.
    pub(super) fn new(
        report: &DiagnosisReport,
        (units, layout): (&PartUnits, &FileLayout),
    ) -> Self {
        let diagnosis = &report.diagnosis;
        let slopes = diagnosis.factors.iter().map(|one| slope(units, one));
        let findings = diagnosis
            .findings
            .iter()
            .map(|one| finding(report, units, one));
        Self {
            table: layout.clone(),
            verdict: diagnosis.verdict,
            grade: diagnosis.grade,
            headline: headline(report),
            sizes_follow: diagnosis.sizes,
            shares: diagnosis.shares,
            omnibus: diagnosis.omnibus,
            lacking: diagnosis.lacking.clone(),
            findings: findings.collect(),
            unexplained: SpecimenUnexplained {
                stratum: diagnosis.unexplained.stratum,
                p: diagnosis.unexplained.p_family,
            },
            before: quality(units, &diagnosis.before),
            after: quality(units, &diagnosis.after),
            slopes: slopes.collect(),
            noise: SpecimenNoise {
                reading_sd: answer(units, diagnosis.noise.reading_sd_m),
                run_slope_sd: diagnosis.noise.run_slope_sd,
            },
            next_measurement: report.next.clone(),
            readings: report.observations.len(),
            order_is_clock: units.order_is_clock,
            seed: report.seed,
            version: env!("CARGO_PKG_VERSION"),
            files: None,
        }
    }
}
