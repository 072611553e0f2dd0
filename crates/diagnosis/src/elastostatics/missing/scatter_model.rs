//! The covariance of load cases in a search: that of the fit where repeats show it, else from what each model leaves.

use crate::search::{Covariance, CovarianceModel};

use crate::elastostatics::outcome::{LoadCaseFit, ScatterSource};
use crate::elastostatics::posed::PosedLoadCases;
use crate::elastostatics::scatter::LoadScatter;

/// Scatter from repeats, or from what a model leaves.
pub(super) struct LoadCaseScatter<'a> {
    posed: &'a PosedLoadCases,
    /// What the repeats give, if there are enough of them: the covariance and its degrees of freedom.
    repeats: Option<(Covariance, f64)>,
}

impl<'a> LoadCaseScatter<'a> {
    pub(super) fn new(posed: &'a PosedLoadCases, baseline: &LoadCaseFit) -> Self {
        let agreement = baseline.agreement.as_ref();
        let repeats = agreement.filter(|one| one.source == ScatterSource::Repeats);
        let repeats = repeats.map(|one| (baseline.scatter.covariance(), one.scatter_dof));
        Self { posed, repeats }
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
        let scatter = LoadScatter::of_residuals(self.posed, residuals, &all, parameters);
        (
            scatter.of_rows(self.posed, residuals).covariance(),
            scatter.dof,
        )
    }
}
