//! Findings as one answers with them: alone, or as a set of which one is true.

use crate::mismatch::Finding;

use super::words::{listed, phrase};

/// What a diagnosis says in one place: one finding, or several of which one is true.
pub(in crate::report) enum Answer<'a> {
    Single(&'a Finding),
    OneOf(Vec<&'a Finding>),
}

impl<'a> Answer<'a> {
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
}

/// What a finding says is missing.
pub(super) fn phrase_of(finding: &Finding) -> String {
    let effect = &finding.effect;
    phrase(effect.law, &effect.place, &effect.values)
}
