//! From what was found and what is left to a verdict and its grade.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::search::constants::{LAW_LEVEL, MOST_OF_THE_MISFIT, STRONG_EVIDENCE};

/// Chance of the family below which a name is given without reservation (1). Stated.
const CERTAIN: f64 = 0.005;

/// What is to be said of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The mismatch has one explanation.
    Explained,
    /// Some of the mismatch has several explanations that these data do not distinguish.
    Ambiguous,
    /// Structure is left that no law of the library explains.
    Unknown,
    /// Nothing is missing down to the detection limits.
    NothingMissing,
    /// These data cannot decide.
    InsufficientData,
}

/// Its name in files.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// How far a verdict may be relied on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VerdictGrade {
    /// What is named explains the readings.
    Is,
    /// What is named explains most of the misfit; something is left.
    Mostly,
    /// What is named is likely, no more.
    Weak,
    /// What is left has no name.
    Unknown,
    /// Nothing is missing.
    Nothing,
    /// These readings cannot decide.
    Undecided,
}

/// What a verdict rests on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GradeBasis {
    /// Whether the scatter is estimated from the residuals of the fit, of which a part may be physics.
    pub(crate) scatter_from_fit: bool,
    /// Smallest chance of a finding on noise alone, the level of all laws as its family; 1 without findings.
    pub(crate) p_family: f64,
    /// Log Bayes factor of the same finding.
    pub(crate) log_bayes: f64,
    /// Whether a place in the answer is held by several that cannot be distinguished.
    pub(crate) is_a_set: bool,
    /// Whether more is left than noise leaves.
    pub(crate) is_left: bool,
    /// Share of the misfit that all findings explain together.
    pub(crate) share_of_misfit: Option<f64>,
    /// The same in readings that were left out of the fit.
    pub(crate) share_unseen: Option<f64>,
}

impl GradeBasis {
    /// Whether a name may stand without reservation, if nothing is left.
    pub(crate) fn is_certain(p_family: f64, log_bayes: f64) -> bool {
        p_family <= CERTAIN && log_bayes >= STRONG_EVIDENCE
    }

    /// Whether findings explain most of a misfit of which some is left.
    pub(crate) fn is_most(&self) -> bool {
        let most = |share: Option<f64>| share.is_some_and(|share| share >= MOST_OF_THE_MISFIT);
        // Beside a scatter from the fit a share of the misfit means nothing.
        let fitted = self.scatter_from_fit || most(self.share_of_misfit);
        Self::is_certain(self.p_family, self.log_bayes) && fitted && most(self.share_unseen)
    }

    /// The verdict and how far it may be relied on.
    pub(crate) fn decide(&self) -> (Verdict, VerdictGrade) {
        let found = self.p_family <= LAW_LEVEL;
        let grade = match (found, self.is_left) {
            (false, false) if self.scatter_from_fit => {
                return (Verdict::InsufficientData, VerdictGrade::Undecided);
            }
            (false, false) => return (Verdict::NothingMissing, VerdictGrade::Nothing),
            (true, _) if self.scatter_from_fit && self.is_most() => VerdictGrade::Mostly,
            // What does not lower the error in left-out poses at all explains nothing there.
            (true, false) if self.scatter_from_fit => match self.share_unseen {
                Some(share) if share > 0.0 => VerdictGrade::Weak,
                _ => return (Verdict::Unknown, VerdictGrade::Unknown),
            },
            (true, false) if Self::is_certain(self.p_family, self.log_bayes) => VerdictGrade::Is,
            (true, false) => VerdictGrade::Weak,
            (true, true) if self.is_most() => VerdictGrade::Mostly,
            (_, true) => return (Verdict::Unknown, VerdictGrade::Unknown),
        };
        let verdict = if self.is_a_set {
            Verdict::Ambiguous
        } else {
            Verdict::Explained
        };
        (verdict, grade)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grades_follow_evidence_rest_and_shares() {
        let certain = GradeBasis {
            scatter_from_fit: false,
            p_family: 1e-4,
            log_bayes: 20.0,
            is_a_set: false,
            is_left: false,
            share_of_misfit: None,
            share_unseen: None,
        };
        let decide = |basis: GradeBasis| basis.decide();
        assert_eq!(decide(certain), (Verdict::Explained, VerdictGrade::Is));
        let hint = GradeBasis {
            log_bayes: 2.9,
            ..certain
        };
        assert_eq!(decide(hint), (Verdict::Explained, VerdictGrade::Weak));
        let chance = GradeBasis {
            p_family: 0.006,
            is_a_set: true,
            ..certain
        };
        assert_eq!(decide(chance), (Verdict::Ambiguous, VerdictGrade::Weak));
        let left = GradeBasis {
            is_left: true,
            ..certain
        };
        let unknown = (Verdict::Unknown, VerdictGrade::Unknown);
        assert_eq!(decide(left), unknown);
        let most = GradeBasis {
            share_of_misfit: Some(0.8),
            share_unseen: Some(0.75),
            ..left
        };
        assert_eq!(decide(most), (Verdict::Explained, VerdictGrade::Mostly));
        let unseen = GradeBasis {
            share_unseen: Some(0.74),
            ..most
        };
        assert_eq!(decide(unseen), unknown);
        let none = GradeBasis {
            p_family: 1.0,
            log_bayes: 0.0,
            ..certain
        };
        assert_eq!(
            decide(none),
            (Verdict::NothingMissing, VerdictGrade::Nothing)
        );
        // A scatter from the fit allows neither `is` nor `nothing`.
        let undecided = (Verdict::InsufficientData, VerdictGrade::Undecided);
        let from_fit = |basis| GradeBasis {
            scatter_from_fit: true,
            ..basis
        };
        assert_eq!(decide(from_fit(none)), undecided);
        assert_eq!(decide(from_fit(certain)), unknown);
        let helps = GradeBasis {
            share_unseen: Some(0.1),
            ..certain
        };
        assert_eq!(decide(from_fit(helps)).1, VerdictGrade::Weak);
        assert_eq!(decide(from_fit(left)).1, VerdictGrade::Unknown);
        let most = GradeBasis {
            share_unseen: Some(0.75),
            ..left
        };
        assert_eq!(decide(from_fit(most)).1, VerdictGrade::Mostly);
    }
}
