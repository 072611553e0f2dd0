//! A fit to load cases as the data of `stiffbench fit --json`.

use schemars::JsonSchema;
use serde::Serialize;

use crate::analysis::DerivedQuantity;
use crate::elastostatics::{
    FittedComponent, FittedFrames, FrameParameter, LoadCaseAgreement, LoadCaseFit, PlannedLoadCase,
    PoseError,
};
use crate::fit::FactorCorrelations;
use crate::physics::Effect;
use crate::robot::FittingFactors;
use crate::test_point::PoseId;

use super::fit_report::{FitReport, ParameterReport};
use super::simulation::TrackerReport;
use super::text::micro;

/// What `fit` gives: of stiffness values, or of load cases.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum FitResult {
    /// Of stiffness values, one a pose and direction.
    Cells(Box<FitReport>),
    /// Of loads and displacements as vectors.
    LoadCases(Box<LoadCaseFitReport>),
}

/// A fit to load cases.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LoadCaseFitReport {
    /// The mechanism that was fitted.
    pub mechanism: String,
    /// What acted beside the linear structure, held fixed.
    pub physics: Vec<Effect>,
    /// Fitted values of all parameters.
    pub factors: FittingFactors,
    /// Every parameter of the fit.
    pub parameters: Vec<ParameterReport>,
    /// Correlations of the determined parameters; `null` without intervals.
    pub correlation: Option<FactorCorrelations>,
    /// Base frame and tool point of absolute positions; `null` of displacements under loads.
    pub frames: Option<FramesReport>,
    /// Scatter, degrees of freedom, rank and condition; `null` without degrees of freedom.
    pub agreement: Option<LoadCaseAgreement>,
    /// Combinations of parameters that the poses do not determine, in words.
    pub not_determined: Vec<String>,
    /// Root mean square errors of the displacements.
    pub rms: LoadCaseErrors,
    /// Errors by pose.
    pub poses: Vec<PoseError>,
    /// Every component that was read.
    pub components: Vec<ComponentReport>,
    /// Why the search ended.
    pub termination: String,
    /// Further load cases that would determine best what is open, one after the other.
    pub next: Vec<PlannedLoadCase>,
    /// Quantities that were derived from the parameters.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub derived: Vec<DerivedQuantity>,
}

/// Where the tracker stands, and which point of the tool it measures.
#[derive(Debug, Clone, Serialize, JsonSchema)]
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
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct LoadCaseErrors {
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
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ComponentReport {
    /// The pose.
    pub pose: PoseId,
    /// Line of the table.
    pub line: u32,
    /// n-th application of the load.
    pub repeat: u32,
    /// Its name, for example `displacement x`.
    pub component: &'static str,
    /// `um` or `urad`; `mm` of a position.
    pub unit: &'static str,
    /// What was read.
    pub measured: f64,
    /// What the fitted model predicts.
    pub predicted: f64,
    /// What a fit without this pose predicts.
    pub unseen: Option<f64>,
    /// Whether its pose took no part in the fit.
    pub held_out: bool,
}

impl LoadCaseFitReport {
    /// A fit with the load cases that would determine what it leaves open.
    #[must_use]
    pub fn new(fit: &LoadCaseFit, next: Vec<PlannedLoadCase>) -> Self {
        let [before_um, fitted_um, unseen_um] = fit.rms_m().map(|rms| rms.map(micro));
        Self {
            mechanism: fit.mechanism.clone(),
            physics: fit.physics.clone(),
            factors: fit.factors.clone(),
            parameters: fit.estimates.iter().map(Into::into).collect(),
            correlation: fit.correlation.clone(),
            frames: fit.frames.as_ref().map(Into::into),
            agreement: fit.agreement.clone(),
            not_determined: fit.not_determined.clone(),
            rms: LoadCaseErrors {
                rigid_um: fit.rigid_rms_m().map(micro),
                before_um,
                fitted_um,
                unseen_um,
            },
            poses: fit.poses.clone(),
            components: fit.components.iter().map(Into::into).collect(),
            termination: fit.termination.clone(),
            next,
            derived: Vec::new(),
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
            component: one.component,
            unit: match (one.is_position, one.is_rotation) {
                (true, _) => "mm",
                (_, true) => "urad",
                _ => "um",
            },
            measured: scaled(one.measured),
            predicted: scaled(one.predicted),
            unseen: one.without_its_pose.map(scaled),
            held_out: one.held_out,
        }
    }
}
