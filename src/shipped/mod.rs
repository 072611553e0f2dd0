//! What comes with the program: robots, procedures and instrument descriptions, embedded.

mod instruments;
mod procedures;
mod robots;

pub use instruments::{
    RegistryError, ShippedInstrument, shipped_instrument, shipped_instruments, unknown_name,
};
pub use procedures::{DEFAULT_PROCEDURE, shipped_procedure, shipped_procedures};
pub use robots::{shipped_robot, shipped_robots};
