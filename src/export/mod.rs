//! Models and tables for other programs. A model is a robot with its springs, friction and play as MJCF, SDF and URDF, and as a table.
//!
//! [`ExportModel`] holds what all of them are written from. MJCF has everything: the beams as six springs each ([`LumpedModel`]). SDF has the
//! joints with springs and friction, URDF the joints with friction; what they cannot hold stands in their comments ([`KinematicTree`]).
//!
//! [`tidy`] holds measurements and results as tables for statistics programs and spreadsheets.

mod inertia;
mod kinematics;
mod lumped;
mod mjcf;
mod model;
mod sdf;
mod table;
pub mod tidy;
mod urdf;
mod xml;

pub use inertia::{Inertia, Rod};
pub use kinematics::{KinematicJoint, KinematicLink, KinematicTree};
pub use lumped::{LumpedBody, LumpedJoint, LumpedModel, LumpedParts, Weld};
pub use model::{ExportModel, NotedFile};
pub use table::{ExportTable, ParameterRow, PoseRow, SpringStiffness};
pub use xml::number;
