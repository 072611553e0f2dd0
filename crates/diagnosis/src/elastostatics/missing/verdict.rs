//! From what was found and what is left to a verdict.

use crate::mismatch::Verdict;
use crate::search::constants::{LAW_LEVEL, STRONG_EVIDENCE, UNEXPLAINED_LEVEL};

use super::outcome::{LoadCaseFinding, VerdictGrade};

/// Chance of the family below which a name is given without reservation (1). Stated.
const CERTAIN: f64 = 0.005;

/// Share of the misfit, seen and unseen, that names must explain to be most of the answer (1). Stated.
const MOST: f64 = 0.75;

/// What a verdict rests on.
pub(super) struct VerdictBasis<'a> {
    pub(super) findings: &'a [LoadCaseFinding],
    pub(super) p_family: f64,
    pub(super) p_unexplained: f64,
    /// Whether free springs would have to be negative for the free parameters to explain the load cases.
    pub(super) is_held_by_bounds: bool,
    pub(super) share_of_misfit: Option<f64>,
    pub(super) share_unseen: Option<f64>,
}

impl VerdictBasis<'_> {
    /// The verdict and how far it may be relied on.
    pub(super) fn decide(&self) -> (Verdict, VerdictGrade) {
        let is_left = self.p_unexplained <= UNEXPLAINED_LEVEL
            || self.findings.is_empty() && self.is_held_by_bounds;
        let found = !self.findings.is_empty() && self.p_family <= LAW_LEVEL;
        let strong = self.p_family <= CERTAIN
            && self
                .findings
                .iter()
                .all(|one| one.log_bayes >= STRONG_EVIDENCE);
        let most = |share: Option<f64>| share.is_some_and(|share| share >= MOST);
        let grade = match (found, is_left) {
            (false, false) => return (Verdict::NothingMissing, VerdictGrade::Nothing),
            (false, true) => return (Verdict::Unknown, VerdictGrade::Unknown),
            (true, false) if strong => VerdictGrade::Is,
            (true, false) => VerdictGrade::Weak,
            (true, true) if strong && most(self.share_of_misfit) && most(self.share_unseen) => {
                VerdictGrade::Mostly
            }
            (true, true) => return (Verdict::Unknown, VerdictGrade::Unknown),
        };
        let is_a_set = self.findings.iter().any(|one| !one.alternatives.is_empty());
        let verdict = if is_a_set {
            Verdict::Ambiguous
        } else {
            Verdict::Explained
        };
        (verdict, grade)
    }
}
