//! What a robot does over its workspace rather than in single poses.
//!
//! [`WorkspaceSample`] draws poses within the limits and states where the end is in each; nothing is left out of its counts.
//! [`StiffnessMap`] is the stiffness over the poses of a [`PoseSample`], each of which is known by its number alone.

mod end_load;
mod extreme;
mod map;
mod plane;
mod pose_set;
mod projected_ascent;
mod sensitivity;
mod workspace;

pub use end_load::{EndShift, PoseSpread, ShiftMap, largest_load};
pub use extreme::{Extreme, RefinedExtreme};
pub use map::{
    ColumnStatistics, ColumnStudy, FitUncertainty, FittedCovariance, Level, MapColumn, MapModel,
    MatrixKind, MechanismStudy, NoMap, Quantile, RefinedStiffness, Region, SampledExtreme,
    SolvedBatch, StiffnessMap, StudyPoses, Surface, cartesian_stiffness, column_statistics,
    fit_uncertainty, regions, row_width,
};
pub use plane::{MapPlane, NoPlaneAxis, PlaneAxis, variables_beside_the_plane};
pub use pose_set::{PosePlan, PoseSample, Sampling, Shard, WorkspaceError};
pub use sensitivity::{
    DesignSensitivity, JointSensitivity, SectionSensitivity, design_sensitivity,
};
pub use workspace::{EndPoint, UnreachablePose, WorkspacePlan, WorkspaceSample};
