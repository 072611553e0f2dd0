//! What a search is to do.

use stiffbench_beams::physics::{Effect, Law};

use crate::mismatch::noise::KnownNoise;

/// What a search is to do; by default with all laws, no known physics, seed 0 and noise from the readings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SearchOptions {
    /// Laws that are left out.
    pub without: Vec<Law>,
    /// Physics that is known to act: no candidate, its values fitted again with every model.
    pub known_effects: Vec<Effect>,
    /// Seed of the limits' draws.
    pub seed: u64,
    /// What is known of the noise before the readings are checked.
    pub noise: KnownNoise,
}
