//! A candidate with its fit and the evidence for it.

use stiffbench_beams::physics::{Effect, Law};

use super::part_evidence::PartEvidence;
use crate::mismatch::problem::FittedModel;
use crate::search::Evidence;

/// A candidate with its fit and its evidence.
#[derive(Debug, Clone)]
pub(crate) struct Ranked {
    pub(crate) effect: Effect,
    pub(crate) wide: bool,
    /// What speaks for it against the state.
    pub(crate) evidence: Evidence,
    /// The model with the candidate in it.
    pub(crate) fitted: FittedModel,
    /// Its effect, white and projected, at the fitted size.
    pub(crate) white: Vec<f64>,
    /// Squared length of the effect before projection.
    pub(crate) whole: f64,
    /// Log-likelihood relative to a change of the same run that comes gradually; infinite for laws that are no jump.
    pub(crate) against_gradual: f64,
    /// What speaks for it in the recording of a part.
    pub(crate) of_a_part: Option<PartEvidence>,
}

impl Ranked {
    /// Logarithm of the Bayes factor against the model without it, or with a gradual change in its stead if that is likelier.
    pub(crate) fn log_bayes(&self) -> f64 {
        self.evidence.log_bayes().min(self.against_gradual)
    }

    /// Whether readings that it was not fitted to may still speak against it.
    pub(crate) fn may_fall(&self) -> bool {
        self.of_a_part.is_some_and(|part| !part.left_out)
    }

    /// The family whose critical value it must exceed: its law, and whether the search is the wide one.
    pub(crate) fn family(&self) -> (Law, bool) {
        (self.effect.law, self.wide)
    }
}

/// Whether two effects are the same law at the same place.
pub(crate) fn same(effect: &Effect, other: &Effect) -> bool {
    effect.law == other.law && effect.place == other.place
}

/// Counts what speaks for each law by the independent values that the one which leaves least leaves.
pub(crate) fn weigh(ranked: &mut [Ranked]) {
    let squares = |one: &&Ranked| one.fitted.squares;
    let best = ranked.iter().filter(|one| one.of_a_part.is_some());
    let best = best.min_by(|a, b| squares(a).total_cmp(&squares(b)));
    let Some(independent) = best.and_then(|best| Some(best.of_a_part?.independent)) else {
        return;
    };
    for ranked in ranked.iter_mut() {
        if let Some(part) = ranked.of_a_part {
            ranked.evidence.delta_chi2 = independent * part.fall;
            ranked.evidence.linear_delta_chi2 = independent * part.linear_fall;
            ranked.evidence.dof = part.dof;
            let better = 0.5 * independent * (part.fall - part.fall_of_a_curve);
            ranked.against_gradual = ranked.against_gradual.min(better);
        }
    }
}
