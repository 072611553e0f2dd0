//! Where a joint fit ends and which values of each factor the data allow.

use stiffbench_numeric::least_squares::{
    CovarianceSettings, LeastSquaresError, LeastSquaresFit, Likelihood, LikelihoodSet,
    LikelihoodSetSettings, LowerMinimum, ParameterCovariance, ParameterSet, ParameterStatus,
    ProfileEnd, ProfileSettings, SigmaMode, covariance, minima, minimise, spread,
};
use stiffbench_units_and_text::digits::significant;

use super::error::FitError;
use super::joint::JointProblem;
use super::outcome::{FactorCorrelations, FactorEstimate, FactorStatus, FitOutcome};
use super::parameters::FitParameters;
use super::problem::FitProblem;
use super::weighed_problem::WeighedProblem;
use crate::search::Information;

/// Starts beside the given one. Sections that carry the same load (Iz and J of the paper's beams) have two minima; of the starts about
/// half lead to each.
const STARTS: usize = 48;

/// Times a fit is begun again because following a factor led to a better one.
const MOST_RESTARTS: usize = 5;

/// A fit with the likelihood-ratio set of every parameter.
#[derive(Debug)]
pub(crate) struct Profiled {
    /// The lowest minimum.
    pub(crate) fit: LeastSquaresFit,
    /// Its covariance; `None` if no degrees of freedom are left to estimate the scatter from.
    pub(crate) covariance: Option<ParameterCovariance>,
    /// What is known of each free parameter.
    sets: Vec<FoundSet>,
    free: Vec<usize>,
}

/// The values of a parameter that the data allow.
#[derive(Debug)]
enum FoundSet {
    /// The interval of the covariance: the model is linear, and no bound comes near.
    Linear(usize),
    Followed(LikelihoodSet),
}

impl Profiled {
    /// Follows every parameter from every minimum to both sides; begins again where that leads to a lower one.
    ///
    /// Where the model is linear and no bound comes near, the likelihood-ratio interval is that of Student's t.
    ///
    /// # Arguments
    /// - `again`: makes the problem once more.
    /// - `minima`: lowest first.
    /// - `covariance_at`: the covariance at a minimum.
    /// - `settings`: those of its refits are the problem's.
    ///
    /// # Errors
    /// [`FitError`].
    pub(crate) fn fit<P: WeighedProblem>(
        again: &(dyn Fn() -> Option<P> + Sync),
        problem: &mut P,
        (set, mut minima): (&ParameterSet, Vec<LeastSquaresFit>),
        covariance_at: &dyn Fn(
            &LeastSquaresFit,
        ) -> Result<Option<ParameterCovariance>, LeastSquaresError>,
        settings: LikelihoodSetSettings,
    ) -> Result<Self, FitError> {
        let refits = problem.settings();
        let settings = LikelihoodSetSettings {
            profile: ProfileSettings {
                refits,
                ..settings.profile
            },
            ..settings
        };
        // Frames come behind the parameters, and have standard errors alone.
        let own = problem.parameters().parameters().len();
        let free = set.free_indices().iter().copied();
        let free: Vec<usize> = free.filter(|place| *place < own).collect();
        let mut covariance = covariance_at(&minima[0])?;
        let mut sets = Vec::new();
        for _ in 0..MOST_RESTARTS {
            let Some(here) = &covariance else {
                break;
            };
            let likelihood = Likelihood {
                again: || again(),
                set,
                minima: &minima,
                covariance: here,
                settings: &settings,
            };
            sets = Vec::with_capacity(free.len());
            for &place in &free {
                let is_lost = matches!(
                    here.estimates[place].status,
                    ParameterStatus::NotIdentified { .. }
                );
                match problem.is_linear() {
                    // What the covariance does not hold is lost however far it is followed.
                    true if is_lost => continue,
                    true if is_clear_of_bounds(set, &minima[0], here, place) => {
                        sets.push(FoundSet::Linear(place));
                        continue;
                    }
                    _ => {}
                }
                match likelihood.of(problem, place) {
                    Ok(found) => sets.push(FoundSet::Followed(found)),
                    // Too few rows: the value has no interval.
                    Err(LeastSquaresError::NoDegreesOfFreedom { .. }) => {}
                    Err(error) => return Err(error.into()),
                }
            }
            let met = sets.iter().filter_map(FoundSet::lower_minimum);
            let Some(lowest) = met.min_by(|a, b| a.sum_of_squares.total_cmp(&b.sum_of_squares))
            else {
                break;
            };
            let places = set.free_indices().iter();
            let start: Vec<f64> = places.map(|&index| lowest.values[index]).collect();
            let again = minimise(problem, &set.with_start(&start)?, &refits)?;
            // A restart that ends no lower has met the floor of rounding.
            if again.objective >= minima[0].objective {
                break;
            }
            minima.insert(0, again);
            covariance = covariance_at(&minima[0])?;
        }
        Ok(Self {
            fit: minima.swap_remove(0),
            covariance,
            sets,
            free,
        })
    }

    /// What the rows say of ln a of factors and of the compliance of springs, nothing of those that the fit keeps; `None` without a covariance.
    fn information(&self, parameters: &FitParameters) -> Option<Information> {
        let covariance = self.covariance.as_ref()?;
        let variance = match covariance.mode {
            SigmaMode::Known => 1.0,
            SigmaMode::Estimated => covariance.reduced_chi_squared?,
        };
        let column = |place: usize| {
            let free = self.free.iter().position(|free| *free == place);
            let rows = free.and_then(|free| self.fit.jacobian_column(free));
            let unit = parameters.slope(place) * variance.sqrt();
            rows.map_or_else(
                || vec![0.0; self.fit.residuals.len()],
                |rows| rows.iter().map(|row| row / unit).collect(),
            )
        };
        let places = 0..parameters.parameters().len();
        let columns: Vec<Vec<f64>> = places.map(column).collect();
        Some(Information::of_columns(&columns))
    }

    /// Writes what is known of the parameters into an outcome, and what a user should know.
    ///
    /// # Arguments
    /// - `names`: what the rows, and the further parameters, are called.
    /// - `counts`: of the values and of the free parameters.
    pub(crate) fn complete(
        &self,
        outcome: &mut FitOutcome,
        (parameters, set): (&FitParameters, &ParameterSet),
        names: [&str; 2],
        counts: &[String; 2],
    ) {
        outcome.termination = self.fit.termination.to_string();
        outcome.warnings = self.describe(parameters, &mut outcome.estimates, names, counts);
        outcome.information = self.information(parameters);
        let covariance = self.covariance.as_ref();
        outcome.correlation = covariance.map(|of| FactorCorrelations::of(parameters, set, of));
    }

    /// Writes bounds, standard errors and intervals into the estimates, and words for parameters that have none. Gives what a user should know.
    ///
    /// # Arguments
    /// - `names`: what the rows, and the further parameters, are called.
    /// - `counts`: of the values and of the free parameters.
    fn describe(
        &self,
        parameters: &FitParameters,
        estimates: &mut [FactorEstimate],
        names: [&str; 2],
        counts: &[String; 2],
    ) -> Vec<String> {
        let Some(covariance) = &self.covariance else {
            return vec![format!(
                "{} leave no degrees of freedom: the values have no intervals",
                counts.join(" and ")
            )];
        };
        let mut warnings = Vec::new();
        for &place in &self.free {
            let found = &covariance.estimates[place];
            estimates[place].describe(parameters, place, found, names);
        }
        for found in &self.sets {
            let found = match found {
                FoundSet::Linear(place) => {
                    let estimate = &mut estimates[*place];
                    estimate.interval_95 = estimate.quadratic_interval_95;
                    continue;
                }
                FoundSet::Followed(found) => found,
            };
            let place = found.parameter;
            let estimate = &mut estimates[place];
            let scaled = |coordinate: f64| parameters.value(place, coordinate);
            // Zero is the end of what is possible of a spring, not of what was looked at: an interval may end there.
            let rigid = parameters.bounds(place)[0].max(0.0);
            let is_spring = !estimate.parameter.is_factor();
            let closed = |end: &ProfileEnd| {
                let is_rigid = is_spring && end.value() <= rigid;
                end.closed().or(is_rigid.then_some(rigid)).map(scaled)
            };
            let parts = found
                .parts
                .iter()
                .map(|[lower, upper]| Some([closed(lower)?, closed(upper)?]));
            let parts: Option<Vec<[f64; 2]>> = parts.collect();
            let is_open = matches!(estimate.status, FactorStatus::NotIdentified { .. });
            let at_bound = matches!(estimate.status, FactorStatus::AtBound { .. });
            match (parts.as_deref(), found.parts.as_slice()) {
                (Some([[lower, _], .., [_, upper]] | [[lower, upper]]), _) => {
                    estimate.interval_95 = Some([*lower, *upper]);
                    if let Some(islands) = parts.filter(|parts| parts.len() > 1) {
                        estimate.islands_95 = islands;
                    }
                    if is_open {
                        estimate.status = FactorStatus::Free;
                    }
                }
                (_, [[lower, _], .., [_, upper]] | [[lower, upper]]) if !at_bound => {
                    let ends = [lower, upper];
                    let is_lost = |end: &&ProfileEnd| matches!(end, ProfileEnd::NotFollowed { .. });
                    let note = if ends.iter().any(is_lost) {
                        " (the fit could not be followed further)"
                    } else {
                        ""
                    };
                    let words = open_words(ends.map(closed), note);
                    estimate.status = FactorStatus::NotIdentified { words };
                }
                _ => {}
            }
            if found.lower_minimum.is_some() {
                let name = &estimate.name;
                warnings.push(format!(
                    "{name}: a better fit exists elsewhere; do not trust its interval"
                ));
            }
        }
        warnings
    }
}

impl FoundSet {
    fn lower_minimum(&self) -> Option<&LowerMinimum> {
        match self {
            Self::Linear(_) => None,
            Self::Followed(found) => found.lower_minimum.as_ref(),
        }
    }
}

/// The minima that starts spread over the bounds lead to, lowest first.
pub(super) fn all_minima(
    problem: &FitProblem<'_>,
    joint: &mut JointProblem<'_>,
    set: &ParameterSet,
) -> Result<Vec<LeastSquaresFit>, FitError> {
    let refits = joint.settings();
    let spread = spread(set).take(STARTS);
    if problem.physics.is_none() {
        return Ok(minima(joint, set, spread, &refits)?);
    }
    // Physics beside the beams costs a hundred times as much, and has its minima where the beams have theirs.
    let beams = FitProblem {
        physics: None,
        ..*problem
    };
    let mut beams = JointProblem::new(&beams, joint.parameters())?;
    Ok(match minima(&mut beams, set, spread, &refits) {
        Ok(of_beams) => {
            let starts = of_beams.into_iter().map(|fit| fit.free_values);
            minima(joint, set, starts, &refits)?
        }
        // Where the physics is all that yields.
        Err(LeastSquaresError::StartHasNoValue { .. }) => {
            minima(joint, set, std::iter::empty(), &refits)?
        }
        Err(error) => return Err(error.into()),
    })
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

/// The covariance at the end of a fit; `None` without degrees of freedom to estimate the scatter from.
///
/// # Errors
/// [`LeastSquaresError`].
pub(crate) fn covariance_if_any(
    set: &ParameterSet,
    fit: &LeastSquaresFit,
    sigma: SigmaMode,
    settings: &CovarianceSettings,
) -> Result<Option<ParameterCovariance>, LeastSquaresError> {
    match covariance(set, fit, sigma, settings) {
        Ok(covariance) => Ok(Some(covariance)),
        Err(LeastSquaresError::NoDegreesOfFreedom { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// What the data say of a factor whose set has an open end.
///
/// # Arguments
/// - `ends`: its lower and upper end; `None` of an open one.
/// - `note`: words behind.
fn open_words(ends: [Option<f64>; 2], note: &str) -> String {
    match ends {
        [Some(lower), None] => format!(
            "the data only bound it from below: {}{note}",
            significant(lower, 4)
        ),
        [None, Some(upper)] => format!(
            "the data only bound it from above: {}{note}",
            significant(upper, 4)
        ),
        _ => format!("every value within its bounds fits as well{note}"),
    }
}
