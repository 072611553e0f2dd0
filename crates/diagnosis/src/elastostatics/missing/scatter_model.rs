//! The covariance of load cases in a search: displacements scatter alike, and rotations do.

use crate::search::{Covariance, CovarianceModel};

use crate::elastostatics::posed::PosedLoadCases;
use crate::elastostatics::scatter::{ScatterSums, sizes};

/// Scatter, as a share of the usual size of a component, below which nothing is asked of a gauge.
const LEAST_SCATTER: f64 = 1e-9;

/// Scatter from repeats, or from what a model leaves.
pub(super) struct LoadCaseScatter<'a> {
    posed: &'a PosedLoadCases,
    /// What the repeats give, if there are enough of them.
    repeats: Option<ScatterSums>,
    least: [f64; 2],
}

impl<'a> LoadCaseScatter<'a> {
    /// # Arguments
    /// - `residuals`: of the baseline, whose differences between repeats count.
    pub(super) fn new(posed: &'a PosedLoadCases, residuals: &[f64]) -> Self {
        let repeats = ScatterSums::of_repeats(posed, residuals);
        Self {
            repeats: repeats.serves(posed).then_some(repeats),
            least: sizes(posed).map(|size| LEAST_SCATTER * size),
            posed,
        }
    }

    /// Whether the scatter is that of repeats.
    pub(super) fn is_from_repeats(&self) -> bool {
        self.repeats.is_some()
    }
}

impl CovarianceModel for LoadCaseScatter<'_> {
    fn estimate(&self, residuals: &[f64], parameters: usize) -> (Covariance, f64) {
        let all = vec![true; residuals.len()];
        let sums = self
            .repeats
            .unwrap_or_else(|| ScatterSums::of_residuals(self.posed, residuals, &all, parameters));
        let variances: Vec<f64> = sums
            .weights(self.posed, self.least)
            .iter()
            .map(|weight| weight.powi(-2))
            .collect();
        (Covariance::new(&variances, []), sums.dof())
    }
}
