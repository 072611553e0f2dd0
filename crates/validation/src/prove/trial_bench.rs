//! Benches with a known answer, made by the tool's own simulator on the plan of a real session.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stiffbench::analysis::Failure;

use stiffbench_beams::physics::{Effect, Place};
use stiffbench_diagnosis::mismatch::{
    Baseline, Diagnosis, EarlierNoise, KnownNoise, LawCriticalValues, Observations, ReadingNoise,
    RobotBaseline, SearchOptions, TrialNoise, Truth, Verdict, diagnose, simulate, standard_errors,
    standard_errors_between, white_laws,
};
use stiffbench_units_and_text::test_point::{DirectionName, PoseId};

use super::ideal::IdealSearch;
use super::score::{groups, is_apart};
use super::session::ValidationSession;
use super::share::Share;

/// How far the beam factors and springs of a trial lie from their start, as the factors of the concealed sessions.
const FACTORS: [f64; 2] = [0.55, 1.8];

/// A gauge with this step or more is coarse, m.
const COARSE_STEP_M: f64 = 1e-5;

/// Range of the noise of a trial: reading and zero, µm; slope of a run, 1. As in the concealed sessions.
const READING_UM: [f64; 2] = [0.9, 2.2];
const ZERO_UM: [f64; 2] = [1.2, 3.0];
const SLOPE: [f64; 2] = [0.0012, 0.003];

/// What is special about the noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NoiseKind {
    /// Normal errors, gauges of 1 µm and 0.1 N.
    Normal,
    /// Errors with a skewness of 1.4.
    Skewed,
    /// A gauge of 10 µm, normal errors of 6 µm.
    Coarse,
    /// A gauge of 10 µm, errors of a micrometre or two: the steps are all that scatters.
    CoarseQuiet,
}

/// A plan with its noise, and the limits that belong to them.
pub(super) struct TrialBench<'a> {
    /// Robot, mechanism and plan.
    pub(super) session: &'a ValidationSession,
    /// The beam model.
    pub(super) baseline: RobotBaseline<'a>,
    /// The plan: the session's loads, the gauge steps of the trials.
    pub(super) plan: Observations,
    /// The noise of the trials.
    pub(super) noise: TrialNoise,
    /// CriticalValues, from the first trial.
    pub(super) critical: LawCriticalValues,
    /// The first trial's truth, without an effect, and its diagnosis.
    pub(super) first: (Truth, Diagnosis),
    /// The readings of the first trial.
    readings: Observations,
    options: SearchOptions,
    /// Sessions of the same bench before each trial, which tell the noise too.
    earlier: usize,
}

impl<'a> TrialBench<'a> {
    /// A plan with noise drawn by a seed, its limits computed on a first trial with nothing missing.
    ///
    /// # Arguments
    /// - `earlier`: sessions of the same bench before each trial.
    ///
    /// # Errors
    /// [`ProveError`].
    pub(super) fn new(
        session: &'a ValidationSession,
        kind: NoiseKind,
        options: &SearchOptions,
        earlier: usize,
        seed: u64,
    ) -> Result<Self, Failure> {
        let baseline = session.baseline()?;
        let noise = noise(kind, seed);
        let mut plan = session.observations.clone();
        plan.steps.displacement_m = Some(noise.displacement_step_m);
        plan.steps.force_n = Some(noise.force_step_n);
        let truth = Truth {
            parameters: drawn_parameters(&baseline, seed),
            effects: Vec::new(),
            noise,
        };
        let readings = simulate(&baseline, &plan, &truth, seed)?;
        let (diagnosis, critical) = diagnose(&baseline, &readings, options, None)?;
        let mut bench = Self {
            session,
            baseline,
            plan,
            noise,
            critical,
            first: (truth, diagnosis),
            readings,
            options: options.clone(),
            earlier,
        };
        if earlier > 0 {
            let known = bench.earlier(&bench.first.0, seed)?;
            bench.first.1 = bench.diagnose(&bench.first.0, &known, seed)?;
        }
        Ok(bench)
    }

    /// What is searched on this bench, for an observer with known noise.
    ///
    /// # Errors
    /// If it cannot be computed.
    pub(super) fn ideal(&self) -> Result<IdealSearch, Failure> {
        let laws = white_laws(
            &self.baseline,
            &self.readings,
            &self.options,
            &self.critical,
        );
        Ok(IdealSearch::new(laws?))
    }

    /// A truth without effects, its factors drawn by a seed.
    pub(super) fn truth(&self, seed: u64) -> Truth {
        Truth {
            parameters: drawn_parameters(&self.baseline, seed),
            effects: Vec::new(),
            noise: self.noise,
        }
    }

    /// How earlier sessions of the same bench scattered: of the same truth but for slips, which happen once.
    ///
    /// # Errors
    /// If it cannot be computed.
    pub(super) fn earlier(&self, truth: &Truth, seed: u64) -> Result<Vec<EarlierNoise>, Failure> {
        let mut lasting = truth.clone();
        lasting.effects.retain(|effect| !effect.law.is_of_one_run());
        let scatter = |number: usize| {
            let own = seed_of(&[seed, 3, number as u64]);
            let readings = simulate(&self.baseline, &self.plan, &lasting, own)?;
            let diagnosis = self.search(&readings, KnownNoise::Nothing)?;
            Ok(EarlierNoise::of(&diagnosis))
        };
        let told: Result<Vec<_>, Failure> = (0..self.earlier).map(scatter).collect();
        Ok(told?.into_iter().flatten().collect())
    }

    /// Makes the readings of a truth and diagnoses them.
    ///
    /// # Arguments
    /// - `earlier`: how earlier sessions scattered; as in a user's hands only those count that scatter as this one.
    ///
    /// # Errors
    /// If it cannot be computed.
    pub(super) fn diagnose(
        &self,
        truth: &Truth,
        earlier: &[EarlierNoise],
        seed: u64,
    ) -> Result<Diagnosis, Failure> {
        let readings = simulate(&self.baseline, &self.plan, truth, seed)?;
        let alone = self.search(&readings, KnownNoise::Nothing)?;
        if earlier.is_empty() {
            return Ok(alone);
        }
        let own = EarlierNoise::of(&alone);
        let like = |one: &&EarlierNoise| own.is_none_or(|own| one.is_like(&own));
        let used: Vec<EarlierNoise> = earlier.iter().filter(like).copied().collect();
        match EarlierNoise::pooled(&used) {
            Some(pooled) => self.search(&readings, KnownNoise::Earlier(pooled)),
            None => Ok(alone),
        }
    }

    /// Diagnoses readings.
    fn search(&self, readings: &Observations, noise: KnownNoise) -> Result<Diagnosis, Failure> {
        // Where a coarse gauge stands, its rounding depends on: limits are those of the readings, not of the plan.
        let known = (self.noise.displacement_step_m < COARSE_STEP_M).then_some(&self.critical);
        let options = SearchOptions {
            noise,
            ..self.options.clone()
        };
        let (diagnosis, _) = diagnose(&self.baseline, readings, &options, known)?;
        Ok(diagnosis)
    }

    /// Holds a diagnosis against the truth.
    ///
    /// # Errors
    /// If it cannot be computed.
    pub(super) fn assess(&self, truth: &Truth, diagnosis: &Diagnosis) -> Result<Judged, Failure> {
        let groups = groups(&diagnosis.findings);
        let mut named = 0;
        let mut alone = 0;
        let mut padded = false;
        let mut sizes = Share::default();
        for (place, effect) in truth.effects.iter().enumerate() {
            let is = |found: &Effect| found.law == effect.law && found.place == effect.place;
            let mut as_last = truth.clone();
            let own = as_last.effects.remove(place);
            as_last.effects.push(own);
            let names_it = |found: &Effect| {
                Ok::<_, Failure>(is(found) || self.is_enough_of_the_last(&as_last, found)?)
            };
            let mut of_effect = None;
            for group in &groups {
                for finding in group {
                    if of_effect.is_none() && names_it(&finding.effect)? {
                        of_effect = Some(group);
                    }
                }
            }
            let Some(group) = of_effect else {
                continue;
            };
            named += 1;
            alone += usize::from(group.len() == 1);
            for finding in group {
                if !is(&finding.effect) {
                    padded |= self.is_padding(&as_last, &finding.effect)?;
                } else if let (Some(value), Some(truth)) =
                    (finding.values.first(), effect.values.first())
                    && let Some([low, high]) = value.interval_95()
                {
                    sizes.add((low..=high).contains(truth));
                }
            }
        }
        let all = named == truth.effects.len();
        let decided = matches!(diagnosis.verdict, Verdict::Explained | Verdict::Ambiguous);
        Ok(Judged {
            found: is_alarm(diagnosis),
            named: named > 0,
            alone: all && decided && groups.len() == alone,
            right: all && decided && groups.len() == named && !padded,
            in_run: decided && named_in_run_of(truth, diagnosis),
            wrong: decided && groups.len() > named,
            sizes,
            factors: factors_covered(truth, diagnosis),
        })
    }

    /// Whether a finding is a simpler law in place of the last effect of a truth, which contains it, and cannot be distinguished from it: of nested
    /// laws the simplest that is not excluded is named.
    fn is_enough_of_the_last(&self, truth: &Truth, found: &Effect) -> Result<bool, Failure> {
        let last = truth.effects.last();
        let is_nested =
            last.is_some_and(|own| own.law.contains(found.law) && own.place == found.place);
        Ok(is_nested && !self.is_padding(truth, found)?)
    }

    /// Whether a member of a set can be distinguished from the last effect of a truth.
    fn is_padding(&self, truth: &Truth, member: &Effect) -> Result<bool, Failure> {
        let last = truth.effects.last();
        if last.is_some_and(|own| member.law.contains(own.law) && member.place == own.place) {
            return Ok(false);
        }
        let own = standard_errors(&self.baseline, &self.plan, truth)?;
        let between = standard_errors_between(&self.baseline, &self.plan, truth, member)?;
        Ok(is_apart(between, own))
    }
}

/// A diagnosis compared with the truth.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is counted by itself; they are no states"
)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Judged {
    /// Something is said to be missing.
    pub(super) found: bool,
    /// At least one true effect is named.
    pub(super) named: bool,
    /// Each true effect is named by itself, and nothing else.
    pub(super) alone: bool,
    /// Each true effect is named, by itself or among those that cannot be distinguished from it, and nothing else.
    pub(super) right: bool,
    /// Whatever is named lies in the run of the true slip, at whichever steps.
    pub(super) in_run: bool,
    /// Something is named that is not there.
    pub(super) wrong: bool,
    /// Sizes of named effects inside their intervals.
    pub(super) sizes: Share,
    /// Identified factors inside their intervals.
    pub(super) factors: Share,
}

/// Whether all that is named are slips of the run in which the only true effect, a slip, happened.
fn named_in_run_of(truth: &Truth, diagnosis: &Diagnosis) -> bool {
    let [slip] = &truth.effects[..] else {
        return false;
    };
    let own = run_of(&slip.place);
    own.is_some()
        && diagnosis
            .findings
            .iter()
            .all(|finding| run_of(&finding.effect.place) == own)
}

/// The run of a place: pose, direction and repeat.
fn run_of(place: &Place) -> Option<(&PoseId, &DirectionName, u32)> {
    match place {
        Place::Run {
            pose,
            direction,
            repeat,
            ..
        } => Some((pose, direction, *repeat)),
        _ => None,
    }
}

/// Whether a diagnosis states that something is missing.
pub(super) fn is_alarm(diagnosis: &Diagnosis) -> bool {
    !matches!(
        diagnosis.verdict,
        Verdict::NothingMissing | Verdict::InsufficientData
    )
}

/// Identified factors of a diagnosis whose intervals hold the truth.
pub(super) fn factors_covered(truth: &Truth, diagnosis: &Diagnosis) -> Share {
    let mut share = Share::default();
    for (factor, truth) in diagnosis.factors.iter().zip(&truth.parameters) {
        if let Some([low, high]) = factor
            .identified
            .then(|| factor.after.interval_95())
            .flatten()
        {
            share.add((low..=high).contains(truth));
        }
    }
    share
}

/// One seed from several numbers (the finaliser of SplitMix64), so that no two trials share theirs.
pub(super) fn seed_of(parts: &[u64]) -> u64 {
    let mut state = 0_u64;
    for part in parts {
        state = state
            .wrapping_add(*part)
            .wrapping_add(0x9e37_79b9_7f4a_7c15);
        state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        state ^= state >> 31;
    }
    state
}

fn between(rng: &mut ChaCha8Rng, [low, high]: [f64; 2]) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

fn drawn_parameters(baseline: &RobotBaseline<'_>, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of(&[seed, 1]));
    baseline
        .parameters()
        .iter()
        .map(|parameter| {
            let by = between(&mut rng, FACTORS.map(f64::ln));
            match parameter.spring_rad_per_nm {
                None => parameter.start + by,
                // A spring is no logarithm.
                Some(_) => (parameter.start * by.exp()).clamp(parameter.lower, parameter.upper),
            }
        })
        .collect()
}

fn noise(kind: NoiseKind, seed: u64) -> TrialNoise {
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of(&[seed, 2]));
    let mut noise = TrialNoise {
        noise: ReadingNoise {
            reading_sd_m: 1e-6 * between(&mut rng, READING_UM),
            zero_sd_m: 1e-6 * between(&mut rng, ZERO_UM),
            run_slope_sd: between(&mut rng, SLOPE),
            ..ReadingNoise::default()
        },
        displacement_step_m: 1e-6,
        force_step_n: 0.1,
        skewed: kind == NoiseKind::Skewed,
    };
    if matches!(kind, NoiseKind::Coarse | NoiseKind::CoarseQuiet) {
        noise.displacement_step_m = 1e-5;
    }
    if kind == NoiseKind::Coarse {
        noise.noise.reading_sd_m = 6e-6;
    }
    noise
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_depend_on_every_part_and_their_order() {
        let seeds = [[1, 2, 3], [1, 3, 2], [3, 2, 1], [1, 2, 4], [0, 2, 3]].map(|p| seed_of(&p));
        for (place, seed) in seeds.iter().enumerate() {
            assert!(!seeds[..place].contains(seed));
        }
        assert_eq!(seed_of(&[1, 2]), seed_of(&[1, 2]));
    }

    #[test]
    fn noise_lies_in_its_range_and_follows_its_kind() {
        for seed in 0..20 {
            let normal = noise(NoiseKind::Normal, seed);
            assert!((0.9e-6..2.2e-6).contains(&normal.noise.reading_sd_m));
            assert_eq!(normal.displacement_step_m, 1e-6);
            assert!(noise(NoiseKind::Skewed, seed).skewed && !normal.skewed);
            assert_eq!(noise(NoiseKind::Coarse, seed).noise.reading_sd_m, 6e-6);
            let quiet = noise(NoiseKind::CoarseQuiet, seed);
            assert_eq!(quiet.noise, normal.noise);
            assert_eq!(quiet.displacement_step_m, 1e-5);
        }
    }
}
