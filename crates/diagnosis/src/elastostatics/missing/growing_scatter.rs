//! Scatter that may grow with the size of what is read, as that of loads that are applied anew does.

use stiffbench_numeric::statistics::f_upper_tail;

/// Rounds: each changes the weights less than the one before, and ten bring them within the noise of the estimate.
const ROUNDS: usize = 10;

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
    pub(super) dof: f64,
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
            dof,
        };
        for _ in 0..ROUNDS {
            scatter = scatter.next(parts, least);
        }
        Some(scatter)
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
                    dof: self.dof,
                };
            }
            held = [0, 1].map(|kind| held[kind] || negative[kind]);
        }
    }

    /// The variance of a value of this kind and squared size.
    pub(super) fn variance(&self, kind: usize, size: f64) -> f64 {
        self.own[kind] + self.growth * size
    }

    /// Chance that one of several values is as many standard errors off (Bonferroni).
    pub(super) fn p_family(&self, standard_errors: f64, values: usize) -> f64 {
        let p = f_upper_tail(standard_errors.powi(2), 1.0, self.dof).unwrap_or(1.0);
        (p * values as f64).min(1.0)
    }
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
