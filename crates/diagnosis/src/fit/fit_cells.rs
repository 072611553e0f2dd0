//! The joint least-squares fit: all chosen cells at once, with intervals and a judgement on cells it did not see.

use stiffbench_beams::robot::FittingFactors;
use stiffbench_numeric::least_squares::{
    CovarianceSettings, LeastSquaresFit, LikelihoodSetSettings, ParameterCovariance,
    SearchSettings, SigmaMode, search_for_lower_minimum,
};
use stiffbench_numeric::statistics::{chi_squared_upper_tail, f_upper_tail};
use stiffbench_units_and_text::test_point::PoseId;

use super::error::FitError;
use super::intervals::{Profiled, all_minima, covariance_if_any};
use super::joint::JointProblem;
use super::measured::{MeasuredStiffness, WeightBasis};
use super::outcome::{FactorEstimate, FitAgreement, FitMethod, FitOutcome};
use super::parameters::FitParameters;
use super::problem::FitProblem;
use super::weighed_problem::{WeighedProblem, leave_poses_out};
use crate::mismatch::StatedScatter;
use crate::parameters::{ParameterChoice, place_of};
use stiffbench_units_and_text::count::counted;

/// What a fit is asked to do.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FitOptions {
    /// Poses to fit; all others are held out. `None`: all poses, assessed by leaving each out in turn.
    pub train: Option<Vec<PoseId>>,
    /// Which parameters may move.
    pub choice: ParameterChoice,
    /// Where the standard deviation of the residuals comes from; `None`: known if the data state uncertainties.
    pub sigma: Option<SigmaMode>,
    /// What is stated of the scatter of load cases; `None` as their repeats show it, or as the fit leaves it.
    pub scatter: Option<StatedScatter>,
}

/// Fits the factors of a mechanism to measured stiffness.
///
/// # Errors
/// [`FitError`]; a search that did not converge is a result, not an error.
pub fn fit_cells(problem: &FitProblem<'_>, options: &FitOptions) -> Result<FitOutcome, FitError> {
    let measured = problem.measured;
    let in_training = |pose: &PoseId| {
        options
            .train
            .as_ref()
            .is_none_or(|train| train.contains(pose))
    };
    let training = measured.select(|cell| in_training(&cell.pose));
    if training.values() == 0 {
        let train = options
            .train
            .iter()
            .flatten()
            .map(PoseId::as_str)
            .collect::<Vec<_>>()
            .join(", ");
        return Err(FitError::NoTrainingCells {
            cells: measured.cells.len(),
            train,
        });
    }
    let parameters = FitParameters::new(&problem.measuring(&training), &options.choice)?;
    let set = parameters.set()?;
    let free = set.free_indices().len();
    if training.values() < free {
        return Err(FitError::TooFewCells {
            free,
            cells: training.values(),
        });
    }
    let training = training.weighted_by_residuals(problem, &parameters, &set)?;
    let sigma = options.sigma.unwrap_or(if training.has_uncertainties() {
        SigmaMode::Known
    } else {
        SigmaMode::Estimated
    });
    let trained = problem.measuring(&training);
    let mut joint = JointProblem::new(&trained, &parameters)?;
    let settings = CovarianceSettings {
        known_dof: training.basis.dof(),
        ..CovarianceSettings::default()
    };
    let minima = all_minima(&trained, &mut joint, &set)?;
    let covariance = |fit: &LeastSquaresFit| covariance_if_any(&set, fit, sigma, &settings);
    let again = || JointProblem::new(&trained, &parameters).ok();
    // Physics beside the beams costs a hundred times as much.
    let fold_starts = if problem.physics.is_some() { 0 } else { 4 };
    let likelihood = LikelihoodSetSettings {
        fold_starts,
        ..LikelihoodSetSettings::default()
    };
    let profiled = Profiled::fit(&again, &mut joint, (&set, minima), &covariance, likelihood)?;
    let fit = &profiled.fit;
    let factors = joint.factors(&fit.values);
    let predicted = JointProblem::new(problem, &parameters)?.predict(&fit.values)?;
    let is_held_out = |pose: &PoseId| !in_training(pose);
    let method = FitMethod::LeastSquares;
    let mut outcome = FitOutcome::plain(
        method,
        problem,
        &parameters,
        &factors,
        &predicted,
        is_held_out,
    );
    let counts = [
        counted(training.values(), "cell"),
        counted(free, "free factor"),
    ];
    let names = ["data", "other factors"];
    profiled.complete(&mut outcome, (&parameters, &set), names, &counts);
    let covariance = profiled.covariance.as_ref();
    outcome.agreement =
        covariance.map(|covariance| agreement(fit, covariance, &training, &parameters));
    if options.train.is_none() {
        let mut poses: Vec<&PoseId> = Vec::new();
        let cells = training.cells.iter().map(|one| &one.cell);
        let all = cells.chain(training.across.iter().map(|one| &one.cell));
        let poses: Vec<usize> = all.map(|cell| place_of(&mut poses, &&cell.pose)).collect();
        let unseen = leave_poses_out(&mut joint, &set, &poses)?;
        for (cell, unseen) in outcome.cells.iter_mut().zip(unseen) {
            cell.predicted_without_its_pose_n_per_m = unseen;
        }
    }
    add_warnings(&mut outcome, fit);
    Ok(outcome)
}

/// Looks for factors that fit better than the minimum least squares finds from `start`: a particle swarm and a simplex within the bounds.
///
/// Returns the better factors, or `None` if none were found.
///
/// # Errors
/// [`FitError`].
pub fn find_lower_minimum(
    problem: &FitProblem<'_>,
    choice: &ParameterChoice,
    settings: &SearchSettings,
) -> Result<Option<FittingFactors>, FitError> {
    let parameters = FitParameters::new(problem, choice)?;
    let set = parameters.set()?;
    let mut joint = JointProblem::new(problem, &parameters)?;
    let fit = joint.minimise(&set)?;
    let lower = search_for_lower_minimum(&mut joint, &set, &fit, settings)?;
    Ok(lower.map(|lower| joint.factors(&lower.values)))
}

fn agreement(
    fit: &LeastSquaresFit,
    covariance: &ParameterCovariance,
    training: &MeasuredStiffness,
    parameters: &FitParameters,
) -> FitAgreement {
    let idle: Vec<&str> = parameters.without_effect().collect();
    let p_value = match covariance.mode {
        // Weights from the residuals cannot be tested by them.
        SigmaMode::Known
            if covariance.dof > 0
                && !matches!(training.basis, WeightBasis::FromResiduals { .. }) =>
        {
            let (squares, dof) = (fit.sum_of_squares(), covariance.dof as f64);
            let repeats = training.basis.dof();
            if repeats.is_finite() {
                // Lack of fit against a scatter that was itself estimated from repeats (Draper & Smith, section 2.1).
                f_upper_tail(squares / dof, dof, repeats)
            } else {
                chi_squared_upper_tail(squares, dof)
            }
        }
        _ => None,
    };
    FitAgreement {
        sigma: covariance.mode,
        basis: training.basis,
        component_sd: [None; 2],
        dof: covariance.dof,
        reduced_chi_squared: covariance.reduced_chi_squared,
        p_value,
        rank: covariance.rank,
        free: covariance.estimated + idle.len(),
        condition: if idle.is_empty() {
            covariance.condition_number
        } else {
            f64::INFINITY
        },
        not_determined: covariance
            .unidentified
            .iter()
            .map(ToString::to_string)
            .collect(),
    }
}

/// What a user should know before using the numbers.
fn add_warnings(outcome: &mut FitOutcome, fit: &LeastSquaresFit) {
    if !fit.termination.is_converged() {
        outcome.warnings.push(format!(
            "the fit {}: its values are not a minimum",
            outcome.termination
        ));
    }
    let estimates = outcome.estimates.iter();
    let disagreements: Vec<_> = estimates.filter_map(FactorEstimate::disagreement).collect();
    outcome.warnings.extend(disagreements);
    if let Some(agreement) = &outcome.agreement
        && let Some(p) = agreement.p_value.filter(|p| *p < 0.01)
    {
        outcome.warnings.push(format!(
                "the model does not agree with the stated uncertainties (reduced chi-squared {:.2}, p = {p:.1e}): the intervals are too \
                 short, and something is missing in the model or in the uncertainties",
                agreement.reduced_chi_squared.unwrap_or(f64::NAN)
            ));
    }
}
