//! Noise that is known from elsewhere, or a part of it.

use super::earlier_noise::EarlierNoise;
use super::estimated_noise::EstimatedNoise;

/// What is known of the noise before the readings are checked.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum KnownNoise {
    /// Nothing: the readings alone tell it.
    #[default]
    Nothing,
    /// How earlier sessions on the same bench scattered: the readings tell it together with them.
    Earlier(EarlierNoise),
    /// All: the readings are not asked.
    Given(EstimatedNoise),
}

impl KnownNoise {
    /// The noise, where the readings are not asked.
    pub(crate) fn given(&self) -> Option<&EstimatedNoise> {
        match self {
            Self::Given(noise) => Some(noise),
            Self::Nothing | Self::Earlier(_) => None,
        }
    }

    /// What earlier sessions tell of it.
    pub(crate) fn earlier(&self) -> Option<&EarlierNoise> {
        match self {
            Self::Earlier(noise) => Some(noise),
            Self::Nothing | Self::Given(_) => None,
        }
    }
}
