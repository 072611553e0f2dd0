//! Pass and fail: limits of the stiffness and the rule by which they are applied.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_document::{Document, NoteKind, Table, TableCell};

use super::results::PageCell;
use super::session::{PageSession, as_stated};
use crate::count::counted;
use crate::load_direction::LoadDirection;

/// How a limit is applied to a value with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DecisionRule {
    /// The value alone is compared with the limit.
    SimpleAcceptance,
    /// The limit is moved by the expanded uncertainty, w = U (ILAC-G8:09/2019, 4.2.3).
    GuardBand,
}

impl DecisionRule {
    /// The rule in a sentence.
    #[must_use]
    pub fn sentence(self) -> &'static str {
        match self {
            Self::SimpleAcceptance => {
                "Simple acceptance (ILAC-G8:09/2019, 4.2.1): a value within the limits passes; its uncertainty is not taken into account."
            }
            Self::GuardBand => {
                "Guard band w = U (ILAC-G8:09/2019, 4.2.3): a value passes if it lies within the limits by U or more, and fails if it lies beyond them by U or more. In between the result is a conditional pass or a conditional fail."
            }
        }
    }
}

/// Limits of the stiffness of a cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Requirement {
    /// The pose.
    pub pose: String,
    /// The direction.
    pub direction: String,
    /// Smallest stiffness, N/µm.
    #[serde(
        rename = "at_least_N_per_um",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub at_least: Option<f64>,
    /// Largest stiffness, N/µm.
    #[serde(
        rename = "at_most_N_per_um",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub at_most: Option<f64>,
}

impl Requirement {
    /// What is wrong with it.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        let cell = format!("requirement of {} {}", self.pose, self.direction);
        let limits: Vec<f64> = self.at_least.into_iter().chain(self.at_most).collect();
        if limits.is_empty() {
            return Some(format!(
                "{cell}: a limit is missing: at_least_N_per_um or at_most_N_per_um"
            ));
        }
        if limits
            .iter()
            .any(|limit| !limit.is_finite() || *limit <= 0.0)
        {
            return Some(format!("{cell}: a limit must be a number above zero"));
        }
        if self.direction.parse::<LoadDirection>().is_err() {
            return Some(format!(
                "{cell}: the direction must be x, y or z, or that of a load such as -y or (0,0.6,0.8)"
            ));
        }
        (limits.len() == 2 && limits[0] > limits[1])
            .then(|| format!("{cell}: at_least_N_per_um is above at_most_N_per_um"))
    }

    fn words(&self) -> String {
        let least = self
            .at_least
            .map(|limit| format!("at least {}", as_stated(limit, 1.0)));
        let most = self
            .at_most
            .map(|limit| format!("at most {}", as_stated(limit, 1.0)));
        let both: Vec<String> = least.into_iter().chain(most).collect();
        both.join(", ")
    }
}

/// What became of a requirement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ConformityDecision {
    /// Within the limits.
    Pass,
    /// Within the limits by less than U.
    ConditionalPass,
    /// Beyond a limit by less than U.
    ConditionalFail,
    /// Beyond a limit.
    Fail,
    /// Without a value, or without an uncertainty that the rule needs.
    NotDecided,
}

impl ConformityDecision {
    fn words(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::ConditionalPass => "conditional pass",
            Self::ConditionalFail => "conditional fail",
            Self::Fail => "fail",
            Self::NotDecided => "not decided",
        }
    }
}

/// One requirement with its decision.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct JudgedRequirement {
    /// The pose.
    pub pose: String,
    /// The direction.
    pub direction: String,
    /// The limits, N/µm, in words.
    pub limits: String,
    /// The stiffness with its uncertainty, as in the results.
    pub stiffness: String,
    /// What became of it.
    pub decision: ConformityDecision,
    /// The same in words.
    pub words: &'static str,
}

/// The statement of conformity.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ConformityStatement {
    /// The rule.
    pub rule: &'static str,
    /// The statement in a sentence.
    pub sentence: String,
    /// Every requirement.
    pub requirements: Vec<JudgedRequirement>,
}

impl ConformityStatement {
    /// Whether every requirement is met, at least on condition.
    #[must_use]
    pub fn all_pass(&self) -> bool {
        let mut decisions = self.requirements.iter().map(|one| one.decision);
        decisions.all(|decision| {
            matches!(
                decision,
                ConformityDecision::Pass | ConformityDecision::ConditionalPass
            )
        })
    }

    /// The statement with its rule, and every requirement.
    pub(super) fn document(&self) -> Document {
        let mut document = Document::new();
        document.note(NoteKind::Verdict, &self.sentence);
        document.paragraph(self.rule);
        let table = Table::of(&self.requirements)
            .words("pose", |one| &one.pose)
            .words("direction", |one| &one.direction)
            .numbers("limits, N/µm", |one| &one.limits)
            .numbers("K ± U", |one| &one.stiffness)
            .words("decision", |one| match one.decision {
                ConformityDecision::Pass => TableCell::from(one.words),
                _ => TableCell::marked(one.words),
            });
        document.table(table);
        document
    }
}

/// The decision on a value with its expanded uncertainty, all in the same unit.
///
/// # Arguments
/// - `limits`: the smallest and the largest value.
#[must_use]
pub fn decide(
    rule: DecisionRule,
    value: Option<f64>,
    expanded: Option<f64>,
    limits: [Option<f64>; 2],
) -> ConformityDecision {
    let margin = |value: f64| {
        let above = limits[0].map(|limit| value - limit);
        let below = limits[1].map(|limit| limit - value);
        above.into_iter().chain(below).fold(f64::INFINITY, f64::min)
    };
    match (rule, value.map(margin), expanded) {
        (_, None, _) | (DecisionRule::GuardBand, _, None) => ConformityDecision::NotDecided,
        (DecisionRule::SimpleAcceptance, Some(margin), _) if margin >= 0.0 => {
            ConformityDecision::Pass
        }
        (DecisionRule::SimpleAcceptance, ..) => ConformityDecision::Fail,
        (DecisionRule::GuardBand, Some(margin), Some(guard)) if margin >= guard => {
            ConformityDecision::Pass
        }
        (DecisionRule::GuardBand, Some(margin), Some(guard)) if margin <= -guard => {
            ConformityDecision::Fail
        }
        (DecisionRule::GuardBand, Some(margin), _) if margin >= 0.0 => {
            ConformityDecision::ConditionalPass
        }
        (DecisionRule::GuardBand, ..) => ConformityDecision::ConditionalFail,
    }
}

/// Decides on every requirement; `None` without requirements or without a rule.
#[must_use]
pub(super) fn conformity(
    rule: Option<DecisionRule>,
    requirements: &[Requirement],
    session: &PageSession,
) -> Option<ConformityStatement> {
    let rule = rule.filter(|_| !requirements.is_empty())?;
    let judged: Vec<JudgedRequirement> = requirements
        .iter()
        .map(|requirement| judged(rule, requirement, session))
        .collect();
    let count = |decision| {
        let same = judged.iter().filter(|one| one.decision == decision);
        same.count()
    };
    let decisions = [
        ConformityDecision::Pass,
        ConformityDecision::ConditionalPass,
        ConformityDecision::ConditionalFail,
        ConformityDecision::Fail,
        ConformityDecision::NotDecided,
    ]
    .map(|decision| (count(decision), decision.words()));
    let parts: Vec<String> = decisions
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, words)| format!("{count} {words}"))
        .collect();
    Some(ConformityStatement {
        rule: rule.sentence(),
        sentence: format!(
            "Of {}: {}.",
            counted(judged.len(), "requirement"),
            parts.join(", ")
        ),
        requirements: judged,
    })
}

fn judged(
    rule: DecisionRule,
    requirement: &Requirement,
    session: &PageSession,
) -> JudgedRequirement {
    let cell = session.cell(&requirement.pose, &requirement.direction);
    let value = cell.and_then(|cell| cell.stiffness.value);
    let expanded = cell.and_then(|cell| cell.stiffness.expanded_uncertainty);
    let limits = [requirement.at_least, requirement.at_most];
    let decision = decide(rule, value, expanded, limits);
    JudgedRequirement {
        pose: requirement.pose.clone(),
        direction: requirement.direction.clone(),
        limits: requirement.words(),
        stiffness: cell.map_or_else(|| "not measured".to_owned(), PageCell::words),
        decision,
        words: decision.words(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_guard_band_divides_the_values_in_four() {
        let decided = |value| {
            decide(
                DecisionRule::GuardBand,
                Some(value),
                Some(0.2),
                [Some(1.0), None],
            )
        };
        assert_eq!(decided(1.3), ConformityDecision::Pass);
        assert_eq!(decided(1.1), ConformityDecision::ConditionalPass);
        assert_eq!(decided(0.9), ConformityDecision::ConditionalFail);
        assert_eq!(decided(0.7), ConformityDecision::Fail);
        let without = decide(DecisionRule::GuardBand, Some(1.3), None, [Some(1.0), None]);
        assert_eq!(without, ConformityDecision::NotDecided);
    }

    #[test]
    fn simple_acceptance_needs_no_uncertainty() {
        let decided = |value| {
            decide(
                DecisionRule::SimpleAcceptance,
                value,
                None,
                [Some(1.0), Some(2.0)],
            )
        };
        assert_eq!(decided(Some(1.0)), ConformityDecision::Pass);
        assert_eq!(decided(Some(2.1)), ConformityDecision::Fail);
        assert_eq!(decided(None), ConformityDecision::NotDecided);
    }
}
