//! The linear structure that readings are compared with: a robot with its factors, or the line of a part without a robot file.
//!
//! Owner: [`Baseline`]. It imports the readings (`observed`).

mod baseline;
mod part_units;
mod robot_baseline;
mod robot_solver;
mod specimen;

pub use baseline::{Baseline, BaselineParameter, ElementCompliance, PoseSolver, StructureColumn};
pub(crate) use baseline::{prior_sd, start};
pub use part_units::{PartUnit, PartUnits};
pub use robot_baseline::RobotBaseline;
pub(crate) use specimen::part_observations;
pub use specimen::{Line, SPECIMEN_JOINT, test_object};
