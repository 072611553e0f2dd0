//! Single values beside the scatter of all others.

use stiffbench_numeric::statistics::f_upper_tail;

/// Degrees of freedom below which a scatter is no measure of anything.
const FEWEST_DOF: f64 = 2.0;

/// Scatter, as a share of the usual size of a component, below which weights do not grow: a simulation without noise has none.
pub(super) const LEAST_SCATTER: f64 = 1e-9;

/// Values of one size beside what they should be.
#[derive(Debug, Clone, Copy)]
pub(super) struct ScatterCase {
    /// 0 of displacements, 1 of rotations.
    pub(super) kind: usize,
    /// Square of the value without error.
    pub(super) size: f64,
    /// Mean square of the errors.
    pub(super) square: f64,
    /// Their degrees of freedom.
    pub(super) dof: f64,
}

/// How values scatter: each by itself, and in proportion to its size, because the size of a load varies from application to application. Soft
/// cells scatter more than stiff ones by that.
///
/// ```text
///   error = (error of the value) + slope v,    v = displacement or rotation under the load
/// ```
///
/// Maximum likelihood by expectation and maximisation (McLachlan & Krishnan, The EM Algorithm, 2008, section 5.9).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LoadScatter {
    /// Standard deviations of the errors of displacements, m, and of rotations, rad; zero of what was not read.
    sd: [f64; 2],
    /// Standard deviation of the slope (1).
    slope_sd: f64,
    /// Degrees of freedom.
    pub(super) dof: f64,
}

impl LoadScatter {
    /// Divides the scatter of values into both parts.
    ///
    /// # Arguments
    /// - `least`: standard deviations below which nothing is asked of displacements and rotations.
    fn of_cases(cases: &[ScatterCase], least: [f64; 2]) -> Self {
        /// Rounds: the slope is known to some percent at best.
        const ROUNDS: usize = 100;
        let (mut sd, mut slope_sd) = ([f64::INFINITY; 2], 0.0);
        let mut dof = [0.0; 2];
        for case in cases {
            dof[case.kind] += case.dof;
        }
        let all: f64 = dof.iter().sum();
        for round in 0..=ROUNDS {
            let (mut slopes, mut squares, mut sizes) = (0.0, [0.0; 2], 0.0);
            for case in cases {
                let share = case.size / f64::powi(sd[case.kind], 2);
                // Without a slope in the first round.
                let variance = f64::recip(f64::powi(slope_sd, -2) + share);
                let by_slope = variance * share;
                slopes += case.dof
                    * (variance * by_slope * case.square / f64::powi(sd[case.kind], 2) + variance);
                let own = (1.0 - by_slope).powi(2) * case.square + variance * case.size;
                squares[case.kind] += case.dof * own;
                sizes += case.dof * case.size;
            }
            for kind in 0..2 {
                sd[kind] = f64::sqrt(squares[kind] / f64::max(dof[kind], f64::MIN_POSITIVE));
                sd[kind] = sd[kind].max(least[kind]);
            }
            // The slope starts where all would be its; one of exactly zero would stay there.
            slope_sd = match round {
                0 => f64::min(f64::sqrt((squares[0] + squares[1]) / sizes), 1.0),
                _ => f64::max(slopes / all, f64::MIN_POSITIVE).sqrt(),
            };
        }
        Self {
            sd: [0, 1].map(|kind| if dof[kind] > 0.0 { sd[kind] } else { 0.0 }),
            slope_sd,
            dof: all,
        }
    }

    /// The variance of a value of this kind, and the square of its size.
    pub(super) fn variance(&self, kind: usize, size: f64) -> f64 {
        self.sd[kind].powi(2) + self.slope_sd.powi(2) * size
    }
}

/// The scatter of values; `None` where they do not scatter, or hardly any does.
pub(super) fn scatter_of(cases: &[ScatterCase], least: [f64; 2]) -> Option<LoadScatter> {
    let scatter = LoadScatter::of_cases(cases, least);
    let scatters = cases.iter().any(|case| case.square != 0.0);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of normal values by their quantiles would hide errors of the search; exact squares show the solution.
    #[test]
    fn exact_squares_give_back_their_variances() {
        let case = |i: usize| {
            let (kind, value) = (i % 2, i as f64);
            ScatterCase {
                kind,
                size: value * value,
                square: [4.0, 9.0][kind] + 0.5 * value * value,
                dof: 3.0,
            }
        };
        let cases: Vec<ScatterCase> = (0..20).map(case).collect();
        let found = LoadScatter::of_cases(&cases, [0.0; 2]);
        assert!((found.variance(0, 0.0) - 4.0).abs() < 0.01, "{found:?}");
        assert!((found.variance(1, 0.0) - 9.0).abs() < 0.01, "{found:?}");
        assert!((found.slope_sd.powi(2) - 0.5).abs() < 0.001, "{found:?}");
        assert!((found.dof - 60.0).abs() < 1e-12);
    }
}
