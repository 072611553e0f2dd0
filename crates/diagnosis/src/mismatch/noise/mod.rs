//! How much readings scatter, estimated or known beforehand, and the covariance that this gives them.
//!
//! The scatter of a gauge is estimated in `restricted_likelihood.rs`; in the recording of a part, which repeats nothing, in `part_noise.rs`.
//!
//! Owner: [`NoiseCovariance`]. It imports the readings (`observed`).

mod cell_slopes;
mod covariance;
mod earlier_noise;
mod estimated_noise;
mod force_scatter;
mod free_means;
mod known_noise;
mod part_noise;
mod restricted_likelihood;
mod rounded;
mod tails;

pub use cell_slopes::{CellSlopes, SeriesSlopes};
pub(crate) use covariance::{ForceReading, NoiseCovariance, ReadForces, groups};
pub use earlier_noise::EarlierNoise;
pub use estimated_noise::{EstimatedNoise, NoiseBasis, StatedScatter};
pub(crate) use force_scatter::{
    force_within_steps, loads_off, positions_of_repeats, positions_off,
};
pub(crate) use free_means::fixed_part;
pub use known_noise::KnownNoise;
pub(crate) use restricted_likelihood::estimate_noise;
pub(crate) use rounded::{LEAST_COUNTED, RoundedNoise};
pub(crate) use tails::{Beside, Tails, chance_if_normal};
