//! Which of the two quantities of a part answers the other.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Which of the two quantities answers the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ResponseVariable {
    /// The load is set, the displacement read.
    #[default]
    Displacement,
    /// The displacement is set, the force read, as in tests that control strain.
    Force,
}

impl ResponseVariable {
    /// Names of what was set and of what answers.
    #[must_use]
    pub fn set_and_answer(self) -> [&'static str; 2] {
        match self {
            Self::Displacement => ["force", "displacement"],
            Self::Force => ["displacement", "force"],
        }
    }

    /// From where the path of what was set is followed: a force counts from zero; a displacement, whose zero is arbitrary, from its first value.
    pub(super) fn origin(self, driver: &[f64]) -> f64 {
        match self {
            Self::Displacement => 0.0,
            Self::Force => driver.first().copied().unwrap_or(0.0),
        }
    }
}

/// What the clock has against a response that was stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ResponseDoubt {
    /// The displacement was stated to answer, and was set.
    #[error(
        "a force that was set: the displacement is a ramp or a sine of time in every branch, so it was set and the force was measured; diagnose with \
         --response force"
    )]
    DisplacementWasSet,
    /// The force was stated to answer, and was set.
    #[error(
        "a displacement that was set: the force is a ramp or a sine of time in every branch, so it was set and the displacement was measured; \
         diagnose with --response displacement"
    )]
    ForceWasSet,
}

impl ResponseDoubt {
    /// The doubt about a response where the clock shows another.
    pub(super) fn about(
        stated: ResponseVariable,
        by_clock: Option<ResponseVariable>,
    ) -> Option<Self> {
        by_clock.filter(|shown| *shown != stated)?;
        Some(match stated {
            ResponseVariable::Displacement => Self::DisplacementWasSet,
            ResponseVariable::Force => Self::ForceWasSet,
        })
    }
}
