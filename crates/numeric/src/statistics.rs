//! Estimates with uncertainty, and the few distributions and robust statistics the analysis needs.
//!
//! Leaf module: it handles numbers, not experiments.

use statrs::distribution::{
    Beta, ChiSquared, Continuous, ContinuousCDF, FisherSnedecor, Normal, StudentsT,
};

/// A value with its standard uncertainty and the degrees of freedom behind it.
///
/// The unit is that of the field that holds the estimate. Degrees of freedom may be infinite (an uncertainty that is known) or
/// zero (none could be computed, `standard_uncertainty` is then NaN).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The best value.
    pub value: f64,
    /// Standard uncertainty (GUM 2.3.1), same unit as `value`.
    pub standard_uncertainty: f64,
    /// Effective degrees of freedom of `standard_uncertainty`.
    pub dof: f64,
}

impl Estimate {
    /// An estimate whose uncertainty could not be computed.
    #[must_use]
    pub fn without_uncertainty(value: f64) -> Self {
        Self {
            value,
            standard_uncertainty: f64::NAN,
            dof: 0.0,
        }
    }

    /// Coverage factor k for 95 % from Student's t (GUM G.3.2); `None` below one degree of freedom.
    #[must_use]
    pub fn coverage_factor_95(&self) -> Option<f64> {
        student_t_quantile(0.975, self.dof)
    }

    /// Expanded uncertainty U = k u for 95 %; `None` without an uncertainty.
    #[must_use]
    pub fn expanded_95(&self) -> Option<f64> {
        let expanded = self.coverage_factor_95()? * self.standard_uncertainty;
        expanded.is_finite().then_some(expanded)
    }

    /// `[value - U, value + U]` for 95 %.
    #[must_use]
    pub fn interval_95(&self) -> Option<[f64; 2]> {
        let expanded = self.expanded_95()?;
        Some([self.value - expanded, self.value + expanded])
    }
}

/// Quantile of Student's t at probability `p`; normal for infinite `dof`, `None` below one degree of freedom.
///
/// Effective degrees of freedom need not be whole; they are used as they are (GUM G.4.1 allows interpolation).
#[must_use]
pub fn student_t_quantile(p: f64, dof: f64) -> Option<f64> {
    if dof.is_nan() || dof < 1.0 {
        return None;
    }
    // Beyond 1e6 the difference to the normal quantile is below 1e-6 of it.
    if dof > 1e6 {
        return Some(normal_quantile(p));
    }
    StudentsT::new(0.0, 1.0, dof).ok().map(|t| t.inverse_cdf(p))
}

/// Logarithm of the density of Student's t; `None` below zero degrees of freedom.
#[must_use]
pub fn student_t_log_density(value: f64, dof: f64) -> Option<f64> {
    StudentsT::new(0.0, 1.0, dof).ok().map(|t| t.ln_pdf(value))
}

/// Standard deviations of a normal distribution on either side of its mean that hold 95 % of it.
pub const NORMAL_95: f64 = 1.96;

/// Median distance of a normal distribution from its mean, in standard deviations: Φ⁻¹(3/4).
pub const NORMAL_MEDIAN_DEVIATION: f64 = 0.6745;

/// Quantile of the standard normal distribution.
#[must_use]
pub fn normal_quantile(p: f64) -> f64 {
    Normal::standard().inverse_cdf(p)
}

/// Probability that a standard normal variable exceeds `value`.
#[must_use]
pub fn normal_upper_tail(value: f64) -> f64 {
    Normal::standard().sf(value)
}

/// Probability that a chi-squared variable with `dof` degrees of freedom exceeds `value`.
#[must_use]
pub fn chi_squared_upper_tail(value: f64, dof: f64) -> Option<f64> {
    ChiSquared::new(dof).ok().map(|d| d.sf(value))
}

/// Quantile of the chi-squared distribution.
#[must_use]
pub fn chi_squared_quantile(p: f64, dof: f64) -> Option<f64> {
    ChiSquared::new(dof).ok().map(|d| d.inverse_cdf(p))
}

/// Probability that an F variable with the given degrees of freedom exceeds `value`; `None` for NaN and degrees of freedom that are none.
#[must_use]
pub fn f_upper_tail(value: f64, dof_numerator: f64, dof_denominator: f64) -> Option<f64> {
    let distribution = FisherSnedecor::new(dof_numerator, dof_denominator).ok()?;
    let product = value * dof_numerator;
    if product.is_finite() {
        return Some(distribution.sf(value));
    }
    // The library has no answer where this product overflows.
    (product > 0.0).then_some(0.0)
}

/// 95 % interval of a share from hits among trials (Clopper and Pearson, Biometrika 26 (1934)): never too narrow.
///
/// `None` without trials.
#[must_use]
pub fn binomial_interval_95(hits: usize, trials: usize) -> Option<[f64; 2]> {
    Some([
        binomial_lower(hits, trials, 0.025)?,
        binomial_upper(hits, trials, 0.025)?,
    ])
}

/// Upper bound that a share exceeds with a chance of 5 % at most, from hits among trials; `None` without trials.
#[must_use]
pub fn binomial_upper_95(hits: usize, trials: usize) -> Option<f64> {
    binomial_upper(hits, trials, 0.05)
}

fn binomial_upper(hits: usize, trials: usize, tail: f64) -> Option<f64> {
    match (hits, trials) {
        (_, 0) => None,
        (hits, trials) if hits >= trials => Some(1.0),
        (hits, trials) => Beta::new(hits as f64 + 1.0, (trials - hits) as f64)
            .ok()
            .map(|beta| beta.inverse_cdf(1.0 - tail)),
    }
}

fn binomial_lower(hits: usize, trials: usize, tail: f64) -> Option<f64> {
    let misses = trials.checked_sub(hits)?;
    Some(1.0 - binomial_upper(misses, trials, tail)?)
}

/// Effective degrees of freedom of a sum of independent components (Welch-Satterthwaite, GUM eq. (G.2b)).
///
/// Each component is (standard uncertainty in the unit of the result, degrees of freedom). Components that are zero are
/// skipped; the result is infinite when all have infinite degrees of freedom.
#[must_use]
pub fn welch_satterthwaite(components: &[(f64, f64)]) -> f64 {
    let total: f64 = components.iter().map(|(u, _)| u * u).sum();
    let denominator: f64 = components
        .iter()
        .filter(|(u, dof)| *u != 0.0 && dof.is_finite())
        .map(|(u, dof)| u.powi(4) / dof)
        .sum();
    if denominator == 0.0 {
        f64::INFINITY
    } else {
        total * total / denominator
    }
}

/// Arithmetic mean; `None` for no values.
#[must_use]
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Root mean square; `None` for no values.
#[must_use]
pub fn root_mean_square(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let squares: Vec<f64> = values.into_iter().map(|value| value * value).collect();
    mean(&squares).map(f64::sqrt)
}

/// Differences of an even order: a slow change of values leaves nothing of itself in them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Differences {
    coefficients: &'static [f64],
    /// Variance of those of white noise over its own (1): the sum of the squares of the coefficients.
    pub variance: f64,
}

impl Differences {
    /// x₀ - 2 x₁ + x₂.
    pub const SECOND: Self = Self {
        coefficients: &[1.0, -2.0, 1.0],
        variance: 6.0,
    };
    /// x₀ - 4 x₁ + 6 x₂ - 4 x₃ + x₄.
    pub const FOURTH: Self = Self {
        coefficients: &[1.0, -4.0, 6.0, -4.0, 1.0],
        variance: 70.0,
    };

    /// Those of values in their order.
    pub fn of(self, values: &[f64]) -> impl Iterator<Item = f64> {
        let windows = values.windows(self.coefficients.len());
        windows.map(move |window| {
            let products = window.iter().zip(self.coefficients);
            products.map(|(value, factor)| value * factor).sum()
        })
    }
}

/// Sample standard deviation with n - 1; `None` for fewer than two values.
#[must_use]
pub fn standard_deviation(values: &[f64]) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let mean = mean(values)?;
    let sum: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    Some((sum / (values.len() - 1) as f64).sqrt())
}

/// Median; `None` for no values. The slice is sorted in place.
#[must_use]
pub fn median(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    Some(if values.len() % 2 == 1 {
        values[middle]
    } else {
        0.5 * (values[middle - 1] + values[middle])
    })
}

/// The root above one of x^(d+1) = x + 1 for d dimensions: the golden ratio for one, the plastic number for two.
///
/// # Source
/// Roberts, "The unreasonable effectiveness of quasirandom sequences" (2018).
#[must_use]
pub fn golden_ratio(dimensions: usize) -> f64 {
    // Each round is nearer by a factor of two or more: sixty go beyond the last digit.
    (0..60).fold(1.5_f64, |root, _| {
        (1.0 + root).powf(1.0 / (dimensions as f64 + 1.0))
    })
}

/// Coordinate `place` of point number `k`, from 0 to 1, of points that fill a box evenly however many are taken: the sequence R_d of
/// [`golden_ratio`], multiples of the powers of 1/`ratio` modulo 1.
#[must_use]
pub fn even_share(ratio: f64, k: u32, place: usize) -> f64 {
    (0.5 + f64::from(k) * ratio.powi(-(place as i32 + 1))).fract()
}

/// The least-squares line through points (x, y).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastSquaresLine {
    /// Change of y per x.
    pub slope: f64,
    /// Σ (x - x̄)².
    pub sxx: f64,
    /// Sum of the squared residuals of y.
    pub residual_squares: f64,
    /// Mean of x and of y, a point of the line.
    pub mean: (f64, f64),
}

impl LeastSquaresLine {
    /// `None` without two different x.
    #[must_use]
    pub fn through(points: impl Iterator<Item = (f64, f64)> + Clone) -> Option<Self> {
        let n = points.clone().count() as f64;
        let mean_x = points.clone().map(|(x, _)| x).sum::<f64>() / n;
        let mean_y = points.clone().map(|(_, y)| y).sum::<f64>() / n;
        let centred = points.map(|(x, y)| (x - mean_x, y - mean_y));
        let sxx: f64 = centred.clone().map(|(x, _)| x.powi(2)).sum();
        let slope = centred.clone().map(|(x, y)| x * y).sum::<f64>() / sxx;
        let residual_squares = centred.map(|(x, y)| (y - slope * x).powi(2)).sum();
        slope.is_finite().then_some(Self {
            slope,
            sxx,
            residual_squares,
            mean: (mean_x, mean_y),
        })
    }

    /// The value of the line at x.
    #[must_use]
    pub fn at(&self, x: f64) -> f64 {
        self.mean.1 + self.slope * (x - self.mean.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coverage_factors_are_those_of_gum_table_g2() {
        // GUM (JCGM 100:2008) table G.2, column 95 %.
        for (dof, k) in [(1.0, 12.71), (4.0, 2.78), (9.0, 2.26), (50.0, 2.01)] {
            let found = student_t_quantile(0.975, dof).unwrap();
            assert!((found - k).abs() < 0.005, "dof {dof}: {found}");
        }
        assert!((student_t_quantile(0.975, f64::INFINITY).unwrap() - 1.959_964).abs() < 1e-6);
        assert_eq!(student_t_quantile(0.975, 0.0), None);
    }

    #[test]
    fn effective_degrees_of_freedom_are_those_of_gum_h1() {
        // GUM H.1.6: components 25, 9.7, 2.9, 16.6 nm with 18, 25.6, 50, 2 degrees of freedom give 16.7.
        let components = [(25.0, 18.0), (9.7, 25.6), (2.9, 50.0), (16.6, 2.0)];
        let dof = welch_satterthwaite(&components);
        assert!((dof - 16.7).abs() < 0.3, "{dof}");
    }

    #[test]
    fn shares_have_the_intervals_of_clopper_and_pearson() {
        // R 4, binom.test(hits, trials)$conf.int.
        for (hits, trials, low, high) in [
            (0, 10, 0.0, 0.308_497),
            (5, 10, 0.187_086, 0.812_914),
            (10, 10, 0.691_503, 1.0),
            (40, 1000, 0.028_730, 0.054_059),
        ] {
            let [a, b] = binomial_interval_95(hits, trials).unwrap();
            assert!((a - low).abs() < 1e-4, "{hits}/{trials}: {a}");
            assert!((b - high).abs() < 1e-4, "{hits}/{trials}: {b}");
        }
        // 1 - 0.05^(1/10)
        assert!((binomial_upper_95(0, 10).unwrap() - 0.258_866).abs() < 1e-5);
        assert_eq!(binomial_interval_95(0, 0), None);
    }

    fn is_near(found: f64, expected: f64, within: f64) {
        assert!(
            (found - expected).abs() < within,
            "{found}, expected {expected}"
        );
    }

    #[test]
    fn estimates_have_expanded_uncertainties_and_intervals() {
        let estimate = Estimate {
            value: 10.0,
            standard_uncertainty: 0.5,
            dof: 4.0,
        };
        // GUM table G.2: k = 2.776 for 4 degrees of freedom.
        is_near(estimate.expanded_95().unwrap(), 1.388, 1e-3);
        let [low, high] = estimate.interval_95().unwrap();
        is_near(low, 8.612, 1e-3);
        is_near(high, 11.388, 1e-3);
        assert_eq!(Estimate::without_uncertainty(1.0).expanded_95(), None);
        assert_eq!(Estimate::without_uncertainty(1.0).interval_95(), None);
        assert_eq!(student_t_quantile(0.975, 0.5), None);
        assert_eq!(student_t_quantile(0.975, f64::NAN), None);
    }

    #[test]
    fn distributions_have_the_values_of_tables() {
        // One degree of freedom: the density of Cauchy, 1/(pi (1 + t^2)).
        let pi = std::f64::consts::PI;
        is_near(student_t_log_density(0.0, 1.0).unwrap(), -pi.ln(), 1e-12);
        is_near(
            student_t_log_density(1.0, 1.0).unwrap(),
            -(2.0 * pi).ln(),
            1e-12,
        );
        // NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7.1, .3 and .4.
        is_near(normal_upper_tail(1.96), 0.0250, 5e-5);
        is_near(normal_upper_tail(-1.0), 0.8413, 5e-5);
        is_near(chi_squared_quantile(0.95, 10.0).unwrap(), 18.307, 5e-4);
        is_near(chi_squared_upper_tail(18.307, 10.0).unwrap(), 0.05, 1e-5);
        is_near(f_upper_tail(3.708, 3.0, 10.0).unwrap(), 0.05, 1e-4);
        assert_eq!(f_upper_tail(1.0, 0.0, 10.0), None);
        assert_eq!(chi_squared_quantile(0.5, 0.0), None);
    }

    #[test]
    fn the_even_sequence_has_the_ratios_of_its_source() {
        // Roberts (2018): golden ratio and plastic number, and the first points of R_2 from them.
        is_near(golden_ratio(1), 1.618_033_988_749_895, 1e-15);
        let plastic = golden_ratio(2);
        is_near(plastic, 1.324_717_957_244_746, 1e-15);
        is_near(even_share(plastic, 0, 0), 0.5, 1e-15);
        is_near(even_share(plastic, 1, 0), 0.254_877_666_246_693, 1e-12);
        is_near(even_share(plastic, 1, 1), 0.069_840_290_998_053, 1e-12);
        is_near(even_share(plastic, 2, 0), 0.009_755_332_493_386, 1e-12);
    }

    #[test]
    fn a_line_through_points_worked_by_hand() {
        // Means 1.5 and 4, sxx 5, sxy 11; residuals 0.3, 0.1, -1.1, 0.7.
        let points = [(0.0, 1.0), (1.0, 3.0), (2.0, 4.0), (3.0, 8.0)];
        let line = LeastSquaresLine::through(points.into_iter()).unwrap();
        is_near(line.slope, 2.2, 1e-12);
        is_near(line.sxx, 5.0, 1e-12);
        is_near(line.residual_squares, 1.8, 1e-12);
        is_near(line.at(0.0), 0.7, 1e-12);
        let alike = [(1.0, 2.0); 3];
        assert_eq!(LeastSquaresLine::through(alike.into_iter()), None);
    }

    #[test]
    fn components_that_are_zero_do_not_count() {
        let dof = welch_satterthwaite(&[(1.0, 8.0), (0.0, 0.0), (1.0, f64::INFINITY)]);
        // (1 + 1)^2 / (1/8)
        is_near(dof, 32.0, 1e-12);
        assert_eq!(welch_satterthwaite(&[(1.0, f64::INFINITY)]), f64::INFINITY);
    }

    #[test]
    fn means_medians_and_standard_deviations() {
        let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
        assert_eq!(mean(&values), Some(5.0));
        // sqrt(32/7)
        is_near(standard_deviation(&values).unwrap(), 2.138_090, 1e-6);
        is_near(
            standard_deviation(&[1.0, 3.0]).unwrap(),
            std::f64::consts::SQRT_2,
            1e-12,
        );
        assert_eq!(standard_deviation(&[1.0]), None);
        assert_eq!(standard_deviation(&[]), None);
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(&mut [9.0, 1.0, 2.0, 3.0, 4.0]), Some(3.0));
        assert_eq!(median(&mut [1.0, 2.0]), Some(1.5));
        assert_eq!((mean(&[]), median(&mut [])), (None, None));
    }
}
