//! Vectors of rows.

use std::borrow::Cow;
use std::ops::Range;

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

/// Takes a vector's parts along orthonormal vectors out of it, one after the other.
pub fn take_out(units: &[Vec<f64>], vector: &mut [f64]) {
    for unit in units {
        let product = dot(unit, vector);
        subtract(vector, product, unit);
    }
}

/// The largest size of some numbers, 0 of none.
pub fn largest<'v>(values: impl IntoIterator<Item = &'v f64>) -> f64 {
    let sizes = values.into_iter().map(|value| value.abs());
    sizes.fold(0.0, f64::max)
}

/// Multiplies numbers by as many others, in place.
#[inline]
pub(super) fn multiply(values: &mut [f64], by: &[f64]) {
    for (value, factor) in values.iter_mut().zip(by) {
        *value *= factor;
    }
}

/// Divides them.
#[inline]
pub(super) fn divide(values: &mut [f64], by: &[f64]) {
    for (value, divisor) in values.iter_mut().zip(by) {
        *value /= divisor;
    }
}

/// Adds a vector to orthonormal ones, unless what is new in it is no longer than a share of its length, or than a length.
pub fn push_orthonormal(units: &mut Vec<Vec<f64>>, mut vector: Vec<f64>, share: f64, least: f64) {
    let before = norm(&vector);
    // Twice: once leaves rounding errors of the size of the vectors before.
    for _ in 0..2 {
        take_out(units, &mut vector);
    }
    let after = norm(&vector);
    if after > 0.0 && after > share * before && after > least {
        for value in &mut vector {
            *value /= after;
        }
        units.push(vector);
    }
}

/// A vector that is zero outside some rows, of which alone it takes memory.
#[derive(Debug, Clone, PartialEq)]
pub struct RowVector {
    /// The first of the rows.
    pub first: usize,
    /// One number for each of them.
    pub values: Vec<f64>,
}

impl From<Vec<f64>> for RowVector {
    /// A vector of all rows.
    fn from(values: Vec<f64>) -> Self {
        Self { first: 0, values }
    }
}

impl RowVector {
    /// Its rows.
    #[must_use]
    pub fn rows(&self) -> Range<usize> {
        self.first..self.first + self.values.len()
    }

    /// What it is in one of its rows; `None` outside them.
    #[must_use]
    pub fn at(&self, row: usize) -> Option<f64> {
        self.values.get(row.checked_sub(self.first)?).copied()
    }

    /// What it is in some rows.
    #[must_use]
    pub fn part(&self, rows: &Range<usize>) -> Cow<'_, [f64]> {
        let own = self.rows();
        if own.start <= rows.start && rows.end <= own.end {
            return Cow::Borrowed(&self.values[rows.start - own.start..rows.end - own.start]);
        }
        let mut part = vec![0.0; rows.len()];
        let both = own.start.max(rows.start)..own.end.min(rows.end);
        if !both.is_empty() {
            let from = both.start - own.start..both.end - own.start;
            part[both.start - rows.start..both.end - rows.start]
                .copy_from_slice(&self.values[from]);
        }
        Cow::Owned(part)
    }

    /// Scalar product with a vector that has at least its rows.
    #[must_use]
    pub fn dot(&self, other: &[f64]) -> f64 {
        dot(&self.values, &other[self.rows()])
    }

    /// Scalar product with another of its kind.
    #[must_use]
    pub fn dot_part(&self, other: &Self) -> f64 {
        let both = self.first.max(other.first)..self.rows().end.min(other.rows().end);
        if both.is_empty() {
            return 0.0;
        }
        dot(&self.part(&both), &other.part(&both))
    }

    /// Takes a multiple of another off this one, which then has the rows of both.
    fn subtract(&mut self, multiple: f64, other: &Self) {
        let (own, others) = (self.rows(), other.rows());
        let both = own.start.min(others.start)..own.end.max(others.end);
        if own != both {
            *self = Self {
                first: both.start,
                values: self.part(&both).into_owned(),
            };
        }
        let start = others.start - both.start;
        subtract(
            &mut self.values[start..start + others.len()],
            multiple,
            &other.values,
        );
    }

    /// All rows of it.
    ///
    /// # Arguments
    /// - `length`: how many there are.
    #[must_use]
    pub fn whole(&self, length: usize) -> Vec<f64> {
        self.part(&(0..length)).into_owned()
    }
}

/// [`push_orthonormal`] of vectors of some rows: those without a common row are orthogonal as they are.
pub fn push_orthonormal_rows(units: &mut Vec<RowVector>, mut vector: RowVector, share: f64) {
    let before = norm(&vector.values);
    for _ in 0..2 {
        for unit in units.iter() {
            let product = unit.dot_part(&vector);
            if product != 0.0 {
                vector.subtract(product, unit);
            }
        }
    }
    let after = norm(&vector.values);
    if after > 0.0 && after > share * before {
        for value in &mut vector.values {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vector_of_some_rows_is_zero_elsewhere() {
        let vector = RowVector {
            first: 2,
            values: vec![1.0, 2.0, 3.0],
        };
        let whole = vec![0.0, 0.0, 1.0, 2.0, 3.0, 0.0];
        assert_eq!(vector.whole(6), whole);
        for rows in [0..1, 0..3, 2..5, 3..4, 4..6, 5..6, 0..6] {
            assert_eq!(*vector.part(&rows), whole[rows]);
        }
        let other = vec![1.0, 10.0, 100.0, 1000.0, 1e4, 1e5];
        assert_eq!(vector.dot(&other), dot(&whole, &other));
        let behind = RowVector {
            first: 4,
            values: vec![7.0, 8.0],
        };
        assert_eq!(vector.dot_part(&behind), 21.0);
        assert_eq!(behind.dot_part(&vector), 21.0);
        let apart = RowVector {
            first: 5,
            values: vec![7.0],
        };
        assert_eq!(vector.dot_part(&apart), 0.0);
        let mut less = vector;
        less.subtract(10.0, &behind);
        assert_eq!(less.whole(6), vec![0.0, 0.0, 1.0, 2.0, -67.0, -80.0]);
    }
}
