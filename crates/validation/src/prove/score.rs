//! Verdicts compared with answers, by fixed rules.

use std::fmt;
use stiffbench::analysis::Failure;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;

use stiffbench_beams::physics::Effect;
use stiffbench_diagnosis::mismatch::{Diagnosis, Finding, Verdict, VerdictGrade};

use super::answer_text::{answer_words, diagnosis_words};
use super::answers::{Expected, KnownRival, SealedAnswer, Set, TrueEffect, place_words};
use super::blind::BlindVerdict;

/// Rivals nearer than this cannot be distinguished, standard errors.
pub const INSEPARABLE: f64 = 2.0;

/// Rivals farther than this must be distinguished, standard errors; and farther than [`APART_SHARE`] of the effect's own length.
pub const APART: f64 = 4.25;

/// See [`APART`].
pub const APART_SHARE: f64 = 0.62;

/// Members of a set at least this far from the truth are padding, standard errors: an observer who knows the noise separates them from it.
pub const SEPARABLE: f64 = 4.0;

/// Outside the library "unknown" is owed where the best three library effects leave this much, standard errors.
pub const UNKNOWN_FROM: f64 = 6.0;

/// What a verdict is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum VerdictOutcome {
    /// As expected.
    Right,
    /// Nothing was found, and nothing had to be.
    #[serde(rename = "may be missed")]
    MayBeMissed,
    /// The truth is named, but not all that cannot be distinguished from it.
    Incomplete,
    /// The truth is named among others from which it can be distinguished.
    Padded,
    /// One of several effects is named, the others are not.
    Partly,
    /// All of the truth is named, and something besides.
    Extra,
    /// All of the truth is named, and structure is said to be left.
    #[serde(rename = "structure claimed")]
    StructureClaimed,
    /// Structure is said to be left where a law of the library acts that was not named.
    #[serde(rename = "unknown instead")]
    UnknownInstead,
    /// Something outside the library is named by laws at its place, under the grade *mostly*, which states what they leave.
    Mostly,
    /// Something outside the library is named as what explains a part of it, and too little is left to owe "unknown".
    #[serde(rename = "part named")]
    PartNamed,
    /// Nothing was found where something should have been.
    #[serde(rename = "not found")]
    NotFound,
    /// Something is named that is not there.
    #[serde(rename = "wrong name")]
    WrongName,
    /// Something was found where nothing is.
    #[serde(rename = "false alarm")]
    FalseAlarm,
    /// The data were called insufficient.
    Undecided,
    /// There is no diagnosis.
    Failed,
}

impl VerdictOutcome {
    /// All, in the order of tables.
    pub const ALL: [Self; 15] = [
        Self::Right,
        Self::MayBeMissed,
        Self::Incomplete,
        Self::Padded,
        Self::Partly,
        Self::Extra,
        Self::StructureClaimed,
        Self::UnknownInstead,
        Self::Mostly,
        Self::PartNamed,
        Self::NotFound,
        Self::WrongName,
        Self::FalseAlarm,
        Self::Undecided,
        Self::Failed,
    ];

    /// Whether it counts as a success.
    #[must_use]
    pub fn is_right(self) -> bool {
        matches!(self, Self::Right | Self::MayBeMissed)
    }
}

/// Its name in files and tables.
impl fmt::Display for VerdictOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// How a true effect was named.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NamedCause {
    /// Alone.
    Alone,
    /// In a set of so many.
    #[serde(rename = "in_set_of")]
    InSet(usize),
    /// Not at all.
    No,
}

/// A true effect and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct TruthScore {
    /// Law and place in words.
    pub title: String,
    /// Its physics.
    #[serde(skip)]
    pub physics: String,
    /// Its length, the sizes of the other effects free, standard errors.
    pub standard_errors: f64,
    /// How it was named.
    pub named: NamedCause,
    /// Members of its set from which an observer who knows the noise separates it, with their distance.
    pub padding: Vec<String>,
    /// What cannot be distinguished from it and is not in its set.
    pub left_out: Vec<String>,
    /// Whether the 95 % interval of its size holds the true one; `None` where it is not named or has no interval.
    #[serde(rename = "size_in_interval")]
    pub size_covered: Option<bool>,
    /// Found over true size; `None` where it is not named.
    #[serde(rename = "size_over_truth")]
    pub size_ratio: Option<f64>,
}

/// Verdict and answer of one session.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Score {
    /// The session.
    pub session: String,
    /// Robot and mechanism.
    pub bench: String,
    /// Which list it is of.
    #[serde(skip)]
    pub set: Set,
    /// Mode of concealment.
    pub mode: String,
    /// What was expected.
    pub expected: Expected,
    /// What was said; `None` without a diagnosis.
    pub verdict: Option<Verdict>,
    /// What that is worth.
    pub outcome: VerdictOutcome,
    /// The answer in words.
    #[serde(rename = "answer")]
    pub answer_words: String,
    /// The verdict in words.
    #[serde(rename = "said")]
    pub verdict_words: String,
    /// Each true effect.
    pub truths: Vec<TruthScore>,
    /// What three effects of the library leave, outside the library, standard errors.
    pub left_by_library: Option<f64>,
    /// Held-out error after over its floor; `None` with one pose.
    #[serde(rename = "held_out_over_floor")]
    pub held_out_ratio: Option<f64>,
    /// Whether the published validation passes.
    #[serde(rename = "published_validation_passes")]
    pub published_passes: Option<bool>,
    /// Factors reported as identified whose 95 % intervals hold the true value.
    pub factors_in_intervals: usize,
    /// Factors reported as identified.
    pub factors_identified: usize,
}

impl Score {
    /// Whether something is there that the published validation does not show.
    #[must_use]
    pub fn is_concealed(&self) -> bool {
        self.published_passes == Some(true) && self.expected != Expected::NothingMissing
    }
}

/// How far a name is from one of the true effects, by its number, for an observer who knows the noise: standard errors.
pub type Distances<'a> = dyn Fn(usize, &Effect) -> Result<f64, Failure> + 'a;

/// Scores a verdict.
///
/// # Arguments
/// - `distances`: asked of each other member of a set that holds a true effect.
///
/// # Errors
/// Those of `distances`.
pub fn score(
    verdict: &BlindVerdict,
    answer: &SealedAnswer,
    set: Set,
    distances: &Distances<'_>,
) -> Result<Score, Failure> {
    let diagnosis = verdict.diagnosis.as_ref().ok();
    let findings = diagnosis.map_or(&[][..], |d| &d.findings);
    let groups = groups(findings);
    let (truths, extra) = match_truths(&groups, &answer.truth, distances)?;
    let outcome = diagnosis.map_or(VerdictOutcome::Failed, |d| {
        let mostly = d.grade == VerdictGrade::Mostly
            && groups.iter().flatten().all(|finding| {
                let place = json!(finding.effect.place);
                answer.truth.iter().any(|truth| truth.place == place)
            });
        outcome(d.verdict, mostly, answer, &truths, extra)
    });
    let floor_m = answer.floor_rms_um * 1e-6;
    let [factors_in_intervals, factors_identified] =
        diagnosis.map_or([0, 0], |d| factors_covered(d, answer));
    Ok(Score {
        session: verdict.session.clone(),
        bench: verdict.bench.clone(),
        set,
        mode: answer.mode.clone(),
        expected: answer.expected,
        verdict: diagnosis.map(|d| d.verdict),
        outcome,
        answer_words: answer_words(answer),
        verdict_words: match &verdict.diagnosis {
            Ok(diagnosis) => diagnosis_words(diagnosis),
            Err(error) => format!("no diagnosis: {error}"),
        },
        truths,
        left_by_library: answer.left_by_library,
        held_out_ratio: diagnosis
            .and_then(|d| d.after.held_out_rms_m)
            .map(|rms_m| rms_m / floor_m)
            .filter(|ratio| ratio.is_finite()),
        published_passes: answer.published_validation_passes,
        factors_in_intervals,
        factors_identified,
    })
}

/// Findings that exclude each other, together.
pub(super) fn groups(findings: &[Finding]) -> Vec<Vec<&Finding>> {
    let mut groups: Vec<Vec<&Finding>> = Vec::new();
    for finding in findings {
        let group = groups.iter_mut().find(|group| {
            finding.alternative_group.is_some()
                && group[0].alternative_group == finding.alternative_group
        });
        match group {
            Some(group) => group.push(finding),
            None => groups.push(vec![finding]),
        }
    }
    groups
}

/// What became of each true effect, and whether a group is left that holds none.
fn match_truths(
    groups: &[Vec<&Finding>],
    truths: &[TrueEffect],
    distances: &Distances<'_>,
) -> Result<(Vec<TruthScore>, bool), Failure> {
    let mut free: Vec<&Vec<&Finding>> = groups.iter().collect();
    let scores = truths
        .iter()
        .enumerate()
        .map(|(number, truth)| {
            let own = free
                .iter()
                .position(|group| group.iter().any(|finding| truth.is(&finding.effect)));
            let group = own.map(|place| free.remove(place));
            truth_score(truth, group, &|member| distances(number, member))
        })
        .collect::<Result<_, Failure>>()?;
    Ok((scores, !free.is_empty()))
}

fn truth_score(
    truth: &TrueEffect,
    group: Option<&Vec<&Finding>>,
    distance: &dyn Fn(&Effect) -> Result<f64, Failure>,
) -> Result<TruthScore, Failure> {
    let members = group.map_or(&[][..], Vec::as_slice);
    let own = members.iter().find(|finding| truth.is(&finding.effect));
    let size = own.and_then(|finding| {
        let name = finding.effect.law.parameters.first()?.name;
        Some((finding.values.first()?, truth.value(name)?))
    });
    let near = truth
        .rivals
        .iter()
        .filter(|rival| rival.standard_errors_between < INSEPARABLE)
        .filter(|rival| !members.iter().any(|m| is_rival(rival, truth, &m.effect)));
    let mut padding = Vec::new();
    for member in members.iter().filter(|member| !truth.is(&member.effect)) {
        let between = distance(&member.effect)?;
        if between >= SEPARABLE {
            padding.push(title_apart(&member.effect.title(), between));
        }
    }
    Ok(TruthScore {
        title: truth.title(),
        physics: truth.physics.clone(),
        standard_errors: truth.standard_errors_beside_the_others,
        named: match (own, members.len()) {
            (None, _) => NamedCause::No,
            (Some(_), 1) => NamedCause::Alone,
            (Some(_), count) => NamedCause::InSet(count),
        },
        padding,
        left_out: own
            .map(|_| near.map(rival_title).collect())
            .unwrap_or_default(),
        size_covered: size.and_then(|(found, true_value)| {
            let [low, high] = found.interval_95()?;
            Some((low..=high).contains(&true_value))
        }),
        size_ratio: size
            .map(|(found, true_value)| found.value / true_value)
            .filter(|ratio| ratio.is_finite()),
    })
}

fn title_apart(title: &str, between: f64) -> String {
    format!("{title} ({between:.1} standard errors apart)")
}

fn rival_title(rival: &KnownRival) -> String {
    let title = format!("{} at {}", rival.physics, place_words(&rival.place));
    title_apart(&title, rival.standard_errors_between)
}

/// Whether a listed rival is this effect. Beside a drift, another drift can only be that of the other unit.
fn is_rival(rival: &KnownRival, truth: &TrueEffect, effect: &Effect) -> bool {
    rival.physics == effect.law.name && rival.place == json!(effect.place) && !truth.is(effect)
}

/// Whether a rival must be distinguished from an effect of a length, both in standard errors.
pub(super) fn is_apart(between: f64, length: f64) -> bool {
    between >= APART && between >= APART_SHARE * length
}

/// # Arguments
/// - `mostly`: the grade is *mostly*, and every law named is at the place of a true effect.
fn outcome(
    verdict: Verdict,
    mostly: bool,
    answer: &SealedAnswer,
    truths: &[TruthScore],
    extra: bool,
) -> VerdictOutcome {
    match (answer.expected, verdict) {
        (_, Verdict::InsufficientData) => VerdictOutcome::Undecided,
        (Expected::NothingMissing, Verdict::NothingMissing) => VerdictOutcome::Right,
        (Expected::NothingMissing, _) => VerdictOutcome::FalseAlarm,
        (Expected::Unknown, Verdict::Unknown) => VerdictOutcome::Right,
        (Expected::Unknown, said) => {
            let owed = answer
                .left_by_library
                .is_none_or(|left| left >= UNKNOWN_FROM);
            match (said, owed && !answer.may_be_missed) {
                (Verdict::NothingMissing, true) => VerdictOutcome::NotFound,
                (Verdict::NothingMissing, false) => VerdictOutcome::MayBeMissed,
                (_, true) if mostly => VerdictOutcome::Mostly,
                (_, true) => VerdictOutcome::WrongName,
                (_, false) => VerdictOutcome::PartNamed,
            }
        }
        (_, Verdict::NothingMissing) if answer.may_be_missed => VerdictOutcome::MayBeMissed,
        (_, Verdict::NothingMissing) => VerdictOutcome::NotFound,
        _ => named_outcome(verdict, answer, truths, extra),
    }
}

/// The outcome where effects of the library were to be named and something was found.
fn named_outcome(
    verdict: Verdict,
    answer: &SealedAnswer,
    truths: &[TruthScore],
    extra: bool,
) -> VerdictOutcome {
    let missing = truths.iter().filter(|t| t.named == NamedCause::No).count();
    let unknown = verdict == Verdict::Unknown;
    if missing > 0 {
        return match (unknown, extra) {
            (true, _) => VerdictOutcome::UnknownInstead,
            (false, true) => VerdictOutcome::WrongName,
            (false, false) if answer.may_be_missed => VerdictOutcome::MayBeMissed,
            (false, false) => VerdictOutcome::Partly,
        };
    }
    if unknown {
        VerdictOutcome::StructureClaimed
    } else if extra {
        VerdictOutcome::Extra
    } else if truths.iter().any(|truth| !truth.padding.is_empty()) {
        VerdictOutcome::Padded
    } else if answer.expected == Expected::Ambiguous
        && truths.iter().any(|truth| !truth.left_out.is_empty())
    {
        VerdictOutcome::Incomplete
    } else {
        VerdictOutcome::Right
    }
}

/// Identified factors whose intervals hold the truth, and all identified ones.
fn factors_covered(diagnosis: &Diagnosis, answer: &SealedAnswer) -> [usize; 2] {
    let mut counts = [0, 0];
    // Outside the library no model is right, and no interval promises anything.
    if answer.expected == Expected::Unknown {
        return counts;
    }
    for factor in diagnosis.factors.iter().filter(|factor| factor.identified) {
        let property = factor.name.trim_start_matches("beam.");
        let (Some(truth), Some([low, high])) = (
            answer.beam_factors.get(property),
            factor.after.interval_95(),
        ) else {
            continue;
        };
        counts[1] += 1;
        counts[0] += usize::from((low..=high).contains(&truth.ln()));
    }
    counts
}
