//! How long the tails of errors are.

use stiffbench_numeric::statistics::{chi_squared_quantile, f_upper_tail, student_t_log_density};

use crate::search::constants::ASKED_FOR;

/// Student's t with a scale: normal with many degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StudentT {
    /// Scale: a standard deviation is larger by √(ν/(ν - 2)).
    pub(super) scale: f64,
    /// Degrees of freedom.
    pub(super) dof: f64,
}

/// Degrees of freedom that are tried: tails can be told apart no better from a few hundred errors.
const TRIED: [f64; 11] = [2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 12.0, 20.0, 40.0, 100.0, 1e6];

/// Scales that are tried, in root mean squares: a root mean square is that of the longest tails, or too small for what was left out.
const SMALLEST_SCALE: f64 = 0.2;
const LARGEST_SCALE: f64 = 1.5;

impl StudentT {
    /// The likeliest for values about zero, beside which `further` ones are known only to lie farther from zero than all of them.
    ///
    /// Values that are left out because they are the largest would otherwise make tails look short (type II censoring: Lawless, Statistical
    /// Models and Methods for Lifetime Data, 2nd edition, section 2.2.2).
    pub(super) fn fitted(values: &[f64], further: usize) -> Self {
        let n = values.len().max(1) as f64;
        let root_mean_square = (values.iter().map(|x| x * x).sum::<f64>() / n).sqrt();
        let normal = Self {
            scale: root_mean_square.max(f64::MIN_POSITIVE),
            dof: TRIED[TRIED.len() - 1],
        };
        if root_mean_square == 0.0 {
            return normal;
        }
        let largest = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let fitted = |dof: f64| {
            let with_scale = |log_scale: f64| {
                let t = Self {
                    scale: log_scale.exp(),
                    dof,
                };
                let beyond = t.two_sided(largest).max(f64::MIN_POSITIVE).ln();
                let likelihood = t.log_likelihood(values) + further as f64 * beyond;
                (likelihood, t)
            };
            let start = root_mean_square.ln();
            maximum(
                with_scale,
                start + SMALLEST_SCALE.ln(),
                start + LARGEST_SCALE.ln(),
            )
        };
        let likeliest = TRIED.map(fitted).into_iter();
        likeliest
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(normal, |(_, t)| t)
    }

    /// The likeliest for the values of a group that lacks its farthest one: that of both groups, unless they ask for different ones.
    pub(super) fn of_group(group: &[f64], other: &[f64]) -> Self {
        let both = [group, other].concat();
        let common = Self::fitted(&both, 1);
        let (own, of_other) = (Self::fitted(group, 1), Self::fitted(other, 0));
        let apart = own.log_likelihood(group) + of_other.log_likelihood(other);
        // Two more values are free then.
        let asked_for = chi_squared_quantile(0.95, 2.0).unwrap_or(f64::INFINITY);
        if 2.0 * (apart - common.log_likelihood(&both)) > asked_for {
            own
        } else {
            common
        }
    }

    /// The same with a scale of at least this.
    pub(super) fn with_scale_at_least(self, scale: f64) -> Self {
        Self {
            scale: self.scale.max(scale),
            ..self
        }
    }

    /// Degrees of freedom, where the values ask for tails that are longer than normal ones.
    pub(super) fn dof_if_longer_than_normal(&self, values: &[f64]) -> Option<f64> {
        let mean_square = values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64;
        let normal = Self {
            scale: mean_square.sqrt().max(f64::MIN_POSITIVE),
            dof: TRIED[TRIED.len() - 1],
        };
        let gained = 2.0 * (self.log_likelihood(values) - normal.log_likelihood(values));
        (gained > ASKED_FOR).then_some(self.dof)
    }

    fn log_likelihood(&self, values: &[f64]) -> f64 {
        let of_value = |x: &f64| {
            let density = student_t_log_density(x / self.scale, self.dof);
            density.unwrap_or(f64::NEG_INFINITY) - self.scale.ln()
        };
        values.iter().map(of_value).sum()
    }

    /// Chance of a value as far from zero or further.
    pub(super) fn two_sided(&self, value: f64) -> f64 {
        // The square of Student's t has an F distribution.
        f_upper_tail((value / self.scale).powi(2), 1.0, self.dof).unwrap_or(1.0)
    }
}

/// The largest value of a function with one maximum, by golden sections.
fn maximum(value: impl Fn(f64) -> (f64, StudentT), mut low: f64, mut high: f64) -> (f64, StudentT) {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut left = value(high - ratio * (high - low));
    let mut right = value(low + ratio * (high - low));
    for _ in 0..20 {
        if left.0 > right.0 {
            high = low + ratio * (high - low);
            right = left;
            left = value(high - ratio * (high - low));
        } else {
            low = high - ratio * (high - low);
            left = right;
            right = value(low + ratio * (high - low));
        }
    }
    if left.0 > right.0 { left } else { right }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal, StudentT as Draws};

    use super::*;

    #[test]
    fn scale_and_tails_come_back() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let normal: Vec<f64> = (0..2000).map(|_| StandardNormal.sample(&mut rng)).collect();
        let long = Draws::new(4.0).unwrap();
        let long: Vec<f64> = (0..2000).map(|_| 3.0 * long.sample(&mut rng)).collect();
        let of_normal = StudentT::fitted(&normal, 0);
        let of_long = StudentT::fitted(&long, 0);
        // The logarithm of a scale has a standard error of 1/√(2 n) = 0.016, more with long tails.
        assert!((of_normal.scale - 1.0).abs() < 0.06 && of_normal.dof >= 20.0);
        assert!((of_long.scale / 3.0 - 1.0).abs() < 0.1, "{of_long:?}");
        assert!((3.0..=6.0).contains(&of_long.dof), "{of_long:?}");
    }

    #[test]
    fn tails_stay_as_long_without_the_largest_values() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let draws = Draws::new(4.0).unwrap();
        let (mut seen, mut blind) = (0.0, 0.0);
        for _ in 0..20 {
            let mut values: Vec<f64> = (0..600).map(|_| draws.sample(&mut rng)).collect();
            values.sort_by(|a: &f64, b| a.abs().total_cmp(&b.abs()));
            let without = &values[..580];
            let inverse = |t: StudentT| t.dof.recip() / 20.0;
            seen += inverse(StudentT::fitted(without, 20));
            blind += inverse(StudentT::fitted(without, 0));
        }
        // 1/ν: 0.25, and that of much shorter tails.
        assert!((0.2..0.3).contains(&seen), "{seen}");
        assert!(blind < 0.15, "{blind}");
    }

    #[test]
    fn a_tail_is_that_of_the_tables() {
        // t(0.975; 4) = 2.776, and half the quantile at twice the scale.
        let t = StudentT {
            scale: 2.0,
            dof: 4.0,
        };
        assert!((t.two_sided(2.0 * 2.776_445) - 0.05).abs() < 1e-6);
    }
}
