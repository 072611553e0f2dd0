//! Where a joint fit ends and how far each factor may move from there.

use stiffbench_numeric::least_squares::{
    Bound, Covariance, CovarianceSettings, LeastSquaresError, LeastSquaresFit, ParameterSet,
    ParameterStatus, ProfileEnd, ProfileInterval, ProfileSettings, SigmaMode, covariance, profile,
};

use super::error::FitError;
use super::joint::JointProblem;
use super::outcome::{FactorStatus, FitOutcome};

/// Times a fit is begun again because following a factor led to a better one. Two factors that can hardly be told apart lie in a
/// long valley with a few shallow basins; more than a handful has not been seen.
const MOST_RESTARTS: usize = 5;

/// A fit with the profile of every factor it determines.
#[derive(Debug)]
pub(super) struct Profiled {
    /// The parameters, starting where the last fit started.
    pub(super) set: ParameterSet,
    /// The fit.
    pub(super) fit: LeastSquaresFit,
    /// Its covariance; `None` if no degrees of freedom are left to estimate the scatter from.
    pub(super) covariance: Option<Covariance>,
    /// Profile of each determined factor, by place among all factors.
    profiles: Vec<ProfileInterval>,
}

impl Profiled {
    /// Fits, follows every determined factor to both sides, and begins again from any better fit met on the way.
    ///
    /// # Errors
    /// [`FitError::LeastSquares`].
    pub(super) fn fit(
        problem: &mut JointProblem<'_>,
        set: ParameterSet,
        sigma: SigmaMode,
        settings: &CovarianceSettings,
    ) -> Result<Self, FitError> {
        let mut profiled = Self::once(problem, set, sigma, settings)?;
        for _ in 0..MOST_RESTARTS {
            let lower = profiled
                .profiles
                .iter()
                .filter_map(|profile| profile.lower_minimum.as_ref());
            let Some(lowest) = lower.min_by(|a, b| a.sum_of_squares.total_cmp(&b.sum_of_squares))
            else {
                break;
            };
            let free: Vec<f64> = profiled
                .set
                .free_indices()
                .iter()
                .map(|&index| lowest.values[index])
                .collect();
            let set = profiled.set.with_start(&free)?;
            let again = Self::once(problem, set, sigma, settings)?;
            // A restart that ends no lower has met the floor of rounding.
            if again.fit.objective >= profiled.fit.objective {
                break;
            }
            profiled = again;
        }
        Ok(profiled)
    }

    fn once(
        problem: &mut JointProblem<'_>,
        set: ParameterSet,
        sigma: SigmaMode,
        settings: &CovarianceSettings,
    ) -> Result<Self, FitError> {
        let fit = problem.minimise(&set)?;
        let covariance = match covariance(&set, &fit, sigma, settings) {
            Ok(covariance) => Some(covariance),
            Err(LeastSquaresError::NoDegreesOfFreedom { .. }) => None,
            Err(error) => return Err(error.into()),
        };
        let mut profiles = Vec::new();
        if let Some(covariance) = &covariance {
            let settings = ProfileSettings {
                refits: problem.settings(),
                ..ProfileSettings::default()
            };
            for &index in set.free_indices() {
                if covariance.estimates[index].status == ParameterStatus::Free {
                    profiles.push(profile(problem, &set, &fit, covariance, index, &settings)?);
                }
            }
        }
        Ok(Self {
            set,
            fit,
            covariance,
            profiles,
        })
    }

    /// Writes intervals into the outcome, and words for factors that have none.
    pub(super) fn describe(&self, outcome: &mut FitOutcome) {
        let Some(covariance) = &self.covariance else {
            return;
        };
        for &index in self.set.free_indices() {
            let estimate = &mut outcome.estimates[index];
            let start = estimate.start;
            let scaled = |ln_ratio: f64| start * ln_ratio.exp();
            estimate.quadratic_interval_95 = covariance.estimates[index]
                .interval_95
                .map(|interval| interval.map(scaled));
            match covariance.estimates[index].status {
                ParameterStatus::AtBound(bound) => {
                    estimate.status = at_bound(bound == Bound::Upper);
                }
                ParameterStatus::NotIdentified { .. } => {
                    let words =
                        "any value fits as well together with the right values of other factors"
                            .to_owned();
                    estimate.status = FactorStatus::NotIdentified { words };
                }
                _ => {}
            }
        }
        for profile in &self.profiles {
            let estimate = &mut outcome.estimates[profile.parameter];
            let start = estimate.start;
            let ends = [&profile.lower, &profile.upper]
                .map(|end| end.closed().map(|ln_ratio| start * ln_ratio.exp()));
            match ends {
                [Some(lower), Some(upper)] => estimate.interval_95 = Some([lower, upper]),
                [lower, upper] => {
                    let words = open_words(lower, upper, &profile.lower, &profile.upper);
                    estimate.status = FactorStatus::NotIdentified { words };
                }
            }
            if profile.lower_minimum.is_some() {
                let name = estimate.name;
                outcome.warnings.push(format!(
                    "{name}: a better fit exists elsewhere; its interval is not to be trusted"
                ));
            }
        }
    }
}

fn at_bound(upper: bool) -> FactorStatus {
    let side = if upper { "upper" } else { "lower" };
    let words = format!(
        "the data push it beyond its {side} bound; the other factors are given for this value"
    );
    FactorStatus::AtBound { upper, words }
}

/// What the data say of a factor whose interval has an open end.
fn open_words(
    lower: Option<f64>,
    upper: Option<f64>,
    low: &ProfileEnd,
    high: &ProfileEnd,
) -> String {
    let followed = |end: &ProfileEnd| !matches!(end, ProfileEnd::NotFollowed { .. });
    let note = if followed(low) && followed(high) {
        ""
    } else {
        " (the fit could not be followed further)"
    };
    match (lower, upper) {
        (Some(lower), None) => format!("the data only say that it is above {lower:.3e}{note}"),
        (None, Some(upper)) => format!("the data only say that it is below {upper:.3e}{note}"),
        _ => format!("every value within its bounds fits as well{note}"),
    }
}
