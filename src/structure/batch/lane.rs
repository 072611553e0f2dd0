//! One number for each of several poses, and arithmetic on all of them at once.
//!
//! Kernels are written once over a [`Lane`], whose length and instructions are those of an instruction set S of the crate `pulp`,
//! chosen when the program runs: eight poses with AVX-512, four with AVX2, two with NEON, one where there is none of these. Between
//! sets results may differ by the rounding of fused products; for a given set they are the same on every machine and for any number
//! of threads.
//!
//! Decision: vector types, not loops over arrays that the compiler is trusted to vectorise. Such loops were tried: some were
//! vectorised along the wrong subscript, for three times the run time, and fused products in a function that was not inlined became
//! calls of software. Price: a dependency, which the linear algebra has anyway, and that every function here must be inlined.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use pulp::{Simd, WithSimd, bytemuck};

/// The same quantity in as many poses as a register of S holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lane<S: Simd> {
    simd: S,
    values: S::f64s,
}

impl<S: Simd> Lane<S> {
    /// Number of poses.
    pub(super) const COUNT: usize = S::F64_LANES;

    #[inline(always)]
    pub(super) fn splat(simd: S, value: f64) -> Self {
        Self {
            simd,
            values: simd.splat_f64s(value),
        }
    }

    /// The same number in every pose of the same set.
    #[inline(always)]
    pub(super) fn of(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        Self::splat(simd, 0.0)
    }

    #[inline(always)]
    pub(super) fn one(simd: S) -> Self {
        Self::splat(simd, 1.0)
    }

    #[inline(always)]
    pub(super) fn inverse(self) -> Self {
        self.of(1.0) / self
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        Self {
            values: self.simd.sqrt_f64s(self.values),
            ..self
        }
    }

    #[inline(always)]
    pub(super) fn simd(self) -> S {
        self.simd
    }

    /// 0 where `self` < `limit`, 1 elsewhere and for NaN.
    #[inline(always)]
    pub(super) fn fault_unless_below(self, limit: Self) -> Self {
        let below = self.simd.less_than_f64s(self.values, limit.values);
        let (zero, one) = (self.simd.splat_f64s(0.0), self.simd.splat_f64s(1.0));
        Self {
            values: self.simd.select_f64s(below, zero, one),
            ..self
        }
    }

    /// The number of one pose.
    pub(super) fn get(&self, pose: usize) -> f64 {
        bytemuck::cast_slice(std::slice::from_ref(&self.values))[pose]
    }

    /// Sets the number of one pose.
    pub(super) fn set(&mut self, pose: usize, value: f64) {
        bytemuck::cast_slice_mut(std::slice::from_mut(&mut self.values))[pose] = value;
    }
}

macro_rules! by_lane {
    ($trait:ident, $method:ident, $of_set:ident) => {
        impl<S: Simd> $trait for Lane<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self {
                    values: self.simd.$of_set(self.values, other.values),
                    ..self
                }
            }
        }
    };
}

by_lane!(Add, add, add_f64s);
by_lane!(Sub, sub, sub_f64s);
by_lane!(Mul, mul, mul_f64s);
by_lane!(Div, div, div_f64s);

impl<S: Simd> Neg for Lane<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            values: self.simd.neg_f64s(self.values),
            ..self
        }
    }
}

impl<S: Simd> AddAssign for Lane<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> SubAssign for Lane<S> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// a b + c, rounded once where the set can.
#[inline(always)]
pub(super) fn multiply_add<S: Simd>(a: Lane<S>, b: Lane<S>, c: Lane<S>) -> Lane<S> {
    Lane {
        values: a.simd.mul_add_e_f64s(a.values, b.values, c.values),
        ..a
    }
}

/// c - a b, rounded once where the set can.
#[inline(always)]
pub(super) fn multiply_subtract<S: Simd>(a: Lane<S>, b: Lane<S>, c: Lane<S>) -> Lane<S> {
    Lane {
        values: a.simd.negate_mul_add_e_f64s(a.values, b.values, c.values),
        ..a
    }
}

/// Scalar product.
#[inline(always)]
pub(super) fn dot<S: Simd>(a: &[Lane<S>; 3], b: &[Lane<S>; 3]) -> Lane<S> {
    multiply_add(a[2], b[2], multiply_add(a[1], b[1], a[0] * b[0]))
}

/// Vector product.
#[inline(always)]
pub(super) fn cross<S: Simd>(a: &[Lane<S>; 3], b: &[Lane<S>; 3]) -> [Lane<S>; 3] {
    [
        multiply_subtract(a[2], b[1], a[1] * b[2]),
        multiply_subtract(a[0], b[2], a[2] * b[0]),
        multiply_subtract(a[1], b[0], a[0] * b[1]),
    ]
}

/// A vector times a number.
#[inline(always)]
pub(super) fn scale<S: Simd>(a: &[Lane<S>; 3], factor: Lane<S>) -> [Lane<S>; 3] {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

/// a - b.
#[inline(always)]
pub(super) fn subtract<S: Simd>(a: &[Lane<S>; 3], b: &[Lane<S>; 3]) -> [Lane<S>; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Work that is compiled for an instruction set.
///
/// What it calls must be `#[inline(always)]`, closures included where they do arithmetic: the rest is compiled for the least machine
/// of the target and calls every vector instruction as a function.
pub(super) trait Kernel {
    fn run(self);
}

/// Runs a kernel with the instructions of a set.
#[inline]
pub(super) fn run<S: Simd>(simd: S, kernel: impl Kernel) {
    simd.vectorize(Within(kernel));
}

struct Within<K>(K);

impl<K: Kernel> WithSimd for Within<K> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.0.run();
    }
}
