//! How long the tails of errors are, as far as a few hundred of them show it.
//!
//! The chance of an error as large as a suspect is that of the predictive distribution, with Student's t as the model: every number of degrees
//! of freedom and every scale counts by its likelihood among the other errors. The likeliest alone names good readings, for a few hundred errors
//! do not determine how often one in a million occurs. Before them errors are as likely normal as not (Jeffreys, Theory of Probability, 3rd edition,
//! 5.0); else the prior is flat in 1/ν, down to those without a variance, and in the logarithm of the scale. The independence Jeffreys prior of
//! the two (Fonseca, Ferreira & Migon, Biometrika 95 (2008) 325) differs from a flat one by a factor of 2.4 between the ends.

use stiffbench_numeric::simd::widest;
use stiffbench_numeric::statistics::{
    chi_squared_quantile, f_upper_tail, normal_upper_tail, student_t_log_density,
};

use crate::search::chance_of_any;
use crate::search::constants::ASKED_FOR;

/// Student's t with a scale: normal with many degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StudentT {
    /// Scale: a standard deviation is larger by √(ν/(ν - 2)).
    scale: f64,
    /// Degrees of freedom.
    dof: f64,
}

/// Values of 1/ν that are tried, at the middle of equal parts of what a distribution with a variance can have: narrower than the standard error of
/// 1/ν from some hundred errors.
const TRIED: usize = 20;

/// Degrees of freedom that count as normal.
const NORMAL: f64 = 1e6;

/// Nodes and weights of the quadrature over the logarithm of the scale, in its standard errors (Gauss-Hermite, three points: Abramowitz & Stegun,
/// 25.4.46, √2 times theirs).
const NODES: [(f64, f64); 3] = [
    (-1.732_050_807_568_877_2, 1.0 / 6.0),
    (0.0, 2.0 / 3.0),
    (1.732_050_807_568_877_2, 1.0 / 6.0),
];

/// Steps of Newton's method to the likeliest scale: it converges quadratically, the logarithm of the likelihood being concave.
const NEWTON_STEPS: usize = 12;

impl StudentT {
    /// The likeliest scale with these degrees of freedom, and the standard error of its logarithm.
    fn with_dof(values: &[f64], dof: f64) -> (Self, f64) {
        let n = values.len() as f64;
        let mean_square = values.iter().map(|x| x * x).sum::<f64>() / n;
        // Below the likeliest the steps stay below it: a normal scale is the largest that is.
        let mut log_scale = 0.5 * mean_square.ln();
        let mut curvature = 2.0 * n;
        for _ in 0..NEWTON_STEPS {
            let [weighted, twice] = weighted_squares(values, dof * (2.0 * log_scale).exp());
            let slope = (dof + 1.0) * weighted - n;
            curvature = (2.0 * (dof + 1.0) * twice).max(f64::MIN_POSITIVE);
            let step = (slope / curvature).clamp(-1.0, 1.0);
            log_scale += step;
            if step.abs() < 1e-6 {
                break;
            }
        }
        let t = Self {
            scale: log_scale.exp(),
            dof,
        };
        (t, curvature.sqrt().recip())
    }

    fn log_likelihood(&self, values: &[f64]) -> f64 {
        let at_zero = student_t_log_density(0.0, self.dof).unwrap_or(f64::NEG_INFINITY);
        let variance = self.dof * self.scale * self.scale;
        let shape = sum_of_logarithms(values, variance);
        values.len() as f64 * (at_zero - self.scale.ln()) - 0.5 * (self.dof + 1.0) * shape
    }

    /// Chance of a value as far from zero or further.
    fn two_sided(&self, value: f64) -> f64 {
        // The square of Student's t has an F distribution.
        f_upper_tail((value / self.scale).powi(2), 1.0, self.dof).unwrap_or(1.0)
    }

    /// The same of a sum with a normal value: Student's t is normal with a variance ν/χ², and so is the sum.
    fn two_sided_beside(&self, normal_sd: f64, value: f64) -> f64 {
        if normal_sd == 0.0 {
            return self.two_sided(value);
        }
        let (step, first, last) = MIXED;
        let half = 0.5 * self.dof;
        let (mut sum, mut whole) = (0.0, 0.0);
        for node in 0..=((last - first) / step) as usize {
            let log = first + step * node as f64;
            let density = (half * (log + 1.0 - log.exp())).exp();
            let sd = self
                .scale
                .mul_add(self.scale * (-log).exp(), normal_sd * normal_sd)
                .sqrt();
            sum += density * 2.0 * normal_upper_tail(value.abs() / sd);
            whole += density;
        }
        sum / whole
    }
}

/// Sums of x/(1 + x) and of x/(1 + x)², where x is the square of a value over a variance.
fn weighted_squares(values: &[f64], variance: f64) -> [f64; 2] {
    widest(
        #[inline(always)]
        || {
            let mut sums = [[0.0; LANES]; 2];
            let mut add = |values: &[f64]| {
                for (lane, value) in values.iter().enumerate() {
                    let own = value * value / variance;
                    let weight = (1.0 + own).recip();
                    sums[0][lane] += own * weight;
                    sums[1][lane] += own * weight * weight;
                }
            };
            let chunks = values.chunks_exact(LANES);
            let rest = chunks.remainder();
            chunks.for_each(&mut add);
            add(rest);
            sums.map(|lanes| lanes.iter().sum())
        },
    )
}

/// Sum of ln (1 + x) with the same x: logarithms of products, which are many times as quick as those of each.
fn sum_of_logarithms(values: &[f64], variance: f64) -> f64 {
    widest(
        #[inline(always)]
        || {
            let mut sum = 0.0;
            for values in values.chunks(FACTORS) {
                let mut products = [1.0; LANES];
                for values in values.chunks(LANES) {
                    for (product, value) in products.iter_mut().zip(values) {
                        *product *= 1.0 + value * value / variance;
                    }
                }
                let product: f64 = products.iter().product();
                sum += if product.is_finite() {
                    product.ln()
                } else {
                    let each = values
                        .iter()
                        .map(|value| (value * value / variance).ln_1p());
                    each.sum()
                };
            }
            sum
        },
    )
}

/// Sums that the compiler makes lanes of, and factors of one product: it stays finite where values are below ten million scales. Numerics.
const LANES: usize = 8;
const FACTORS: usize = 2 * LANES;

/// Chance that the largest of `count` values is as far from zero or further if errors are normal and scatter as others do: with
/// longer tails it is no smaller.
///
/// # Arguments
/// - `others`: root mean square of the errors of others.
pub(crate) fn chance_if_normal(value: f64, others: f64, beside: Beside, count: usize) -> f64 {
    let sd = (beside.own * others).hypot(beside.normal_sd);
    chance_of_any(2.0 * normal_upper_tail(value.abs() / sd), count as f64)
}

/// Step of the quadrature over the logarithm of χ²/ν, and where it begins and ends. The trapezoidal rule converges exponentially, the density being
/// smooth and zero at both ends. Numerics.
const MIXED: (f64, f64, f64) = (0.1, -30.0, 4.0);

/// What a value has besides an error with tails.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Beside {
    /// Standard deviation of a normal part.
    pub(crate) normal_sd: f64,
    /// Factor of the error itself (1).
    pub(crate) own: f64,
}

impl Beside {
    /// Nothing but the error.
    pub(crate) const NOTHING: Self = Self {
        normal_sd: 0.0,
        own: 1.0,
    };
}

/// Distribution of the errors, as far as values about zero show it: Student's t of each number of degrees of freedom and scale with its share.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tails {
    shares: Vec<(f64, StudentT)>,
    likeliest: StudentT,
}

impl Tails {
    /// Those of values, beside which `further` ones are known only to lie farther from zero than all of them.
    ///
    /// Values that are left out because they are the largest would otherwise make tails look short (type II censoring: Lawless, Statistical
    /// Models and Methods for Lifetime Data, 2nd edition, section 2.2.2).
    pub(crate) fn of(values: &[f64], further: usize) -> Self {
        let largest = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        if largest == 0.0 {
            let none = StudentT {
                scale: f64::MIN_POSITIVE,
                dof: NORMAL,
            };
            return Self {
                shares: vec![(1.0, none)],
                likeliest: none,
            };
        }
        let mut shares = Vec::with_capacity((TRIED + 1) * NODES.len());
        let long = (0..TRIED).map(|part| (2.0 * TRIED as f64 / (part as f64 + 0.5), 1.0));
        for (dof, prior) in long.chain([(NORMAL, TRIED as f64)]) {
            let (likeliest, u) = StudentT::with_dof(values, dof);
            for (node, weight) in NODES {
                let t = StudentT {
                    scale: likeliest.scale * (node * u).exp(),
                    dof,
                };
                let beyond = t.two_sided(largest).max(f64::MIN_POSITIVE).ln();
                let likelihood = t.log_likelihood(values) + further as f64 * beyond;
                shares.push((
                    likelihood + 0.5 * node * node + (prior * weight * u).ln(),
                    t,
                ));
            }
        }
        let likeliest = shares.iter().max_by(|a, b| a.0.total_cmp(&b.0));
        let (most, likeliest) = *likeliest.expect("every number of degrees of freedom has a node");
        let sum: f64 = shares.iter().map(|one| (one.0 - most).exp()).sum();
        for (share, _) in &mut shares {
            *share = (*share - most).exp() / sum;
        }
        Self { shares, likeliest }
    }

    /// Those of a group that lacks its `further` farthest values: of both groups together, unless they ask for different ones.
    pub(crate) fn of_group(group: &[f64], other: &[f64], further: usize) -> Self {
        let both = [group, other].concat();
        let common = Self::of(&both, further);
        let own = Self::of(group, further);
        let likelihood = |tails: &Self, values: &[f64]| tails.likeliest.log_likelihood(values);
        let apart = likelihood(&own, group) + likelihood(&Self::of(other, 0), other);
        // Two more values are free then.
        let asked_for = chi_squared_quantile(0.95, 2.0).unwrap_or(f64::INFINITY);
        if 2.0 * (apart - likelihood(&common, &both)) > asked_for {
            own
        } else {
            common
        }
    }

    /// The same with scales of at least this.
    pub(crate) fn with_scale_at_least(mut self, scale: f64) -> Self {
        for (_, t) in &mut self.shares {
            t.scale = t.scale.max(scale);
        }
        self
    }

    /// Chance that the largest of `count` values lies as far from zero or further.
    ///
    /// # Arguments
    /// - `beside`: what the values have besides errors.
    pub(crate) fn p_of_largest(&self, value: f64, beside: Beside, count: usize) -> f64 {
        let p = |t: &StudentT| {
            let own = StudentT {
                scale: t.scale * beside.own,
                ..*t
            };
            let one = own.two_sided_beside(beside.normal_sd, value);
            chance_of_any(one, count as f64)
        };
        self.mean(p)
    }

    /// Scale of values.
    pub(crate) fn scale(&self, beside: Beside) -> f64 {
        let square = self.mean(|t| t.scale * t.scale);
        (beside.own * beside.own * square)
            .sqrt()
            .hypot(beside.normal_sd)
    }

    /// Degrees of freedom, where values are longer-tailed than normal ones: of the mean of 1/ν.
    pub(crate) fn dof_if_longer_than_normal(&self, values: &[f64]) -> Option<f64> {
        let (normal, _) = StudentT::with_dof(values, NORMAL);
        let gained = self.likeliest.log_likelihood(values) - normal.log_likelihood(values);
        (2.0 * gained > ASKED_FOR).then(|| self.mean(|t| t.dof.recip()).recip())
    }

    fn mean(&self, of: impl Fn(&StudentT) -> f64) -> f64 {
        self.shares.iter().map(|(share, t)| share * of(t)).sum()
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal, StudentT as Draws};

    use super::*;

    fn normal(rng: &mut ChaCha8Rng, count: usize) -> Vec<f64> {
        (0..count).map(|_| StandardNormal.sample(rng)).collect()
    }

    fn long(rng: &mut ChaCha8Rng, count: usize) -> Vec<f64> {
        let draws = Draws::new(4.0).unwrap();
        (0..count).map(|_| draws.sample(rng)).collect()
    }

    #[test]
    fn scale_and_tails_come_back() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let values = normal(&mut rng, 2000);
        let of_normal = Tails::of(&values, 0);
        // The logarithm of a scale has a standard error of 1/√(2 n) = 0.016, more with long tails.
        assert!((of_normal.scale(Beside::NOTHING) - 1.0).abs() < 0.06);
        assert_eq!(of_normal.dof_if_longer_than_normal(&values), None);
        let values: Vec<f64> = long(&mut rng, 2000).iter().map(|x| 3.0 * x).collect();
        let of_long = Tails::of(&values, 0);
        let dof = of_long.dof_if_longer_than_normal(&values).unwrap();
        assert!(
            (of_long.scale(Beside::NOTHING) / 3.0 - 1.0).abs() < 0.1,
            "{of_long:?}"
        );
        assert!((3.0..=6.0).contains(&dof), "{dof}");
    }

    #[test]
    fn tails_stay_as_long_without_the_largest_values() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let (mut seen, mut blind) = (0.0, 0.0);
        for _ in 0..20 {
            let mut values = long(&mut rng, 600);
            values.sort_by(|a: &f64, b| a.abs().total_cmp(&b.abs()));
            let without = &values[..580];
            let inverse = |tails: Tails| tails.mean(|t| t.dof.recip()) / 20.0;
            seen += inverse(Tails::of(without, 20));
            blind += inverse(Tails::of(without, 0));
        }
        // 1/ν: 0.25, and that of much shorter tails.
        assert!((0.2..0.3).contains(&seen), "{seen}");
        assert!(blind < 0.15, "{blind}");
    }

    #[test]
    fn the_largest_error_is_called_rare_as_often_as_it_is() {
        // 5 % of 400 samples, give or take three standard deviations of 1.1 %.
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for draw in [normal, long] {
            let mut rare = 0;
            for _ in 0..400 {
                let mut values = draw(&mut rng, 300);
                values.sort_by(|a: &f64, b| a.abs().total_cmp(&b.abs()));
                let tails = Tails::of(&values[..299], 1);
                rare += usize::from(tails.p_of_largest(values[299], Beside::NOTHING, 300) <= 0.05);
            }
            assert!((4..=33).contains(&rare), "{rare}");
        }
    }

    #[test]
    fn a_normal_part_has_no_tails() {
        let t = StudentT {
            scale: 0.5,
            dof: 4.0,
        };
        // P(|0.5 t + 0.8 z| > 4), with SciPy: 2 * quad(lambda z: norm.pdf(z) * t.sf((4 - 0.8 * z) / 0.5, 4), -9, 9).
        let p = t.two_sided_beside(0.8, 4.0);
        assert!((p / 2.087_537_83e-3 - 1.0).abs() < 1e-6, "{p:e}");
        // Beside next to nothing it is the tail of the tables.
        let alone = t.two_sided_beside(1e-9, 4.0) / t.two_sided(4.0);
        assert!((alone - 1.0).abs() < 1e-6, "{alone}");
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
