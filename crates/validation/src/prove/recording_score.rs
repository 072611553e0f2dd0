//! What was said of a recording, compared with its known answer. The rules stand in `data/recordings/README.md`.

use std::collections::BTreeSet;
use stiffbench::analysis::Failure;

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_diagnosis::mismatch::{
    Diagnosis, Line, MisfitShares, MismatchError, SearchOptions, Verdict, VerdictGrade, diagnose,
};
use stiffbench_measurement::specimen::SpecimenTable;

use super::answer_text::diagnosis_words;
use super::recordings::Recording;

/// How an answer counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RecordingOutcome {
    /// The verdict is right, and the dominant physics leads the headline if there is one.
    Right,
    /// The verdict is right, and the headline holds the dominant physics behind a law that may stand beside it.
    RightBehind,
    /// A foreign name leads the headline.
    FalseDominant,
    /// Nothing was said where something is right.
    Mute,
    /// Anything else.
    NotRight,
}

impl RecordingOutcome {
    /// Whether the headline is right.
    #[must_use]
    pub fn is_headline_right(self) -> bool {
        matches!(self, Self::Right | Self::RightBehind)
    }
}

/// A recording and what was said of it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RecordingScore {
    /// Its name.
    #[serde(rename = "recording")]
    pub name: String,
    /// How many readings it has.
    pub readings: usize,
    /// Verdicts that are right.
    #[serde(rename = "right")]
    pub expected: Vec<String>,
    /// Laws one of which must lead.
    pub physics: Vec<String>,
    /// The verdict.
    #[serde(rename = "said")]
    pub verdict: String,
    /// How far the verdict may be relied on; `null` without a graded diagnosis.
    pub grade: Option<VerdictGrade>,
    /// The leading finding, or the members of its set.
    pub leading: Vec<String>,
    /// Shares of the misfit that all findings explain together.
    #[serde(flatten)]
    pub shares: MisfitShares,
    /// The same in words.
    pub words: String,
    /// How it counts.
    pub outcome: RecordingOutcome,
    /// Laws that were named and are foreign: neither the physics nor what is acceptable beside it holds them.
    #[serde(rename = "false_names")]
    pub foreign: Vec<String>,
    /// Why that is the right answer.
    #[serde(skip)]
    pub why: String,
    /// Known figures beside ours, where ours has the same meaning.
    pub figures: Vec<ComparedFigure>,
}

/// A known figure and ours.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ComparedFigure {
    /// What it is.
    pub name: String,
    /// As known.
    pub known: Option<f64>,
    /// Ours.
    pub ours: Option<f64>,
}

impl RecordingScore {
    /// Whether all is right.
    #[must_use]
    pub fn is_right(&self) -> bool {
        self.outcome.is_headline_right() && self.foreign.is_empty()
    }
}

/// Whether a text of `also-right` is a verdict; else it is a law.
fn is_verdict(text: &str) -> bool {
    let verdicts = [
        Verdict::Explained,
        Verdict::Ambiguous,
        Verdict::Unknown,
        Verdict::NothingMissing,
        Verdict::InsufficientData,
    ];
    verdicts.iter().any(|verdict| verdict.to_string() == text)
}

impl Recording {
    /// Verdicts that are right.
    #[must_use]
    pub fn right_verdicts(&self) -> Vec<String> {
        let also = self.also_right.iter().filter(|text| is_verdict(text));
        std::iter::once(&self.verdict)
            .chain(also)
            .cloned()
            .collect()
    }
}

/// A finding as it counts.
#[derive(Debug, Clone, Copy)]
struct SaidLaw<'a> {
    law: &'a str,
    group: Option<u32>,
    share: Option<f64>,
}

/// The finding with the largest share of the misfit, or all members of its set.
fn leading<'a>(said: &[SaidLaw<'a>]) -> BTreeSet<&'a str> {
    let share = |law: &SaidLaw<'_>| law.share.unwrap_or(-1.0);
    // The first of equals.
    let first = said
        .iter()
        .rev()
        .max_by(|a, b| share(a).total_cmp(&share(b)));
    let belongs = |law: &&SaidLaw<'_>| match first {
        Some(first) if first.group.is_none() => std::ptr::eq(*law, first),
        Some(first) => law.group == first.group,
        None => false,
    };
    said.iter().filter(belongs).map(|law| law.law).collect()
}

/// Names that neither the physics nor what is acceptable beside it holds.
fn foreign<'a>(recording: &Recording, verdict: Verdict, said: &[SaidLaw<'a>]) -> BTreeSet<&'a str> {
    let listed = |names: &[String], law: &str| names.iter().any(|name| name == law);
    let in_a_right_set = |law: &SaidLaw<'_>| {
        let mut members = said.iter().filter(|other| other.group == law.group);
        law.group.is_some() && members.any(|other| listed(&recording.physics, other.law))
    };
    let is_foreign = |law: &&SaidLaw<'_>| {
        if listed(&recording.not, law.law) {
            return true;
        }
        // With the verdict unknown, what explains a part may be any law that is not excluded.
        let may_stand = verdict == Verdict::Unknown
            || listed(&recording.physics, law.law)
            || listed(&recording.also_right, law.law)
            || (listed(&recording.only_in_sets, law.law) && in_a_right_set(law));
        !may_stand
    };
    said.iter().filter(is_foreign).map(|law| law.law).collect()
}

/// Counts a verdict with its laws.
fn outcome(
    recording: &Recording,
    verdict: Verdict,
    grade: VerdictGrade,
    said: &[SaidLaw<'_>],
) -> RecordingOutcome {
    let is_expected = recording.right_verdicts().contains(&verdict.to_string());
    let foreign = foreign(recording, verdict, said);
    let is_physics = |law: &&str| recording.physics.iter().any(|name| name == *law);
    if !matches!(verdict, Verdict::Explained | Verdict::Ambiguous) {
        return match (is_expected, verdict) {
            (true, _) if foreign.is_empty() => RecordingOutcome::Right,
            (false, Verdict::Unknown) if !said.is_empty() => RecordingOutcome::NotRight,
            (false, _) => RecordingOutcome::Mute,
            (true, _) => RecordingOutcome::NotRight,
        };
    }
    let lead = leading(said);
    let is_flat = matches!(grade, VerdictGrade::Is | VerdictGrade::Mostly);
    let holds = said.iter().any(|law| is_physics(&law.law));
    if !lead.is_empty() && lead.is_subset(&foreign) {
        RecordingOutcome::FalseDominant
    } else if !(is_expected && is_flat && holds) {
        RecordingOutcome::NotRight
    } else if lead.iter().any(is_physics) {
        RecordingOutcome::Right
    } else {
        RecordingOutcome::RightBehind
    }
}

/// Diagnoses a table without a robot and compares the verdict with the known answer.
///
/// # Errors
/// If it cannot be computed.
pub fn score_recording(
    recording: &Recording,
    table: &SpecimenTable,
    seed: u64,
) -> Result<RecordingScore, Failure> {
    let (line, observations) = Line::of_table(table)?;
    let options = SearchOptions {
        seed,
        ..SearchOptions::default()
    };
    let readings = table.readings.len();
    let diagnosis = match diagnose(&line, &observations, &options, None) {
        Ok((diagnosis, _)) => diagnosis,
        Err(error) => return Ok(failed(recording, readings, &error)),
    };
    // Each gauge zero and each slope was fitted.
    let count = table.readings.len() as f64;
    let fitted = (table.runs.len() + table.configurations.len()) as f64;
    let spread = (count / (count - fitted).max(1.0)).sqrt();
    let with_effects: usize = diagnosis.effects.iter().map(|e| e.values.len()).sum();
    let spread_after = (count / (count - fitted - with_effects as f64).max(1.0)).sqrt();
    let mut figures = vec![
        ComparedFigure {
            name: "residual sd of a line (ours: a zero for each run)".to_owned(),
            known: recording.line_residual_sd,
            ours: Some(spread * diagnosis.before.rms_m),
        },
        ComparedFigure {
            name: format!(
                "residual sd of the answer ({})",
                answer_figure(recording).map_or("none known", |(name, _)| name)
            ),
            known: answer_figure(recording).map(|(_, value)| value),
            ours: Some(spread_after * diagnosis.after.rms_m),
        },
    ];
    figures.retain(|figure| figure.known.is_some() || figure.ours.is_some());
    Ok(assess(recording, readings, &diagnosis, figures))
}

/// The known residual standard deviation of the best model that the recording's answer knows.
fn answer_figure(recording: &Recording) -> Option<(&str, f64)> {
    recording
        .figures
        .iter()
        .filter(|(name, _)| name.contains("residual-sd"))
        .map(|(name, value)| (name.as_str(), *value))
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The score of a recording without a diagnosis.
fn failed(recording: &Recording, readings: usize, error: &MismatchError) -> RecordingScore {
    RecordingScore {
        name: recording.name.clone(),
        readings,
        expected: recording.right_verdicts(),
        physics: recording.physics.clone(),
        verdict: "no diagnosis".to_owned(),
        grade: None,
        leading: Vec::new(),
        shares: MisfitShares::default(),
        words: error.to_string(),
        outcome: RecordingOutcome::Mute,
        foreign: Vec::new(),
        why: recording.why.clone(),
        figures: Vec::new(),
    }
}

/// Holds a diagnosis against the known answer.
#[must_use]
pub fn assess(
    recording: &Recording,
    readings: usize,
    diagnosis: &Diagnosis,
    figures: Vec<ComparedFigure>,
) -> RecordingScore {
    let said: Vec<SaidLaw<'_>> = diagnosis
        .findings
        .iter()
        .map(|finding| SaidLaw {
            law: finding.effect.law.name,
            group: finding.alternative_group,
            share: finding.shares.share_of_misfit,
        })
        .collect();
    RecordingScore {
        name: recording.name.clone(),
        readings,
        expected: recording.right_verdicts(),
        physics: recording.physics.clone(),
        verdict: diagnosis.verdict.to_string(),
        grade: Some(diagnosis.grade),
        leading: leading(&said).into_iter().map(str::to_owned).collect(),
        shares: diagnosis.shares,
        words: diagnosis_words(diagnosis),
        outcome: outcome(recording, diagnosis.verdict, diagnosis.grade, &said),
        foreign: foreign(recording, diagnosis.verdict, &said)
            .into_iter()
            .map(str::to_owned)
            .collect(),
        why: recording.why.clone(),
        figures,
    }
}

#[cfg(test)]
mod tests;
