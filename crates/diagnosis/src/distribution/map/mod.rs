//! Stiffness of the end of a mechanism over poses.
//!
//! A [`MapModel`] is a mechanism with its factors and found physics; a [`StiffnessMap`] is what it gives in the poses of a
//! [`super::PoseSample`]: one row of numbers a pose, each the same whatever the other poses are. All that is said of a map afterwards
//! (statistics, regions, files) comes from these rows, so that a map put together from shares is the map of the whole.

mod column;
mod fit_uncertainty;
mod matrix;
mod model;
mod refine;
mod regions;
mod statistics;
mod stiffness_map;
mod study;
mod surface;

pub(super) use fit_uncertainty::gradients;

pub use column::{MapColumn, row_width};
pub use fit_uncertainty::{FitUncertainty, FittedCovariance, fit_uncertainty};
pub use matrix::{MatrixKind, cartesian_stiffness};
pub use model::{MapModel, NoMap, SolvedBatch};
pub use refine::RefinedStiffness;
pub use regions::{Level, Region, regions};
pub use statistics::{ColumnStatistics, Quantile, SampledExtreme, column_statistics};
pub use stiffness_map::StiffnessMap;
pub use study::{ColumnStudy, MechanismStudy, StudyPoses};
pub use surface::Surface;
