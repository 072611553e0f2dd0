//! Names taken back where structure is left that no law explains: they stand for what is unknown as well as they can.

use super::law_search::{LawSearch, SearchResult};
use crate::mismatch::error::MismatchError;
use crate::mismatch::unexplained::unexplained;
use crate::search::ForwardProblem;

/// Δχ² by which an effect must exceed the best pattern without a law in its stead to keep its name: three standard errors. By hand (516ef64).
const BEYOND_PATTERNS: f64 = 9.0;

impl LawSearch<'_, '_> {
    /// Takes back, where structure is left that no law explains, names that stand for what is unknown.
    ///
    /// # Returns
    /// Whether anything was taken back.
    pub(crate) fn take_back_stand_ins(
        &self,
        found: &mut SearchResult,
    ) -> Result<bool, MismatchError> {
        if self.problem().observations.is_recording() {
            self.drop_stand_ins_of_a_part(found)
        } else {
            self.drop_stand_ins(found)
        }
    }

    /// Takes back, where structure is left that no law explains, what explains less than the largest pattern that is left, or not clearly more
    /// than a pattern without a law would in its stead: it stands for the unknown cause as well as it can, and its name carries no information.
    ///
    /// # Returns
    /// Whether anything was taken back.
    fn drop_stand_ins(&self, found: &mut SearchResult) -> Result<bool, MismatchError> {
        let mut kept: Vec<bool> = Vec::new();
        for (place, resolved) in found.resolved.iter().enumerate() {
            let rest = self.without(&found.after, place)?;
            let instead = unexplained(self.problem(), &rest, &self.critical.unexplained)?;
            let instead = instead.delta_chi2 + BEYOND_PATTERNS;
            let needed = found.left.delta_chi2.max(instead);
            let mut ranked = resolved.ranked.iter();
            kept.push(ranked.any(|best| best.evidence.delta_chi2 > needed));
        }
        self.keep(found, &kept)
    }

    /// The same of a part: one after the other what explains less than what is left, the least first; the last one stays as the known part of
    /// something unknown.
    fn drop_stand_ins_of_a_part(&self, found: &mut SearchResult) -> Result<bool, MismatchError> {
        let mut dropped = false;
        loop {
            let left = found.after.fitted.squares;
            let beyond_noise = left - self.problem().observations.len() as f64;
            let explained = (0..found.resolved.len()).map(|place| {
                let rest = self.without(&found.after, place)?;
                Ok::<_, MismatchError>(rest.fitted.squares - left)
            });
            let explained: Vec<f64> = explained.collect::<Result<_, _>>()?;
            let least = explained.iter().copied().fold(f64::INFINITY, f64::min);
            if explained.len() < 2 || least > beyond_noise {
                return Ok(dropped);
            }
            let kept: Vec<bool> = explained.iter().map(|one| *one > least).collect();
            dropped |= self.keep(found, &kept)?;
        }
    }

    /// Leaves of what was found what is to be kept.
    ///
    /// # Returns
    /// Whether anything was taken back.
    fn keep(&self, found: &mut SearchResult, kept: &[bool]) -> Result<bool, MismatchError> {
        if kept.iter().all(|kept| *kept) {
            return Ok(false);
        }
        let known = self.problem().known_effects.iter().map(|_| &true);
        let mut keep = known.chain(kept);
        let mut model = found.after.fitted.model.clone();
        model.effects.retain(|_| *keep.next().unwrap_or(&true));
        let Some(state) = self.problem().alternate(model, self.options.noise)? else {
            return Ok(false);
        };
        let families: Vec<f64> = found
            .resolved
            .iter()
            .zip(kept)
            .filter(|(_, kept)| **kept)
            .map(|(resolved, _)| resolved.family_p)
            .collect();
        found.resolved = self.rivals_of_each(&state, &families)?;
        found.left = unexplained(self.problem(), &state, &self.critical.unexplained)?;
        found.after = state;
        Ok(true)
    }
}
