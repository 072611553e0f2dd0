//! What comes with the program: robots, procedures, instrument descriptions and explanations, embedded.

mod explanations;
mod files;
mod instruments;

pub use explanations::{Explanation, error_explanations, verdict_explanations};
pub use files::{
    DEFAULT_PROCEDURE, ShippedText, shipped_instruments, shipped_procedure, shipped_procedures,
    shipped_robot, shipped_robots,
};
pub use instruments::{RegistryError, nearest_and_all, shipped_instrument, unknown_name};
