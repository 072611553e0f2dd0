//! What formulas are written over once: a number, or one number a pose.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A real number: one `f64`, or one in each [`Lane`](super::Lane).
///
/// Constants are made [`Number::of`] a number at hand, which knows its instruction set.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// A constant.
    #[must_use]
    fn of(self, value: f64) -> Self;

    /// a b + c with a = `self`, rounded once where the instruction set can.
    #[must_use]
    fn multiply_add(self, b: Self, c: Self) -> Self;

    /// c - a b with a = `self`, rounded once where the instruction set can.
    #[must_use]
    fn multiply_subtract(self, b: Self, c: Self) -> Self;

    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Absolute value.
    #[must_use]
    fn abs(self) -> Self;

    /// The larger of two; which of them where one is no number depends on the instruction set.
    #[must_use]
    fn max(self, other: Self) -> Self;

    /// `below` where `self` < `limit`, `otherwise` elsewhere and for NaN.
    #[must_use]
    fn choose(self, limit: Self, below: Self, otherwise: Self) -> Self;

    /// Reciprocal.
    #[must_use]
    #[inline(always)]
    fn inverse(self) -> Self {
        self.of(1.0) / self
    }

    /// 0 where `self` < `limit`, 1 elsewhere and for NaN.
    #[must_use]
    #[inline(always)]
    fn fault_unless_below(self, limit: Self) -> Self {
        self.choose(limit, self.of(0.0), self.of(1.0))
    }
}

impl Number for f64 {
    #[inline(always)]
    fn of(self, value: f64) -> Self {
        value
    }

    // Without a fused product of the machine, one would be a call of software.
    #[inline(always)]
    fn multiply_add(self, b: Self, c: Self) -> Self {
        self * b + c
    }

    #[inline(always)]
    fn multiply_subtract(self, b: Self, c: Self) -> Self {
        c - self * b
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.max(other)
    }

    #[inline(always)]
    fn choose(self, limit: Self, below: Self, otherwise: Self) -> Self {
        if self < limit { below } else { otherwise }
    }
}

/// a b + c.
#[inline(always)]
pub fn multiply_add<T: Number>(a: T, b: T, c: T) -> T {
    a.multiply_add(b, c)
}

/// c - a b.
#[inline(always)]
pub fn multiply_subtract<T: Number>(a: T, b: T, c: T) -> T {
    a.multiply_subtract(b, c)
}

/// Scalar product.
#[inline(always)]
pub fn dot<T: Number>(a: &[T; 3], b: &[T; 3]) -> T {
    multiply_add(a[2], b[2], multiply_add(a[1], b[1], a[0] * b[0]))
}

/// Vector product.
#[inline(always)]
pub fn cross<T: Number>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    [
        multiply_subtract(a[2], b[1], a[1] * b[2]),
        multiply_subtract(a[0], b[2], a[2] * b[0]),
        multiply_subtract(a[1], b[0], a[0] * b[1]),
    ]
}

/// A vector times a number.
#[inline(always)]
pub fn scale<T: Number>(a: &[T; 3], factor: T) -> [T; 3] {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

/// a - b.
#[inline(always)]
pub fn subtract<T: Number>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// What is left of a vector at right angles to a unit vector.
#[inline(always)]
pub fn across<T: Number>(v: &[T; 3], unit: &[T; 3]) -> [T; 3] {
    let along = dot(v, unit);
    [
        multiply_subtract(along, unit[0], v[0]),
        multiply_subtract(along, unit[1], v[1]),
        multiply_subtract(along, unit[2], v[2]),
    ]
}

/// A right-handed frame on a normal: the normal, and two unit vectors at right angles to it.
#[inline(always)]
pub fn frame_on<T: Number>(normal: &[T; 3]) -> [[T; 3]; 3] {
    // The global axis farthest from the normal fixes the second axis: its part across the normal is at least √(2/3) long.
    let [x, y, z] = [
        normal[0] * normal[0],
        normal[1] * normal[1],
        normal[2] * normal[2],
    ];
    let (one, zero) = (x.of(1.0), x.of(0.0));
    // One where y is least, where it is not but x is, and where neither is.
    let of_y = x.choose(y, zero, z.choose(y, zero, one));
    let of_x = (one - of_y) * z.choose(x, zero, one);
    let hint = [of_x, of_y, one - of_y - of_x];
    let first = across(&hint, normal);
    let first = scale(&first, dot(&first, &first).sqrt().inverse());
    [*normal, first, cross(normal, &first)]
}
