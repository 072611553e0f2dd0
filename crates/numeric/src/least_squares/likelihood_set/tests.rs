//! Sets of one part and of two, and how often a set of two wells holds the truth.

use super::*;
use crate::least_squares::rows::{ResidualRows, Row};
use crate::least_squares::{
    CovarianceSettings, LeastSquaresSettings, Parameter, covariance, minima,
};

/// p² and c p measured, each with standard deviation σ: wells near the roots of the first, the second states which.
struct Square {
    measured: [f64; 2],
    sigma: f64,
    c: f64,
}

impl Square {
    /// The residuals of both.
    fn rows(&self) -> ResidualRows<impl Clone + FnMut(&[f64], usize) -> Row> {
        let Self { measured, sigma, c } = *self;
        ResidualRows(2, move |p: &[f64], i| match i {
            0 => (
                (p[0] * p[0] - measured[0]) / sigma,
                vec![2.0 * p[0] / sigma],
            ),
            _ => ((c * p[0] - measured[1]) / sigma, vec![c / sigma]),
        })
    }

    fn set(&self, draws: usize) -> LikelihoodSet {
        let set = ParameterSet::new(vec![Parameter::free("p", 0.5, -3.0, 3.0)]).unwrap();
        let refits = LeastSquaresSettings::for_refits();
        let minima = minima(&mut self.rows(), &set, spread(&set).take(8), &refits).unwrap();
        let (mode, settings) = (SigmaMode::Known, CovarianceSettings::default());
        let covariance = covariance(&set, &minima[0], mode, &settings).unwrap();
        let likelihood = Likelihood {
            again: || Some(self.rows()),
            set: &set,
            minima: &minima,
            covariance: &covariance,
            settings: &LikelihoodSetSettings {
                draws,
                ..LikelihoodSetSettings::default()
            },
        };
        likelihood.of(&mut self.rows(), 0).unwrap()
    }

    fn chi2(&self, p: f64) -> f64 {
        ((p * p - self.measured[0]) / self.sigma).powi(2)
            + ((self.c * p - self.measured[1]) / self.sigma).powi(2)
    }
}

#[test]
fn two_wells_within_reach_are_two_islands_that_end_where_the_rise_is_the_limit() {
    let square = Square {
        measured: [1.0, 0.05],
        sigma: 0.1,
        c: 0.1,
    };
    let found = square.set(0);
    assert!(!found.drawn);
    let islands = found.closed().unwrap();
    assert_eq!(islands.len(), 2, "{islands:?}");
    // The lowest point and the crossings by scanning in steps of 1e-5.
    let scan: Vec<f64> = (-300_000..=300_000).map(|k| f64::from(k) * 1e-5).collect();
    let lowest = scan
        .iter()
        .map(|&p| square.chi2(p))
        .fold(f64::MAX, f64::min);
    let allowed = |p: f64| square.chi2(p) - lowest <= 3.841_458_820_694_124;
    let ends: Vec<f64> = scan
        .windows(2)
        .filter(|pair| allowed(pair[0]) != allowed(pair[1]))
        .map(|pair| pair[0])
        .collect();
    let flat: Vec<f64> = islands.into_iter().flatten().collect();
    assert_eq!(flat.len(), ends.len());
    for (a, b) in flat.iter().zip(&ends) {
        assert!((a - b).abs() < 3e-5, "{flat:?} {ends:?}");
    }
}

#[test]
fn a_well_out_of_reach_is_no_island_and_nothing_is_drawn() {
    let square = Square {
        measured: [1.0, 0.5],
        sigma: 0.1,
        c: 0.5,
    };
    let found = square.set(99);
    assert!(!found.drawn);
    assert_eq!(found.parts.len(), 1);
    assert!((found.estimate - 1.0).abs() < 1e-6);
}

#[test]
fn of_two_wells_a_standard_error_and_a_half_apart_the_drawn_set_holds_the_truth_more_often_than_the_f_law()
 {
    let truth = 1.0;
    let trials = 400;
    let mut covered = [0, 0];
    for trial in 0..trials {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        random.set_stream(trial);
        let mut error = || 0.1 * normal_quantile(random.random_range(f64::EPSILON..1.0));
        // 2 c = 0.15: one well predicts the second value 1.5 standard deviations off the other's.
        let square = Square {
            measured: [truth + error(), 0.075 + error()],
            sigma: 0.1,
            c: 0.075,
        };
        for (covered, draws) in covered.iter_mut().zip([0, 99]) {
            let parts = square.set(draws).closed().unwrap();
            let holds = parts
                .iter()
                .any(|part| part[0] <= truth && truth <= part[1]);
            *covered += u32::from(holds);
        }
    }
    let share = covered.map(|covered| f64::from(covered) / trials as f64);
    // 400 trials: 95 % to 1.1 % by chance.
    assert!((0.92..=0.975).contains(&share[1]), "{share:?}");
    assert!(share[1] > share[0], "{share:?}");
}
