//! Findings as one answers with them: alone, or as a set of which one is true.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::mismatch::Finding;
use crate::physics::Law;

use super::phrases::{listed, phrase};

/// Where naming all alternatives would take more than this, bytes, a headline states how many there are.
const LONGEST_IN_A_HEADLINE: usize = 150;

/// The statement of a diagnosis in one place: one finding, or several of which one is true.
pub(in crate::report) enum DiagnosisAnswer<'a> {
    Single(&'a Finding),
    OneOf(Vec<&'a Finding>),
}

/// What an answer accuses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Accused {
    /// Physics that the model leaves out.
    Physics,
    /// The robot file or the set-up.
    Setup,
    /// The one or the other.
    Either,
}

/// What a finding accuses.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FindingKind {
    /// The robot, its gauges or their surroundings.
    Physics,
    /// The robot file, or how gauges and loads were set up.
    Setup,
}

impl From<Law> for FindingKind {
    fn from(law: Law) -> Self {
        if law.is_setup() {
            Self::Setup
        } else {
            Self::Physics
        }
    }
}

impl Accused {
    /// Heading of the section about it.
    pub(super) fn heading(self) -> &'static str {
        match self {
            Self::Physics => "What is missing",
            Self::Setup => "What may be wrong in the robot file or the set-up",
            Self::Either => "What is missing, or wrong in the robot file or the set-up",
        }
    }

    /// What a headline says of it.
    ///
    /// # Arguments
    /// - `model`: what was fitted, in a word.
    /// - `mostly`: whether something else is left.
    pub(super) fn sentence(self, model: &str, object: &str, mostly: bool) -> String {
        let mostly = if mostly { "mostly " } else { "" };
        match self {
            Self::Physics => format!("The {model} {mostly}leaves out {object}."),
            Self::Setup => format!("The robot file or the set-up is {mostly}at fault: {object}."),
            Self::Either => format!(
                "The {model} {mostly}leaves out, or the robot file or the set-up is wrong about, {object}."
            ),
        }
    }
}

impl<'a> DiagnosisAnswer<'a> {
    /// Findings with their alternatives together.
    pub(in crate::report) fn all(findings: &'a [Finding]) -> Vec<Self> {
        let mut answers: Vec<(Option<u32>, Vec<&Finding>)> = Vec::new();
        for finding in findings {
            let group = finding.alternative_group;
            match answers.iter_mut().find(|(g, _)| g.is_some() && *g == group) {
                Some((_, members)) => members.push(finding),
                None => answers.push((group, vec![finding])),
            }
        }
        answers
            .into_iter()
            .map(|(group, members)| match (group, &members[..]) {
                (None, [one]) => Self::Single(one),
                _ => Self::OneOf(members),
            })
            .collect()
    }

    /// The findings, the first the most likely.
    pub(in crate::report) fn members(&self) -> &[&'a Finding] {
        match self {
            Self::Single(one) => std::slice::from_ref(one),
            Self::OneOf(members) => members,
        }
    }

    /// What it accuses.
    pub(super) fn accuses(&self) -> Accused {
        let is_setup = |finding: &&Finding| finding.effect.law.is_setup();
        let members = self.members();
        match members.iter().filter(|finding| is_setup(finding)).count() {
            0 => Accused::Physics,
            setups if setups == members.len() => Accused::Setup,
            _ => Accused::Either,
        }
    }

    /// What is missing, as the object of a sentence.
    pub(super) fn phrase(&self) -> String {
        let members = self.members();
        let names: Vec<String> = members.iter().map(|f| phrase_of(f)).collect();
        // "friction in joint A3, joint A4 or joint A5": what the names begin with is said once.
        let parts: Option<Vec<(&str, String)>> = members
            .iter()
            .zip(&names)
            .map(|(finding, name)| {
                let place = finding.effect.place.to_string();
                Some((name.strip_suffix(place.as_str())?, place))
            })
            .collect();
        match parts.as_deref() {
            Some([(first, _), rest @ ..])
                if !rest.is_empty() && rest.iter().all(|(start, _)| start == first) =>
            {
                let places: Vec<String> = parts.iter().flatten().map(|p| p.1.clone()).collect();
                format!("{first}{}", listed(&places, "or"))
            }
            _ => listed(&names, "or"),
        }
    }

    /// The same of several, for a headline.
    pub(super) fn open_question(&self) -> String {
        let (phrase, members) = (self.phrase(), self.members());
        match members {
            [first, ..] if phrase.len() > LONGEST_IN_A_HEADLINE => format!(
                "one of {} effects (listed below) that these readings do not distinguish; {} explains them as well as any other",
                members.len(),
                phrase_of(first)
            ),
            _ => format!("{phrase}; these readings do not decide which"),
        }
    }
}

/// What is missing according to a finding.
pub(super) fn phrase_of(finding: &Finding) -> String {
    let effect = &finding.effect;
    phrase(effect.law, &effect.place, &effect.values)
}

#[cfg(test)]
mod tests {
    use insta::assert_snapshot;

    use super::*;
    use crate::mismatch::{MisfitShares, VerdictGrade};
    use crate::physics::{Effect, Law, Place, laws};

    fn finding(law: Law, joint: &str) -> Finding {
        let size = vec![1e-5; law.parameters.len()];
        Finding {
            effect: Effect::new(law, Place::Joint(joint.to_owned()), size).unwrap(),
            grade: VerdictGrade::Is,
            shares: MisfitShares::default(),
            values: Vec::new(),
            combination: None,
            at_bound: false,
            spans_range: false,
            alternative_group: Some(1),
            end_effect_m: 1e-5,
            absorbed_share: 0.0,
            log_bayes: 10.0,
            standard_errors: 6.0,
            p_family: 1e-3,
            rivals: Vec::new(),
        }
    }

    fn question(findings: &[Finding]) -> String {
        let answers = DiagnosisAnswer::all(findings);
        assert_eq!(answers.len(), 1);
        answers[0].open_question()
    }

    #[test]
    fn many_places_of_one_law_stand_in_the_headline() {
        let joints = ["A3", "A4", "A5B", "B1", "B2a", "B2b", "B3"];
        let findings = joints.map(|joint| finding(laws::JOINT_FRICTION, joint));
        assert_snapshot!(question(&findings), @"friction in joint A3, joint A4, joint A5B, joint B1, joint B2a, joint B2b or joint B3; these readings do not decide which");
    }

    #[test]
    fn of_many_laws_and_places_the_headline_gives_the_count_and_the_first() {
        let laws = [
            laws::JOINT_COMPLIANCE,
            laws::JOINT_FRICTION,
            laws::JOINT_BACKLASH,
        ];
        let findings: Vec<Finding> = ["B1", "A5F", "B3"]
            .iter()
            .flat_map(|joint| laws.map(|law| finding(law, joint)))
            .collect();
        assert_snapshot!(question(&findings), @"one of 9 effects (listed below) that these readings do not distinguish; a compliant joint B1 explains them as well as any other");
    }
}
