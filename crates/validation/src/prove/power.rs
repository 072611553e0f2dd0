//! How often an effect is found, and under its right name, against its size.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use stiffbench::analysis::Failure;

use stiffbench_beams::physics::{Effect, Law, Needs, Place, laws};
use stiffbench_diagnosis::mismatch::{SearchOptions, Truth};

use super::calibration::{is_full, places_of_benches};
use super::cases::{missing_member, reaching, reshaped, scaled, testable};
use super::ideal::{IdealSearch, IdealSession};
use super::score::is_apart;
use super::session::ValidationSession;
use super::share::Share;
use super::trial_bench::{Judged, NoiseKind, TrialBench, seed_of};

/// Trials that share their factors and place: scaling an effect to its size costs as much as several trials.
const SHARE_FACTORS: usize = 8;

/// Places of a law that are tried on one bench, from the one in the middle by its smallest visible size outwards.
const MOST_PLACES: usize = 12;

/// Sessions of an observer with known noise: shares are known to half a percent.
const IDEAL_SESSIONS: usize = 4000;

/// Quantiles of the normal distribution for 80 and 95 %: slip is assessed at its own limit and so much more.
const SLIP_BEYOND_LIMIT: [f64; 2] = [0.84, 1.64];

/// Sizes of both effects of a pair, standard errors.
const PAIR_SIZE: f64 = 12.0;

/// Pairs of laws, in a joint of a closed loop where they sit in one.
const PAIRS: [[Law; 2]; 4] = [
    [laws::JOINT_BACKLASH, laws::DRIFT_PER_SECOND],
    [laws::JOINT_COMPLIANCE, laws::SETTING_IN],
    [laws::JOINT_FRICTION, laws::GAUGE_PERIODIC],
    [laws::BASE_COMPLIANCE, laws::FORCE_GAUGE_NONLINEARITY],
];

/// What is to be counted.
#[derive(Debug, Clone, PartialEq)]
pub struct PowerOptions {
    /// Laws.
    pub laws: Vec<Law>,
    /// Sizes, standard errors.
    pub sizes: Vec<f64>,
    /// Trials of each size.
    pub trials: usize,
    /// Benches with closed loops that the laws of joints are tried on.
    pub closed_benches: usize,
    /// Sessions of the same bench before each block of trials, which tell the noise too.
    pub earlier: usize,
    /// Whether pairs are tried.
    pub pairs: bool,
    /// Seed.
    pub seed: u64,
}

/// Trials of one law at one size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct PowerPoint {
    /// Its size, standard errors.
    #[serde(rename = "standard_errors")]
    pub size: f64,
    /// Something was found.
    pub found: Share,
    /// A true effect named, alone or in whatever set.
    pub named: Share,
    /// Each true effect named, alone or among those that cannot be distinguished from it, and nothing else.
    pub right: Share,
    /// Each true effect named by itself.
    pub alone: Share,
    /// Of a slip: nothing but slips of its run named, at whichever steps.
    pub in_run: Share,
    /// Something named that is not there.
    pub wrong: Share,
    /// Sizes of named effects inside their 95 % intervals.
    #[serde(rename = "sizes_in_intervals")]
    pub sizes: Share,
    /// Identified factors inside their 95 % intervals.
    #[serde(rename = "factors_in_intervals")]
    pub factors: Share,
    /// What could be counted at best; `None` of pairs and of what has no size.
    pub ideal: Option<IdealPoint>,
}

/// Effects of the same law, places and size, seen by an observer with known noise and for whom each is one of the shapes that are searched.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct IdealPoint {
    /// Something was found.
    pub found: Share,
    /// The true effect named, alone or with what cannot be distinguished from it, and nothing else.
    pub right: Share,
    /// Found, and the likeliest is the true effect or may be named with it: no set around the likeliest can be right more often.
    pub nameable: Share,
}

/// Trials of one law on one bench, or of a pair.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PowerCase {
    /// The laws: one, or two.
    pub laws: Vec<Law>,
    /// Laws and places in words; of several places their number.
    #[serde(rename = "effects")]
    pub title: String,
    /// The places, one for each block of trials in turn; of a pair one for each law.
    pub places: Vec<Place>,
    /// Robot and mechanism.
    pub bench: String,
    /// Whether its joint lies in a closed loop; `None` for other laws.
    pub in_closed_loop: Option<bool>,
    /// The sizes.
    pub points: Vec<PowerPoint>,
}

/// Counts power and right names; the same for any number of threads.
///
/// # Arguments
/// - `sessions`: plans to choose from: the first of each robot and mechanism with unloading, five repeats and four poses; for creep one with holds.
///   Laws of no joint are tried on the first with closed loops, else on the first.
/// - `done`: called after each trial.
/// - `so_far`: called after each law of a bench with all cases until then.
///
/// # Errors
/// If a trial cannot be computed, and those of `so_far`.
pub fn power(
    sessions: &[ValidationSession],
    options: &PowerOptions,
    done: &(dyn Fn() + Sync),
    so_far: &mut dyn FnMut(&[PowerCase]) -> Result<(), Failure>,
) -> Result<Vec<PowerCase>, Failure> {
    let search = SearchOptions {
        seed: options.seed,
        ..SearchOptions::default()
    };
    let full = places_of_benches(sessions, is_full);
    let held = places_of_benches(sessions, has_holds);
    let bench = |place: usize| {
        let seed = seed_of(&[options.seed, 200, place as u64]);
        TrialBench::new(
            &sessions[place],
            NoiseKind::Normal,
            &search,
            options.earlier,
            seed,
        )
    };
    let mut cases: Vec<PowerCase> = Vec::new();
    let mut benches: Vec<(TrialBench<'_>, bool)> = Vec::new();
    let (mut closed, mut open) = (0, 0);
    for &place in &full {
        if closed >= options.closed_benches && open >= 1 {
            break;
        }
        let bench = bench(place)?;
        let is_closed = !testable(&bench, laws::JOINT_COMPLIANCE, false)?.is_empty();
        let count = if is_closed { &mut closed } else { &mut open };
        let wanted = if is_closed { options.closed_benches } else { 1 };
        if *count >= wanted {
            continue;
        }
        *count += 1;
        benches.push((bench, is_closed));
    }
    // What belongs to no joint is tried once: where there are closed loops, if there are any.
    let main = benches.iter().position(|(_, is_closed)| *is_closed);
    let main = main.unwrap_or_default();
    for (number, (bench, is_closed)) in benches.iter().enumerate() {
        let ideal = bench.ideal()?;
        for &law in &options.laws {
            let here = law.is_of_a_joint() || (number == main && !needs_holds(law));
            if here {
                cases.extend(law_case((bench, &ideal), law, !is_closed, options, done)?);
                so_far(&cases)?;
            }
        }
        if number == main && options.pairs {
            for laws in PAIRS {
                cases.extend(pair_case(bench, laws, !is_closed, options, done)?);
                so_far(&cases)?;
            }
        }
    }
    let of_holds: Vec<Law> = options
        .laws
        .iter()
        .copied()
        .filter(|law| needs_holds(*law))
        .collect();
    if let Some(&place) = held.first().filter(|_| !of_holds.is_empty()) {
        let bench = bench(place)?;
        let ideal = bench.ideal()?;
        for law in of_holds {
            cases.extend(law_case((&bench, &ideal), law, false, options, done)?);
            so_far(&cases)?;
        }
    }
    Ok(cases)
}

/// Whether only a session with holds shows a law.
fn needs_holds(law: Law) -> bool {
    law.search.needs == Needs::Hold
}

fn has_holds(session: &ValidationSession) -> bool {
    let mut readings = session.observations.readings.iter();
    session.observations.poses.len() >= 4 && readings.any(|reading| reading.hold_number > 0)
}

fn law_case(
    (bench, ideal): (&TrialBench<'_>, &IdealSearch),
    law: Law,
    open: bool,
    options: &PowerOptions,
    done: &(dyn Fn() + Sync),
) -> Result<Option<PowerCase>, Failure> {
    let (effects, sizes) = if law.is_missing_element() {
        let Some((effect, size)) = missing_member(bench)? else {
            return Ok(None);
        };
        (vec![effect], vec![size])
    } else {
        let most = options.trials.div_ceil(SHARE_FACTORS).min(MOST_PLACES);
        let effects = reaching(bench, &testable(bench, law, open)?, most)?;
        (effects, sizes_of(bench, law, options))
    };
    let Some(first) = effects.first() else {
        return Ok(None);
    };
    let points = sizes
        .into_iter()
        .enumerate()
        .map(|(number, size)| {
            let seed = seed_of(&[
                options.seed,
                300,
                law.number() as u64,
                u64::from(open),
                number as u64,
            ]);
            let truth_at = |block: usize| -> Result<Option<Truth>, Failure> {
                let factors_seed = seed_of(&[seed, 1, block as u64]);
                let effect = &effects[block % effects.len()];
                let mut truth = bench.truth(factors_seed);
                if law.is_missing_element() {
                    truth.effects.push(effect.clone());
                    return Ok(Some(truth));
                }
                let other = reshaped(effect, seed_of(&[factors_seed, 1]));
                scaled(bench, &other, &truth, size)
            };
            Ok::<_, Failure>(PowerPoint {
                ideal: ideal_point(ideal, &effects, size, seed_of(&[seed, 3])),
                ..point(bench, size, seed, options.trials, &truth_at, done)?
            })
        })
        .collect::<Result<_, _>>()?;
    Ok(Some(PowerCase {
        laws: vec![law],
        title: match effects.len() {
            1 => first.title(),
            count => format!("{} at {count} places", law.name),
        },
        places: effects.iter().map(|effect| effect.place.clone()).collect(),
        bench: bench.session.bench(),
        in_closed_loop: law.is_of_a_joint().then_some(!open),
        points,
    }))
}

/// What an observer with known noise finds and names of effects, each as often as any other.
fn ideal_point(
    ideal: &IdealSearch,
    effects: &[Effect],
    size: f64,
    seed: u64,
) -> Option<IdealPoint> {
    let each = IDEAL_SESSIONS / effects.len();
    let seen = |effect: &Effect| ideal.sessions((effect.law, &effect.place), size, each, seed);
    let sessions: Vec<IdealSession> = effects.iter().flat_map(seen).collect();
    (!sessions.is_empty()).then(|| IdealPoint {
        found: Share::of(&sessions, |session| session.found),
        right: Share::of(&sessions, |session| {
            session.found && session.named && !is_apart(session.farthest_apart, size)
        }),
        nameable: Share::of(&sessions, |session| {
            session.found && !is_apart(session.likeliest_apart, size)
        }),
    })
}

/// The sizes of a power curve; slip is assessed at its own limit.
fn sizes_of(bench: &TrialBench<'_>, law: Law, options: &PowerOptions) -> Vec<f64> {
    let limit = bench.critical.laws.values.get(&(law, false));
    match limit.filter(|_| law.is_of_one_run()) {
        Some(limit) => SLIP_BEYOND_LIMIT
            .iter()
            .map(|beyond| limit.sqrt() + beyond)
            .collect(),
        None => options.sizes.clone(),
    }
}

fn pair_case(
    bench: &TrialBench<'_>,
    laws: [Law; 2],
    open: bool,
    options: &PowerOptions,
    done: &(dyn Fn() + Sync),
) -> Result<Option<PowerCase>, Failure> {
    let mut effects: Vec<Effect> = Vec::new();
    for law in laws {
        let reaching = reaching(bench, &testable(bench, law, open)?, 1)?;
        let Some(effect) = reaching.into_iter().next() else {
            return Ok(None);
        };
        effects.push(effect);
    }
    let seed = seed_of(&[
        options.seed,
        400,
        laws[0].number() as u64,
        laws[1].number() as u64,
    ]);
    let truth_at = |block: usize| -> Result<Option<Truth>, Failure> {
        let mut truth = Some(bench.truth(seed_of(&[seed, 1, block as u64])));
        for effect in &effects {
            let Some(beside) = truth else {
                return Ok(None);
            };
            truth = scaled(bench, effect, &beside, PAIR_SIZE)?;
        }
        Ok(truth)
    };
    let found = point(bench, PAIR_SIZE, seed, options.trials, &truth_at, done)?;
    Ok(Some(PowerCase {
        laws: laws.to_vec(),
        title: effects
            .iter()
            .map(Effect::title)
            .collect::<Vec<_>>()
            .join(" and "),
        places: effects.iter().map(|effect| effect.place.clone()).collect(),
        bench: bench.session.bench(),
        in_closed_loop: laws.iter().any(|law| law.is_of_a_joint()).then_some(!open),
        points: vec![found],
    }))
}

/// Trials of one size.
fn point(
    bench: &TrialBench<'_>,
    size: f64,
    seed: u64,
    trials: usize,
    truth_at: &(dyn Fn(usize) -> Result<Option<Truth>, Failure> + Sync),
    done: &(dyn Fn() + Sync),
) -> Result<PowerPoint, Failure> {
    let blocks = trials.div_ceil(SHARE_FACTORS);
    let judged: Vec<Vec<Judged>> = (0..blocks)
        .into_par_iter()
        .map(|block| {
            // Other factors may not let the effect grow to its size; then the trial is made without.
            let Some(truth) = truth_at(block)? else {
                return Ok(Vec::new());
            };
            let earlier = bench.earlier(&truth, seed_of(&[seed, 4, block as u64]))?;
            let last = trials.min((block + 1) * SHARE_FACTORS);
            (block * SHARE_FACTORS..last)
                .into_par_iter()
                .map(|trial| {
                    let own = seed_of(&[seed, 2, trial as u64]);
                    let diagnosis = bench.diagnose(&truth, &earlier, own);
                    done();
                    // A trial without a diagnosis found nothing.
                    diagnosis.map_or(Ok(Judged::default()), |diagnosis| {
                        bench.assess(&truth, &diagnosis)
                    })
                })
                .collect()
        })
        .collect::<Result<_, Failure>>()?;
    let judged: Vec<Judged> = judged.into_iter().flatten().collect();
    let sum = |share: fn(&Judged) -> Share| {
        judged
            .iter()
            .fold(Share::default(), |sum, judged| sum.with(share(judged)))
    };
    Ok(PowerPoint {
        size,
        found: Share::of(&judged, |judged| judged.found),
        named: Share::of(&judged, |judged| judged.named),
        right: Share::of(&judged, |judged| judged.right),
        alone: Share::of(&judged, |judged| judged.alone),
        in_run: Share::of(&judged, |judged| judged.in_run),
        wrong: Share::of(&judged, |judged| judged.wrong),
        sizes: sum(|judged| judged.sizes),
        factors: sum(|judged| judged.factors),
        ideal: None,
    })
}
