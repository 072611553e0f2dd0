//! What a fit to load cases found.

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_beams::robot::{FittingFactors, TrackerFrames};
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use crate::fit::{FactorCorrelations, FactorEstimate};

/// Where the scatter of the components comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScatterSource {
    /// Differences between repeats of one load in one pose.
    Repeats,
    /// What the fit leaves over the poses.
    Residuals,
}

/// How well the fitted model agrees with the components that it was fitted to.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCaseAgreement {
    /// Where the scatter comes from.
    pub source: ScatterSource,
    /// Standard deviation of a displacement, m; `None` if none was read.
    pub displacement_sd_m: Option<f64>,
    /// Standard deviation of a rotation, rad; `None` if none was read.
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
    /// Largest over smallest singular value of the columns of unit length.
    pub condition: f64,
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
    /// What the fitted model predicts, m or rad.
    pub predicted: f64,
    /// What a fit without this pose predicts, m or rad.
    pub without_its_pose: Option<f64>,
    /// Whether its pose took no part in the fit.
    pub held_out: bool,
}

/// Root mean square errors of the displacements of a pose.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseError {
    /// The pose.
    pub pose: PoseId,
    /// Without what was fitted, m; of positions the rigid robot with frames of its own.
    pub before_m: f64,
    /// Of the fitted model, m.
    pub fitted_m: f64,
    /// Of a fit without this pose, m.
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
#[derive(Debug, Clone, PartialEq)]
pub struct FrameParameter {
    /// Its name, for example `base_frame.rx`.
    pub name: &'static str,
    /// Standard error, m or rad; `None` where the poses do not determine it.
    pub standard_error: Option<f64>,
    /// Half of its 95 % interval, m or rad.
    pub half_width_95: Option<f64>,
}

/// The result of a fit to load cases.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCaseFit {
    /// The mechanism that was fitted.
    pub mechanism: String,
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
    /// Why the search ended.
    pub termination: String,
    /// What a user should know before using the numbers.
    pub warnings: Vec<String>,
}

impl LoadCaseFit {
    /// Root mean square of the displacements that the start of the fit leaves, of those that the fit leaves, and of those that fits
    /// without their pose leave, m.
    ///
    /// The last is of held-out poses if there are any, else of all poses left out in turn; `None` if neither was done.
    #[must_use]
    pub fn rms_m(&self) -> [Option<f64>; 3] {
        let rms = |of: &dyn Fn(&FittedComponent) -> Option<f64>| {
            let displacements = self.components.iter().filter(|one| !one.is_rotation);
            let errors: Vec<f64> = displacements.filter_map(of).collect();
            let squares: f64 = errors.iter().map(|error| error * error).sum();
            (!errors.is_empty()).then(|| (squares / errors.len() as f64).sqrt())
        };
        let before = {
            let poses = self.poses.iter();
            let counts = self.poses.iter().map(|pose| {
                let own = self.components.iter();
                own.filter(|one| one.pose == pose.pose && !one.is_rotation)
                    .count() as f64
            });
            let (squares, count) = poses.zip(counts).fold((0.0, 0.0), |(sum, all), (pose, n)| {
                (sum + pose.before_m * pose.before_m * n, all + n)
            });
            (count > 0.0).then(|| f64::sqrt(squares / count))
        };
        [
            before,
            rms(&|one| (!one.held_out).then_some(one.predicted - one.measured)),
            rms(&|one| {
                let unseen = one
                    .without_its_pose
                    .or(one.held_out.then_some(one.predicted));
                Some(unseen? - one.measured)
            }),
        ]
    }

    /// The estimate of a parameter by name.
    #[must_use]
    pub fn estimate(&self, name: &str) -> Option<&FactorEstimate> {
        self.estimates.iter().find(|estimate| estimate.name == name)
    }
}
