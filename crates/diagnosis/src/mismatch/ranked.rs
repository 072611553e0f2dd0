//! A candidate with its fit: what is held against its limit, and the evidence for it.

use stiffbench_beams::physics::Effect;
use stiffbench_numeric::statistics::{chi_squared_quantile, f_upper_tail};

use super::limits::Limits;
use super::refit::Fitted;

/// A candidate with its fit and its evidence.
#[derive(Debug, Clone)]
pub(super) struct Ranked {
    pub(super) effect: Effect,
    pub(super) wide: bool,
    /// Drop of the weighted squares against the state.
    pub(super) gain: f64,
    /// The same of the best shape that was searched, all else linear: what the limits are drawn of.
    pub(super) linear_gain: f64,
    /// Logarithm of the Bayes factor against the state; minus infinity until it is weighed.
    pub(super) log_bayes: f64,
    /// The model with the candidate in it.
    pub(super) fitted: Fitted,
    /// Its effect, white and projected, at the fitted size.
    pub(super) white: Vec<f64>,
    /// Squared length of the effect before projection.
    pub(super) whole: f64,
    /// Degrees of freedom of its standard error.
    pub(super) dof: f64,
}

impl Ranked {
    /// The gain that is held against the limit of its law.
    ///
    /// # Arguments
    /// - `alone`: whether no other effect stands beside it. Then it is the gain of a shape that the limits were drawn of: a fit moves the
    ///   shape to where noise suits it best, and passes a quarter more often. Beside other effects the linear gain takes some of
    ///   their values for fixed, and the fit counts.
    pub(super) fn judged_gain(&self, alone: bool) -> f64 {
        let gain = if alone {
            self.gain.min(self.linear_gain)
        } else {
            self.gain
        };
        self.as_if_noise_were_known(gain)
    }

    /// The gain that would be as rare as another if the noise were known exactly: F to χ².
    fn as_if_noise_were_known(&self, gain: f64) -> f64 {
        if self.dof > 1e5 || gain <= 0.0 {
            return gain;
        }
        // On noise alone a gain grows by the sizes, of which a law with a phase has two.
        let has_phase = self.effect.law.search.phase.is_some();
        let sizes = if has_phase { 2.0 } else { 1.0 };
        let Some(p) = f_upper_tail(gain / sizes, sizes, self.dof) else {
            return gain;
        };
        // Beyond what the tail can say in 16 digits the effect needs no exact limit.
        if p < 1e-14 {
            return gain.min(60.0);
        }
        chi_squared_quantile(1.0 - p, sizes).unwrap_or(gain)
    }

    /// Weighs its evidence.
    pub(super) fn weigh(&mut self, limits: &Limits) {
        let limit = limits.of((self.effect.law, self.wide));
        self.log_bayes = log_bayes(self.gain, limit, self.effect.values.len());
    }
}

/// Logarithm of the Bayes factor of a law against no law.
///
/// The prior of a law is such that a gain at its limit leaves it even: the law whose many shapes and places noise imitates well
/// must be that much better than one with a single shape, and the odds of no law depend on what its size was thought to be. Beyond the
/// limit each value that was fitted costs what it is known better by (Laplace's approximation; Kass & Raftery, Journal of the
/// American Statistical Association 90, 1995, p. 777).
///
/// # Arguments
/// - `values`: how many were fitted.
pub(super) fn log_bayes(gain: f64, limit: f64, values: usize) -> f64 {
    let known_better = 0.5 * (gain.max(limit) / limit).ln();
    0.5 * (gain - limit) - values as f64 * known_better
}

/// Whether two effects are the same law at the same place.
pub(super) fn same(effect: &Effect, other: &Effect) -> bool {
    effect.law == other.law && effect.place == other.place
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mismatch::refit::Model;
    use stiffbench_beams::physics::{Place, laws};
    use stiffbench_numeric::statistics::f_upper_tail;

    fn ranked(gain: f64, linear_gain: f64, dof: f64) -> Ranked {
        let effect = Effect {
            law: laws::SETTING_IN,
            place: Place::Structure,
            values: vec![1e-3, 1.0],
        };
        let model = Model {
            parameters: Vec::new(),
            effects: vec![effect.clone()],
        };
        Ranked {
            effect,
            wide: false,
            gain,
            linear_gain,
            log_bayes: 0.0,
            fitted: Fitted {
                model,
                squares: 1.0,
            },
            white: Vec::new(),
            whole: 1.0,
            dof,
        }
    }

    #[test]
    fn alone_the_shape_counts_that_the_limits_were_drawn_of() {
        let known = 1e6;
        assert_eq!(ranked(16.0, 12.0, known).judged_gain(true), 12.0);
        assert_eq!(ranked(16.0, 12.0, known).judged_gain(false), 16.0);
        // A linear gain that no fit reaches is none.
        assert_eq!(ranked(10.0, 12.0, known).judged_gain(true), 10.0);
    }

    #[test]
    fn a_scatter_that_few_degrees_of_freedom_tell_makes_a_gain_less_rare() {
        let judged = ranked(16.0, 16.0, 20.0).judged_gain(true);
        let as_rare = f_upper_tail(judged, 1.0, 1e9).unwrap();
        let rare = f_upper_tail(16.0, 1.0, 20.0).unwrap();
        // Quantiles are found to six digits.
        assert!((as_rare - rare).abs() < 1e-5 * rare, "{as_rare} {rare}");
        assert!(judged < 12.0, "{judged}");
    }
}
