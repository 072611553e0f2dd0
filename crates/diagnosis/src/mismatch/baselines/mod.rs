//! The linear structure that readings are compared with: a robot with its factors, or the line of a part without a robot file.
//!
//! Owner: [`Baseline`]. It imports the readings (`observed`).

mod baseline;
mod line;
mod part_units;
mod robot_baseline;
mod robot_solver;

pub use baseline::{Baseline, BaselineParameter, ElementCompliance, PoseSolver, StructureColumn};
pub(crate) use baseline::{prior_sd, start};
pub(crate) use line::part_observations;
pub use line::{Line, test_object};
pub use part_units::{PartUnit, PartUnits};
pub use robot_baseline::RobotBaseline;
