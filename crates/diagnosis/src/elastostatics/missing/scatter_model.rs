//! The covariance of load cases in a search: displacements scatter alike, rotations do, and where repeats show it all that was read together.

use crate::search::{Covariance, CovarianceModel};

use crate::elastostatics::posed::PosedLoadCases;
use crate::elastostatics::scatter::{LEAST_SCATTER, ScatterSums, SlopeScatter, sizes};

/// Scatter from repeats, or from what a model leaves.
pub(super) struct LoadCaseScatter<'a> {
    posed: &'a PosedLoadCases,
    /// What the repeats give, if there are enough of them: the covariance and its degrees of freedom.
    repeats: Option<(Covariance, f64)>,
    least: [f64; 2],
}

impl<'a> LoadCaseScatter<'a> {
    /// # Arguments
    /// - `residuals`: of the baseline, whose differences between repeats count.
    pub(super) fn new(posed: &'a PosedLoadCases, residuals: &[f64]) -> Self {
        let least = sizes(posed).map(|size| LEAST_SCATTER * size);
        let sums = ScatterSums::of_repeats(posed, residuals);
        let repeats = sums.serves(posed).then(|| {
            let start = sums.standard_deviations();
            let start = [0, 1].map(|kind| start[kind].unwrap_or(1.0).max(least[kind]));
            let scatter = SlopeScatter::of_repeats(posed, residuals, start, least);
            (scatter.covariance(posed), sums.dof())
        });
        Self {
            posed,
            repeats,
            least,
        }
    }

    /// Whether the scatter is that of repeats.
    pub(super) fn is_from_repeats(&self) -> bool {
        self.repeats.is_some()
    }
}

impl CovarianceModel for LoadCaseScatter<'_> {
    fn estimate(&self, residuals: &[f64], parameters: usize) -> (Covariance, f64) {
        if let Some(repeats) = &self.repeats {
            return repeats.clone();
        }
        let all = vec![true; residuals.len()];
        let sums = ScatterSums::of_residuals(self.posed, residuals, &all, parameters);
        let variances: Vec<f64> = sums
            .weights(self.posed, self.least)
            .iter()
            .map(|weight| weight.powi(-2))
            .collect();
        (Covariance::new(&variances, []), sums.dof())
    }
}
