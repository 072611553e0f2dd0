//! A candidate with its fit: what is held against its limit, and the evidence for it.

use stiffbench_beams::physics::{Effect, Law};

use super::critical_values::CriticalValues;
use super::refit::Fitted;
use crate::search::{log_bayes, under_known_covariance};

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
        // On noise alone Δχ² grows by the sizes, of which a law with a phase has two.
        let has_phase = self.effect.law.search.phase.is_some();
        let amplitudes = if has_phase { 2.0 } else { 1.0 };
        under_known_covariance(gain, amplitudes, self.dof)
    }

    /// The family whose critical value it must exceed: its law, and whether the search is the wide one.
    pub(super) fn family(&self) -> (Law, bool) {
        (self.effect.law, self.wide)
    }

    /// Weighs its evidence.
    pub(super) fn weigh(&mut self, limits: &CriticalValues) {
        let limit = limits.laws.of(self.family());
        self.log_bayes = log_bayes(self.gain, limit, self.effect.values.len());
    }
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
}
