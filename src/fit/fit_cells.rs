//! The joint least-squares fit: all chosen cells at once, with intervals and a judgement on cells it did not see.

use crate::least_squares::{
    Covariance, CovarianceSettings, EvaluationFailure, JacobianView, LeastSquaresError,
    LeastSquaresFit, ParameterSet, ResidualFunction, SearchOutcome, SearchSettings, SigmaMode,
    Termination, search_for_lower_minimum,
};
use crate::robot::{FittingFactors, Mechanism, Robot, RobotError};
use crate::statistics::{chi_squared_upper_tail, median};
use crate::test_point::PoseId;

use super::advice::{Advice, advise};
use super::cell_model::{CellModel, FACTOR_NAMES, FACTORS};
use super::choice::{FactorChoice, FactorRole};
use super::intervals::Profiled;
use super::joint::JointProblem;
use super::measured::MeasuredStiffness;
use super::outcome::{
    Agreement, Correlation, FactorStatus, FitMethod, FitOutcome, FittedCell, fitted_cells,
    plain_estimates,
};

/// Uncertainty of ln K assumed for a further cell in advice when the data state none: one percent, a good bench.
const TYPICAL_LN_UNCERTAINTY: f64 = 0.01;

/// A factor known to less than this, upper over lower end of its interval, deserves advice.
const WIDE: f64 = 2.0;

/// What a fit is asked to do.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FitOptions {
    /// Poses to fit; all others are held out. `None`: all poses, judged by leaving each out in turn.
    pub train: Option<Vec<PoseId>>,
    /// Which factors may move.
    pub choice: FactorChoice,
    /// Where the standard deviation of the residuals comes from; `None`: known if the data state uncertainties.
    pub sigma: Option<SigmaMode>,
}

/// Errors of the fit stage.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum FitError {
    /// A pose, mechanism or structure of the robot.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Robot(#[from] RobotError),
    /// The least-squares core.
    #[error(transparent)]
    #[diagnostic(transparent)]
    LeastSquares(#[from] LeastSquaresError),
    /// No cell to fit.
    #[error("none of the {cells} measured cell(s) belongs to the training poses ({train})")]
    #[diagnostic(
        code(stiffbench::fit::no_training_cells),
        help("--train takes pose names as they stand in the data, for example P1,P3")
    )]
    NoTrainingCells {
        /// Number of usable measured cells.
        cells: usize,
        /// The training poses asked for.
        train: String,
    },
    /// Fewer cells than free factors.
    #[error("{free} free factors cannot be fitted to {cells} cell(s)")]
    #[diagnostic(
        code(stiffbench::fit::too_few_cells),
        help("train on more poses or fix some factors, for example --fix beam.J")
    )]
    TooFewCells {
        /// Free factors.
        free: usize,
        /// Training cells.
        cells: usize,
    },
    /// The paper's procedure needs all three directions of a pose.
    #[error(
        "pose {pose} has no stiffness along {missing}; the paper's procedure fits one factor to each direction"
    )]
    #[diagnostic(
        code(stiffbench::fit::missing_direction),
        help("measure it, train on other poses, or use --method least-squares")
    )]
    MissingDirection {
        /// The pose.
        pose: PoseId,
        /// The direction.
        missing: crate::test_point::Direction,
    },
    /// Weights of a combination that cannot be used.
    #[error("the weights of the poses must not be negative and must not all be zero")]
    #[diagnostic(code(stiffbench::fit::weights))]
    Weights,
}

/// Fits the factors of a mechanism to measured stiffness.
///
/// # Errors
/// [`FitError`]; a search that did not converge is a result, not an error.
pub fn fit_cells(
    robot: &Robot,
    mechanism: &Mechanism,
    measured: &MeasuredStiffness,
    start: &FittingFactors,
    options: &FitOptions,
) -> Result<FitOutcome, FitError> {
    let in_training = |pose: &PoseId| {
        options
            .train
            .as_ref()
            .is_none_or(|train| train.contains(pose))
    };
    let training = measured.select(|cell| in_training(&cell.pose));
    if training.cells.is_empty() {
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
    let set = options.choice.parameters()?;
    let free = set.free_indices().len();
    if training.cells.len() < free {
        return Err(FitError::TooFewCells {
            free,
            cells: training.cells.len(),
        });
    }
    let sigma = sigma_mode(options, &training);
    let mut problem = JointProblem::new(robot, mechanism, &training, start)?;
    let settings = CovarianceSettings {
        known_dof: training.basis.dof(),
        ..CovarianceSettings::default()
    };
    let profiled = Profiled::fit(&mut problem, set, sigma, &settings)?;
    let Profiled { set, fit, .. } = &profiled;
    let factors = problem.factors(&fit.values);
    let cells: Vec<_> = measured
        .cells
        .iter()
        .map(|cell| cell.cell.clone())
        .collect();
    let predicted = CellModel::new(robot, mechanism, &cells)?.stiffness(&factors)?;
    let mut outcome = FitOutcome {
        method: FitMethod::LeastSquares,
        mechanism: mechanism.name.clone(),
        factors,
        estimates: plain_estimates(start, &factors, |i| match options.choice.roles[i] {
            FactorRole::Free => FactorStatus::Free,
            FactorRole::Fixed => FactorStatus::Fixed,
            FactorRole::TiedTo(other) => FactorStatus::Tied {
                to: FACTOR_NAMES[other],
            },
        }),
        correlation: None,
        agreement: None,
        cells: fitted_cells(measured, &predicted, |cell| !in_training(&cell.pose)),
        termination: describe(&fit.termination),
        advice: Vec::new(),
        warnings: Vec::new(),
    };
    if let Some(covariance) = &profiled.covariance {
        profiled.describe(&mut outcome);
        outcome.correlation = Some(correlation(set, covariance));
        outcome.agreement = Some(agreement(fit, covariance, &training));
        outcome.advice = advice(
            robot,
            mechanism,
            &outcome,
            set,
            fit,
            &training,
            &options.choice,
        )?;
    } else {
        outcome.warnings.push(format!(
            "{} cells and {free} free factors leave no degrees of freedom: the values have no intervals",
            training.cells.len()
        ));
    }
    if options.train.is_none() {
        leave_poses_out(robot, mechanism, measured, start, set, &mut outcome.cells)?;
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
    robot: &Robot,
    mechanism: &Mechanism,
    training: &MeasuredStiffness,
    start: &FittingFactors,
    choice: &FactorChoice,
    settings: &SearchSettings,
) -> Result<Option<FittingFactors>, FitError> {
    let set = choice.parameters()?;
    let mut problem = JointProblem::new(robot, mechanism, training, start)?;
    let fit = problem.minimise(&set)?;
    let ratios = choice.ratios()?;
    let mut by_ratio = InRatios {
        problem: &mut problem,
    };
    let search = search_for_lower_minimum(&mut by_ratio, &ratios, &fit, settings)?;
    Ok(match search.outcome {
        SearchOutcome::NoLowerMinimum { .. } => None,
        SearchOutcome::LowerMinimum { fit } => {
            let logarithms: Vec<f64> = fit.values.iter().map(|ratio| ratio.ln()).collect();
            Some(problem.factors(&logarithms))
        }
    })
}

/// The joint problem in the ratios of the factors to their start instead of the logarithms: the search takes logarithms itself.
struct InRatios<'p, 'a> {
    problem: &'p mut JointProblem<'a>,
}

impl ResidualFunction for InRatios<'_, '_> {
    fn residual_count(&self) -> usize {
        self.problem.residual_count()
    }

    fn evaluate(
        &mut self,
        parameters: &[f64],
        residuals: &mut [f64],
        mut jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        let logarithms: Vec<f64> = parameters.iter().map(|ratio| ratio.ln()).collect();
        self.problem
            .evaluate(&logarithms, residuals, jacobian.as_deref_mut())?;
        if let Some(jacobian) = jacobian {
            for (parameter, ratio) in parameters.iter().enumerate() {
                for entry in jacobian.column_mut(parameter).into_iter().flatten() {
                    *entry /= ratio;
                }
            }
        }
        Ok(())
    }
}

fn sigma_mode(options: &FitOptions, training: &MeasuredStiffness) -> SigmaMode {
    let known = training.has_uncertainties();
    options.sigma.unwrap_or(if known {
        SigmaMode::Known
    } else {
        SigmaMode::Estimated
    })
}

fn correlation(set: &ParameterSet, covariance: &Covariance) -> Correlation {
    let known: Vec<usize> = set
        .free_indices()
        .iter()
        .copied()
        .filter(|&i| covariance.of(i, i).is_some())
        .collect();
    let entry = |a: usize, b: usize| {
        covariance
            .correlation(a, b)
            .unwrap_or(f64::from(u8::from(a == b)))
    };
    Correlation {
        names: known.iter().map(|&i| FACTOR_NAMES[i]).collect(),
        matrix: known
            .iter()
            .map(|&a| known.iter().map(|&b| entry(a, b)).collect())
            .collect(),
    }
}

fn agreement(
    fit: &LeastSquaresFit,
    covariance: &Covariance,
    training: &MeasuredStiffness,
) -> Agreement {
    let p_value = match covariance.mode {
        SigmaMode::Known if covariance.dof > 0 => {
            chi_squared_upper_tail(fit.sum_of_squares(), covariance.dof as f64)
        }
        _ => None,
    };
    Agreement {
        sigma: covariance.mode,
        basis: training.basis,
        dof: covariance.dof,
        reduced_chi_squared: covariance.reduced_chi_squared,
        p_value,
    }
}

/// Advice for every factor that is on a bound or not determined.
fn advice(
    robot: &Robot,
    mechanism: &Mechanism,
    outcome: &FitOutcome,
    set: &ParameterSet,
    fit: &LeastSquaresFit,
    training: &MeasuredStiffness,
    choice: &FactorChoice,
) -> Result<Vec<Advice>, FitError> {
    let free = set.free_indices();
    let mut information = [[0.0; FACTORS]; FACTORS];
    for (a, &i) in free.iter().enumerate() {
        for (b, &j) in free.iter().enumerate() {
            let product =
                |(x, y): (&[f64], &[f64])| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
            information[i][j] = fit
                .jacobian_column(a)
                .zip(fit.jacobian_column(b))
                .map_or(0.0, product);
        }
    }
    let open: Vec<usize> = free
        .iter()
        .copied()
        .filter(|&i| {
            matches!(
                outcome.estimates[i].status,
                FactorStatus::AtBound { .. } | FactorStatus::NotIdentified { .. }
            ) || outcome.estimates[i]
                .interval_95
                .is_none_or(|[lower, upper]| upper > WIDE * lower)
        })
        .collect();
    // In mode `Known` the Jacobian is in units of the standard uncertainties; otherwise it has none, and the scatter about the fit
    // stands in for them.
    let (unit, ln_uncertainty) = match outcome
        .agreement
        .as_ref()
        .map(|a| (a.sigma, a.reduced_chi_squared))
    {
        Some((SigmaMode::Estimated, Some(variance))) if variance > 0.0 => {
            (variance, variance.sqrt())
        }
        _ => {
            let mut own: Vec<f64> = training
                .cells
                .iter()
                .filter_map(|cell| cell.ln_uncertainty)
                .map(|u| u.own)
                .collect();
            (
                1.0,
                median(&mut own)
                    .filter(|u| *u > 0.0)
                    .unwrap_or(TYPICAL_LN_UNCERTAINTY),
            )
        }
    };
    for entry in information.iter_mut().flatten() {
        *entry /= unit;
    }
    let prior = 0.5 * (choice.range[1] / choice.range[0]).ln();
    Ok(advise(
        robot,
        mechanism,
        &outcome.factors,
        &information,
        free,
        &open,
        ln_uncertainty,
        prior,
    )?)
}

/// Predicts each pose by a fit that did not know it.
fn leave_poses_out(
    robot: &Robot,
    mechanism: &Mechanism,
    measured: &MeasuredStiffness,
    start: &FittingFactors,
    set: &ParameterSet,
    cells: &mut [FittedCell],
) -> Result<(), FitError> {
    let mut poses: Vec<PoseId> = Vec::new();
    for cell in &measured.cells {
        if !poses.contains(&cell.cell.pose) {
            poses.push(cell.cell.pose.clone());
        }
    }
    for pose in &poses {
        let others = measured.select(|cell| cell.pose != *pose);
        if others.cells.len() < set.free_indices().len() {
            // Too little is left to fit: such a pose has no prediction from the others.
            continue;
        }
        let mut problem = JointProblem::new(robot, mechanism, &others, start)?;
        let fit = problem.minimise(set)?;
        let factors = problem.factors(&fit.values);
        let left_out: Vec<usize> = (0..cells.len())
            .filter(|&i| cells[i].cell.pose == *pose)
            .collect();
        let names: Vec<_> = left_out.iter().map(|&i| cells[i].cell.clone()).collect();
        let predicted = CellModel::new(robot, mechanism, &names)?.stiffness(&factors)?;
        for (i, k) in left_out.into_iter().zip(predicted) {
            cells[i].predicted_without_its_pose_n_per_m = Some(k);
        }
    }
    Ok(())
}

fn describe(termination: &Termination) -> String {
    match termination {
        Termination::Converged(_) => "converged".to_owned(),
        Termination::AtLimit { max_evaluations } => {
            format!("stopped after {max_evaluations} evaluations")
        }
        Termination::Stalled => "stopped: no step reduced the sum of squares".to_owned(),
        Termination::EvaluationFailed(failure) => format!("stopped: {failure}"),
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
    if let Some(agreement) = &outcome.agreement {
        if let Some(p) = agreement.p_value.filter(|p| *p < 0.01) {
            outcome.warnings.push(format!(
                "the model does not agree with the stated uncertainties (reduced chi-squared {:.2}, p = {p:.1e}): the intervals are too \
                 short, and something is missing in the model or in the uncertainties",
                agreement.reduced_chi_squared.unwrap_or(f64::NAN)
            ));
        }
    }
}
