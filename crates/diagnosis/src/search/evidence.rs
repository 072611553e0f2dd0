//! What a score is worth: under a covariance that was estimated, against no effect, and beside another candidate.

use stiffbench_numeric::statistics::{chi_squared_quantile, f_upper_tail};

use super::constants::DISTINGUISHABLE;

/// Log Bayes factor by which a rival must be behind whose effect has a cosine κ with the winner's: this times κ⁴, for the rows that speak for the one say less of the
/// other. By hand (7c24409): right sets 95.1, 95.3, 98.9 % at 4.5, 6, 8 standard errors; 95.3, 93.7, 98.5 % with 5 κ² (seed 709).
const DISTINGUISHABLE_BY_COSINE: f64 = 8.0;

/// The Δχ² that would be as rare as another if the covariance were known exactly: F to χ².
///
/// # Arguments
/// - `amplitudes`: along which Δχ² grows on noise alone: 1, or 2 of a candidate with a phase.
/// - `dof`: degrees of freedom of the estimated variance.
#[must_use]
pub fn under_known_covariance(delta_chi2: f64, amplitudes: f64, dof: f64) -> f64 {
    if dof > 1e5 || delta_chi2 <= 0.0 {
        return delta_chi2;
    }
    let Some(p) = f_upper_tail(delta_chi2 / amplitudes, amplitudes, dof) else {
        return delta_chi2;
    };
    // Beyond what the tail can say in 16 digits the effect needs no exact critical value.
    if p < 1e-14 {
        return delta_chi2.min(60.0);
    }
    chi_squared_quantile(1.0 - p, amplitudes).unwrap_or(delta_chi2)
}

/// Chance that at least one of so many independent events of one chance occurs: of a family of tests that of its least p (Šidák, Journal of
/// the American Statistical Association 62, 1967).
#[must_use]
pub fn chance_of_any(one: f64, count: f64) -> f64 {
    -(count * (-one).ln_1p()).exp_m1()
}

/// Logarithm of the Bayes factor of a candidate against no effect.
///
/// The prior of a candidate is such that a Δχ² at its critical value leaves it even: one whose many shapes noise imitates well must be that
/// much better than one with a single shape, and the odds of no effect do not depend on what its size was thought to be. Beyond the
/// critical value each parameter that was fitted costs what it is known better by (Laplace's approximation; Kass & Raftery, Journal of
/// the American Statistical Association 90, 1995, p. 777).
///
/// # Arguments
/// - `parameters`: how many were fitted.
#[must_use]
pub fn log_bayes(delta_chi2: f64, critical_value: f64, parameters: usize) -> f64 {
    let known_better = 0.5 * (delta_chi2.max(critical_value) / critical_value).ln();
    0.5 * (delta_chi2 - critical_value) - parameters as f64 * known_better
}

/// Whether the data distinguish a rival from the likeliest candidate.
///
/// # Arguments
/// - `behind`: log Bayes factor by which it is behind.
/// - `squared_cosine`: of the angle between the two effects, white and projected.
#[must_use]
pub fn distinguishable(behind: f64, squared_cosine: f64) -> bool {
    behind > (DISTINGUISHABLE_BY_COSINE * squared_cosine.powi(2)).min(DISTINGUISHABLE)
}
