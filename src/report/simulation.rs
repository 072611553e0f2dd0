//! Software benches and written figures for programs.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::bench::NoiseModel;
use crate::physics::Effect;
use crate::robot::FittingFactors;

/// A simulated session.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SimulationReport {
    /// Its folder.
    pub folder: PathBuf,
    /// Number of readings.
    pub readings: usize,
    /// Seed of the noise.
    pub seed: u64,
    /// Name of the procedure.
    pub procedure: String,
    /// Minutes that it would take on a real bench.
    pub minutes: f64,
    /// Name of the mechanism.
    pub mechanism: String,
    /// The true factors.
    pub factors: FittingFactors,
    /// Effects beside the beams.
    pub physics: Vec<Effect>,
    /// Standard deviations and steps of the noise, SI.
    pub noise: NoiseModel,
}

/// A software bench that waits for a session.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct EmulationReport {
    /// The ports.
    pub ports: SimulatedGauges<PathBuf>,
    /// Names of the instrument descriptions.
    pub instruments: SimulatedGauges<String>,
    /// Name of the procedure.
    pub procedure: String,
    /// Seed of the noise.
    pub seed: u64,
    /// Bench seconds in a real one.
    pub speed: f64,
}

/// One thing of each gauge.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SimulatedGauges<T> {
    /// Of the force gauge.
    pub force: T,
    /// Of the displacement gauge.
    pub displacement: T,
}

/// A figure that was written.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct FigureReport {
    /// Its name.
    pub figure: &'static str,
    /// Its files.
    pub files: Vec<PathBuf>,
}

/// A share of a map that was written.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ShardReport {
    /// Which share of how many, as `K/N`.
    pub shard: String,
    /// Its file.
    pub file: PathBuf,
    /// Poses in it.
    pub poses: usize,
    /// Points of the whole map.
    pub of: usize,
}
