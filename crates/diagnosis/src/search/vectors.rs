//! Vectors of rows.

use stiffbench_numeric::lanes::{sums_side_by_side, widest};

/// Scalar product.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    widest(
        #[inline(always)]
        || sums_side_by_side(a, b),
    )
}

/// Euclidean length.
#[must_use]
pub fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Takes a multiple of a vector off another.
pub fn subtract(vector: &mut [f64], multiple: f64, other: &[f64]) {
    for (value, other) in vector.iter_mut().zip(other) {
        *value -= multiple * other;
    }
}
