//! What a robot does over its workspace rather than in single poses.
//!
//! [`PoseSample`] draws poses within the limits, each of which is known by its number alone; [`StiffnessMap`] is the stiffness over them. Poses
//! that cannot be reached are counted, not left out.

mod end_load;
mod extreme;
mod map;
mod plane;
mod pose_set;
mod projected_ascent;
mod sensitivity;

pub use end_load::{EndShift, PoseSpread, ShiftMap, largest_load};
pub use extreme::Extreme;
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
