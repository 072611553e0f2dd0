//! From what a search found to what is to be said.

use stiffbench_beams::physics::Effect;

use super::detection::{detection_limits, impossible};
use super::diagnosis::{Diagnosis, FactorChange, Finding, KnownEffect, Rival};
use super::grade::{GradeBasis, Verdict, VerdictGrade};
use super::stated_values::{EstimatedValue, estimated_values};
use crate::mismatch::baselines::BaselineParameter;
use crate::mismatch::candidates::{
    Candidates, ConfigurationSizes, LawCriticalValues, Ranked, ResolvedEffect, SearchResult, same,
};
use crate::mismatch::error::MismatchError;
use crate::mismatch::hold_out::{HoldOut, Quality};
use crate::mismatch::noise::NoiseBasis;
use crate::mismatch::observed::Observations;
use crate::mismatch::problem::{DiagnosisProblem, Stated, end_effect_m};
use crate::mismatch::screen::{lacking, lacking_cells, lacking_scatter};
use crate::mismatch::unexplained::{Location, Stratum, UnexplainedStructure};
use crate::search::constants::STRONG_EVIDENCE;
use crate::search::constants::UNEXPLAINED_LEVEL;
use crate::search::{distinguishable, dot, largest};

/// Distance from a plausible bound, as a share of it, at which a size stands there (1): fits stop at bounds up to rounding, and a page prints three
/// digits. Stated.
const AT_A_PLAUSIBLE_BOUND: f64 = 1e-3;

/// Squared cosine above which what a richer law adds to the one that it contains is less than a tenth of it (1). Definition.
const SAME_SHAPE: f64 = 0.99;

/// Rivals that are printed (1).
const RIVALS: usize = 8;

/// A factor whose interval spans more than this share of what was allowed beforehand is not identified by the data (1). By hand (750d6b5).
const IDENTIFIED: f64 = 0.5;

/// What a search found, as it is to be said.
pub(crate) fn conclude(
    candidates: Candidates<'_, '_>,
    found: &SearchResult,
    critical: &LawCriticalValues,
) -> Result<Diagnosis, MismatchError> {
    let problem = candidates.problem;
    let mut findings: Vec<Finding> = Vec::new();
    let mut group = 0;
    for (place, resolved) in found.resolved.iter().enumerate() {
        // What explains one part already is not offered again for another.
        let mut members = members(resolved);
        members.retain(|&member| {
            let effect = &resolved.ranked[member].effect;
            findings
                .iter()
                .all(|finding| !same(&finding.effect, effect))
        });
        let alternative = (members.len() > 1).then(|| {
            group += 1;
            group
        });
        for &member in &members {
            findings.push(finding(
                problem,
                found,
                resolved,
                place,
                member,
                &members,
                alternative,
            )?);
        }
    }
    let is_from_fit = found.before.noise.basis == NoiseBasis::Fit;
    let mut lacking = lacking(problem, is_from_fit);
    let (mut verdict, mut grade) = if lacking.is_empty() {
        GradeBasis {
            is_a_set: group > 0,
            ..grade_basis(found)
        }
        .decide()
    } else {
        (Verdict::InsufficientData, VerdictGrade::Undecided)
    };
    if verdict == Verdict::InsufficientData && lacking.is_empty() {
        lacking.push(lacking_scatter(problem.observations));
    }
    if verdict == Verdict::NothingMissing
        && let Some(lack) = lacking_cells(problem)
    {
        lacking.push(lack);
        (verdict, grade) = (Verdict::InsufficientData, VerdictGrade::Undecided);
    }
    for finding in &mut findings {
        let certain = GradeBasis::is_certain(finding.p_family, finding.log_bayes);
        finding.grade = match grade {
            VerdictGrade::Is | VerdictGrade::Mostly if !certain => VerdictGrade::Weak,
            all => all,
        };
        // Of nested laws the simplest that does the same.
        if finding.alternative_group.is_none() {
            finding.effect = finding.effect.simplest();
            finding.values.truncate(finding.effect.values.len());
        }
    }
    let effects = &found.after.fitted.model.effects;
    let factors = problem.baseline.described().len();
    let model = &found.after.fitted.model;
    let of_known =
        (0..problem.known_effects.len()).flat_map(|effect| Stated::of_an_effect(model, effect));
    let stated: Vec<Stated> = (0..factors)
        .map(Stated::Parameter)
        .chain(of_known)
        .collect();
    let stated =
        found.both(|state| estimated_values(problem, state, &state.fitted, &stated, None))?;
    let of_factors = stated.each_ref().map(|all| &all[..factors]);
    let of_known = stated.each_ref().map(|all| &all[factors..]);
    let [before, after] = qualities(problem, found)?;
    let impossible = impossible(&found.first, critical, &findings);
    Ok(Diagnosis {
        verdict,
        grade,
        lacking,
        locations: locations(problem, found, critical),
        findings,
        sizes: ConfigurationSizes::Common,
        beginnings: problem.observations.beginnings.clone(),
        unexplained: location_of(problem.observations, &found.left),
        unexplained_standard_errors: standard_errors_left(problem, found)?,
        omnibus: found.omnibus,
        shares: found.shares.together,
        misfit_steps: found.shares.steps.clone(),
        before,
        after,
        known_effects: known_effects(problem, of_known),
        factors: factor_shifts(problem, of_factors),
        noise: found.after.noise.noise,
        noise_basis: found.after.noise.basis,
        noise_dof: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|share| found.after.noise.degrees_of_freedom(share)),
        further_noise: found.after.noise.further_ci95(),
        detection_limits: detection_limits(candidates, found, critical)?,
        impossible,
        parameters: found.after.fitted.model.parameters.clone(),
        effects: effects.iter().map(Effect::simplest).collect(),
    })
}

/// Length of the largest pattern that is left, in standard errors: those of drawn and rounded readings where the gauge is coarse.
fn standard_errors_left(
    problem: &DiagnosisProblem<'_>,
    found: &SearchResult,
) -> Result<f64, MismatchError> {
    let state = &found.after;
    let length = found.left.delta_chi2.max(0.0).sqrt();
    let (Some(rounded), Some(pattern)) = (problem.rounded(state)?, &found.left.pattern) else {
        return Ok(length);
    };
    let (space, _) = problem.space(state)?;
    let of_noise = rounded.standard_error(|white| {
        let mut left = white.to_vec();
        left.resize(space.length, 0.0);
        space.project(&mut left);
        pattern.delta_chi2(&left) / pattern.units.len() as f64
    });
    Ok(length / of_noise)
}

fn finding(
    problem: &DiagnosisProblem<'_>,
    found: &SearchResult,
    resolved: &ResolvedEffect,
    place: usize,
    member: usize,
    members: &[usize],
    alternative_group: Option<u32>,
) -> Result<Finding, MismatchError> {
    let ranked = &as_it_acts(problem, found, place, &resolved.ranked[member])?;
    let model = &ranked.fitted.model;
    let last = model.effects.len() - 1;
    let stated: Vec<Stated> = Stated::of_an_effect(model, last).collect();
    let dof = Some(ranked.evidence.dof);
    let mut values = estimated_values(problem, &found.after, &ranked.fitted, &stated, dof)?;
    let has_combination = ranked.effect.law.combination.is_some();
    let combination = has_combination.then(|| values.pop()).flatten();
    let linearised = problem
        .predictor()
        .linearised(&model.parameters, &model.effects)?;
    let square = dot(&ranked.white, &ranked.white);
    let cosine = |other: &Ranked| {
        dot(&ranked.white, &other.white)
            / (square.sqrt() * dot(&other.white, &other.white).sqrt()).max(f64::MIN_POSITIVE)
    };
    let rivals = resolved
        .ranked
        .iter()
        .enumerate()
        .filter(|(other, rival)| {
            !members.contains(other)
                && !same(&rival.effect, &ranked.effect)
                && rival.evidence.log_bayes() > 0.0
        })
        .take(RIVALS)
        .map(|(_, rival)| Rival {
            effect: rival.effect.clone(),
            log_bayes_to_winner: ranked.evidence.log_bayes() - rival.evidence.log_bayes(),
            cosine: cosine(rival),
        })
        .collect();
    let end_effect = if ranked.effect.law.changes_structure() {
        largest(&problem.effect_m(model, last)?)
    } else {
        end_effect_m(&linearised, problem.observations, &model.effects)
    };
    debug_assert!(place < found.after.fitted.model.effects.len());
    Ok(Finding {
        effect: ranked.effect.clone(),
        grade: VerdictGrade::Undecided,
        shares: found.shares.each.get(place).copied().unwrap_or_default(),
        at_bound: is_at_bound(problem, &ranked.effect),
        spans_range: spans_range(problem, &ranked.effect, values.first()),
        values,
        combination,
        alternative_group,
        end_effect_m: end_effect,
        absorbed_share: 1.0 - square / ranked.whole.max(f64::MIN_POSITIVE),
        log_bayes: ranked.log_bayes(),
        standard_errors: square.sqrt(),
        p_family: resolved.family_p,
        rivals,
    })
}

/// Whether the interval of the size of an effect reaches both ends of what is plausible.
fn spans_range(
    problem: &DiagnosisProblem<'_>,
    effect: &Effect,
    size: Option<&EstimatedValue>,
) -> bool {
    let bounds = problem.scales().bounds(effect);
    let interval = size.and_then(EstimatedValue::interval_95);
    interval
        .zip(bounds.first())
        .is_some_and(|([low, high], [least, most])| low <= *least && high >= *most)
}

/// A candidate with its values in the final model, if it acts there beside others: in a fit of its own it may have changed places with one of
/// them.
fn as_it_acts(
    problem: &DiagnosisProblem<'_>,
    found: &SearchResult,
    place: usize,
    ranked: &Ranked,
) -> Result<Ranked, MismatchError> {
    let mut own = ranked.clone();
    let place = problem.known_effects.len() + place;
    let effect = &found.after.fitted.model.effects[place];
    if found.resolved.len() > 1 && same(effect, &ranked.effect) {
        own.effect = effect.clone();
        own.fitted = found.after.fitted.clone();
        let model = &mut own.fitted.model;
        model.effects[place..].rotate_left(1);
        let last = model.effects.len() - 1;
        let mut rest = found.after.clone();
        rest.fitted.model.effects.remove(place);
        let (space, _) = problem.space(&rest)?;
        (own.white, own.whole) = problem.effect_vector(model, last, &space)?;
    }
    Ok(own)
}

/// Whether the size of an effect stands at a plausible bound that is not zero.
fn is_at_bound(problem: &DiagnosisProblem<'_>, effect: &Effect) -> bool {
    let bounds = problem.scales().bounds(effect);
    let size = effect.values.first().zip(bounds.first());
    size.is_some_and(|(size, bounds)| {
        let near = |bound: &f64| (size - bound).abs() < AT_A_PLAUSIBLE_BOUND * bound.abs();
        bounds.iter().any(near)
    })
}

/// The parameters of the baseline without and with what was found.
fn factor_shifts(
    problem: &DiagnosisProblem<'_>,
    [before, after]: [&[EstimatedValue]; 2],
) -> Vec<FactorChange> {
    let described = problem.baseline.described().iter();
    let values = before.iter().zip(after);
    let change =
        |(parameter, (before, after)): (&BaselineParameter, (&EstimatedValue, &EstimatedValue))| {
            let at_bound = parameter.is_near_bound(after.value);
            let is_sharp = after.u.is_some_and(|u| u < IDENTIFIED * parameter.prior_sd);
            FactorChange {
                name: parameter.name.clone(),
                spring_rad_per_nm: parameter.spring_rad_per_nm,
                before: *before,
                identified: !at_bound && is_sharp,
                after: *after,
            }
        };
    described.zip(values).map(change).collect()
}

/// Patterns of the baseline's residuals that noise does not explain, the largest of each stratum.
fn locations(
    problem: &DiagnosisProblem<'_>,
    found: &SearchResult,
    critical: &LawCriticalValues,
) -> Vec<Location> {
    let mut out: Vec<Location> = found
        .first_patterns
        .iter()
        .map(|(delta_chi2, pattern)| UnexplainedStructure {
            p: critical.unexplained.p(*delta_chi2),
            delta_chi2: *delta_chi2,
            pattern: Some(pattern.clone()),
        })
        .filter(|left| left.p <= UNEXPLAINED_LEVEL)
        .map(|left| location_of(problem.observations, &left))
        .collect();
    out.sort_by(|a, b| a.p_family.total_cmp(&b.p_family));
    out
}

fn location_of(observations: &Observations, left: &UnexplainedStructure) -> Location {
    let pattern = left.pattern.as_ref();
    Location {
        stratum: pattern.map_or(Stratum::Rest, |p| p.stratum),
        pose: pattern
            .and_then(|p| p.group.pose)
            .map(|pose| observations.poses[pose].clone()),
        direction: pattern.and_then(|p| p.group.direction),
        period_s: pattern.and_then(|p| p.period_s),
        p_family: left.p,
        p_at_floor: false,
        size_m: pattern.map_or(0.0, |p| p.size_m * left.delta_chi2.sqrt()),
    }
}

/// What became of the physics that was known beforehand.
///
/// # Arguments
/// - What is stated of it without and with what was found, one effect after the other.
pub(crate) fn known_effects(
    problem: &DiagnosisProblem<'_>,
    [mut before, mut after]: [&[EstimatedValue]; 2],
) -> Vec<KnownEffect> {
    let known = problem.known_effects.iter();
    let effect = |given: &Effect| {
        let mut own = |count: usize| {
            [&mut before, &mut after].map(|all| {
                let own;
                (own, *all) = all.split_at(count);
                own.to_vec()
            })
        };
        let [before, after] = own(given.values.len());
        let [made_before, made_after] = own(usize::from(given.law.combination.is_some()));
        KnownEffect {
            given: given.clone(),
            before,
            after,
            combination: made_before
                .first()
                .copied()
                .zip(made_after.first().copied())
                .map(<[_; 2]>::from),
        }
    };
    known.map(effect).collect()
}

/// How well the model serves before and after what was found, both as multiples of the noise that is left after it.
fn qualities(
    problem: &DiagnosisProblem<'_>,
    found: &SearchResult,
) -> Result<[Quality; 2], MismatchError> {
    let noise = if found.changed() {
        &found.after
    } else {
        &found.before
    };
    found.both(|state| HoldOut::new(problem, state).in_noise_of(noise).quality())
}

/// Places in the ranking of the first and of those that cannot be distinguished from the likeliest.
fn members(resolved: &ResolvedEffect) -> Vec<usize> {
    // The first may be a simpler law than the likeliest. Of equal ones the first.
    let likeliest = resolved.ranked.iter().rev();
    let Some(winner) =
        likeliest.max_by(|a, b| a.evidence.log_bayes().total_cmp(&b.evidence.log_bayes()))
    else {
        return Vec::new();
    };
    let mut out: Vec<usize> = Vec::new();
    let mut seen: Vec<(&'static str, &stiffbench_beams::physics::Place)> = Vec::new();
    for (place, ranked) in resolved.ranked.iter().enumerate() {
        let behind = winner.evidence.log_bayes() - ranked.evidence.log_bayes();
        let squared_cosine = dot(&winner.white, &ranked.white).powi(2)
            / (dot(&winner.white, &winner.white) * dot(&ranked.white, &ranked.white))
                .max(f64::MIN_POSITIVE);
        let name = (ranked.effect.law.name, &ranked.effect.place);
        if (place == 0 || !distinguishable(behind, squared_cosine)) && !seen.contains(&name) {
            seen.push(name);
            out.push(place);
        }
    }
    // Of nested laws at one place the simpler, unless the data lean to a richer one that does something else.
    let is_needless = |richer: &Ranked| {
        out.iter().any(|&place| {
            let simpler = &resolved.ranked[place];
            let product = dot(&richer.white, &simpler.white).powi(2);
            let squares = dot(&richer.white, &richer.white) * dot(&simpler.white, &simpler.white);
            let room = if product > SAME_SHAPE * squares {
                STRONG_EVIDENCE
            } else {
                0.0
            };
            richer.effect.law.contains(simpler.effect.law)
                && richer.effect.place == simpler.effect.place
                && richer.evidence.log_bayes() <= simpler.evidence.log_bayes() + room
        })
    };
    let kept = out.iter().copied();
    kept.filter(|&place| !is_needless(&resolved.ranked[place]))
        .collect()
}

/// What the verdict rests on.
fn grade_basis(found: &SearchResult) -> GradeBasis {
    let best = found.resolved.iter().min_by(|a, b| {
        let log_bayes = |one: &ResolvedEffect| one.ranked[0].log_bayes();
        let by_evidence = || log_bayes(b).total_cmp(&log_bayes(a));
        a.family_p.total_cmp(&b.family_p).then_with(by_evidence)
    });
    GradeBasis {
        scatter_from_fit: found.before.noise.basis == NoiseBasis::Fit,
        p_family: best.map_or(1.0, |best| best.family_p),
        log_bayes: best.map_or(0.0, |best| best.ranked[0].log_bayes()),
        is_a_set: false,
        is_left: found.is_left(),
        share_of_misfit: found.shares.together.share_of_misfit,
        share_unseen: found.shares.together.share_unseen,
    }
}
