//! Where a joint fit ends and which values of each factor the data allow.

use stiffbench_numeric::least_squares::{
    CovarianceSettings, LeastSquaresError, LeastSquaresFit, Likelihood, LikelihoodSet,
    LikelihoodSetSettings, ParameterCovariance, ParameterSet, ProfileEnd, ProfileSettings,
    SigmaMode, covariance, minima, spread,
};

use super::error::FitError;
use super::joint::JointProblem;
use super::outcome::{FactorStatus, FitOutcome};
use super::parameters::FitParameters;
use super::problem::FitProblem;

/// Starts beside the given one. Sections that carry the same load (Iz and J of the paper's beams) have two minima; of the starts about
/// half lead to each.
const STARTS: usize = 48;

/// Times a fit is begun again because following a factor led to a better one.
const MOST_RESTARTS: usize = 5;

/// A fit with the likelihood-ratio set of every factor.
#[derive(Debug)]
pub(super) struct Profiled {
    /// Coordinates of the parameters.
    pub(super) set: ParameterSet,
    /// The lowest minimum.
    pub(super) fit: LeastSquaresFit,
    /// Its covariance; `None` if no degrees of freedom are left to estimate the scatter from.
    pub(super) covariance: Option<ParameterCovariance>,
    /// The set of each free factor.
    sets: Vec<LikelihoodSet>,
}

impl Profiled {
    /// Fits from many starts, and follows every factor from every minimum to both sides.
    ///
    /// # Errors
    /// [`FitError`].
    pub(super) fn fit(
        problem: &FitProblem<'_>,
        joint: &mut JointProblem<'_>,
        set: ParameterSet,
        sigma: SigmaMode,
        settings: &CovarianceSettings,
    ) -> Result<Self, FitError> {
        let mut minima = all_minima(problem, joint, &set)?;
        let at_lowest =
            |minima: &[LeastSquaresFit]| covariance_if_any(&set, &minima[0], sigma, settings);
        let mut covariance = at_lowest(&minima)?;
        let mut sets = Vec::new();
        for _ in 0..MOST_RESTARTS {
            let Some(covariance_here) = &covariance else {
                break;
            };
            sets = likelihood_sets(problem, &set, &minima, covariance_here, joint)?;
            let met = sets.iter().filter_map(|found| found.lower_minimum.as_ref());
            let Some(lowest) = met.min_by(|a, b| a.sum_of_squares.total_cmp(&b.sum_of_squares))
            else {
                break;
            };
            let free = set.free_indices().iter();
            let start: Vec<f64> = free.map(|&index| lowest.values[index]).collect();
            let again = joint.minimise(&set.with_start(&start)?)?;
            // A restart that ends no lower has met the floor of rounding.
            if again.objective >= minima[0].objective {
                break;
            }
            minima.insert(0, again);
            covariance = at_lowest(&minima)?;
        }
        let fit = minima.swap_remove(0);
        Ok(Self {
            set,
            fit,
            covariance,
            sets,
        })
    }

    /// Writes intervals into the outcome, and words for factors that have none.
    pub(super) fn describe(&self, parameters: &FitParameters, outcome: &mut FitOutcome) {
        let Some(covariance) = &self.covariance else {
            return;
        };
        for &index in self.set.free_indices() {
            let found = &covariance.estimates[index];
            outcome.estimates[index].describe(parameters, index, found, ["data", "other factors"]);
        }
        for found in &self.sets {
            let estimate = &mut outcome.estimates[found.parameter];
            let scaled = |coordinate: f64| parameters.value(found.parameter, coordinate);
            let at_bound = matches!(estimate.status, FactorStatus::AtBound { .. });
            match (found.closed(), found.parts.as_slice()) {
                (Some(parts), [[lower, _], .., [_, upper]] | [[lower, upper]]) => {
                    estimate.interval_95 = Some([lower, upper].map(|end| scaled(end.value())));
                    if parts.len() > 1 {
                        estimate.islands_95 =
                            parts.into_iter().map(|part| part.map(scaled)).collect();
                    }
                    estimate.status = FactorStatus::Free;
                }
                (_, [[lower, _], .., [_, upper]] | [[lower, upper]]) if !at_bound => {
                    let ends = [lower, upper];
                    let is_lost = |end: &&ProfileEnd| matches!(end, ProfileEnd::NotFollowed { .. });
                    let note = if ends.iter().any(is_lost) {
                        " (the fit could not be followed further)"
                    } else {
                        ""
                    };
                    let words = open_words(ends.map(|end| end.closed().map(scaled)), note);
                    estimate.status = FactorStatus::NotIdentified { words };
                }
                _ => {}
            }
            if found.lower_minimum.is_some() {
                let name = &estimate.name;
                outcome.warnings.push(format!(
                    "{name}: a better fit exists elsewhere; its interval is not to be trusted"
                ));
            }
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
    let of_beams = minima(&mut beams, set, spread, &refits)?;
    let starts = of_beams.into_iter().map(|fit| fit.free_values);
    Ok(minima(joint, set, starts, &refits)?)
}

/// The sets of all free factors.
fn likelihood_sets(
    problem: &FitProblem<'_>,
    set: &ParameterSet,
    minima: &[LeastSquaresFit],
    covariance: &ParameterCovariance,
    joint: &mut JointProblem<'_>,
) -> Result<Vec<LikelihoodSet>, FitError> {
    let settings = LikelihoodSetSettings {
        profile: ProfileSettings {
            refits: joint.settings(),
            ..ProfileSettings::default()
        },
        fold_starts: if problem.physics.is_some() { 0 } else { 4 },
        ..LikelihoodSetSettings::default()
    };
    let parameters = joint.parameters().clone();
    let likelihood = Likelihood {
        again: || JointProblem::new(problem, &parameters).ok(),
        set,
        minima,
        covariance,
        settings: &settings,
    };
    let found = set
        .free_indices()
        .iter()
        .map(|&index| likelihood.of(joint, index));
    Ok(found.collect::<Result<_, _>>()?)
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
pub(crate) fn open_words(ends: [Option<f64>; 2], note: &str) -> String {
    match ends {
        [Some(lower), None] => format!("the data only bound it from below: {lower:.3e}{note}"),
        [None, Some(upper)] => format!("the data only bound it from above: {upper:.3e}{note}"),
        _ => format!("every value within its bounds fits as well{note}"),
    }
}
