//! A diagnosis as the data of `stiffbench diagnose --json`.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::analysis::{DiagnosisReport, Subject};
use crate::fit::TableMistake;
use crate::mismatch::{
    Beginnings, ConfigurationSizes, Contrast, EstimatedValue, ExplainedShare, FactorChange,
    Finding, HeldOut, Impossible, LawAtPlace, Location, MisfitShares, NextMeasurement, Omnibus,
    PartUnits, Rival, Stratum, StratumTest, Verdict, VerdictGrade,
};
use crate::physics::{FileLine, Law, ParameterSpec};
use crate::report::{micro, text::open_interval};
use crate::robot::ModelParameter;
use crate::table_files::FileLayout;
use crate::test_point::{Direction, PoseId};

use super::answer::FindingKind;
use super::data_findings::DataFindingReport;
use super::detection_limits::{DetectionLimitReport, SearchLevels};
use super::known_effects::KnownEffectReport;
use super::noise::NoiseReport;
use super::page::headline;
use super::sessions::SessionReport;
use super::{DiagnosedModel, check, factor_value, phrases};

/// A diagnosis: of sessions and load cases, or of a part, whose table states its own units.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct DiagnosisSummary {
    /// What in the table of a part was taken for what.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<FileLayout>,
    /// The verdict.
    pub verdict: Verdict,
    /// How far it may be relied on.
    pub grade: VerdictGrade,
    /// The verdict in a sentence.
    pub headline: String,
    /// What the readings lack, where they cannot decide.
    pub lacking: Vec<String>,
    /// Where the model without effects fails.
    #[serde(rename = "where")]
    pub locations: Vec<Location>,
    /// What is missing; with the verdict `unknown` what explains part of it.
    pub findings: Vec<FindingReport>,
    /// What the sizes of the findings follow from configuration to configuration of a part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sizes_follow: Option<ConfigurationSizes>,
    /// How the runs begin, where not all begin virgin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beginnings: Option<Beginnings>,
    /// Shares of the misfit that all findings explain together.
    #[serde(flatten)]
    pub shares: MisfitShares,
    /// Whether the final model leaves more than noise does.
    pub omnibus: Omnibus,
    /// What the final model leaves.
    #[serde(rename = "left_over")]
    pub unexplained: UnexplainedReport,
    /// The model without effects.
    pub before: QualityReport,
    /// The final model.
    pub after: QualityReport,
    /// Physics that was known beforehand: no candidate of the search, its values fitted again.
    pub known_effects: Vec<KnownEffectReport>,
    /// The factors without and with what was found; none of a part.
    pub factors: Vec<FactorChangeReport>,
    /// The slope of each configuration of a part.
    pub slopes: Vec<SlopeReport>,
    /// Readings that their repeats contradict; they never change the verdict's meaning.
    pub data_findings: Vec<DataFindingReport>,
    /// What a table of load cases has wrong as a whole: a unit, a sign, components under the name of each other.
    #[serde(rename = "wrong_factor", skip_serializing_if = "Option::is_none")]
    pub table_mistake: Option<TableMistake>,
    /// The tests behind `where`.
    pub strata: Strata,
    /// Which parts of the structure carry the misfit.
    #[serde(rename = "carriers")]
    pub component_shares: ComponentShares,
    /// Laws rejected because only an impossible value would serve.
    pub impossible: Vec<RejectedLaw>,
    /// Plans that would separate what is open.
    pub next_measurement: Vec<NextMeasurement>,
    /// Size of each law and place that these readings would have shown, or the reason why there is none.
    pub detection_limits: Vec<DetectionLimitReport>,
    /// The noise of the final model.
    pub noise: NoiseReport,
    /// How the level is split between the laws, and the critical values that follow.
    pub levels: SearchLevels,
    /// Name of the robot; `null` of a part, as the next two.
    pub robot: Option<String>,
    /// Name of the mechanism.
    pub mechanism: Option<String>,
    /// Name of the factors that the search started from.
    pub start_factors: Option<String>,
    /// Number of readings.
    pub readings: usize,
    /// Whether a part has no clock, and the order of its readings stands for its history.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order_is_clock: Option<bool>,
    /// Each session, where several were diagnosed together. Their poses are called `session/pose`; `noise` above is that of the first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sessions: Vec<SessionReport>,
    /// Laws that the search left out.
    pub without: Vec<Law>,
    /// Seed of the simulated noise.
    pub seed: u64,
    /// Version of the program.
    pub version: Cow<'static, str>,
    /// Files that were written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub files: Option<Vec<PathBuf>>,
}

/// A found effect.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FindingReport {
    /// The law and its place.
    #[serde(flatten)]
    pub law: LawAtPlace,
    /// Physics of the robot, or a mistake in its file or in the set-up.
    pub kind: FindingKind,
    /// How far its name may be relied on.
    pub grade: VerdictGrade,
    /// Shares of the misfit that it explains beside the other findings.
    #[serde(flatten)]
    pub shares: MisfitShares,
    /// What to do by hand at that place, as a clause; `null` where nothing but a measurement helps, and of a part.
    pub check: Option<String>,
    /// The line of the robot file that it accuses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file_line: Option<FileLine>,
    /// Its parameters by name.
    pub parameters: IndexMap<Cow<'static, str>, FittedParameter>,
    /// By its name what readings determine where they do not tell the parameters apart, if the law has such a number.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub combination: IndexMap<Cow<'static, str>, FittedParameter>,
    /// Whether its size stands at the bound of what is plausible.
    pub at_bound: bool,
    /// Largest change of a reading, µm; `null` of readings that are no lengths.
    pub end_effect_um: Option<f64>,
    /// The same of a part, in the unit of its readings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end_effect: Option<f64>,
    /// The same of a part, in the SI unit of its readings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end_effect_si: Option<f64>,
    /// Share of the effect that the factors or slopes had absorbed.
    pub absorbed_share: f64,
    /// Natural logarithm of the Bayes factor against the model without it.
    pub log_bayes_factor: f64,
    /// Its length in standard errors.
    pub standard_errors: f64,
    /// Chance that noise alone gives any law as much.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p_family: f64,
    /// Rivals that are distinguished, the nearest first.
    pub rivals: Vec<RivalReport>,
    /// Findings of one group exclude each other and are indistinguishable; `null` of one that stands alone.
    pub alternative_group: Option<u32>,
}

/// A fitted value.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FittedParameter {
    /// The value in `unit`.
    pub value: f64,
    /// ASCII unit.
    pub unit: String,
    /// 95 % interval in `unit`.
    pub ci95: Option<[f64; 2]>,
    /// Ends of the interval that are bounds of what is plausible: the readings do not reach them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub open_ends: Vec<IntervalEnd>,
    /// Why there is no interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<Cow<'static, str>>,
    /// The same in SI, of a part; as in the file where its table has no units.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub si: Option<SiValue>,
}

/// A value in SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SiValue {
    /// The value in `unit`.
    pub value: f64,
    /// ASCII unit.
    pub unit: String,
    /// 95 % interval in `unit`, of a value that has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ci95: Option<[f64; 2]>,
}

/// A reading, or what one is off by, in the unit of a table, and in SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TableValue {
    /// The value in `unit`.
    pub value: f64,
    /// Unit of the table.
    pub unit: String,
    /// The same in SI; as in the file where the table has no units.
    pub si: SiValue,
}

/// The slope of a configuration of a part.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SlopeReport {
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

/// An end of an interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum IntervalEnd {
    /// The lower one.
    Lower,
    /// The upper one.
    Upper,
}

/// A rival of a finding.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RivalReport {
    /// The law and its place.
    #[serde(flatten)]
    pub law: LawAtPlace,
    /// Natural logarithm of the Bayes factor of the finding against it.
    pub log_bayes_factor_to_winner: f64,
    /// Cosine of the angle between the two effects on the readings.
    pub cosine: f64,
}

/// What a model leaves.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct UnexplainedReport {
    /// The stratum that shows most.
    pub stratum: Stratum,
    /// The pose, if it is one.
    pub pose: Option<PoseId>,
    /// The direction, if it is one.
    pub direction: Option<Direction>,
    /// Chance that noise alone shows as much anywhere.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p: f64,
    /// Largest change of a reading by the pattern, µm; `null` of readings that are no lengths.
    pub size_um: Option<f64>,
    /// Length of the pattern in standard errors.
    pub standard_errors: f64,
    /// Share of the misfit that the final model leaves; `null` where the misfit is too small to be divided.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub share: Option<f64>,
}

/// How well a model serves.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct QualityReport {
    /// Root mean square of the residuals, each gauge zero fitted, µm; `null` of readings that are no lengths, as all others in µm.
    pub rms_um: Option<f64>,
    /// The same of a part, in the unit of its table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms: Option<TableValue>,
    /// The same in percent of the root mean square reading.
    pub rms_percent: f64,
    /// The same by direction; empty of a part.
    pub rms_um_by_direction: BTreeMap<Direction, f64>,
    /// Root mean square of the residuals without zero and slope of each run, µm.
    pub within_runs_rms_um: Option<f64>,
    /// Root mean square in poses left out of the fit, µm; `null` with one pose.
    pub held_out_rms_um: Option<f64>,
    /// The same in percent of the root mean square displacement.
    pub held_out_rms_percent: Option<f64>,
    /// Root mean square in units of the noise.
    pub noise_units: f64,
    /// The same in poses left out of the fit; `null` with one pose.
    pub held_out_noise_units: Option<f64>,
    /// Each pose left out of the fit.
    pub held_out: Vec<HeldOut>,
    /// Weighted squares over degrees of freedom.
    pub reduced_chi2: f64,
}

/// A factor or spring without and with what was found.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FactorChangeReport {
    /// Its name.
    pub name: String,
    /// In the model without effects.
    pub before: FittedParameter,
    /// In the final model.
    pub after: FittedParameter,
    /// Change from the one to the other, %; `null` from a spring that did not yield.
    pub change_percent: Option<f64>,
    /// Whether the readings determine it.
    pub status: Determination,
}

/// Whether readings determine a factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Determination {
    /// They do.
    Free,
    /// It stands at its bound.
    AtBound,
    /// They do not.
    NotIdentified,
}

/// The tests of strata.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Strata {
    /// All tests, in the order of the strata.
    pub tests: Vec<StratumTest>,
    /// What could not be tested.
    pub untested: Vec<UntestedContrast>,
}

/// A contrast that these readings cannot test.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct UntestedContrast {
    /// What would be compared.
    pub contrast: Contrast,
    /// Where it belongs.
    pub stratum: Stratum,
    /// Why it cannot be tested.
    pub reason: String,
}

/// Parts of the structure by how much of the misfit each explains alone, the most first.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ComponentShares {
    /// Of slopes; empty if they do not misfit.
    pub slopes: Vec<ExplainedShare>,
    /// Of curves, steps and loops over the load.
    pub shapes: Vec<ExplainedShare>,
}

/// A law that would explain the readings with an impossible value.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RejectedLaw {
    /// The law and its place.
    #[serde(flatten)]
    pub law: LawAtPlace,
    /// Fall of the weighted squares that the impossible sign would give.
    pub gain: f64,
    /// Why it was rejected.
    pub reason: String,
}

impl From<&DiagnosisReport> for DiagnosisSummary {
    fn from(report: &DiagnosisReport) -> Self {
        let (robot, part) = match &report.subject {
            Subject::Robot(robot) => (Some(robot), None),
            Subject::Part { units, layout } => (None, Some((units, layout))),
        };
        let factors = report.factor_changes().filter(|_| robot.is_some());
        let slopes = (part.iter()).flat_map(|(units, _)| SlopeReport::all(units, report));
        let diagnosis = &report.diagnosis;
        let left = &diagnosis.unexplained;
        let located = &report.located;
        let untested = located.untested.iter().map(|one| UntestedContrast {
            contrast: one.contrast,
            stratum: one.contrast.stratum(),
            reason: one.why.clone(),
        });
        let mut without = report.without.clone();
        // The two drifts share a name.
        without.dedup_by_key(|law| law.name);
        Self {
            table: part.map(|(_, layout)| layout.clone()),
            verdict: diagnosis.verdict,
            grade: diagnosis.grade,
            headline: headline(report),
            sizes_follow: part.map(|_| diagnosis.sizes),
            beginnings: Some(&diagnosis.beginnings)
                .filter(|one| !one.are_virgin())
                .cloned(),
            shares: diagnosis.shares,
            omnibus: diagnosis.omnibus,
            lacking: diagnosis.lacking.clone(),
            locations: report.locations(),
            findings: (diagnosis.findings.iter())
                .map(|finding| FindingReport::new(report, finding))
                .collect(),
            unexplained: UnexplainedReport {
                stratum: left.stratum,
                pose: left.pose.clone(),
                direction: left.direction,
                p: left.p_family,
                size_um: report.subject.micrometres(left.size_m),
                standard_errors: diagnosis.unexplained_standard_errors,
                share: diagnosis.shares.share_of_misfit.map(|share| 1.0 - share),
            },
            before: QualityReport::new(report, DiagnosedModel::Before),
            after: QualityReport::new(report, DiagnosedModel::After),
            known_effects: (diagnosis.known_effects.iter().map(Into::into)).collect(),
            factors: factors.collect(),
            slopes: slopes.collect(),
            data_findings: DataFindingReport::all(report),
            table_mistake: report.table_mistake.clone(),
            strata: Strata {
                tests: located.tests.clone(),
                untested: untested.collect(),
            },
            component_shares: ComponentShares {
                slopes: located.slope_components.clone(),
                shapes: located.shape_components.clone(),
            },
            impossible: report.impossible().map(Into::into).collect(),
            next_measurement: report.next.clone(),
            detection_limits: report.detection_limits(),
            noise: report.into(),
            levels: (&report.critical).into(),
            robot: robot.map(|robot| robot.robot.clone()),
            mechanism: robot.map(|robot| robot.mechanism.clone()),
            start_factors: robot.map(|robot| robot.start_factors.clone()),
            readings: report.observations.len(),
            order_is_clock: part.map(|(units, _)| units.order_is_clock),
            sessions: report.sessions.iter().map(Into::into).collect(),
            without,
            seed: report.seed,
            version: env!("CARGO_PKG_VERSION").into(),
            files: None,
        }
    }
}

impl FindingReport {
    fn new(report: &DiagnosisReport, finding: &Finding) -> Self {
        let subject = &report.subject;
        let stated = finding.stated();
        let mut stated =
            stated.map(|(spec, value)| (spec.name.into(), subject.fitted(&spec, value)));
        let parameters = stated.by_ref().take(finding.values.len()).collect();
        let in_table = subject.in_table(finding.end_effect_m);
        Self {
            law: (&finding.effect).into(),
            kind: finding.effect.law.into(),
            grade: finding.grade,
            shares: finding.shares,
            check: check(&finding.effect).filter(|_| !report.is_of_part()),
            file_line: report.file_line(&finding.effect).cloned(),
            parameters,
            combination: stated.collect(),
            at_bound: finding.at_bound,
            end_effect_um: subject.micrometres(finding.end_effect_m),
            end_effect: in_table.as_ref().map(|one| one.value),
            end_effect_si: in_table.as_ref().map(|one| one.si.value),
            absorbed_share: finding.absorbed_share,
            log_bayes_factor: finding.log_bayes,
            standard_errors: finding.standard_errors,
            p_family: finding.p_family,
            rivals: finding.rivals.iter().map(Into::into).collect(),
            alternative_group: finding.alternative_group,
        }
    }
}

impl SlopeReport {
    fn all(units: &PartUnits, report: &DiagnosisReport) -> impl Iterator<Item = Self> {
        let unit = units.of_slope();
        report.diagnosis.factors.iter().map(move |slope| Self {
            name: slope.name.clone(),
            before: unit.in_table(slope.before.value),
            after: unit.in_table(slope.after.value),
            si: SiValue {
                value: slope.after.value,
                unit: unit.si_name.clone(),
                ci95: slope.after.interval_95(),
            },
            unit: unit.name.clone(),
        })
    }
}

/// Why a parameter has no interval.
pub(super) const STEPPED: &str =
    "the readings change with this parameter by steps, so that no standard error can be given";

impl FittedParameter {
    /// A value of a law.
    #[must_use]
    pub fn of_law(spec: &ParameterSpec, value: &EstimatedValue) -> Self {
        let interval = value.interval_95();
        Self::new(value.value, spec.unit().to_owned(), interval, STEPPED).with_open_ends(value)
    }

    /// The same with the ends of its interval that readings do not reach.
    pub(in crate::report) fn with_open_ends(self, value: &EstimatedValue) -> Self {
        let ends = [IntervalEnd::Lower, IntervalEnd::Upper].into_iter();
        let open = ends.zip(value.is_open()).filter(|(_, is_open)| *is_open);
        Self {
            open_ends: open.map(|(end, _)| end).collect(),
            ..self
        }
    }

    /// Its interval in words.
    pub(in crate::report) fn interval_in_words(&self, digits: usize) -> String {
        let ends = [IntervalEnd::Lower, IntervalEnd::Upper];
        let is_open = ends.map(|end| self.open_ends.contains(&end));
        open_interval(self.ci95, is_open, digits)
    }

    /// A value with its interval, or the reason why there is none.
    pub(in crate::report) fn new(
        value: f64,
        unit: String,
        ci95: Option<[f64; 2]>,
        why_none: &'static str,
    ) -> Self {
        let ci95 = ci95.filter(|ends| ends.iter().all(|end| end.is_finite()));
        Self {
            value,
            unit,
            ci95,
            open_ends: Vec::new(),
            reason: ci95.is_none().then_some(why_none.into()),
            si: None,
        }
    }
}

impl From<&Rival> for RivalReport {
    fn from(rival: &Rival) -> Self {
        Self {
            law: (&rival.effect).into(),
            log_bayes_factor_to_winner: rival.log_bayes_to_winner,
            cosine: rival.cosine,
        }
    }
}

impl From<&Impossible> for RejectedLaw {
    fn from(one: &Impossible) -> Self {
        Self {
            law: LawAtPlace {
                law: one.law,
                place: one.place.clone(),
            },
            gain: one.delta_chi2,
            reason: phrases::impossible(one.law),
        }
    }
}

impl QualityReport {
    fn new(report: &DiagnosisReport, model: DiagnosedModel) -> Self {
        let quality = report.quality(model);
        let micrometres = |reading: f64| report.subject.micrometres(reading);
        let directions = report.directions().filter(|_| !report.is_of_part());
        let by_direction = directions.map(|direction| {
            let [rms_m, _] = report.rms_m(model, Some(direction));
            (direction, micro(rms_m))
        });
        let [_, within_runs_m] = report.rms_m(model, None);
        let percent = |rms_m: f64| 100.0 * rms_m / report.trace.displacement_rms_m;
        Self {
            rms_um: micrometres(quality.rms_m),
            rms: report.subject.in_table(quality.rms_m),
            rms_percent: percent(quality.rms_m),
            rms_um_by_direction: by_direction.collect(),
            within_runs_rms_um: micrometres(within_runs_m),
            held_out_rms_um: quality.held_out_rms_m.and_then(micrometres),
            held_out_rms_percent: quality.held_out_rms_m.map(percent),
            noise_units: quality.reduced_chi2.sqrt(),
            held_out_noise_units: quality.held_out_noise_units,
            held_out: quality.held_out.clone(),
            reduced_chi2: quality.reduced_chi2,
        }
    }
}

impl FactorChangeReport {
    /// A factor with what became of it.
    pub(super) fn new(subject: &Subject, factor: &FactorChange, status: Determination) -> Self {
        let unit = match (subject, factor.spring_rad_per_nm) {
            (Subject::Part { units, .. }, _) => units.of_slope().name,
            (_, None) => "1".to_owned(),
            (_, Some(_)) => {
                let spring = ModelParameter::spring_named(&factor.name);
                let unit = spring.as_ref().map_or("rad/(N*m)", ModelParameter::unit);
                unit.to_owned()
            }
        };
        let [before, after] = [&factor.before, &factor.after].map(|fitted| {
            let (value, interval) = factor_value(subject, factor, fitted);
            let reason = "the data do not determine this factor";
            FittedParameter::new(value, unit.clone(), interval, reason).with_open_ends(fitted)
        });
        let is_factor = factor.spring_rad_per_nm.is_none() && matches!(subject, Subject::Robot(_));
        let change_percent = match is_factor {
            true => Some(100.0 * (factor.after.value - factor.before.value).exp_m1()),
            false if before.value == 0.0 => None,
            false => Some(100.0 * (after.value / before.value - 1.0)),
        };
        Self {
            name: factor.name.clone(),
            before,
            after,
            change_percent,
            status,
        }
    }
}
