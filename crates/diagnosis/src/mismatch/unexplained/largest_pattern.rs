//! The largest pattern that a model leaves.

use super::patterns::{Patterns, ResidualPattern, autocorrelation_p};
use crate::mismatch::error::MismatchError;
use crate::mismatch::observed::Observations;
use crate::mismatch::problem::{DiagnosisProblem, State};
use crate::search::{NullDistribution, WhiteSpace};

/// The largest pattern that a model leaves.
#[derive(Debug, Clone)]
pub(crate) struct UnexplainedStructure {
    pub(crate) pattern: Option<ResidualPattern>,
    pub(crate) delta_chi2: f64,
    pub(crate) p: f64,
}

/// The largest pattern of each stratum that a state leaves, and its fall of the squares.
pub(crate) fn largest_patterns(
    problem: &DiagnosisProblem<'_>,
    state: &State,
    space: &WhiteSpace,
    residuals: &[f64],
) -> Result<Vec<(f64, ResidualPattern)>, MismatchError> {
    let slopes = problem.slope(&state.fitted.model)?;
    Ok(Patterns::new(problem.observations, &slopes.compliance).largest(space, residuals))
}

/// The largest pattern that a state leaves.
///
/// # Arguments
/// - `of_noise`: Δχ² of the largest pattern on noise alone.
pub(crate) fn unexplained(
    problem: &DiagnosisProblem<'_>,
    state: &State,
    of_noise: &NullDistribution,
) -> Result<UnexplainedStructure, MismatchError> {
    let (space, residuals) = problem.space(state)?;
    let patterns = largest_patterns(problem, state, &space, &residuals)?;
    Ok(largest_left(
        problem.observations,
        &patterns,
        &residuals,
        of_noise,
    ))
}

/// The largest of some patterns that are left in white residuals.
pub(crate) fn largest_left(
    observations: &Observations,
    patterns: &[(f64, ResidualPattern)],
    residuals: &[f64],
    of_noise: &NullDistribution,
) -> UnexplainedStructure {
    // Of equal ones the first.
    let best = patterns.iter().rev().max_by(|a, b| a.0.total_cmp(&b.0));
    let delta_chi2 = best.map_or(0.0, |(delta_chi2, _)| *delta_chi2);
    let mut p = of_noise.p(delta_chi2);
    let mut pattern = best.map(|(_, pattern)| pattern.clone());
    if let Some(rhythm) = autocorrelation_p(observations, residuals) {
        // Two tests share the level.
        if rhythm < p {
            pattern = pattern.map(ResidualPattern::of_the_rest);
        }
        p = (2.0 * p.min(rhythm)).min(1.0);
    }
    UnexplainedStructure {
        pattern,
        delta_chi2,
        p,
    }
}
