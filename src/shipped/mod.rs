//! What comes with the program: robots, procedures, instrument descriptions and explanations, embedded.

mod explanations;
mod instruments;
mod procedures;
mod robots;

pub use explanations::{Explanation, error_explanations, verdict_explanations};
pub use instruments::{
    RegistryError, ShippedInstrument, shipped_instrument, shipped_instruments, unknown_name,
};
pub use procedures::{DEFAULT_PROCEDURE, shipped_procedure, shipped_procedures};
pub use robots::{shipped_robot, shipped_robots};
