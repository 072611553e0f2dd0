//! Weights of cells that were measured in one run each: reading noise is seen, the scatter from run to run is not.
//!
//! A stiff cell, which hardly gives way, is known less well than a soft one: equal weights would make intervals of what stiff cells decide
//! too short. What runs differ by is taken from the residuals: as large as it must be for them to be as large as they are.

use nalgebra::{DMatrix, DVector};
use stiffbench_numeric::least_squares::{LeastSquaresFit, ParameterSet};

use super::error::FitError;
use super::intervals::all_minima;
use super::joint::JointProblem;
use super::measured::{LnUncertainty, MeasuredStiffness, WeightBasis};
use super::parameters::FitParameters;
use super::problem::FitProblem;

/// A variance between runs is known by so many halvings of its bracket: far better than a few degrees of freedom know it.
const HALVINGS: u32 = 24;

/// Largest relative scatter between runs that is searched for: no run says anything beyond it.
const LARGEST_SD: f64 = 1.0;

impl MeasuredStiffness {
    /// With reading noise and the scatter between runs that makes the weighted sum of squared residuals equal to its degrees of freedom;
    /// zero if reading noise alone makes it larger.
    ///
    /// Left as it is if weights are known, if reading noise was not seen, or without degrees of freedom.
    ///
    /// # Errors
    /// [`FitError`].
    ///
    /// # Source
    /// Paule and Mandel, Journal of Research of the National Bureau of Standards 87 (1982) 377.
    pub(super) fn weighted_by_residuals(
        self,
        problem: &FitProblem<'_>,
        parameters: &FitParameters,
        set: &ParameterSet,
    ) -> Result<Self, FitError> {
        let noise: Option<Vec<LnUncertainty>> =
            self.cells.iter().map(|cell| cell.reading_noise).collect();
        let dof = self.values().saturating_sub(set.free_indices().len());
        let Some(noise) = noise.filter(|_| self.basis == WeightBasis::Equal && dof > 0) else {
            return Ok(self);
        };
        let dof = dof as f64;
        let with = |variance: f64, dof: f64| {
            let mut weighted = self.clone();
            weighted.basis = WeightBasis::FromResiduals {
                run_slope_sd: variance.sqrt(),
                dof,
            };
            for (cell, noise) in weighted.cells.iter_mut().zip(&noise) {
                cell.ln_uncertainty = Some(LnUncertainty {
                    own: noise.own.hypot(variance.sqrt()),
                    ..*noise
                });
            }
            for one in &mut weighted.across {
                one.u_m_per_n = one
                    .u_m_per_n
                    .hypot(variance.sqrt() * one.compliance_m_per_n);
            }
            weighted
        };
        let unweighted = problem.measuring(&self);
        let mut joint = JointProblem::new(&unweighted, parameters)?;
        let starts = all_minima(&unweighted, &mut joint, set)?;
        let lowest = |variance: f64| -> Result<Option<LeastSquaresFit>, FitError> {
            let weighted = with(variance, dof);
            let mut joint = JointProblem::new(&problem.measuring(&weighted), parameters)?;
            let mut fits = Vec::new();
            for start in &starts {
                fits.push(joint.minimise(&set.with_start(&start.free_values)?)?);
            }
            Ok(fits
                .into_iter()
                .min_by(|a, b| a.objective.total_cmp(&b.objective)))
        };
        let too_large = |variance: f64| -> Result<bool, FitError> {
            Ok(lowest(variance)?.is_some_and(|fit| fit.sum_of_squares() > dof))
        };
        let mut variance = 0.0;
        if too_large(0.0)? {
            // In logarithms of the standard deviation, from what no stiffness is known to.
            let (mut low, mut high) = (1e-6_f64.ln(), LARGEST_SD.ln());
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if too_large((2.0 * middle).exp())? {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            variance = (low + high).exp();
        }
        let along = noise.iter().map(|noise| noise.own);
        let across = self.across.iter();
        let across = across.map(|one| one.u_m_per_n / one.compliance_m_per_n.abs().max(1e-300));
        let variances = along.chain(across).map(|own| own * own + variance);
        let variances: Vec<f64> = variances.collect();
        let Some(fit) = lowest(variance)? else {
            return Ok(self);
        };
        Ok(with(variance, known_dof(&variances, &fit, set)))
    }
}

/// Degrees of freedom with which the variance of the best cell is known: v² tr(P²), by the information that all residuals hold on a variance
/// common to the cells, with P = W - W X (Xᵀ W X)⁻¹ Xᵀ W. It is cells less factors where all variances are alike.
///
/// # Source
/// Searle, Casella and McCulloch, Variance Components (1992), section 6.6: information of restricted likelihood.
fn known_dof(variances: &[f64], fit: &LeastSquaresFit, set: &ParameterSet) -> f64 {
    let cells = variances.len();
    let columns: Vec<DVector<f64>> = (0..set.free_indices().len())
        .filter_map(|free| fit.jacobian_column(free))
        .map(DVector::from_column_slice)
        .collect();
    let mut left = DMatrix::identity(cells, cells);
    if !columns.is_empty() {
        let basis = DMatrix::from_columns(&columns).qr().q();
        left -= &basis * basis.transpose();
    }
    let trace: f64 = (0..cells)
        .flat_map(|i| (0..cells).map(move |j| (i, j)))
        .map(|(i, j)| left[(i, j)].powi(2) / (variances[i] * variances[j]))
        .sum();
    let least = variances.iter().copied().fold(f64::INFINITY, f64::min);
    (least * least * trace).max(1.0)
}
