//! What a robot does over its workspace rather than in single poses.
//!
//! [`WorkspaceSample`] draws poses within the limits and says where the end is in each; nothing is left out of its counts.

mod extreme;
mod workspace;

pub use extreme::{Extreme, RefinedExtreme};
pub use workspace::{EndPoint, UnreachablePose, WorkspaceError, WorkspacePlan, WorkspaceSample};
