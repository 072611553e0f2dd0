//! The prior mass that a fitted candidate is judged against: what makes a law with many shapes pay for them.

use crate::physics::{Law, Sign};

use super::candidate::Candidate;
use super::screen::{WhiteCandidate, WhiteShape};

/// Logarithm of the prior mass that the size's standard error covers: a half-Cauchy about zero (both halves where both signs are
/// possible), whose scale is the largest plausible size and whose tail leaves room for gross faults.
pub(super) fn log_size_prior(candidate: &Candidate, size: f64, length: f64) -> f64 {
    if length == 0.0 || size == 0.0 || candidate.law == Law::LooseMember {
        return 0.0;
    }
    let standard_error = size.abs() / length;
    let relative = size / candidate.largest;
    let density = std::f64::consts::FRAC_1_PI / (candidate.largest * (1.0 + relative * relative));
    let one_sided = candidate
        .law
        .parameters()
        .first()
        .is_some_and(|parameter| parameter.sign == Sign::Positive);
    let halves = if one_sided { 2.0 } else { 1.0 };
    let covered = (std::f64::consts::TAU).sqrt() * standard_error * density * halves;
    let mut log = covered.min(1.0).ln();
    if candidate.law == Law::GaugePeriodic {
        // Any phase is as likely: of the circle with the radius of the amplitude the standard error covers its share.
        log -= (std::f64::consts::TAU.sqrt() * length).ln().max(0.0);
    }
    log
}

/// Logarithm of the prior mass of the shapes that serve about as well as the best.
pub(super) fn log_shape_prior(white: &WhiteCandidate, residuals: &[f64]) -> f64 {
    let gains: Vec<(f64, f64)> = white
        .shapes
        .iter()
        .map(|shape: &WhiteShape| (shape.shape.weight, shape.gain(residuals).1))
        .collect();
    let best = gains
        .iter()
        .fold(0.0_f64, |best, (_, gain)| best.max(*gain));
    let sum: f64 = gains
        .iter()
        .map(|(weight, gain)| weight * (0.5 * (gain - best)).exp())
        .sum();
    sum.max(f64::MIN_POSITIVE).ln()
}
