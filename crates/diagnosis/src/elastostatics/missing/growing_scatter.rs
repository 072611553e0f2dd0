//! Scatter that may grow with the size of what is read, as that of loads that are applied anew does.

use nalgebra::{Matrix3, Vector3};

use stiffbench_numeric::statistics::f_upper_tail;

/// Rounds: each changes the weights less than the one before, and ten bring them within the noise of the estimate.
const ROUNDS: usize = 10;

/// Share of the information below which something is not shown.
const UNSHOWN: f64 = 1e-10;

/// Degrees of freedom below which a scatter is no measure of anything.
const FEWEST_DOF: f64 = 2.0;

/// What some values show of their scatter.
#[derive(Debug, Clone, Copy)]
pub(super) struct SquaresOfValues {
    /// 0 of displacements, 1 of rotations.
    pub(super) kind: usize,
    /// Sum of squares whose expectation is `dof` times the variance.
    pub(super) squares: f64,
    pub(super) dof: f64,
    /// Square of the size of the values.
    pub(super) size: f64,
}

/// Variance = own variance of the kind + growth times the square of the size.
///
/// Maximum likelihood of normal values by scoring: weighted least squares of the squares, the weights from the variances of the round
/// before (McCullagh & Nelder, Generalized Linear Models, 1989, chapter 8); no part is negative.
#[derive(Debug, Clone, Copy)]
pub(super) struct GrowingScatter {
    own: [f64; 2],
    growth: f64,
    /// Covariance of both own variances and the growth.
    covariance: Matrix3<f64>,
}

impl GrowingScatter {
    /// `None` where the values do not scatter, or hardly any does.
    ///
    /// # Arguments
    /// - `least`: variances below which nothing is asked of a gauge, by kind.
    pub(super) fn of(parts: &[SquaresOfValues], least: [f64; 2]) -> Option<Self> {
        let dof: f64 = parts.iter().map(|part| part.dof).sum();
        if dof < FEWEST_DOF || parts.iter().all(|part| part.squares == 0.0) {
            return None;
        }
        let mut scatter = Self {
            own: [0, 1].map(|kind| {
                let of_kind = parts.iter().filter(|part| part.kind == kind);
                let (squares, dof) = of_kind.fold((0.0, 0.0), |(squares, dof), part| {
                    (squares + part.squares, dof + part.dof)
                });
                f64::max(squares / f64::max(dof, 1.0), least[kind])
            }),
            growth: 0.0,
            covariance: Matrix3::zeros(),
        };
        for _ in 0..ROUNDS {
            scatter = scatter.next(parts, least);
        }
        scatter.covariance = scatter.covariance_of(parts);
        Some(scatter)
    }

    /// Inverse of the information on both own variances and the growth; what the values do not show takes no part.
    fn covariance_of(&self, parts: &[SquaresOfValues]) -> Matrix3<f64> {
        let mut information = Matrix3::zeros();
        for part in parts {
            let row = shares(part.kind, part.size);
            let variance = self.variance(part.kind, part.size);
            // A sum of squares with n degrees of freedom has the variance 2 n times the square of its variance.
            let weight = part.dof / (2.0 * variance * variance);
            information += row * row.transpose() * weight;
        }
        // Sizes and variances differ by many powers of ten.
        let scales = information
            .diagonal()
            .map(|own: f64| if own > 0.0 { own.sqrt().recip() } else { 0.0 });
        let scale = Matrix3::from_diagonal(&scales);
        let inverse = (scale * information * scale).pseudo_inverse(UNSHOWN);
        inverse.map_or_else(|_| Matrix3::zeros(), |inverse| scale * inverse * scale)
    }

    fn next(self, parts: &[SquaresOfValues], least: [f64; 2]) -> Self {
        let weight = |part: &SquaresOfValues| {
            part.dof
                / self
                    .variance(part.kind, part.size)
                    .powi(2)
                    .max(f64::MIN_POSITIVE)
        };
        let mean = |kind: usize, of: &dyn Fn(&SquaresOfValues) -> f64| {
            let own = parts
                .iter()
                .filter(|part| part.kind == kind && part.dof > 0.0);
            let (sum, all) = own.fold((0.0, 0.0), |(sum, all), part| {
                (sum + weight(part) * of(part), all + weight(part))
            });
            if all > 0.0 { sum / all } else { 0.0 }
        };
        let variance = |part: &SquaresOfValues| part.squares / part.dof;
        let sizes = [0, 1].map(|kind| mean(kind, &|part| part.size));
        let variances = [0, 1].map(|kind| mean(kind, &variance));
        // A kind whose own variance would be negative keeps the least.
        let mut held = [false; 2];
        loop {
            let (mut products, mut squares) = (0.0, 0.0);
            for part in parts.iter().filter(|part| part.dof > 0.0) {
                let (size, value) = if held[part.kind] {
                    (part.size, variance(part) - least[part.kind])
                } else {
                    (part.size - sizes[part.kind], variance(part))
                };
                products += weight(part) * size * value;
                squares += weight(part) * size * size;
            }
            let growth = if squares > 0.0 {
                f64::max(products / squares, 0.0)
            } else {
                0.0
            };
            let own = [0, 1].map(|kind| variances[kind] - growth * sizes[kind]);
            let negative = [0, 1].map(|kind| own[kind] < least[kind]);
            if (0..2).all(|kind| held[kind] || !negative[kind]) {
                return Self {
                    own: [0, 1].map(|kind| own[kind].max(least[kind])),
                    growth,
                    covariance: self.covariance,
                };
            }
            held = [0, 1].map(|kind| held[kind] || negative[kind]);
        }
    }

    /// The variance of a value of this kind and squared size.
    pub(super) fn variance(&self, kind: usize, size: f64) -> f64 {
        self.own[kind] + self.growth * size
    }

    /// Degrees of freedom of that variance (Satterthwaite, Biometrics Bulletin 2, 1946).
    fn dof(&self, kind: usize, size: f64) -> f64 {
        let row = shares(kind, size);
        let variance_of_it = (row.transpose() * self.covariance * row)[0];
        2.0 * self.variance(kind, size).powi(2) / variance_of_it
    }

    /// How many standard errors a value is off.
    pub(super) fn standard_errors(&self, value: FarValue) -> f64 {
        value.off.abs() / (self.variance(value.kind, value.size) * value.of_itself).sqrt()
    }

    /// Chance that one of several values is as far from zero (Bonferroni).
    ///
    /// # Arguments
    /// - `together`: values of one application of a load. They count as one against the degrees of freedom: a load that is off shifts them all.
    pub(super) fn p_family(&self, value: FarValue, values: usize, together: f64) -> f64 {
        let dof = self.dof(value.kind, value.size) / together.max(1.0);
        let p = f_upper_tail(self.standard_errors(value).powi(2), 1.0, dof).unwrap_or(1.0);
        (p * values as f64).min(1.0)
    }
}

/// A value that may be too far off.
#[derive(Debug, Clone, Copy)]
pub(super) struct FarValue {
    /// 0 of displacements, 1 of rotations.
    pub(super) kind: usize,
    /// Square of its size.
    pub(super) size: f64,
    /// How far off it is.
    pub(super) off: f64,
    /// Variance of that over the variance of a value of this kind and size.
    pub(super) of_itself: f64,
}

/// What both own variances and the growth add to the variance of a value.
fn shares(kind: usize, size: f64) -> Vector3<f64> {
    let own = |of: usize| f64::from(u8::from(kind == of));
    Vector3::new(own(0), own(1), size)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of normal values by their quantiles would hide errors of the scoring; exact squares show the solution.
    #[test]
    fn exact_squares_give_back_their_variances() {
        let part = |kind: usize, size: f64, variance: f64| SquaresOfValues {
            kind,
            squares: 3.0 * variance,
            dof: 3.0,
            size,
        };
        let parts: Vec<SquaresOfValues> = (0..20)
            .map(|i| {
                let (kind, size) = (i % 2, f64::from(i as u32).powi(2));
                part(kind, size, [4.0, 9.0][kind] + 0.5 * size)
            })
            .collect();
        let found = GrowingScatter::of(&parts, [0.0; 2]).unwrap();
        assert!((found.own[0] - 4.0).abs() < 1e-6, "{found:?}");
        assert!((found.own[1] - 9.0).abs() < 1e-6, "{found:?}");
        assert!((found.growth - 0.5).abs() < 1e-6, "{found:?}");
        // Shrinking with the size is no growth.
        let shrinking: Vec<SquaresOfValues> = (0..20)
            .map(|i| part(0, f64::from(i), 40.0 - f64::from(i)))
            .collect();
        let found = GrowingScatter::of(&shrinking, [0.0; 2]).unwrap();
        assert!(found.growth == 0.0 && found.own[0] > 20.0, "{found:?}");
        assert!(GrowingScatter::of(&[part(0, 1.0, 0.0)], [0.0; 2]).is_none());
    }
}
