//! From what a search found to what is to be said.

use rayon::prelude::*;

use stiffbench_beams::physics::{Effect, TestObject, values_of};
use stiffbench_numeric::least_squares::ProfileEnd;
use stiffbench_numeric::statistics::student_t_quantile;
use stiffbench_units_and_text::count::counted;

use super::baseline::{is_near, prior_sd};
use super::changes::end_effect_m;
use super::configurations::ConfigurationSizes;
use super::critical_values::LawCriticalValues;
use super::diagnosis::{
    Diagnosis, EstimatedValue, FactorChange, Finding, FollowedInterval, Location, Rival, Verdict,
};
use super::error::MismatchError;
use super::estimated_noise::NoiseBasis;
use super::grade::{GradeBasis, VerdictGrade};
use super::problem::DiagnosisProblem;
use super::ranked_candidate::{Ranked, same};
use super::refit::{Followed, MadeOfValues};
use super::search::{ResolvedEffect, SearchResult, UnexplainedStructure};
use super::state::State;
use super::stratum::Stratum;
use crate::search::constants::{
    AT_A_PLAUSIBLE_BOUND, ENOUGH_OF_A_LINE, FEWEST_LEFT, FEWEST_POSES, IDENTIFIED, RIVALS,
    UNEXPLAINED_LEVEL,
};
use crate::search::{Information, distinguishable, dot, largest};

impl DiagnosisProblem<'_> {
    /// What a search found, as it is to be said.
    pub(super) fn conclude(
        &self,
        found: &SearchResult,
        critical: &LawCriticalValues,
    ) -> Result<Diagnosis, MismatchError> {
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
                findings.push(self.finding(
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
        let mut lacking = self.lacking(is_from_fit);
        let (mut verdict, mut grade) = if lacking.is_empty() {
            GradeBasis {
                is_a_set: group > 0,
                ..found.grade_basis()
            }
            .decide()
        } else {
            (Verdict::InsufficientData, VerdictGrade::Undecided)
        };
        if verdict == Verdict::InsufficientData && lacking.is_empty() {
            lacking.push("no load sequence was repeated: the scatter is known from the fit alone, which may hide missing physics; take at least three repeats".to_owned());
        }
        if verdict == Verdict::NothingMissing
            && let Some(lack) = self.lacking_cells()
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
        let [before, after] = found.both(|state| self.quality(state))?;
        Ok(Diagnosis {
            verdict,
            grade,
            lacking,
            locations: self.locations(found, critical),
            findings,
            sizes: ConfigurationSizes::Common,
            unexplained: self.location_of(&found.left),
            unexplained_standard_errors: self.standard_errors_left(found)?,
            omnibus: found.omnibus,
            shares: found.shares.together,
            misfit_steps: found.shares.steps.clone(),
            before,
            after,
            known_effects: self.known_effects(found)?,
            factors: self.factor_shifts(found)?,
            noise: found.after.noise.noise,
            noise_basis: found.after.noise.basis,
            noise_dof: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .map(|share| found.after.noise.degrees_of_freedom(share)),
            further_noise: found.after.noise.further_ci95(),
            detection_limits: self.detection_limits(found, critical)?,
            impossible: found.first.impossible(critical),
            parameters: found.after.fitted.model.parameters.clone(),
            effects: effects.iter().map(Effect::simplest).collect(),
        })
    }

    /// Length of the largest pattern that is left, in standard errors: those of drawn and rounded readings where the gauge is coarse.
    fn standard_errors_left(&self, found: &SearchResult) -> Result<f64, MismatchError> {
        let state = &found.after;
        let length = found.left.delta_chi2.max(0.0).sqrt();
        let (Some(rounded), Some(pattern)) = (self.rounded(state)?, &found.left.pattern) else {
            return Ok(length);
        };
        let (space, _) = self.space(state)?;
        let of_noise = rounded.standard_error(|white| {
            let mut left = white.to_vec();
            left.resize(space.length, 0.0);
            space.project(&mut left);
            pattern.delta_chi2(&left) / pattern.units.len() as f64
        });
        Ok(length / of_noise)
    }

    /// What must be there before anything can be decided.
    ///
    /// # Arguments
    /// - `is_from_fit`: whether the noise is what the fit leaves.
    pub(super) fn lacking(&self, is_from_fit: bool) -> Vec<String> {
        let mut lacking = Vec::new();
        let observations = self.observations;
        // Own weight loads what a tracker sees.
        let is_loaded = observations.tracker.is_some()
            || observations.loads.iter().any(|load| load.force_n != 0.0);
        // A line through many readings shows its own scatter.
        let is_line = observations.free_zeros;
        if !is_loaded && !is_line {
            lacking.push("no reading is under load".to_owned());
        }
        let several = observations.has_repeats();
        let is_long = is_line && observations.len() >= ENOUGH_OF_A_LINE;
        let (readings, parameters) = (observations.len(), self.baseline.parameters().len());
        if observations.bench == TestObject::Robot {
            let dof = readings.saturating_sub(parameters);
            if is_from_fit && dof < FEWEST_LEFT {
                lacking.push(format!(
                    "the free parameters leave {}, and {FEWEST_LEFT} are needed: read more components or poses",
                    counted(dof, "degree of freedom")
                ));
            }
            let poses = observations.poses.len();
            if is_from_fit && poses < FEWEST_POSES {
                lacking.push(format!(
                    "no load sequence was repeated: then at least {FEWEST_POSES} poses are needed, and the data have {poses}; or take three repeats"
                ));
            }
        } else if !several && !is_long {
            let or = if is_line {
                format!(", or {ENOUGH_OF_A_LINE} readings along the line")
            } else {
                String::new()
            };
            lacking.push(format!(
                "no load sequence was repeated: the scatter and missing physics cannot be distinguished; at least three repeats are needed{or}"
            ));
        }
        if observations.displacement_was_set() {
            lacking.push("a force that was set: the displacement is a straight line of time in every branch, so it was set and the force answers: diagnose with --response force".to_owned());
        }
        if readings < 3 * parameters + 6 {
            lacking.push(format!(
                "{readings} readings are too few for {parameters} factors"
            ));
        }
        lacking
    }

    /// Why a single cell cannot show that nothing is missing: the free factors fit any stiffness of it.
    fn lacking_cells(&self) -> Option<String> {
        let factors = self.baseline.parameters().len();
        let observations = self.observations;
        let absorbed = !observations.free_zeros && observations.cells.len() == 1 && factors > 0;
        absorbed.then(|| {
            format!(
                "1 cell for {}: they fit any stiffness, so no compliance can show; measure other directions and poses, or fix the factors with --fix",
                counted(factors, "free factor")
            )
        })
    }

    fn finding(
        &self,
        found: &SearchResult,
        resolved: &ResolvedEffect,
        place: usize,
        member: usize,
        members: &[usize],
        alternative_group: Option<u32>,
    ) -> Result<Finding, MismatchError> {
        let ranked = &self.as_it_acts(found, place, &resolved.ranked[member])?;
        let model = &ranked.fitted.model;
        let last = model.effects.len() - 1;
        let (values, combination) = self.values(&found.after, ranked)?;
        let linearised = self
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
            largest(&self.effect_m(&mut self.predictor(), model, last)?)
        } else {
            end_effect_m(&linearised, self.observations, &model.effects)
        };
        debug_assert!(place < found.after.fitted.model.effects.len());
        Ok(Finding {
            effect: ranked.effect.clone(),
            grade: VerdictGrade::Undecided,
            shares: found.shares.each.get(place).copied().unwrap_or_default(),
            at_bound: self.is_at_bound(&ranked.effect),
            spans_range: self.spans_range(&ranked.effect, values.first()),
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
    fn spans_range(&self, effect: &Effect, size: Option<&EstimatedValue>) -> bool {
        let bounds = self.scales().bounds(effect);
        let interval = size.and_then(EstimatedValue::interval_95);
        interval
            .zip(bounds.first())
            .is_some_and(|([low, high], [least, most])| low <= *least && high >= *most)
    }

    /// A candidate with its values in the final model, if it acts there beside others: in a fit of its own it may have changed places with one of
    /// them.
    fn as_it_acts(
        &self,
        found: &SearchResult,
        place: usize,
        ranked: &Ranked,
    ) -> Result<Ranked, MismatchError> {
        let mut own = ranked.clone();
        let place = self.known_effects.len() + place;
        let effect = &found.after.fitted.model.effects[place];
        if found.resolved.len() > 1 && same(effect, &ranked.effect) {
            own.effect = effect.clone();
            own.fitted = found.after.fitted.clone();
            let model = &mut own.fitted.model;
            model.effects[place..].rotate_left(1);
            let last = model.effects.len() - 1;
            let mut rest = found.after.clone();
            rest.fitted.model.effects.remove(place);
            let (space, _) = self.space(&rest)?;
            (own.white, own.whole) =
                self.effect_vector(&mut self.predictor(), model, last, &space)?;
        }
        Ok(own)
    }

    /// Whether the size of an effect stands at a plausible bound that is not zero.
    fn is_at_bound(&self, effect: &Effect) -> bool {
        let bounds = self.scales().bounds(effect);
        let size = effect.values.first().zip(bounds.first());
        size.is_some_and(|(size, bounds)| {
            let near = |bound: &f64| (size - bound).abs() < AT_A_PLAUSIBLE_BOUND * bound.abs();
            bounds.iter().any(near)
        })
    }

    /// Values of the last effect of a ranked model, with standard uncertainties from its linearisation and likelihood intervals; and the number made
    /// of them that its law declares.
    fn values(
        &self,
        state: &State,
        ranked: &Ranked,
    ) -> Result<(Vec<EstimatedValue>, Option<EstimatedValue>), MismatchError> {
        let (model, law) = (&ranked.fitted.model, ranked.effect.law);
        let covariance = self.covariance(state, model)?;
        let independent = self.independent_values(state, &mut self.predictor(), model)?;
        // What is left goes on from reading to reading: it moves the values as independent errors of that size would.
        let wider =
            independent.map_or(1.0, |count| (ranked.fitted.squares / count).max(1.0).sqrt());
        let dof = independent.unwrap_or(ranked.evidence.dof).max(2.0);
        let own = ranked.effect.values.len();
        let of_last = covariance[covariance.len() - own..].iter();
        let linear = ranked
            .effect
            .values
            .iter()
            .zip(of_last)
            .map(|(value, (u, _))| {
                EstimatedValue::of_covariance(*value, (u.map(|u| u * wider), dof))
            });
        let scales = self.scales();
        let scale = scales.at(&ranked.effect.place);
        let combination = law.combination.map(|combination| {
            move |effect: &Effect| (combination.of)(&values_of(&effect.values), scale)
        });
        let made = combination
            .iter()
            .map(|of| EstimatedValue::of_covariance(of(&ranked.effect), (None, dof)));
        let mut values: Vec<EstimatedValue> = linear.chain(made).collect();
        if let Some(t) = student_t_quantile(0.975, dof) {
            let (refit, rise) = (self.refit(&state.whitening), (t * wider).powi(2));
            let stated = |place: usize, effect: &Effect| match &combination {
                Some(of) if place == own => of(effect),
                _ => effect.values[place],
            };
            let profile = |place: usize| {
                let made = |effect: &Effect| stated(place, effect);
                let made = |value: usize| Followed::Made(MadeOfValues { of: &made, value });
                let followed = match law.parameters.get(place) {
                    Some(spec) if !spec.is_ratio() => Followed::Value(place),
                    // A ratio is moved with the first value, and is not what is stated.
                    Some(_) => made(place),
                    None => made(0),
                };
                refit.profile_of_last(&mut self.predictor(), model, followed, rise)
            };
            let profiles: Vec<_> = (0..values.len()).into_par_iter().map(profile).collect();
            let inside: Vec<&Effect> = profiles.iter().flatten().flat_map(|(_, all)| all).collect();
            for (place, (value, found)) in values.iter_mut().zip(&profiles).enumerate() {
                let inside = inside.iter().map(|effect| stated(place, effect));
                let ends = found.as_ref();
                value.followed = ends.and_then(|(ends, _)| followed(value, ends, inside));
            }
        }
        let made = combination.and_then(|_| values.pop());
        Ok((values, made))
    }

    /// Standard uncertainty of every parameter of a model, and its degrees of freedom; no uncertainty where the readings do not change with it.
    pub(super) fn covariance(
        &self,
        state: &State,
        model: &super::refit::Model,
    ) -> Result<Vec<(Option<f64>, f64)>, MismatchError> {
        let mut predictor = self.predictor();
        let mut columns = self.columns(&mut predictor, model)?;
        for column in &mut columns {
            state.whitening.covariance.whiten(column);
        }
        let prior_sd = prior_sd(self.baseline);
        let known = Information::of_prior(&prior_sd, columns.len() - prior_sd.len());
        let known = known.with(&Information::of_columns(&columns));
        let lengths = known.lengths();
        let used: Vec<usize> = (0..columns.len()).filter(|&i| lengths[i] > 0.0).collect();
        // Columns of unit length: factors and compliances differ by many orders of magnitude.
        let units: Vec<f64> = used.iter().map(|&i| lengths[i].recip()).collect();
        let inverse = known.of_some(&used, &units).inverse();
        let mut out = vec![(None, f64::INFINITY); columns.len()];
        let mut scratch = Vec::new();
        for (place, &column) in used.iter().enumerate() {
            // The estimate is the sum of the white readings with these weights.
            let mut weights = vec![0.0; self.observations.len()];
            for (other, &from) in used.iter().enumerate() {
                let factor = inverse[(place, other)] * units[other];
                for (weight, value) in weights.iter_mut().zip(&columns[from]) {
                    *weight += factor * value;
                }
            }
            let shares = state
                .whitening
                .variance_shares(self.observations, &weights, &mut scratch);
            out[column] = (
                Some(inverse[(place, place)].sqrt() * units[place]),
                state.noise.degrees_of_freedom(shares),
            );
        }
        Ok(out)
    }

    fn factor_shifts(&self, found: &SearchResult) -> Result<Vec<FactorChange>, MismatchError> {
        let [before, after] = found.both(|state| self.covariance(state, &state.fitted.model))?;
        Ok(self
            .baseline
            .described()
            .iter()
            .enumerate()
            .map(|(index, parameter)| {
                let value = |state: &State, covariance: &[(Option<f64>, f64)]| {
                    let value = state.fitted.model.parameters[index];
                    EstimatedValue::of_covariance(value, covariance[index])
                };
                let after_value = value(&found.after, &after);
                let at_bound = is_near(after_value.value, [parameter.lower, parameter.upper]);
                FactorChange {
                    name: parameter.name.clone(),
                    spring_rad_per_nm: parameter.spring_rad_per_nm,
                    before: value(&found.before, &before),
                    identified: !at_bound
                        && after_value
                            .u
                            .is_some_and(|u| u < IDENTIFIED * parameter.prior_sd),
                    after: after_value,
                }
            })
            .collect())
    }

    /// Patterns of the baseline's residuals that noise does not explain, the largest of each stratum.
    fn locations(&self, found: &SearchResult, critical: &LawCriticalValues) -> Vec<Location> {
        let mut out: Vec<Location> = found
            .first_patterns
            .iter()
            .map(|(delta_chi2, pattern)| UnexplainedStructure {
                p: critical.unexplained.p(*delta_chi2),
                delta_chi2: *delta_chi2,
                pattern: Some(pattern.clone()),
            })
            .filter(|left| left.p <= UNEXPLAINED_LEVEL)
            .map(|left| self.location_of(&left))
            .collect();
        out.sort_by(|a, b| a.p_family.total_cmp(&b.p_family));
        out
    }

    fn location_of(&self, left: &UnexplainedStructure) -> Location {
        let pattern = left.pattern.as_ref();
        Location {
            stratum: pattern.map_or(Stratum::Rest, |p| p.stratum),
            pose: pattern
                .and_then(|p| p.group.pose)
                .map(|pose| self.observations.poses[pose].clone()),
            direction: pattern.and_then(|p| p.group.direction),
            period_s: pattern.and_then(|p| p.period_s),
            p_family: left.p,
            p_at_floor: false,
            size_m: pattern.map_or(0.0, |p| p.size_m * left.delta_chi2.sqrt()),
        }
    }
}

/// The likelihood interval of a value; `None` without an end.
///
/// # Arguments
/// - `inside`: where the profiles of it and of the other values were inside: past a kink another's may find a way that its own does not.
fn followed(
    value: &EstimatedValue,
    ends: &[ProfileEnd; 2],
    inside: impl Iterator<Item = f64> + Clone,
) -> Option<FollowedInterval> {
    let linear = value.interval_95();
    let found = |end: usize| match ends[end] {
        ProfileEnd::Closed { value } | ProfileEnd::OpenAtBound { value, .. } => Some(value),
        // Where a profile could not be followed to its end the interval is as wide as its linearisation at least.
        ProfileEnd::Open { value, .. } | ProfileEnd::NotFollowed { value, .. } => {
            let linear = linear?[end];
            Some([value.min(linear), value.max(linear)][end])
        }
    };
    // Values that move readings by kinks were searched for, and may stand beside the lowest point.
    let inside = inside.chain([value.value]);
    Some(FollowedInterval {
        ends: [
            inside.clone().fold(found(0)?, f64::min),
            inside.fold(found(1)?, f64::max),
        ],
        is_open: [0, 1].map(|end| matches!(ends[end], ProfileEnd::OpenAtBound { .. })),
    })
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
    // Of nested laws at one place the simpler, unless the data lean to the richer.
    let is_needless = |richer: &Ranked| {
        out.iter().any(|&place| {
            let simpler = &resolved.ranked[place];
            richer.effect.law.contains(simpler.effect.law)
                && richer.effect.place == simpler.effect.place
                && richer.evidence.log_bayes() <= simpler.evidence.log_bayes()
        })
    };
    let kept = out.iter().copied();
    kept.filter(|&place| !is_needless(&resolved.ranked[place]))
        .collect()
}
