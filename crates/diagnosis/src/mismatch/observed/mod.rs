//! What was measured, laid out for everything else in this module: poses, cells, runs and readings.
//!
//! Owner: [`Observations`]. It imports no other room.

mod beginnings;
mod joined_sessions;
mod observations;
mod plan;
mod reading_noise;
mod recorded_history;
#[cfg(test)]
pub(crate) mod tests;
mod unloaded_zero;

pub use beginnings::Beginnings;
pub(crate) use joined_sessions::NoisePart;
pub use observations::{
    GaugeSteps, Observations, ObservedCell, ObservedReading, ObservedRun, ObservedSession, Recorded,
};
pub(crate) use observations::{OnPath, ReadingClock, about_means, load_point};
pub use plan::{PlannedCell, PlannedLoad};
pub use reading_noise::{GaugeNoise, ReadingNoise};
