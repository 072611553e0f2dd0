//! Which values of each parameter the load cases allow.

use stiffbench_numeric::least_squares::{
    LeastSquaresError, LeastSquaresFit, Likelihood, LikelihoodSetSettings, ParameterCovariance,
    ParameterSet, ProfileSettings,
};

use crate::fit::{FactorStatus, open_words};

use super::error::LoadCaseFitError;
use super::held_out::WeighedProblem;
use super::outcome::LoadCaseFit;
use super::problem::LoadCaseProblem;

/// Writes standard errors, 95 % intervals and what is known of each parameter into an outcome.
///
/// Where the model is linear and no bound comes near, the likelihood-ratio interval is that of Student's t; else the profile is followed.
///
/// # Arguments
/// - `again`: makes the problem of the fit once more.
///
/// # Errors
/// [`LoadCaseFitError`].
pub(super) fn add_intervals<'a>(
    again: &(dyn Fn() -> Option<LoadCaseProblem<'a>> + Sync),
    set: &ParameterSet,
    fit: &LeastSquaresFit,
    covariance: &ParameterCovariance,
    outcome: &mut LoadCaseFit,
) -> Result<(), LoadCaseFitError> {
    let mut problem: Option<LoadCaseProblem<'a>> = again();
    let Some(problem) = &mut problem else {
        return Ok(());
    };
    let parameters = problem.parameters().clone();
    let settings = LikelihoodSetSettings {
        profile: ProfileSettings {
            refits: problem.settings(),
            ..ProfileSettings::default()
        },
        fold_starts: 0,
        draws: 0,
        ..LikelihoodSetSettings::default()
    };
    let minima = std::slice::from_ref(fit);
    let own = parameters.parameters().len();
    for &place in set.free_indices().iter().filter(|place| **place < own) {
        let of = |coordinate: f64| parameters.value(place, coordinate);
        let estimate = &mut outcome.estimates[place];
        let found = &covariance.estimates[place];
        estimate.describe(&parameters, place, found, ["poses", "others"]);
        if matches!(estimate.status, FactorStatus::NotIdentified { .. }) {
            continue;
        }
        if problem.is_linear() && is_clear_of_bounds(set, fit, covariance, place) {
            estimate.interval_95 = estimate.quadratic_interval_95;
            continue;
        }
        let likelihood = Likelihood {
            again: || again(),
            set,
            minima,
            covariance,
            settings: &settings,
        };
        let followed = match likelihood.of(problem, place) {
            // Too few components: the value has no interval.
            Err(LeastSquaresError::NoDegreesOfFreedom { .. }) => continue,
            followed => followed?,
        };
        let bounds = parameters.bounds(place);
        let ends = followed.parts.first().zip(followed.parts.last());
        let Some(([lower, _], [_, upper])) = ends else {
            continue;
        };
        // Zero is the end of what is possible, not of what was looked at: an interval may end there.
        let is_rigid = |value: f64| !estimate.parameter.is_factor() && value <= bounds[0].max(0.0);
        let low = lower
            .closed()
            .or_else(|| is_rigid(lower.value()).then_some(bounds[0]));
        let ends = [low, upper.closed()].map(|end| end.map(of));
        if let [Some(low), Some(high)] = ends {
            estimate.interval_95 = Some([low, high]);
            continue;
        }
        let words = open_words(ends, "");
        if !matches!(estimate.status, FactorStatus::AtBound { .. }) {
            estimate.status = FactorStatus::NotIdentified { words };
        }
    }
    Ok(())
}

/// Whether, at both ends of the interval of a parameter of a linear model, all parameters stay within their bounds.
fn is_clear_of_bounds(
    set: &ParameterSet,
    fit: &LeastSquaresFit,
    covariance: &ParameterCovariance,
    place: usize,
) -> bool {
    let Some(ends) = covariance.estimates[place].interval_95 else {
        return false;
    };
    let (Some(own), true) = (
        covariance.of(place, place),
        fit.at_bound.iter().all(Option::is_none),
    ) else {
        return false;
    };
    let free = set.free_indices().iter().zip(set.free_bounds());
    ends.iter().all(|end| {
        free.clone().all(|(&other, (lower, upper))| {
            let Some(common) = covariance.of(place, other) else {
                return false;
            };
            let there = fit.values[other] + common / own * (end - fit.values[place]);
            (lower..=upper).contains(&there)
        })
    })
}
