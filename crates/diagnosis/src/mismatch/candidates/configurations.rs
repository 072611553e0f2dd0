//! How the size of an effect changes from configuration to configuration of a part.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_beams::physics::TestObject;

use super::beginnings::largest_fall;
use super::problem_candidates::{CandidateMemo, Candidates};
use crate::mismatch::error::MismatchError;
use crate::mismatch::observed::Observations;
use crate::mismatch::problem::{DiagnosisProblem, SearchOptions};
use crate::search::constants::STRONG_EVIDENCE;

/// What the sizes of all effects follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ConfigurationSizes {
    /// One size for all configurations.
    #[default]
    Common,
    /// In proportion to the slope of the configuration's line.
    Slope,
    /// In proportion to the number that names the configuration.
    Number,
    /// To its square.
    NumberSquared,
    /// To its cube.
    NumberCubed,
    /// To its inverse.
    InverseNumber,
}

impl ConfigurationSizes {
    /// All but the common size.
    const CHANGING: [Self; 5] = [
        Self::Slope,
        Self::Number,
        Self::NumberSquared,
        Self::NumberCubed,
        Self::InverseNumber,
    ];

    /// Factors on the effects, one a configuration, of mean one; `None` where they are not defined, not positive or all the same.
    fn factors(self, slopes: &[f64], numbers: Option<&[f64]>) -> Option<Vec<f64>> {
        let power = match self {
            Self::Common => return None,
            Self::Slope | Self::Number => 1,
            Self::NumberSquared => 2,
            Self::NumberCubed => 3,
            Self::InverseNumber => -1,
        };
        let basis = if self == Self::Slope {
            slopes
        } else {
            numbers?
        };
        let raised: Vec<f64> = basis.iter().map(|value| value.powi(power)).collect();
        let mean = raised.iter().sum::<f64>() / raised.len() as f64;
        let factors: Vec<f64> = raised.iter().map(|value| value / mean).collect();
        let usable = factors
            .iter()
            .all(|factor| factor.is_finite() && *factor > 0.0);
        let differ = factors
            .iter()
            .any(|factor| (factor - 1.0).abs() > SAME_FACTOR);
        (usable && differ).then_some(factors)
    }

    /// What sizes are in proportion to, in words.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Common => "the same in all configurations",
            Self::Slope => "in proportion to the slope of each configuration",
            Self::Number => "in proportion to the number of each configuration",
            Self::NumberSquared => {
                "in proportion to the square of the number of each configuration"
            }
            Self::NumberCubed => "in proportion to the cube of the number of each configuration",
            Self::InverseNumber => "in inverse proportion to the number of each configuration",
        }
    }

    /// Factors on the effects, one a configuration; `None` where one size is all.
    ///
    /// # Arguments
    /// - `slopes`: of the lines of the configurations.
    pub(crate) fn size_factors(
        self,
        observations: &Observations,
        slopes: &[f64],
    ) -> Option<Vec<f64>> {
        let numbers = observations.poses.iter().map(|pose| pose.as_str().parse());
        let numbers: Option<Vec<f64>> = numbers.collect::<Result<_, _>>().ok();
        self.factors(slopes, numbers.as_deref())
    }
}

/// Factors nearer to one than this make no difference (1).
const SAME_FACTOR: f64 = 0.02;

/// The readings with effects whose sizes follow what the readings speak for clearly, and what that is; `None` where one size is enough.
pub(crate) fn changing_sizes(
    problem: &DiagnosisProblem<'_>,
    options: &SearchOptions,
) -> Result<Option<(ConfigurationSizes, Observations)>, MismatchError> {
    let observations = problem.observations;
    if observations.object == TestObject::Robot || observations.cells.len() < 2 {
        return Ok(None);
    }
    let memo = CandidateMemo::default();
    let candidates = Candidates::new(problem, &memo);
    let state = candidates.first_state(options)?;
    let slopes = &state.fitted.model.parameters;
    let largest =
        |observations: &Observations| largest_fall(problem, observations, &state, options);
    let independent = problem.independent_values(&state, &state.fitted.model)?;
    let Some(independent) = independent else {
        return Ok(None);
    };
    let squares = state.fitted.squares;
    let common = largest(observations)?;
    let mut best = (common, None);
    for sizes in ConfigurationSizes::CHANGING {
        let Some(factors) = sizes.size_factors(observations, slopes) else {
            continue;
        };
        let scaled = observations.with_size_factors(&factors);
        let delta_chi2 = largest(&scaled)?;
        if delta_chi2 > best.0 {
            best = (delta_chi2, Some((sizes, scaled)));
        }
    }
    let better = 0.5 * independent * ((squares - common) / (squares - best.0)).ln();
    Ok(best.1.filter(|_| better > STRONG_EVIDENCE))
}
