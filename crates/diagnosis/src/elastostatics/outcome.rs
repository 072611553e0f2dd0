//! What a fit to load cases found.

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use stiffbench_beams::physics::Effect;
use stiffbench_beams::robot::{FittingFactors, TrackerFrames};
use stiffbench_numeric::statistics::root_mean_square;
use stiffbench_units_and_text::quantity::METRES_PER_MICROMETRE;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use crate::fit::{FactorCorrelations, FactorEstimate};

use super::scatter::RowScatter;

/// Where the scatter of the components comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScatterSource {
    /// Differences between repeats of one load in one pose.
    Repeats,
    /// What the fit leaves over the poses.
    #[default]
    Residuals,
}

/// The unit in which JSON and words state a displacement or a rotation.
pub(super) fn micro_unit(is_rotation: bool) -> &'static str {
    if is_rotation { "urad" } else { "um" }
}

/// A length in µm, or an angle in µrad.
#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes a reference"
)]
pub(super) fn in_micro<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    (value / METRES_PER_MICROMETRE).serialize(serializer)
}

/// The same where there may be none.
#[expect(clippy::ref_option, reason = "serde passes the field")]
fn in_micro_if_any<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    value
        .map(|value| value / METRES_PER_MICROMETRE)
        .serialize(serializer)
}

/// How well the fitted model agrees with the components that it was fitted to.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LoadCaseAgreement {
    /// Where the scatter comes from.
    #[serde(rename = "scatter_from")]
    pub source: ScatterSource,
    /// Standard deviation of what a load moves from application to application, as a share of it; zero of positions without repeats.
    pub load_sd: f64,
    /// Standard deviation of a displacement beside that, m, in JSON um; none if none was read.
    #[serde(rename = "displacement_sd_um", serialize_with = "in_micro_if_any")]
    pub displacement_sd_m: Option<f64>,
    /// Standard deviation of a rotation beside that, rad, in JSON urad; none if none was read.
    #[serde(rename = "rotation_sd_urad", serialize_with = "in_micro_if_any")]
    pub rotation_sd_rad: Option<f64>,
    /// Degrees of freedom of that scatter, which intervals have too.
    pub scatter_dof: f64,
    /// Components less determined parameters.
    pub dof: usize,
    /// Sum of the squared residuals in units of the scatter over `dof`; 1 by construction if the scatter is that of the residuals.
    pub reduced_chi2: Option<f64>,
    /// Probability of a sum of squares at least as large if the model is right; only with scatter from repeats.
    pub p: Option<f64>,
    /// Number of independent combinations of parameters that the poses determine.
    pub rank: usize,
    /// Number of parameters that were to be determined.
    pub free: usize,
    /// Largest over smallest singular value of the columns of unit length; in JSON `null` if the smallest is zero.
    #[schemars(with = "Option<f64>")]
    pub condition: f64,
}

impl LoadCaseAgreement {
    /// Standard deviations of displacements, m, and of rotations, rad; none of what was not read.
    pub(super) fn sd(&self) -> [Option<f64>; 2] {
        [self.displacement_sd_m, self.rotation_sd_rad]
    }
}

/// A component with what the model says of it.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedComponent {
    /// Line of the table.
    pub line: u32,
    /// The pose.
    pub pose: PoseId,
    /// n-th application of the load.
    pub repeat: u32,
    /// Its name, for example `displacement x`.
    pub component: &'static str,
    /// Whether it is a rotation, rad; else a displacement, m.
    pub is_rotation: bool,
    /// Whether it is an absolute position, m.
    pub is_position: bool,
    /// Its axis among the stated ones, of a position among those of the tracker.
    pub axis: Direction,
    /// What was read, m or rad.
    pub measured: f64,
    /// What the rigid robot predicts, m or rad; of positions with frames of its own.
    pub rigid: f64,
    /// What the fitted model predicts, m or rad.
    pub predicted: f64,
    /// What a fit without this pose predicts, m or rad.
    pub without_its_pose: Option<f64>,
    /// Whether its pose took no part in the fit.
    pub held_out: bool,
}

impl FittedComponent {
    /// Predicted less measured, m or rad, by a fit that did not know the pose; `None` without one.
    pub(super) fn unseen_error(&self) -> Option<f64> {
        let predicted = self.held_out.then_some(self.predicted);
        Some(self.without_its_pose.or(predicted)? - self.measured)
    }
}

/// Root mean square errors of the displacements of a pose, m, in JSON um.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PoseError {
    /// The pose.
    pub pose: PoseId,
    /// Of the rigid robot: fitted springs without compliance, fitted factors 1; of positions with frames of its own.
    #[serde(rename = "rigid_um", serialize_with = "in_micro")]
    pub rigid_m: f64,
    /// Of the model with the values that the fit began at; of positions that of the rigid robot.
    #[serde(rename = "before_um", serialize_with = "in_micro")]
    pub before_m: f64,
    /// Of the fitted model.
    #[serde(rename = "fitted_um", serialize_with = "in_micro")]
    pub fitted_m: f64,
    /// Of a fit without this pose.
    #[serde(rename = "unseen_um", serialize_with = "in_micro_if_any")]
    pub without_its_pose_m: Option<f64>,
}

/// Base frame and tool point, fitted to absolute positions beside the springs.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedFrames {
    /// Where the tracker stands, and which point of the tool it measures.
    pub frames: TrackerFrames,
    /// Those that fit the rigid robot best, the same springs rigid.
    pub rigid: TrackerFrames,
    /// Position of the base (m), its rotation about the axes of the tracker (rad), and the point of the tool (m), each along three axes.
    pub parameters: [FrameParameter; 9],
    /// Root mean square error of the rigid robot with its own frames in poses that its fit did not know, m.
    pub rigid_unseen_m: Option<f64>,
}

/// How well one of the nine parameters of the frames is known.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "FrameParameterReport")]
pub struct FrameParameter {
    /// Its name: `base_frame.x`, `base_frame.rx` (about the axes of the tracker), `tool_point.x`.
    pub name: &'static str,
    /// `um` or `urad`.
    pub unit: &'static str,
    /// Standard error, m or rad, in JSON in `unit`; `null` where the poses do not determine it.
    #[serde(rename = "se", serialize_with = "in_micro_if_any")]
    pub standard_error: Option<f64>,
    /// Half of its 95 % interval, m or rad, in JSON in `unit`.
    #[serde(serialize_with = "in_micro_if_any")]
    pub half_width_95: Option<f64>,
}

/// The result of a fit to load cases.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCaseFit {
    /// The mechanism that was fitted.
    pub mechanism: String,
    /// What acted beside the linear structure, held fixed.
    pub physics: Vec<Effect>,
    /// Fitted values.
    pub factors: FittingFactors,
    /// One entry a parameter.
    pub estimates: Vec<FactorEstimate>,
    /// Correlations of the determined parameters.
    pub correlation: Option<FactorCorrelations>,
    /// Base frame and tool point; only of absolute positions.
    pub frames: Option<FittedFrames>,
    /// Agreement with the components of the fit; `None` without degrees of freedom.
    pub agreement: Option<LoadCaseAgreement>,
    /// Combinations of parameters that the poses do not determine, in words.
    pub not_determined: Vec<String>,
    /// Every component, in the order of the table.
    pub components: Vec<FittedComponent>,
    /// Errors by pose, in the order of the table.
    pub poses: Vec<PoseError>,
    /// How the components scatter.
    pub(crate) scatter: RowScatter,
    /// The same without a part that grows with the load: a mistake of the table must not pass for it.
    pub(crate) plain_scatter: RowScatter,
    /// Why the search ended.
    pub termination: String,
    /// What a user should know before using the numbers.
    pub warnings: Vec<String>,
}

impl LoadCaseFit {
    /// Measured less predicted of every component, m and rad.
    #[must_use]
    pub fn residuals(&self) -> Vec<f64> {
        let components = self.components.iter();
        components.map(|one| one.measured - one.predicted).collect()
    }

    /// Root mean square of the displacements that the start of the fit leaves, of those that the fit leaves, and of those that fits
    /// without their pose leave, m.
    ///
    /// The last is of held-out poses if there are any, else of all poses left out in turn; `None` if neither was done.
    #[must_use]
    pub fn rms_m(&self) -> [Option<f64>; 3] {
        let rms = |of: &dyn Fn(&FittedComponent) -> Option<f64>| {
            let displacements = self.components.iter().filter(|one| !one.is_rotation);
            root_mean_square(displacements.filter_map(of))
        };
        [
            self.over_poses(&|pose| pose.before_m),
            rms(&|one| (!one.held_out).then_some(one.predicted - one.measured)),
            rms(&FittedComponent::unseen_error),
        ]
    }

    /// Root mean square of the displacements that the rigid robot leaves, m; `None` without displacements.
    #[must_use]
    pub fn rigid_rms_m(&self) -> Option<f64> {
        self.over_poses(&|pose| pose.rigid_m)
    }

    /// The same of the rigid robot in the poses that [`LoadCaseFit::rms_m`] states last: nothing was fitted to them.
    #[must_use]
    pub fn rigid_unseen_m(&self) -> Option<f64> {
        match &self.frames {
            Some(frames) => frames.rigid_unseen_m,
            None if self.held_out_poses() > 0 => self.rigid_of(true),
            None => self.rigid_rms_m(),
        }
    }

    /// The same in the poses of the fit, or in those that were held out.
    #[must_use]
    pub fn rigid_of(&self, held_out: bool) -> Option<f64> {
        let own = self.components.iter();
        let own = own.filter(|one| one.held_out == held_out && !one.is_rotation);
        root_mean_square(own.map(|one| one.rigid - one.measured))
    }

    /// Number of poses that took no part in the fit.
    #[must_use]
    pub fn held_out_poses(&self) -> usize {
        let held_out = self.components.iter().filter(|one| one.held_out);
        let held_out: BTreeSet<&PoseId> = held_out.map(|one| &one.pose).collect();
        held_out.len()
    }

    /// Whether a pose took no part in the fit.
    #[must_use]
    pub fn is_held_out(&self, pose: &PoseId) -> bool {
        let mut own = self.components.iter();
        own.any(|one| one.held_out && one.pose == *pose)
    }

    /// Root mean square over all displacements, from those of the poses.
    fn over_poses(&self, rms: &dyn Fn(&PoseError) -> f64) -> Option<f64> {
        let mut counts: BTreeMap<&PoseId, f64> = BTreeMap::new();
        for one in self.components.iter().filter(|one| !one.is_rotation) {
            *counts.entry(&one.pose).or_default() += 1.0;
        }
        let (squares, count) = self.poses.iter().fold((0.0, 0.0), |(sum, all), pose| {
            let count = counts.get(&pose.pose).copied().unwrap_or_default();
            (sum + rms(pose).powi(2) * count, all + count)
        });
        (count > 0.0).then(|| f64::sqrt(squares / count))
    }

    /// The estimate of a parameter by name.
    #[must_use]
    pub fn estimate(&self, name: &str) -> Option<&FactorEstimate> {
        self.estimates.iter().find(|estimate| estimate.name == name)
    }
}
