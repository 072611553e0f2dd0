//! Lanczos1 in offsets from the values it was generated from.
//!
//! The data of Lanczos1 are its model rounded to 14 digits: the certified residuals are of the size 1e-13 beside values of 2.5, and in
//! `f64` both the model and the parameters are rounded to 1e-16 of themselves, so that only three digits of a residual are
//! left whatever the solver does. With the parameters counted from the generating values b⁰, and f(b⁰) − y computed once with 32
//! digits, the residuals f(b⁰) − y + [f(b⁰ + β) − f(b⁰)] have all their digits again and the standard deviations can be checked.

use stiffbench_numeric::least_squares::{EvaluationFailure, JacobianView, ResidualFunction};

/// A number as the sum of two, about 32 digits.
///
/// Source of the sums and products: Dekker, Numerische Mathematik 18 (1971) 224, with a fused multiplication.
#[derive(Clone, Copy)]
struct Double {
    high: f64,
    low: f64,
}

impl Double {
    const ONE: Self = Self {
        high: 1.0,
        low: 0.0,
    };

    fn of(value: f64) -> Self {
        Self {
            high: value,
            low: 0.0,
        }
    }

    fn normalised(high: f64, low: f64) -> Self {
        let sum = high + low;
        Self {
            high: sum,
            low: low - (sum - high),
        }
    }

    fn plus(self, other: Self) -> Self {
        let sum = self.high + other.high;
        let part = sum - self.high;
        let error = (self.high - (sum - part)) + (other.high - part);
        Self::normalised(sum, error + self.low + other.low)
    }

    fn times(self, other: Self) -> Self {
        let product = self.high * other.high;
        let error = self.high.mul_add(other.high, -product);
        Self::normalised(
            product,
            error + self.high * other.low + self.low * other.high,
        )
    }

    fn over(self, divisor: f64) -> Self {
        let quotient = self.high / divisor;
        let rest = self.plus(Self::of(divisor).times(Self::of(-quotient)));
        Self::normalised(quotient, rest.high / divisor)
    }

    /// Taylor's series at a 1024th of the argument, squared ten times.
    fn exp(self) -> Self {
        let small = self.over(1024.0);
        let mut sum = Self::ONE;
        for k in (1..=14).rev() {
            sum = Self::ONE.plus(small.times(sum).over(f64::from(k)));
        }
        (0..10).fold(sum, |power, _| power.times(power))
    }
}

/// 0.0951, 0.8607, 1.5576 with rates 1, 3, 5, in ten-thousandths.
const AMPLITUDES: [f64; 3] = [951.0, 8607.0, 15576.0];
const RATES: [f64; 3] = [1.0, 3.0, 5.0];

/// The generating values in the order of the parameters.
pub(crate) const GENERATING: [f64; 6] = [0.0951, 1.0, 0.8607, 3.0, 1.5576, 5.0];

pub(crate) struct Lanczos1InOffsets {
    x: Vec<f64>,
    residuals_at_generating: Vec<f64>,
}

impl Lanczos1InOffsets {
    pub(crate) fn new(observations: &[(f64, [f64; 2])]) -> Self {
        let residual = |i: usize, y: f64| {
            let x = Double::of(5.0 * i as f64).over(100.0);
            let decay = |k: usize| {
                let power = x.times(Double::of(-RATES[k])).exp();
                Double::of(AMPLITUDES[k]).over(1e4).times(power)
            };
            // The file gives y with at most 14 decimals; as an integer over a power of ten it is exact.
            let y = Double::of((y * 1e14).round()).over(1e14);
            let sum = decay(0).plus(decay(1)).plus(decay(2));
            sum.plus(Double {
                high: -y.high,
                low: -y.low,
            })
            .high
        };
        let rows = observations.iter().enumerate();
        Self {
            x: rows.clone().map(|(i, _)| 0.05 * i as f64).collect(),
            residuals_at_generating: rows.map(|(i, &(y, _))| residual(i, y)).collect(),
        }
    }
}

impl ResidualFunction for Lanczos1InOffsets {
    fn residual_count(&self) -> usize {
        self.x.len()
    }

    fn evaluate(
        &mut self,
        offsets: &[f64],
        residuals: &mut [f64],
        mut jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        for (i, &x) in self.x.iter().enumerate() {
            residuals[i] = self.residuals_at_generating[i];
            for k in 0..3 {
                let (amplitude, rate) = (GENERATING[2 * k], GENERATING[2 * k + 1]);
                let (a, r) = (offsets[2 * k], offsets[2 * k + 1]);
                let slower = (-r * x).exp_m1();
                residuals[i] += (-rate * x).exp() * ((amplitude + a) * slower + a);
                if let Some(jacobian) = jacobian.as_deref_mut() {
                    let power = (-(rate + r) * x).exp();
                    jacobian.set(i, 2 * k, power);
                    jacobian.set(i, 2 * k + 1, -x * (amplitude + a) * power);
                }
            }
        }
        Ok(())
    }
}
