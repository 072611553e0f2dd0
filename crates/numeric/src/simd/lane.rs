//! The number type of the lanes, and how kernels over it are run.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use pulp::{Simd, WithSimd, bytemuck};

use super::number::Number;

/// Something in memory whose lanes start on cache lines.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct Aligned<T>(pub T);

/// The same quantity in as many poses as a register of S holds.
#[derive(Debug, Clone, Copy)]
pub struct Lane<S: Simd> {
    simd: S,
    values: S::f64s,
}

impl<S: Simd> Lane<S> {
    /// Number of poses.
    pub const COUNT: usize = S::F64_LANES;

    /// One value in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self {
            simd,
            values: simd.splat_f64s(value),
        }
    }

    /// The first numbers of a slice; zero where it has none.
    #[inline(always)]
    pub fn read(simd: S, values: &[f64]) -> Self {
        Self {
            simd,
            values: simd.partial_load_f64s(values),
        }
    }

    /// Writes as many numbers as a slice has room for.
    #[inline(always)]
    pub fn write(self, out: &mut [f64]) {
        self.simd.partial_store_f64s(out, self.values);
    }

    /// Nought in every lane.
    #[inline(always)]
    pub fn zero(simd: S) -> Self {
        Self::splat(simd, 0.0)
    }

    /// One in every lane.
    #[inline(always)]
    pub fn one(simd: S) -> Self {
        Self::splat(simd, 1.0)
    }

    /// The instruction set.
    #[inline(always)]
    pub fn simd(self) -> S {
        self.simd
    }

    /// Whether all poses have the same number in both; none has with NaN.
    pub fn is_same(&self, other: &Self) -> bool {
        let numbers = |lane: &Self| -> [f64; 8] {
            let mut numbers = [0.0; 8];
            let values: &[f64] = bytemuck::cast_slice(std::slice::from_ref(&lane.values));
            numbers[..values.len()].copy_from_slice(values);
            numbers
        };
        numbers(self) == numbers(other)
    }

    /// The number of one pose.
    pub fn get(&self, pose: usize) -> f64 {
        bytemuck::cast_slice(std::slice::from_ref(&self.values))[pose]
    }

    /// Sets the number of one pose.
    pub fn set(&mut self, pose: usize, value: f64) {
        bytemuck::cast_slice_mut(std::slice::from_mut(&mut self.values))[pose] = value;
    }
}

impl<S: Simd> Number for Lane<S> {
    #[inline(always)]
    fn of(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    #[inline(always)]
    fn multiply_add(self, b: Self, c: Self) -> Self {
        Self {
            values: self.simd.mul_add_e_f64s(self.values, b.values, c.values),
            ..self
        }
    }

    #[inline(always)]
    fn multiply_subtract(self, b: Self, c: Self) -> Self {
        Self {
            values: self
                .simd
                .negate_mul_add_e_f64s(self.values, b.values, c.values),
            ..self
        }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self {
            values: self.simd.sqrt_f64s(self.values),
            ..self
        }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self {
            values: self.simd.abs_f64s(self.values),
            ..self
        }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self {
            values: self.simd.max_f64s(self.values, other.values),
            ..self
        }
    }

    #[inline(always)]
    fn choose(self, limit: Self, below: Self, otherwise: Self) -> Self {
        let mask = self.simd.less_than_f64s(self.values, limit.values);
        Self {
            values: self.simd.select_f64s(mask, below.values, otherwise.values),
            ..self
        }
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

/// Work that is compiled for an instruction set.
///
/// What it calls must be `#[inline(always)]`, closures included where they do arithmetic: the rest is compiled for the least machine
/// of the target and calls every vector instruction as a function.
pub trait Kernel {
    /// Does the work.
    fn run(self);
}

/// Runs a kernel with the instructions of a set.
#[inline]
pub fn run<S: Simd>(simd: S, kernel: impl Kernel) {
    simd.vectorize(Within(kernel));
}

/// Runs a loop with the instructions of the widest set of this machine: the compiler makes lanes of it.
///
/// For loops over slices whose sums stand side by side already: the results are the same with every set. What is called in it must be
/// `#[inline(always)]`.
#[inline]
pub fn widest<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

struct Within<K>(K);

impl<K: Kernel> WithSimd for Within<K> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.0.run();
    }
}
