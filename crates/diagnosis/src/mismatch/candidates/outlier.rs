//! A jump that rests on one reading: where errors have long tails it is one of them.
//!
//! The tail of a distribution beyond the few hundred errors of a session is not known, so that no limit can be drawn for what one reading
//! decides.

use super::sharpness::delta_chi2;
use crate::mismatch::observed::Observations;
use crate::search::constants::CANCELLED;
use crate::search::{FittedRows, WhiteSpace};

/// Share of a slip's Δχ² that goes where one reading may be anything, if that reading decides about it (1). By hand (fc4705d): alarms on benches with skewed
/// errors 12 of 182 with the rule, 18 without (seed 708).
const ONE_READING: f64 = 0.5;

/// Standard errors of skewness and kurtosis from which on residuals are not normal. By hand (fc4705d).
const NOT_NORMAL: f64 = 5.0;

/// Whether one reading decides about a jump, and the errors of the other runs are not normal.
///
/// One reading decides if the jump explains less than half as much once that reading may be anything: a first reading that is off looks like a
/// jump of all later ones.
///
/// # Arguments
/// - `jump`: white and projected.
/// - `residuals`: the residuals that it explains, white.
pub(crate) fn is_outlier(
    observations: &Observations,
    space: &WhiteSpace,
    jump: &[f64],
    residuals: &[f64],
) -> bool {
    let all = 0..observations.len();
    let largest =
        |size: &dyn Fn(usize) -> f64| all.clone().max_by(|a, b| size(*a).total_cmp(&size(*b)));
    let (Some(widest), Some(loudest)) = (
        largest(&|reading| jump[reading].abs()),
        largest(&|reading| jump[reading] * residuals[reading]),
    ) else {
        return false;
    };
    let needed = (1.0 - ONE_READING) * delta_chi2(jump, residuals);
    let decides = [widest, loudest].into_iter().any(|reading| {
        let mut one = vec![0.0; observations.len()];
        one[reading] = 1.0;
        let mut rest = FittedRows::new(residuals.to_vec());
        rest.set_free(space.projected(&one).into(), 0.0);
        let jump = rest.shift(jump.to_vec().into());
        // Or nothing of it is left.
        !jump.is_seen(CANCELLED) || jump.fall() < needed
    });
    let run = observations.readings[widest].run;
    let others = all.filter(|&reading| observations.readings[reading].run != run);
    let others: Vec<f64> = others.map(|reading| residuals[reading]).collect();
    decides && !is_normal(&others)
}

/// Whether skewness and excess kurtosis are what normal numbers may have; a kurtosis below theirs makes no outliers.
fn is_normal(values: &[f64]) -> bool {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let moment = |power: i32| values.iter().map(|x| (x - mean).powi(power)).sum::<f64>() / n;
    let variance = moment(2);
    if variance == 0.0 {
        return true;
    }
    let skewness = moment(3) / variance.powf(1.5);
    let kurtosis = moment(4) / (variance * variance) - 3.0;
    // Standard errors of both for normal numbers, n large.
    skewness.abs() <= NOT_NORMAL * (6.0 / n).sqrt() && kurtosis <= NOT_NORMAL * (24.0 / n).sqrt()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Gamma};

    use super::*;
    use crate::mismatch::observed::tests::observations;
    use crate::search::Covariance;
    use crate::tests::normal;

    #[test]
    fn gamma_errors_are_distinguished_from_normal_and_uniform_ones() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let gamma = Gamma::new(2.0, 1.0).unwrap();
        let skewed: Vec<f64> = (0..1000).map(|_| gamma.sample(&mut rng)).collect();
        let even: Vec<f64> = (0..1000).map(f64::from).collect();
        assert!(is_normal(&normal(1000, 1)));
        assert!(!is_normal(&skewed));
        // A coarse gauge has errors that are spread evenly.
        assert!(is_normal(&even));
        assert!(is_normal(&[]) && is_normal(&[1.0; 9]));
    }

    #[test]
    fn one_reading_decides_only_where_errors_are_not_normal() {
        let observations = observations();
        let n = observations.len();
        let own = observations.readings[0].run;
        assert!(observations.readings.iter().any(|r| r.run != own));
        let mut white = vec![0.0; n];
        white[0] = 1.0;
        let with_outlier = |tail: f64| -> Vec<f64> {
            let error = |i: usize| {
                if i == n - 1 {
                    tail
                } else {
                    (1.7 * i as f64).sin()
                }
            };
            (0..n)
                .map(|i| if i == 0 { 6.0 } else { error(i) })
                .collect()
        };
        let space = WhiteSpace::new(Covariance::equal(n, 1.0), &[], &[]);
        let outlier =
            |white: &[f64], residuals: &[f64]| is_outlier(&observations, &space, white, residuals);
        assert!(!outlier(&white, &with_outlier(1.0)));
        assert!(outlier(&white, &with_outlier(50.0)));
        // Two readings that say the same.
        white[1] = 1.0;
        let mut two = with_outlier(50.0);
        two[1] = 6.0;
        assert!(!outlier(&white, &two));
        // All but the first reading of a run whose zero is free: the first reading decides.
        let readings = observations.runs[own].readings.clone();
        let mut zero = vec![0.0; n];
        zero[readings.clone()].fill(1.0);
        let space = WhiteSpace::new(Covariance::equal(n, 1.0), &[], std::slice::from_ref(&zero));
        zero[readings.start] = 0.0;
        let mut off = with_outlier(50.0);
        space.project(&mut off);
        assert!(is_outlier(
            &observations,
            &space,
            &space.projected(&zero),
            &off
        ));
    }
}
