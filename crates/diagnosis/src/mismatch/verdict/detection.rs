//! The smallest effects that readings would have shown.

use stiffbench_beams::physics::{Law, Place};
use stiffbench_numeric::statistics::NORMAL_95;

use super::diagnosis::{DetectionLimit, Finding, Impossible};
use crate::mismatch::candidates::{
    BestShape, CandidateScores, Candidates, LawCriticalValues, ScoredCandidate, ScoredShape,
    SearchResult, best_shapes,
};
use crate::mismatch::error::MismatchError;
use crate::search::constants::POWER_80;

/// For each law and place the size that 80 % of such sessions would show; of slips in one cell that which is hardest to see.
pub(crate) fn detection_limits(
    candidates: Candidates<'_, '_>,
    found: &SearchResult,
    critical: &LawCriticalValues,
) -> Result<Vec<DetectionLimit>, MismatchError> {
    let first = &found.first;
    let of = |seen: &ScoredCandidate| {
        let limit = critical.laws.values.get(&seen.candidate.family()).copied();
        detection_limit(seen, limit.unwrap_or(f64::INFINITY))
    };
    let is_slip = |seen: &&ScoredCandidate| seen.candidate.law.is_of_one_run();
    let (slips, others): (Vec<_>, Vec<_>) = first
        .seen
        .iter()
        .filter(|seen| !seen.candidate.wide)
        .partition(is_slip);
    let mut out: Vec<DetectionLimit> = others.into_iter().map(of).collect();
    let loose = candidates.missing_member_shapes(&found.before, &first.space)?;
    out.extend(
        loose
            .iter()
            .map(|white| of(&ScoredCandidate::of(white, &first.residuals))),
    );
    let observations = candidates.problem.observations;
    for cell in &observations.cells {
        let here = |seen: &&&ScoredCandidate| observations.is_cell_of(&seen.candidate.place, cell);
        out.extend(hardest(slips.iter().filter(here).map(|seen| of(seen))));
    }
    if found.changed() {
        // What was found shows in all laws that resemble it: their estimates without it limit nothing.
        for limit in &mut out {
            limit.upper_95 = None;
        }
    }
    Ok(out)
}

/// That of the largest size, or one that no size reaches.
fn hardest(critical: impl Iterator<Item = DetectionLimit>) -> Option<DetectionLimit> {
    let size = |limit: &DetectionLimit| limit.size_80.unwrap_or(f64::INFINITY);
    critical.max_by(|a, b| size(a).total_cmp(&size(b)))
}

/// Size of a shape for a multiple of it; of a shape without a size the multiple.
fn size_of(shape: &ScoredShape, scale: f64) -> f64 {
    scale * shape.shape.values.first().copied().unwrap_or(1.0)
}

fn detection_limit(seen: &ScoredCandidate, limit: f64) -> DetectionLimit {
    let candidate = &seen.candidate;
    let smallest = seen
        .shapes
        .iter()
        .filter_map(|shape| Some((shape, multiple_80(shape, limit)?)))
        .filter(|(shape, scale)| size_of(shape, *scale) <= candidate.largest(&shape.shape))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let upper = seen
        .shapes
        .iter()
        .map(|shape| {
            let estimate = shape.moments.product / shape.moments.square;
            size_of(
                shape,
                estimate.abs() + NORMAL_95 / shape.moments.square.sqrt(),
            )
        })
        .fold(0.0, f64::max);
    DetectionLimit {
        law: candidate.law,
        place: candidate.place.clone(),
        size_80: smallest.map(|(shape, scale)| size_of(shape, scale)),
        end_effect_m: smallest.map(|(shape, scale)| scale * shape.peak_m),
        upper_95: (upper > 0.0 && !candidate.law.parameters.is_empty()).then_some(upper),
    }
}

/// The multiple of a shape whose fall of the squares passes a limit in 80 % of sessions; `None` if it may not be as large.
///
/// A size that is free gives the fall z², z normal about the length L; one that is what it is, as a member that is off or not, 2 z L - L².
fn multiple_80(shape: &ScoredShape, limit: f64) -> Option<f64> {
    let length = shape.moments.square.sqrt();
    let [lowest, highest] = shape.shape.scale;
    if lowest == highest {
        return (length * length - limit >= 2.0 * POWER_80 * length).then_some(lowest);
    }
    let multiple = (limit.sqrt() + POWER_80) / length;
    (multiple <= highest).then_some(multiple)
}

/// Candidates that would need an impossible value to lower the squares by more than their limit, the largest fall first; none that are found or rivals,
/// for beside what was found a possible value serves.
pub(crate) fn impossible(
    scores: &CandidateScores,
    critical: &LawCriticalValues,
    findings: &[Finding],
) -> Vec<Impossible> {
    let is_named = |law: Law, place: &Place| {
        let rivals = findings.iter().flat_map(|finding| &finding.rivals);
        let effects = findings.iter().map(|finding| &finding.effect);
        let mut effects = effects.chain(rivals.map(|rival| &rival.effect));
        effects.any(|effect| effect.law == law && effect.place == *place)
    };
    let impossible = |(seen, best): (&ScoredCandidate, Option<BestShape>)| {
        let candidate = &seen.candidate;
        let limit = critical.laws.values.get(&(candidate.law, false))?;
        let delta_chi2 = best?.best.forbidden_delta_chi2;
        let is_rejected = !is_named(candidate.law, &candidate.place);
        (is_rejected && delta_chi2 > limit.max(0.0)).then(|| Impossible {
            law: candidate.law,
            place: candidate.place.clone(),
            delta_chi2,
        })
    };
    let all = scores.seen.iter().zip(best_shapes(&scores.seen));
    let mut out: Vec<Impossible> = all.filter_map(impossible).collect();
    out.sort_by(|a, b| b.delta_chi2.total_cmp(&a.delta_chi2));
    out
}
