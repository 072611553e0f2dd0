//! Thresholds for many comparisons at once, and the test of one effect per cell against scatter pooled over the cells.

use stiffbench_numeric::statistics::{LeastSquaresLine, mean, normal_quantile, student_t_quantile};

/// Chance that a flawless table raises any flag of one rule.
pub(super) const FAMILY_ERROR: f64 = 0.05;

/// Standard normal quantile of the power that `detectable` is stated for, 80 %.
const NORMAL_QUANTILE_80: f64 = 0.841_621;

/// A test statistic with what it was compared with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TestStatistic {
    /// Size of the effect in standard errors.
    pub statistic: f64,
    /// The limit it exceeded.
    pub limit: f64,
    /// Number of comparisons over which the limit holds its 5 % (Bonferroni).
    pub n_tested: usize,
    /// Smallest effect found in 80 % of cases, in the unit of the effect.
    pub detectable: f64,
}

impl TestStatistic {
    /// An effect of `statistic` standard errors against a limit of `limit` standard errors.
    pub(super) fn new(statistic: f64, limit: f64, n_tested: usize, standard_error: f64) -> Self {
        Self {
            statistic,
            limit,
            n_tested,
            detectable: (limit + NORMAL_QUANTILE_80) * standard_error,
        }
    }

    pub(super) fn is_found(&self) -> bool {
        self.statistic > self.limit
    }
}

/// Two-sided limit of Student's t for `n_tested` comparisons at 5 % together; normal below one degree of freedom.
pub(super) fn student_limit(dof: f64, n_tested: usize) -> f64 {
    let p = 1.0 - FAMILY_ERROR / (2.0 * n_tested.max(1) as f64);
    student_t_quantile(p, dof).unwrap_or_else(|| normal_quantile(p))
}

/// Limit of the largest of `n_tested` studentised deviations at 5 % together, two-sided.
///
/// The deviation is divided by its own standard deviation, estimated with `dof` degrees of freedom from a scatter that holds
/// the deviation itself: √(ν t²/(ν - 1 + t²)) with t of ν - 1 degrees of freedom at 5 %/(2 n). With ν = n - 1 and the deviation
/// in units of s instead, this is Grubbs' limit. `None` below two degrees of freedom.
///
/// # Source
/// F. E. Grubbs, Technometrics 11 (1969) 1; the bound by Bonferroni as in Pearson and Chandra Sekar, Biometrika 28 (1936) 308.
pub(super) fn deviation_limit(dof: f64, n_tested: usize) -> Option<f64> {
    if dof < 2.0 {
        return None;
    }
    let t = student_limit(dof - 1.0, n_tested);
    Some((dof * t * t / (dof - 1.0 + t * t)).sqrt())
}

/// What is searched for in a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SeriesContrast {
    /// Change of y per x.
    Slope,
    /// Mean of y away from zero.
    Mean,
}

/// One series of a family, usually one cell.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ReadingSeries {
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    /// Variance of each y that reading noise alone explains.
    pub(super) known_variance: f64,
}

/// Effect in one series of a family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SeriesEffect {
    pub(super) effect: f64,
    pub(super) significance: TestStatistic,
}

/// Effect and sum of squares left after it, of one series.
struct Reduced {
    effect: f64,
    /// Variance of the effect in units of the variance of y.
    share: f64,
    left: f64,
    dof: f64,
}

impl ReadingSeries {
    pub(super) fn new(points: impl Iterator<Item = (f64, f64)>, known_variance: f64) -> Self {
        let (x, y) = points.unzip();
        Self {
            x,
            y,
            known_variance,
        }
    }

    fn reduced(&self, contrast: SeriesContrast) -> Option<Reduced> {
        let n = self.y.len() as f64;
        if contrast == SeriesContrast::Mean {
            let mean_y = mean(&self.y)?;
            return Some(Reduced {
                effect: mean_y,
                share: 1.0 / n,
                left: self.y.iter().map(|y| (y - mean_y).powi(2)).sum(),
                dof: n - 1.0,
            });
        }
        let points = self.x.iter().copied().zip(self.y.iter().copied());
        let line = LeastSquaresLine::through(points)?;
        Some(Reduced {
            effect: line.slope,
            share: 1.0 / line.sxx,
            left: line.residual_squares,
            dof: n - 2.0,
        })
    }
}

/// Tests every series for its effect, all together at 5 %.
///
/// y varies by reading noise, known, and by what runs differ in besides, unknown and the same for all series: the excess
/// variance τ². It is pooled over the series from what is left after the effects, weighted by the precision of each series.
/// t has the pooled degrees of freedom; `noise_dof` if no series has any. `None` for a series that cannot show the effect or
/// has no scatter to be compared with.
pub(super) fn test_family(
    series: &[ReadingSeries],
    contrast: SeriesContrast,
    noise_dof: f64,
) -> Vec<Option<SeriesEffect>> {
    let reduced: Vec<Option<Reduced>> = series.iter().map(|s| s.reduced(contrast)).collect();
    let known: Vec<(&Reduced, f64)> = reduced
        .iter()
        .zip(series)
        .filter_map(|(r, s)| Some((r.as_ref()?, s.known_variance)))
        .collect();
    let pooled_dof: f64 = known.iter().map(|(r, _)| r.dof).sum();
    let excess = excess_variance(&known);
    let dof = if pooled_dof > 0.0 {
        pooled_dof
    } else {
        noise_dof
    };
    let limit = student_limit(dof, known.len());
    reduced
        .iter()
        .zip(series)
        .map(|(reduced, series)| {
            let reduced = reduced.as_ref()?;
            let error = ((excess + series.known_variance) * reduced.share).sqrt();
            (error > 0.0).then(|| SeriesEffect {
                effect: reduced.effect,
                significance: TestStatistic::new(
                    reduced.effect.abs() / error,
                    limit,
                    known.len(),
                    error,
                ),
            })
        })
        .collect()
}

fn excess_variance(known: &[(&Reduced, f64)]) -> f64 {
    let mut excess = 0.0;
    // A fixed point; five rounds bring the weights well within the noise of the estimate.
    for _ in 0..5 {
        let (mut sum, mut total) = (0.0, 0.0);
        for (reduced, variance) in known {
            let expected = excess + variance;
            let weight = if expected > 0.0 {
                1.0 / (expected * expected)
            } else {
                1.0
            };
            sum += weight * (reduced.left - reduced.dof * variance);
            total += weight * reduced.dof;
        }
        if total == 0.0 {
            return 0.0;
        }
        excess = f64::max(0.0, sum / total);
    }
    excess
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grubbs_limits_are_the_published_ones() {
        // Grubbs, Technometrics 11 (1969), table 1, two-sided 5 % (one-sided 2.5 %).
        let table: [(u32, f64); 8] = [
            (3, 1.155),
            (4, 1.481),
            (5, 1.715),
            (6, 1.887),
            (7, 2.020),
            (8, 2.126),
            (10, 2.290),
            (20, 2.709),
        ];
        for (n, limit) in table {
            // The table has the deviation in units of s instead of its own standard deviation.
            let count = f64::from(n);
            let found =
                deviation_limit(count - 1.0, n as usize).unwrap() * ((count - 1.0) / count).sqrt();
            assert!((found - limit).abs() < 0.001, "n = {n}: {found}");
        }
        assert_eq!(deviation_limit(1.0, 2), None);
    }

    #[test]
    fn a_slope_in_one_of_many_series_is_found_against_the_scatter_of_all() {
        let flat = |sign: f64| ReadingSeries {
            x: vec![1.0, 2.0, 3.0, 4.0, 5.0],
            y: [1.0, -1.0, 0.0, -1.0, 1.0].map(|y| sign * y).to_vec(),
            known_variance: 0.0,
        };
        let mut series = vec![flat(1.0), flat(-1.0), flat(1.0), flat(-1.0)];
        series[2].y = vec![-6.0, -4.0, 0.0, 2.0, 7.0];
        let effects = test_family(&series, SeriesContrast::Slope, f64::INFINITY);
        let found: Vec<bool> = effects
            .iter()
            .map(|e| e.unwrap().significance.is_found())
            .collect();
        assert_eq!(found, [false, false, true, false]);
        // Slope by hand: Σ(x - 3) y / 10 = (12 + 4 + 2 + 14)/10.
        assert!((effects[2].unwrap().effect - 3.2).abs() < 1e-12);
        // Pooled: 3 · 4 + left of series 2, 105.2 - 5·0.04 - 102.4 over 12 dof.
        let left: f64 = [-6.0_f64, -4.0, 0.0, 2.0, 7.0]
            .iter()
            .zip([-2.0, -1.0, 0.0, 1.0, 2.0])
            .map(|(y, x)| (y + 0.2 - 3.2 * x).powi(2))
            .sum();
        let error = ((12.0 + left) / 12.0 / 10.0).sqrt();
        let statistic = effects[2].unwrap().significance.statistic;
        assert!((statistic - 3.2 / error).abs() < 1e-9);
    }

    #[test]
    fn a_series_without_scatter_or_extent_is_not_tested() {
        let series = [ReadingSeries {
            x: vec![1.0, 1.0],
            y: vec![0.0, 1.0],
            known_variance: 1.0,
        }];
        assert_eq!(test_family(&series, SeriesContrast::Slope, 10.0), [None]);
        let series = [ReadingSeries {
            x: vec![1.0],
            y: vec![1.0],
            known_variance: 0.0,
        }];
        assert_eq!(test_family(&series, SeriesContrast::Mean, 10.0), [None]);
    }
}
