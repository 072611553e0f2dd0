//! Which measurement would determine a factor that the data leave open.

use stiffbench_beams::robot::{FittingFactors, RobotError};
use stiffbench_numeric::least_squares::{LeastSquaresFit, ParameterSet, SigmaMode};
use stiffbench_numeric::statistics::median;
use stiffbench_units_and_text::test_point::{Cell, Direction};

use super::error::FitError;
use super::measured::MeasuredStiffness;
use super::outcome::{Advice, FactorStatus, FitOutcome};
use super::parameters::FitParameters;
use super::problem::FitProblem;
use super::shares::Shares;

/// Uncertainty of ln K assumed for a further cell when the data state none: one percent, a good bench.
const TYPICAL_LN_UNCERTAINTY: f64 = 0.01;

/// A factor whose interval reaches this far, upper end over lower end, deserves advice.
const WIDE: f64 = 2.0;

/// For each factor that is not determined, or known to no better than a factor of two, the cell among the robot's named poses that determines it
/// best. A factor on a bound is left out: no further cell says more of it before the bound is wider.
///
/// # Arguments
/// - `problem`: the training cells.
/// - `outcome`, `fit`: the fit of these cells and what was found of the factors.
///
/// # Errors
/// Those of [`CellModel`](super::cell_model::CellModel); poses the mechanism cannot reach are passed over.
pub(super) fn advise(
    problem: &FitProblem<'_>,
    outcome: &FitOutcome,
    (set, fit): (&ParameterSet, &LeastSquaresFit),
    parameters: &FitParameters,
) -> Result<Vec<Advice>, FitError> {
    let knowledge = Knowledge::new((set, fit), problem.measured, outcome, parameters);
    let open: Vec<usize> = knowledge
        .free
        .iter()
        .copied()
        .filter(|&i| {
            outcome.estimates[i]
                .interval_95
                .is_none_or(|[lower, upper]| upper > WIDE * lower)
        })
        .collect();
    if open.is_empty() {
        return Ok(Vec::new());
    }
    let candidates = candidates(problem, parameters, &outcome.factors)?;
    let best = |&factor: &usize| {
        let estimate = &outcome.estimates[factor];
        // The coordinate of a factor is its logarithm; one of a spring is compared with its value.
        let (is_factor, value) = (estimate.parameter.is_factor(), estimate.value);
        if !is_factor && value <= 0.0 {
            return None;
        }
        let relative = |u: f64| {
            if is_factor {
                u
            } else {
                u * parameters.slope(factor) / value
            }
        };
        // Both from the covariance, so that they can be compared: the standard error of the fit, where it has one.
        let stated = estimate.standard_uncertainty.map(|u| u / value);
        let now = stated.or_else(|| knowledge.uncertainty(factor, None).map(relative))?;
        let (cell, then) = candidates
            .iter()
            .filter_map(|(cell, shares)| {
                Some((cell, relative(knowledge.uncertainty(factor, Some(shares))?)))
            })
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Advice {
            factor: outcome.estimates[factor].name.clone(),
            measure: cell.clone(),
            ln_uncertainty_now: now,
            ln_uncertainty_then: then.min(now),
        })
    };
    Ok(open.iter().filter_map(best).collect())
}

/// Every cell of the robot's named poses with the shares of the factors in its compliance.
fn candidates(
    problem: &FitProblem<'_>,
    parameters: &FitParameters,
    factors: &FittingFactors,
) -> Result<Vec<(Cell, Shares)>, FitError> {
    let mut candidates = Vec::new();
    for named in &problem.robot.poses {
        let cells = Direction::ALL.map(|direction| Cell::new(named.id.clone(), direction));
        let mut model = match problem.cell_model(parameters.parameters(), &cells) {
            Ok(model) => model,
            Err(RobotError::Unreachable { .. }) => continue,
            Err(error) => return Err(error.into()),
        };
        let mut shares = [const { Shares::new() }; 3];
        model.evaluate(factors, &mut [0.0; 3], Some(&mut shares))?;
        for (place, derivative) in shares.iter_mut().flat_map(|of| of.iter_mut().enumerate()) {
            *derivative *= parameters.slope(place);
        }
        candidates.extend(cells.into_iter().zip(shares));
    }
    Ok(candidates)
}

/// What the training cells say of the free factors.
struct Knowledge {
    /// Factors that the fit moves and that are not on a bound.
    free: Vec<usize>,
    /// JᵀJ of ln K to the free coordinates, in units of the inverse variance.
    information: Vec<Vec<f64>>,
    /// Standard uncertainty of ln K of a further cell.
    further_ln_uncertainty: f64,
    /// Half the width of what bounds allow each free coordinate, taken as a standard deviation: keeps undetermined directions finite.
    prior: Vec<f64>,
}

impl Knowledge {
    fn new(
        (set, fit): (&ParameterSet, &LeastSquaresFit),
        training: &MeasuredStiffness,
        outcome: &FitOutcome,
        parameters: &FitParameters,
    ) -> Self {
        // With known uncertainties the Jacobian is in units of them. Without, it has none, and the scatter about the fit stands in.
        let scatter = match outcome
            .agreement
            .as_ref()
            .map(|a| (a.sigma, a.reduced_chi_squared))
        {
            Some((SigmaMode::Estimated, Some(variance))) if variance > 0.0 => Some(variance.sqrt()),
            _ => None,
        };
        let mut own: Vec<f64> = training
            .cells
            .iter()
            .filter_map(|cell| cell.ln_uncertainty)
            .map(|u| u.own)
            .collect();
        let stated = median(&mut own).filter(|u| *u > 0.0);
        let further = scatter.or(stated).unwrap_or(TYPICAL_LN_UNCERTAINTY);
        let unit = if scatter.is_some() || stated.is_none() {
            further
        } else {
            1.0
        };
        let is_free = |&place: &usize| {
            let (before, after) = (parameters.status(place), &outcome.estimates[place].status);
            matches!(
                before,
                FactorStatus::Free | FactorStatus::NotIdentified { .. }
            ) && !matches!(after, FactorStatus::AtBound { .. })
        };
        let free = (0..parameters.parameters().len()).filter(is_free);
        let free: Vec<usize> = free.collect();
        let product = |(x, y): (&[f64], &[f64])| {
            x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>() / (unit * unit)
        };
        let entry = |a: usize, b: usize| {
            // Of what no cell depends on the fit has no derivatives.
            let column = |place: usize| {
                let mut fitted = set.free_indices().iter();
                fit.jacobian_column(fitted.position(|fitted| *fitted == free[place])?)
            };
            column(a).zip(column(b)).map_or(0.0, product)
        };
        Self {
            information: (0..free.len())
                .map(|a| (0..free.len()).map(|b| entry(a, b)).collect())
                .collect(),
            prior: free
                .iter()
                .map(|&place| {
                    let [lower, upper] = parameters.bounds(place);
                    0.5 * (upper - lower)
                })
                .collect(),
            free,
            further_ln_uncertainty: further,
        }
    }

    /// Standard uncertainty of the coordinate of a free parameter, with the data at hand or with one cell more.
    fn uncertainty(&self, factor: usize, further: Option<&Shares>) -> Option<f64> {
        let place = self.free.iter().position(|free| *free == factor)?;
        let count = self.free.len();
        let weight = 1.0 / (self.further_ln_uncertainty * self.further_ln_uncertainty);
        let matrix = nalgebra::DMatrix::from_fn(count, count, |i, j| {
            let prior = if i == j { self.prior[i].powi(-2) } else { 0.0 };
            let more = further.map_or(0.0, |shares| {
                shares[self.free[i]] * shares[self.free[j]] * weight
            });
            self.information[i][j] + prior + more
        });
        Some(matrix.cholesky()?.inverse()[(place, place)].sqrt())
    }
}
