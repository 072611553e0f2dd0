//! Verdicts and answers in one line each.

use std::fmt::Write;

use stiffbench_diagnosis::mismatch::{Diagnosis, Finding, Verdict};

use super::answers::SealedAnswer;

/// A diagnosis in one line.
#[must_use]
pub fn diagnosis_words(diagnosis: &Diagnosis) -> String {
    let mut parts = vec![diagnosis.verdict.to_string()];
    parts.extend(diagnosis.lacking.iter().cloned());
    let mut group = None;
    for finding in &diagnosis.findings {
        let word = finding_words(finding);
        match parts.last_mut() {
            Some(last) if group.is_some() && group == finding.alternative_group => {
                last.push_str(" or ");
                last.push_str(&word);
            }
            _ => parts.push(word),
        }
        group = finding.alternative_group;
    }
    if diagnosis.verdict == Verdict::Unknown {
        let left = &diagnosis.unexplained;
        let pose = left.pose.as_ref().map_or("all poses", |pose| pose.as_str());
        let direction = left
            .direction
            .map_or_else(String::new, |direction| format!(" {direction}"));
        parts.push(format!(
            "left: {} in {pose}{direction} (p {:.4})",
            left.stratum, left.p_family
        ));
    }
    parts.join("; ")
}

fn finding_words(finding: &Finding) -> String {
    format!(
        "{} ({:.1} standard errors, p {:.4})",
        finding.effect.title(),
        finding.standard_errors,
        finding.p_family
    )
}

/// An answer in one line.
#[must_use]
pub fn answer_words(answer: &SealedAnswer) -> String {
    let mut parts = vec![answer.expected.to_string()];
    for truth in &answer.truth {
        let mut words = format!(
            "{} ({:.1} standard errors",
            truth.title(),
            truth.standard_errors_beside_the_others
        );
        if let Some(rival) = truth.rivals.first() {
            let between = rival.standard_errors_between;
            let _ = write!(words, ", next {} {between:.1} away", rival.physics);
        }
        words.push(')');
        parts.push(words);
    }
    if let Some(left) = answer.left_by_library {
        parts.push(format!("the library leaves {left:.1}"));
    }
    if answer.may_be_missed {
        parts.push("may be missed".to_owned());
    }
    parts.join("; ")
}
