//! Single values beside the scatter of all others.

use stiffbench_numeric::statistics::f_upper_tail;

use crate::elastostatics::scatter::{LoadScatter, ScatterCase};

/// Degrees of freedom below which a scatter is no measure of anything.
const FEWEST_DOF: f64 = 2.0;

/// Values that are read one by one.
pub(super) fn single_values(kind: usize, size: f64, squares: f64, dof: f64) -> ScatterCase {
    let dof = dof.max(f64::EPSILON);
    ScatterCase {
        kinds: vec![kind],
        values: vec![size.sqrt()],
        errors: vec![vec![(squares / dof).sqrt()]],
        dof,
    }
}

/// The scatter of values; `None` where they do not scatter, or hardly any does.
pub(super) fn scatter_of(cases: &[ScatterCase], least: [f64; 2]) -> Option<LoadScatter> {
    let scatter = LoadScatter::of_cases(cases, least);
    let scatters = cases.iter().any(|case| case.errors[0][0] != 0.0);
    (scatters && scatter.dof >= FEWEST_DOF).then_some(scatter)
}

/// A value that may be too far off.
#[derive(Debug, Clone, Copy)]
pub(super) struct FarValue {
    /// 0 of displacements, 1 of rotations.
    pub(super) kind: usize,
    /// Square of its size.
    pub(super) size: f64,
    /// How far off it is.
    pub(super) off: f64,
    /// Variance of that over the variance of a value of this kind and size.
    pub(super) of_itself: f64,
}

impl FarValue {
    /// How many standard errors it is off.
    pub(super) fn standard_errors(&self, scatter: &LoadScatter) -> f64 {
        let share = self.of_itself.max(f64::EPSILON);
        self.off.abs() / (scatter.variance(self.kind, self.size) * share).sqrt()
    }

    /// Chance that one of several values is as far from zero (Bonferroni).
    ///
    /// # Arguments
    /// - `together`: values of one application of a load. They count as one against the degrees of freedom: a load that is off shifts them all.
    pub(super) fn p_family(&self, scatter: &LoadScatter, values: usize, together: f64) -> f64 {
        let dof = scatter.dof / together.max(1.0);
        let p = f_upper_tail(self.standard_errors(scatter).powi(2), 1.0, dof).unwrap_or(1.0);
        (p * values as f64).min(1.0)
    }
}
