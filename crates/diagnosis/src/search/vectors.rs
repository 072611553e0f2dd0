//! Vectors of rows.

use stiffbench_numeric::simd::{sums_side_by_side, widest};

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

/// Adds a vector to orthonormal ones, unless what is new in it is no longer than a share of its length, or than a length.
pub fn push_orthonormal(units: &mut Vec<Vec<f64>>, mut vector: Vec<f64>, share: f64, least: f64) {
    let before = norm(&vector);
    // Twice: once leaves rounding errors of the size of the vectors before.
    for _ in 0..2 {
        for unit in units.iter() {
            let product = dot(unit, &vector);
            subtract(&mut vector, product, unit);
        }
    }
    let after = norm(&vector);
    if after > 0.0 && after > share * before && after > least {
        for value in &mut vector {
            *value /= after;
        }
        units.push(vector);
    }
}

/// Takes a multiple of a vector off another.
pub fn subtract(vector: &mut [f64], multiple: f64, other: &[f64]) {
    for (value, other) in vector.iter_mut().zip(other) {
        *value -= multiple * other;
    }
}
