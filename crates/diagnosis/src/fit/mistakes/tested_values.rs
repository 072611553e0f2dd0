//! Single values beside the scatter of all others: each against the fit without it.

use stiffbench_numeric::statistics::f_upper_tail;

use crate::search::{FittedRows, chance_of_any};

/// Degrees of freedom below which a scatter is no measure of anything.
const FEWEST_DOF: f64 = 2.0;

/// Scatter, as a share of the usual size of a component, below which weights do not grow: a simulation without noise has none.
pub(super) const LEAST_SCATTER: f64 = 1e-9;

/// Values that are looked at closely each time: those that are farthest off by two measures of the scatter.
const LOOKED_AT: usize = 8;

/// A value stands out where the others look like noise once it is gone: none is so far off that noise does it in fewer tables.
pub(super) const REST_IS_NOISE: f64 = 0.05;

/// Or it stands alone: so many times as far off as the next, in standard errors. What a model lacks spreads over many values.
pub(super) const STANDS_ALONE: f64 = 4.0;

/// How values scatter: each by itself, and in proportion to its size, because the size of a load varies from application to application. Soft
/// cells scatter more than stiff ones by that.
///
/// ```text
///   error = (error of the value) + slope v,    v = displacement or rotation under the load
/// ```
///
/// Maximum likelihood by expectation and maximisation (McLachlan & Krishnan, The EM Algorithm, 2008, section 5.9).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct LoadScatter {
    /// Standard deviations of the errors of displacements and of rotations; zero of what was not read.
    sd: [f64; 2],
    /// Standard deviation of the slope (1).
    slope_sd: f64,
    /// Degrees of freedom.
    dof: f64,
}

impl LoadScatter {
    /// Divides the scatter of values into both parts.
    ///
    /// # Arguments
    /// - `least`: standard deviations below which nothing is asked of displacements and rotations.
    fn of(values: &[FarValue], least: [f64; 2]) -> Self {
        /// Rounds: the slope is known to some percent at best.
        const ROUNDS: usize = 100;
        let (mut sd, mut slope_sd) = ([f64::INFINITY; 2], 0.0);
        let mut dof = [0.0; 2];
        for value in values {
            dof[value.kind] += value.dof();
        }
        let all: f64 = dof.iter().sum();
        for round in 0..=ROUNDS {
            let (mut slopes, mut squares, mut sizes) = (0.0, [0.0; 2], 0.0);
            for value in values {
                let (dof, square) = (value.dof(), value.off.powi(2));
                let share = value.size / f64::powi(sd[value.kind], 2);
                // Without a slope in the first round.
                let variance = f64::recip(f64::powi(slope_sd, -2) + share);
                let by_slope = variance * share;
                slopes += variance * (by_slope * square / f64::powi(sd[value.kind], 2) + dof);
                squares[value.kind] +=
                    (1.0 - by_slope).powi(2) * square + dof * variance * value.size;
                sizes += dof * value.size;
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

    /// The same; `None` where values do not scatter, or hardly any does.
    fn if_any(values: &[FarValue], least: [f64; 2]) -> Option<Self> {
        let scatter = Self::of(values, least);
        let scatters = values.iter().any(|one| one.off.abs() > LEAST_SCATTER);
        (scatters && scatter.dof >= FEWEST_DOF).then_some(scatter)
    }

    /// The variance of a value of this kind and size.
    fn variance(&self, value: &FarValue) -> f64 {
        self.sd[value.kind].powi(2) + self.slope_sd.powi(2) * value.size
    }

    /// How many standard errors a value is off.
    fn ratio(&self, value: &FarValue) -> f64 {
        value.off.abs() / (self.variance(value) * value.dof()).sqrt()
    }
}

/// A value with what a fit leaves of it.
#[derive(Debug, Clone, Copy)]
struct FarValue {
    /// 0 of displacements, 1 of rotations.
    kind: usize,
    /// Square of the value without error.
    size: f64,
    /// How far off it is.
    off: f64,
    /// Variance of that over the variance of a value of this kind and size.
    of_itself: f64,
}

impl FarValue {
    /// Degrees of freedom that it shows of the scatter.
    fn dof(&self) -> f64 {
        self.of_itself.max(f64::EPSILON)
    }
}

/// Values that are tested one by one, displacements and rotations each in a unit of their own.
pub(super) struct TestedValues {
    pub(super) fitted: FittedRows,
    /// 0 of displacements, 1 of rotations.
    pub(super) kinds: Vec<usize>,
    /// Squares of the values without error.
    pub(super) sizes: Vec<f64>,
    /// Scatter of each kind below which nothing is asked.
    pub(super) least: [f64; 2],
    /// Values of one application of a load. They count as one against the degrees of freedom: a load that is off shifts them all.
    pub(super) together: f64,
}

/// A value beside the others.
pub(super) struct FarthestValue {
    pub(super) row: usize,
    /// Value less what the fit to the others lets expect.
    pub(super) off: f64,
    /// Of that.
    pub(super) standard_error: f64,
    /// Chance that noise takes any of those tested as far.
    pub(super) p: f64,
    /// Whether the others are noise, or far less off.
    pub(super) stands_out: bool,
}

impl TestedValues {
    /// The value that is farthest from the fit to all others, measured by their scatter; `None` where they do not scatter.
    ///
    /// # Arguments
    /// - `suspects`: those that may be it.
    /// - `tests`: how many different tests of them there are.
    /// - `shows`: whether the second value may show the scatter beside which the first is tested.
    pub(super) fn farthest(
        &self,
        suspects: &[usize],
        tests: usize,
        shows: impl Fn(usize, usize) -> bool,
    ) -> Option<FarthestValue> {
        let residuals = self.fitted.residuals.iter().enumerate();
        let values = residuals.map(|(row, off)| FarValue {
            kind: self.kinds[row],
            size: self.sizes[row],
            off: *off,
            of_itself: self.fitted.shift_of_row(row).square,
        });
        let values: Vec<FarValue> = values.collect();
        let of_all = LoadScatter::if_any(&values, self.least)?;
        let in_units = LoadScatter {
            sd: [1.0; 2],
            ..LoadScatter::default()
        };
        let looked_at = [of_all, in_units].into_iter().flat_map(|scatter| {
            let mut order = suspects.to_vec();
            let far = |row: usize| scatter.ratio(&values[row]);
            order.sort_by(|a, b| far(*b).total_cmp(&far(*a)));
            order.into_iter().take(LOOKED_AT)
        });
        let tested = looked_at.filter_map(|row| self.tested(&values, row, tests, &shows));
        let ratio = |one: &FarthestValue| (one.off / one.standard_error).abs();
        tested.max_by(|a, b| ratio(a).total_cmp(&ratio(b)))
    }

    fn tested(
        &self,
        values: &[FarValue],
        row: usize,
        tests: usize,
        shows: &impl Fn(usize, usize) -> bool,
    ) -> Option<FarthestValue> {
        let (own, shift) = (values[row], self.fitted.shift_of_row(row));
        let free = own.of_itself;
        let others = values.iter().enumerate();
        let others = others.filter(|(other, _)| *other != row && shows(row, *other));
        let others = others.map(|(other, value)| {
            let beside = self.fitted.shift_of_row(other).beside(&shift);
            FarValue {
                off: beside.product,
                of_itself: beside.square,
                ..*value
            }
        });
        let others: Vec<FarValue> = others.collect();
        let scatter = LoadScatter::if_any(&others, self.least)?;
        let dof = scatter.dof / self.together.max(1.0);
        let p = |ratio: f64, count: usize| {
            let one = f_upper_tail(ratio.powi(2), 1.0, dof).unwrap_or(1.0);
            chance_of_any(one, count as f64)
        };
        let next = others.iter().map(|one| scatter.ratio(one));
        let (ratio, next) = (scatter.ratio(&own), next.fold(0.0, f64::max));
        Some(FarthestValue {
            row,
            off: shift.size(),
            standard_error: (scatter.variance(&own) / free).sqrt(),
            p: p(ratio, tests),
            stands_out: p(next, others.len()) > REST_IS_NOISE || ratio >= STANDS_ALONE * next,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of normal values by their quantiles would hide errors of the search; exact squares show the solution.
    #[test]
    fn exact_squares_give_back_their_variances() {
        let value = |kind: usize, size: f64, square: f64| FarValue {
            kind,
            size,
            off: (3.0 * square).sqrt(),
            of_itself: 3.0,
        };
        let of_number = |i: usize| {
            let (kind, size) = (i % 2, (i * i) as f64);
            value(kind, size, [4.0, 9.0][kind] + 0.5 * size)
        };
        let values: Vec<FarValue> = (0..20).map(of_number).collect();
        let found = LoadScatter::of(&values, [0.0; 2]);
        let variance = |kind: usize| found.variance(&value(kind, 0.0, 0.0));
        assert!((variance(0) - 4.0).abs() < 0.01, "{found:?}");
        assert!((variance(1) - 9.0).abs() < 0.01, "{found:?}");
        assert!((found.slope_sd.powi(2) - 0.5).abs() < 0.001, "{found:?}");
        assert!((found.dof - 60.0).abs() < 1e-12);
    }
}
