//! A fit as the data of `stiffbench fit --json`.

use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::analysis::{DerivedQuantity, FitData, FittedSession, ReadingMark, RunsTest};
use crate::fit::{
    BootstrapDraws, FactorCorrelations, FactorEstimate, FactorStatus, FitMethod, FitOutcome,
    FittedCell, FittedCompliance, FittedComponent, FittedFrames, FrameParameter, MonteCarloFit,
    PaperFit, PoseError, PoseFit, SequenceStep, StatusWord, WeightBasis,
};
use crate::fit::{PlannedLoadCase, PlannedLoadCases, ProposedWithin};
use crate::least_squares::SigmaMode;
use crate::physics::Effect;
use crate::quantity::{
    METRES_PER_MICROMETRE, NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM,
};
use crate::reported::Reported;
use crate::robot::{ElementClass, FittingFactors, ModelParameter, StoredSprings};
use crate::structure::Property;
use crate::test_point::{Direction, PoseId};

use super::model_comparison::ModelComparison;
use super::significance::SignificanceReport;
use super::simulation::TrackerReport;
use super::text::micro;

/// A fit.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FitReport {
    /// How the parameters were found.
    pub method: FitMethod,
    /// The mechanism that was fitted.
    pub mechanism: String,
    /// What acted beside the beams, held fixed: law, place and parameters.
    pub physics: Vec<Effect>,
    /// The factors of beams and links by section constant, A, Iy, Iz, J, and the compliances of springs.
    pub factors: ClassFactors,
    /// Every parameter of the model: factors of classes, then single sections and springs.
    pub parameters: Vec<ParameterReport>,
    /// Correlations of the determined parameters; `null` without intervals.
    pub correlation: Option<FactorCorrelations>,
    /// Where the standard deviation of the residuals comes from.
    pub sigma: Option<SigmaMode>,
    /// Where the weights come from.
    pub weights: Option<WeightBasis>,
    /// Standard deviation of a displacement beside what a load scatters by, um; of load cases only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_sd_um: Option<f64>,
    /// The same of a rotation, urad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_sd_urad: Option<f64>,
    /// Residuals less determined parameters.
    pub dof: Option<usize>,
    /// Sum of squared residuals over `dof`.
    pub reduced_chi2: Option<f64>,
    /// Probability of a sum of squares at least as large if model and uncertainties are right: lack of fit, by the F distribution where the
    /// scatter was estimated from repeats.
    pub p: Option<f64>,
    /// Number of independent combinations of parameters that the cells determine: the rank of the Jacobian.
    pub rank: Option<usize>,
    /// Number of parameters that were to be determined: free and not on a bound.
    pub free: Option<usize>,
    /// Largest over smallest singular value of the Jacobian with columns of unit length; `null` if the smallest is zero.
    pub condition: Option<f64>,
    /// Combinations of parameters that the cells do not determine, in words.
    pub not_determined: Vec<String>,
    /// How the intervals of the bootstrap came about, if it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bootstrap: Option<BootstrapDraws>,
    /// The sessions, where several were fitted together, in the order of their cells.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sessions: Vec<FittedSession>,
    /// Readings that the fit leaves out because of their status, and those that it uses though they are flagged.
    pub marked: Vec<ReadingMark>,
    /// Whether residuals of the readings keep their sign for longer than independent errors do; empty without readings.
    pub runs_tests: Vec<RunsTest>,
    /// Every measured cell.
    pub cells: Vec<FittedCellReport>,
    /// Every compliance that was measured along another axis than that of the load.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub across: Vec<FittedComplianceReport>,
    /// Every component of load cases.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub components: Vec<ComponentReport>,
    /// Root mean square errors of the displacements or positions of load cases.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms: Option<ComponentErrors>,
    /// The same by pose.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub poses: Vec<PoseError>,
    /// Base frame and tool point, of absolute positions only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<FramesReport>,
    /// Largest |ratio - 100| over held-out cells, else over all.
    pub max_error_percent: Option<f64>,
    /// Why the search ended.
    pub termination: String,
    /// Further load cases that would determine best what is open, one after the other.
    pub next: Vec<PlannedLoadCase>,
    /// What their poses keep; not there without any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_within: Option<ProposedWithin>,
    /// Quantities that were derived from the parameters.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub derived: Vec<DerivedQuantity>,
    /// Other models of the same cells, where they were named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub comparison: Option<ModelComparison>,
    /// The nine steps, of the paper's method only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<PaperSteps>,
}

/// Factors by class of element and section constant, and springs.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ClassFactors {
    /// Of beams.
    pub beam: BTreeMap<Property, FactorReport>,
    /// Of links.
    pub link: BTreeMap<Property, FactorReport>,
    /// The springs of the fitted model, those that the fit did not move among them.
    #[serde(flatten)]
    pub springs: StoredSprings,
}

/// A factor of a class.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FactorReport {
    /// Its value, 1.
    pub value: f64,
    /// 95 % likelihood-ratio interval, from the first island to the last.
    pub ci95: Option<[f64; 2]>,
    /// Islands of that interval; empty if it has no gaps.
    pub islands: Vec<[f64; 2]>,
    /// 95 % interval from the covariance.
    pub ci95_quadratic: Option<[f64; 2]>,
    /// 95 % interval of the bootstrap over runs or cells.
    pub ci95_bootstrap: Option<[f64; 2]>,
    /// What the fit did with it.
    pub status: StatusWord,
    /// The parameter that it is tied to.
    pub tied_to: Option<String>,
    /// Where the fit began.
    pub start: f64,
    /// What the data show of it instead of an interval.
    pub words: Option<String>,
}

/// A parameter of the model.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ParameterReport {
    /// Its name, for example `beam.Iy`, `section.rod.A`, `joint.J2` or `base.rx`.
    pub name: String,
    /// Its value in `unit`; `null` of a spring that had none before the fit and of which the data say nothing.
    pub value: Option<f64>,
    /// `1` of a factor, `rad/(N*m)` of a spring.
    pub unit: Cow<'static, str>,
    /// Standard uncertainty.
    pub se: Option<f64>,
    /// 95 % likelihood-ratio interval, from the first island to the last.
    pub ci95: Option<[f64; 2]>,
    /// Islands of that interval; empty if it has no gaps.
    pub islands: Vec<[f64; 2]>,
    /// 95 % interval of the bootstrap over runs or cells, if it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ci95_bootstrap: Option<[f64; 2]>,
    /// Smallest and largest value that the fit could give it; `null` of one that it does not move.
    pub bounds: Option<[f64; 2]>,
    /// What the fit did with it.
    pub status: StatusWord,
    /// Where the fit began.
    pub start: f64,
    /// Whether the fit moved it from there; `null` of one that it may not move, or that ended on a bound.
    pub moved: Option<bool>,
    /// Stiffness of a spring, the inverse of its compliance; not there of a factor and where it is infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// 95 % interval of the stiffness; an end that is `null` is infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_ci95: Option<[Option<f64>; 2]>,
    /// Unit of the stiffness; not there of a factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_unit: Option<String>,
    /// The parameter that it is tied to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tied_to: Option<String>,
    /// What the data show of it instead of an interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub words: Option<String>,
}

/// A measured cell beside its prediction.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FittedCellReport {
    /// The session, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub session: Option<String>,
    /// The pose.
    pub pose: PoseId,
    /// The direction.
    pub direction: Direction,
    /// Measured stiffness.
    pub measured: Reported,
    /// Stiffness of the fitted model.
    pub predicted: Reported,
    /// Predicted over measured, %.
    pub ratio_percent: f64,
    /// Combined standard uncertainty of ln K measured.
    pub ln_uncertainty: Option<f64>,
    /// Whether its pose took no part in the fit.
    pub held_out: bool,
    /// Stiffness predicted by a fit without this pose.
    pub predicted_without_its_pose: Option<Reported>,
}

/// A compliance that was measured along another axis than that of the load, beside its prediction.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FittedComplianceReport {
    /// The session, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub session: Option<String>,
    /// The pose.
    pub pose: PoseId,
    /// Direction of the load.
    pub load: String,
    /// Axis of the displacement.
    pub axis: Direction,
    /// Measured compliance, with its standard uncertainty.
    pub measured: Reported,
    /// Compliance of the fitted model.
    pub predicted: Reported,
}

/// Where the tracker stands, and which point of the tool it measures.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FramesReport {
    /// As `simulate` writes them.
    #[serde(flatten)]
    pub frames: TrackerReport,
    /// The rotation as a matrix, row by row.
    pub rotation: [[f64; 3]; 3],
    /// The nine parameters with their standard errors.
    pub parameters: Vec<FrameParameter>,
    /// Root mean square error of the rigid robot, with frames of its own, in poses left out of its fit, um.
    pub rigid_unseen_um: Option<f64>,
}

/// Root mean square errors of all displacements, µm.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct ComponentErrors {
    /// Of the rigid robot: fitted springs without compliance, fitted factors 1; `null` if no displacement was read, as of the others.
    pub rigid_um: Option<f64>,
    /// Of the model with the values that the fit began at, such as springs of the robot file; of positions that of the rigid robot.
    pub before_um: Option<f64>,
    /// Of the fitted model, in the poses of the fit.
    pub fitted_um: Option<f64>,
    /// In poses that the fit did not know: held-out ones if there are any, else each left out in turn.
    pub unseen_um: Option<f64>,
}

/// A component beside what the model says of it.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ComponentReport {
    /// The pose.
    pub pose: PoseId,
    /// Line of the table.
    pub line: u32,
    /// n-th application of the load.
    pub repeat: u32,
    /// Its name, for example `displacement x`.
    pub component: Cow<'static, str>,
    /// `um` or `urad`; `mm` of a position.
    pub unit: Cow<'static, str>,
    /// What was read.
    pub measured: f64,
    /// What the fitted model predicts.
    pub predicted: f64,
    /// What a fit without this pose predicts.
    pub unseen: Option<f64>,
    /// Whether its pose took no part in the fit.
    pub held_out: bool,
}

impl FitReport {
    /// States what is to be measured next.
    pub fn plan_next(&mut self, plan: PlannedLoadCases) {
        (self.next, self.next_within) = (plan.planned, plan.within);
    }

    /// The same with the marks of the readings behind it, and with the cells named by their sessions, which follow each other.
    #[must_use]
    pub fn of_data(mut self, data: &FitData) -> Self {
        self.marked.clone_from(&data.marked);
        let mut cells = self.cells.iter_mut().map(|cell| &mut cell.session);
        let mut across = self.across.iter_mut().map(|one| &mut one.session);
        for session in &data.sessions {
            let own = cells.by_ref().take(session.cells);
            for name in own.chain(across.by_ref().take(session.across)) {
                *name = Some(session.name.clone());
            }
        }
        self.sessions.clone_from(&data.sessions);
        self
    }
}

/// The nine steps of the paper.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PaperSteps {
    /// Step 1.
    #[serde(rename = "1_objective")]
    pub objective: String,
    /// Steps 2 to 4, by pose; empty if the factors were given.
    #[serde(rename = "2_to_4_single_source")]
    pub single_source: Vec<PoseFitReport>,
    /// The set of factors that was given instead.
    pub single_source_given: Option<String>,
    /// Single-source factors.
    pub single_source_factors: FittingFactors,
    /// Step 5.
    #[serde(rename = "5_start_with_link_factors")]
    pub start: FittingFactors,
    /// Steps 6 and 7, by pose.
    #[serde(rename = "6_and_7_multi_source")]
    pub multi_source: Vec<PoseFitReport>,
    /// Step 8.
    #[serde(rename = "8_combined_factors")]
    pub combined: FittingFactors,
    /// Step 9.
    #[serde(rename = "9_validation")]
    pub validation: Vec<FittedCellReport>,
}

/// The fit of one pose.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PoseFitReport {
    /// The pose.
    pub pose: PoseId,
    /// Its weight in the combination.
    pub weight: f64,
    /// Significance around the start.
    pub significance: SignificanceReport,
    /// Sequence that follows from it.
    pub sequence: Vec<SequenceStep>,
    /// The random trials.
    pub trials: MonteCarloFit,
    /// The factors it ended with.
    pub factors: FittingFactors,
}

impl From<&FitOutcome> for FitReport {
    fn from(outcome: &FitOutcome) -> Self {
        let agreement = outcome.agreement.as_ref();
        let [displacement_sd, rotation_sd] = agreement.map_or([None; 2], |one| one.component_sd);
        let [before_um, fitted_um, unseen_um] = outcome.rms_m().map(|rms| rms.map(micro));
        let of_class = |class: ElementClass| {
            let estimates = outcome.estimates.iter();
            estimates
                .filter_map(|estimate| match &estimate.parameter {
                    ModelParameter::Class(own, property) if *own == class => {
                        Some((*property, FactorReport::from(estimate)))
                    }
                    _ => None,
                })
                .collect()
        };
        Self {
            method: outcome.method,
            mechanism: outcome.mechanism.clone(),
            physics: outcome.physics.clone(),
            factors: ClassFactors {
                beam: of_class(ElementClass::Beam),
                link: of_class(ElementClass::Link),
                springs: (&outcome.factors).into(),
            },
            parameters: outcome.estimates.iter().map(Into::into).collect(),
            correlation: outcome.correlation.clone(),
            sigma: agreement.map(|agreement| agreement.sigma),
            weights: agreement.map(|agreement| agreement.basis),
            displacement_sd_um: displacement_sd.map(micro),
            rotation_sd_urad: rotation_sd.map(micro),
            dof: agreement.map(|agreement| agreement.dof),
            reduced_chi2: agreement.and_then(|agreement| agreement.reduced_chi_squared),
            p: agreement.and_then(|agreement| agreement.p_value),
            rank: agreement.map(|agreement| agreement.rank),
            free: agreement.map(|agreement| agreement.free),
            condition: agreement
                .map(|agreement| agreement.condition)
                .filter(|condition| condition.is_finite()),
            not_determined: agreement
                .map(|agreement| agreement.not_determined.clone())
                .unwrap_or_default(),
            sessions: Vec::new(),
            marked: Vec::new(),
            runs_tests: Vec::new(),
            cells: outcome.cells.iter().map(Into::into).collect(),
            across: outcome.across.iter().map(Into::into).collect(),
            rms: (!outcome.components.is_empty()).then(|| ComponentErrors {
                rigid_um: outcome.rigid_rms_m().map(micro),
                before_um,
                fitted_um,
                unseen_um,
            }),
            components: outcome.components.iter().map(Into::into).collect(),
            poses: outcome.pose_errors(),
            frames: outcome.frames.as_ref().map(Into::into),
            max_error_percent: outcome.max_error_percent(),
            termination: outcome.termination.clone(),
            next: Vec::new(),
            next_within: None,
            bootstrap: outcome.bootstrap.clone(),
            derived: Vec::new(),
            comparison: None,
            steps: None,
        }
    }
}

impl From<&PaperFit> for PaperSteps {
    fn from(fit: &PaperFit) -> Self {
        let of_poses = |fits: &[PoseFit]| fits.iter().map(Into::into).collect();
        Self {
            objective: format!("multi-source model of mechanism {}", fit.outcome.mechanism),
            single_source: of_poses(&fit.single_source),
            single_source_given: fit.single_source_given.clone(),
            single_source_factors: fit.single_source_factors.clone(),
            start: fit.start.clone(),
            multi_source: of_poses(&fit.multi_source),
            combined: fit.outcome.factors.clone(),
            validation: fit.outcome.cells.iter().map(Into::into).collect(),
        }
    }
}

/// The parameter that one is tied to.
fn tied_to(estimate: &FactorEstimate) -> Option<String> {
    match &estimate.status {
        FactorStatus::Tied { to } => Some(to.clone()),
        _ => None,
    }
}

/// What the data show of a parameter instead of an interval.
fn words_instead(estimate: &FactorEstimate) -> Option<String> {
    estimate.status.why_open().map(str::to_owned)
}

impl From<&FactorEstimate> for FactorReport {
    fn from(estimate: &FactorEstimate) -> Self {
        Self {
            value: estimate.value,
            ci95: estimate.interval_95,
            islands: estimate.islands_95.clone(),
            ci95_quadratic: estimate.quadratic_interval_95,
            ci95_bootstrap: estimate.bootstrap_interval_95,
            status: estimate.status.word(),
            tied_to: tied_to(estimate),
            start: estimate.start,
            words: match &estimate.status {
                FactorStatus::Tied { to } => Some(format!("in proportion to {to}")),
                _ => words_instead(estimate),
            },
        }
    }
}

impl From<&FactorEstimate> for ParameterReport {
    fn from(estimate: &FactorEstimate) -> Self {
        let is_spring = !estimate.parameter.is_factor();
        let inverse = |compliance: f64| (compliance > 0.0).then(|| 1.0 / compliance);
        let known = estimate.known_value().filter(|_| is_spring);
        let interval = estimate.interval_95.filter(|_| is_spring);
        Self {
            stiffness: known.and_then(inverse),
            stiffness_ci95: interval.map(|[low, high]| [inverse(high), inverse(low)]),
            stiffness_unit: is_spring.then(|| stiffness_unit(estimate.parameter.unit())),
            name: estimate.name.clone(),
            value: estimate.known_value(),
            unit: estimate.parameter.unit().into(),
            se: estimate.standard_uncertainty,
            ci95: estimate.interval_95,
            islands: estimate.islands_95.clone(),
            ci95_bootstrap: estimate.bootstrap_interval_95,
            bounds: estimate.bounds,
            status: estimate.status.word(),
            start: estimate.start,
            moved: estimate.moved(),
            tied_to: tied_to(estimate),
            words: words_instead(estimate),
        }
    }
}

/// The unit of the inverse of a compliance.
pub(super) fn stiffness_unit(compliance: &str) -> String {
    match compliance.split_once('/') {
        Some((over, under)) => format!("{}/{over}", under.trim_matches(['(', ')'])),
        None => compliance.to_owned(),
    }
}

impl From<&FittedCell> for FittedCellReport {
    fn from(cell: &FittedCell) -> Self {
        let stiffness = |n_per_m: f64| Reported::exact(n_per_m / N_PER_UM, "N/um");
        Self {
            session: None,
            pose: cell.cell.pose.clone(),
            direction: cell.cell.direction,
            measured: stiffness(cell.measured_n_per_m),
            predicted: stiffness(cell.predicted_n_per_m),
            ratio_percent: cell.ratio_percent(),
            ln_uncertainty: cell.ln_uncertainty,
            held_out: cell.held_out,
            predicted_without_its_pose: cell.predicted_without_its_pose_n_per_m.map(stiffness),
        }
    }
}

impl From<&FittedCompliance> for FittedComplianceReport {
    fn from(one: &FittedCompliance) -> Self {
        let um_per_n = |m_per_n: f64| Reported::exact(m_per_n / METRES_PER_MICROMETRE, "um/N");
        let load = one.cell.load.as_ref();
        Self {
            session: None,
            pose: one.cell.pose.clone(),
            load: load.map_or_else(|| one.cell.direction.to_string(), ToString::to_string),
            axis: one.cell.direction,
            measured: Reported {
                standard_uncertainty: Some(one.u_m_per_n / METRES_PER_MICROMETRE),
                ..um_per_n(one.measured_m_per_n)
            },
            predicted: um_per_n(one.predicted_m_per_n),
        }
    }
}

impl From<&PoseFit> for PoseFitReport {
    fn from(fit: &PoseFit) -> Self {
        Self {
            pose: fit.pose.clone(),
            weight: fit.weight,
            significance: (&fit.significance).into(),
            sequence: fit.sequence.clone(),
            trials: fit.fit.clone(),
            factors: fit.fit.factors.clone(),
        }
    }
}

impl From<&FittedFrames> for FramesReport {
    fn from(fitted: &FittedFrames) -> Self {
        Self {
            frames: TrackerReport::from(&fitted.frames),
            rotation: fitted.frames.rotation,
            parameters: fitted.parameters.to_vec(),
            rigid_unseen_um: fitted.rigid_unseen_m.map(micro),
        }
    }
}

impl From<&FittedComponent> for ComponentReport {
    fn from(one: &FittedComponent) -> Self {
        let scaled = |value: f64| {
            if one.is_position {
                1e3 * value
            } else {
                micro(value)
            }
        };
        Self {
            pose: one.pose.clone(),
            line: one.line,
            repeat: one.repeat,
            component: one.component.into(),
            unit: match (one.is_position, one.is_rotation) {
                (true, _) => "mm".into(),
                (_, true) => "urad".into(),
                _ => "um".into(),
            },
            measured: scaled(one.measured),
            predicted: scaled(one.predicted),
            unseen: one.without_its_pose.map(scaled),
            held_out: one.held_out,
        }
    }
}
