//! Software benches and written figures for programs.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::bench::NoiseModel;
use crate::physics::Effect;
use crate::robot::{FittingFactors, TrackerFrames};

/// A simulated session.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
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
    /// The tracker of absolute positions; `null` of other sessions.
    pub tracker: Option<TrackerReport>,
}

/// Where a tracker stands against the robot's base, and which point of the tool it measures.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct TrackerReport {
    /// Position of the robot's base in the axes of the tracker, mm.
    pub base_mm: [f64; 3],
    /// Rotation vector from the axes of the base to those of the tracker, degrees.
    pub rotation_vector_deg: [f64; 3],
    /// The measured point from the tool centre, in the axes of the tool, mm.
    pub tool_point_mm: [f64; 3],
}

impl From<&TrackerFrames> for TrackerReport {
    fn from(frames: &TrackerFrames) -> Self {
        let mm = |metres: [f64; 3]| metres.map(|metres| 1e3 * metres);
        Self {
            base_mm: mm(frames.base_m),
            rotation_vector_deg: frames.rotation_vector_rad().map(f64::to_degrees),
            tool_point_mm: mm(frames.tool_point_m),
        }
    }
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

/// A share of a map that was written.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
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
