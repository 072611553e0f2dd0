//! The measurement to make next: for each pair that is still open the quickest plan that tells it apart.

use std::collections::BTreeSet;

use super::next_measurement::NextMeasurement;
use crate::mismatch::candidates::same;
use crate::mismatch::error::MismatchError;
use crate::mismatch::observed::Observations;
use crate::mismatch::verdict::{Diagnosis, Finding, Verdict};
use crate::search::Projected;
use crate::search::constants::{CAN_TELL, CANNOT_TELL};
use stiffbench_beams::physics::{Effect, title};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_units_and_text::test_point::{Branch, Direction};

use super::advice::advice;
use super::bench::{DesignBench, LawAtPlace};
use super::plans::{loadings, proposed};
use super::separation::{CellInformation, Effects};
use super::unexplained::refine_scores;

/// Pairs that are planned for (1), those with the largest posterior. By judgement (2d002a9).
const MOST_PAIRS: usize = 6;

/// What a finding is compared with where nothing else explains the readings as well.
const NOTHING: &str = "nothing";

/// Two explanations that are indistinguishable.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OpenPair {
    pub(super) effects: [usize; 2],
    /// Probability of the less likely one as a share of that of the other.
    pub(super) weight: f64,
    /// Effects found besides, which count as factors.
    pub(super) besides: Vec<usize>,
}

/// Plans the next measurement after a diagnosis: one entry a pair, the most probable pair first.
///
/// Where no load plan reaches an expected log-likelihood ratio of 3, the entry is the check without loads that does; where one reaches 3
/// but not 5, both are given. Where nothing is open, it is the measurement that confirms or refutes each finding; where nothing is missing
/// or decided, what would show most of what these readings could not. One plan stands for several pairs if it is quicker than one for each.
/// Before them, where structure is left that no law explains, stands the plan that shows more of it.
///
/// # Arguments
/// - `done`: the readings already made.
/// - `base`: the procedure by which they were made, or one like it.
///
/// # Errors
/// [`MismatchError::UnknownPose`] if a measured pose is not among those at hand; [`MismatchError::Robot`].
pub fn next_measurements(
    bench: &DesignBench<'_>,
    done: &Observations,
    diagnosis: &Diagnosis,
    base: &Procedure,
) -> Result<Vec<NextMeasurement>, MismatchError> {
    let done = &bench.in_order(done)?;
    let verdict = diagnosis.verdict;
    if let Verdict::NothingMissing | Verdict::InsufficientData = verdict {
        let decided = verdict == Verdict::NothingMissing;
        return Ok(further(bench, done, base, decided).into_iter().collect());
    }
    let (fitted, pairs) = open_pairs(&diagnosis.findings);
    if pairs.is_empty() && verdict == Verdict::Explained {
        return confirmations(bench, done, &diagnosis.findings, base);
    }
    let closer = (verdict == Verdict::Unknown)
        .then(|| refine_scores(bench, done, &diagnosis.unexplained, base));
    let mut out: Vec<NextMeasurement> = closer.flatten().into_iter().collect();
    out.extend(plan_for(bench, done, fitted, &pairs, base)?);
    Ok(out)
}

/// Effects that are open, and which of them are rivals.
pub(super) fn open_pairs(findings: &[Finding]) -> (Vec<Effect>, Vec<OpenPair>) {
    let mut open = Open::default();
    for (place, finding) in findings.iter().enumerate() {
        for other in &findings[place + 1..] {
            if exclude_each_other(finding, other) {
                let weight = (-(finding.log_bayes - other.log_bayes).abs()).exp();
                open.pair(&finding.effect, &other.effect, weight);
            }
        }
        for rival in &finding.rivals {
            if rival.log_bayes_to_winner < CAN_TELL {
                let weight = (-rival.log_bayes_to_winner.max(0.0)).exp();
                open.pair(&finding.effect, &rival.effect, weight);
            }
        }
    }
    open.pairs.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    open.pairs.truncate(MOST_PAIRS);
    open.add_besides(findings);
    (open.effects, open.pairs)
}

fn exclude_each_other(a: &Finding, b: &Finding) -> bool {
    a.alternative_group.is_some() && a.alternative_group == b.alternative_group
}

/// Pairs as they are found.
#[derive(Default)]
struct Open {
    effects: Vec<Effect>,
    pairs: Vec<OpenPair>,
}

impl Open {
    fn place(&mut self, effect: &Effect) -> usize {
        let known = self.effects.iter().position(|other| same(other, effect));
        known.unwrap_or_else(|| {
            self.effects.push(effect.clone());
            self.effects.len() - 1
        })
    }

    fn pair(&mut self, first: &Effect, second: &Effect, weight: f64) {
        if first.title() == second.title() {
            // Two equations of one effect: whichever it is, the same is to be done.
            return;
        }
        let (a, b) = (self.place(first), self.place(second));
        let known = |pair: &OpenPair| pair.effects == [a, b] || pair.effects == [b, a];
        if a != b && !self.pairs.iter().any(known) {
            self.pairs.push(OpenPair {
                effects: [a, b],
                weight,
                besides: Vec::new(),
            });
        }
    }

    /// To each pair what was found besides: of each other set of alternatives the first.
    fn add_besides(&mut self, findings: &[Finding]) {
        for index in 0..self.pairs.len() {
            let pair = self.pairs[index].effects.map(|place| &self.effects[place]);
            let of_pair = |finding: &&Finding| pair.iter().any(|own| same(own, &finding.effect));
            let mut taken: Vec<&Finding> = findings.iter().filter(of_pair).collect();
            let own = taken.len();
            for finding in findings {
                let known = |other: &&Finding| {
                    same(&other.effect, &finding.effect) || exclude_each_other(other, finding)
                };
                if !taken.iter().any(known) {
                    taken.push(finding);
                }
            }
            let besides = taken[own..].iter().map(|found| self.place(&found.effect));
            self.pairs[index].besides = besides.collect();
        }
    }
}

/// A plan with the expected log-likelihood ratio that it reaches for each question.
struct Rated {
    plan: NextMeasurement,
    log_lr: Vec<f64>,
}

impl Rated {
    /// The plan for one of the questions.
    fn proposed(&self, question: usize, separates: [String; 2]) -> NextMeasurement {
        NextMeasurement {
            separates,
            expected_log_lr: Some(self.log_lr[question]),
            ..self.plan.clone()
        }
    }
}

/// Every way of loading, in all that [`coverages`] names.
///
/// # Arguments
/// - `old`: what the readings already made say.
/// - `rate`: the expected log-likelihood ratio for each question, of what old and planned readings leave of the effects.
fn rated_plans(
    bench: &DesignBench<'_>,
    done: &Observations,
    (effects, old): (&Effects, &[CellInformation]),
    base: &Procedure,
    rate: &dyn Fn(&Projected) -> Vec<f64>,
) -> Result<Vec<Rated>, MismatchError> {
    let mut rated = Vec::new();
    for loading in loadings(base) {
        let everywhere = Procedure {
            poses: Some(bench.poses.to_vec()),
            directions: bench
                .directions()
                .iter()
                .map(|axis| (*axis).into())
                .collect(),
            ..loading.clone()
        };
        let new = bench.cells(effects, &bench.observations(&everywhere)?, true)?;
        rated.extend(coverages(bench, done).into_iter().map(|coverage| {
            let covered = new.iter().filter(|cell| coverage.covers(cell));
            Rated {
                log_lr: rate(&bench.projected(effects, old.iter().chain(covered))),
                plan: coverage.proposed(bench, &loading, <[String; 2]>::default()),
            }
        }));
    }
    Ok(rated)
}

/// The quickest of the plans that are wanted.
fn quickest(rated: &[Rated], is_wanted: impl Fn(&Rated) -> bool) -> Option<usize> {
    let minutes = |plan: usize| rated[plan].plan.minutes;
    (0..rated.len())
        .filter(|&plan| is_wanted(&rated[plan]))
        .min_by(|&a, &b| minutes(a).total_cmp(&minutes(b)))
}

/// For each pair the quickest plan that tells it apart, and a check without loads where none does.
///
/// # Arguments
/// - `done`: the readings already made, in the order of the poses at hand.
pub(super) fn plan_for(
    bench: &DesignBench<'_>,
    done: &Observations,
    fitted: Vec<Effect>,
    pairs: &[OpenPair],
    base: &Procedure,
) -> Result<Vec<NextMeasurement>, MismatchError> {
    if pairs.is_empty() {
        return Ok(Vec::new());
    }
    let suspects: Vec<LawAtPlace> = fitted.iter().map(LawAtPlace::from).collect();
    let effects = Effects::new(bench, done, fitted)?;
    let old = bench.cells(&effects, done, false)?;
    let rate = |projected: &Projected| -> Vec<f64> {
        let log_lr = |pair: &OpenPair| {
            let besides = pair.besides.iter();
            let rest = besides.fold(projected.clone(), |rest, &effect| rest.without(effect));
            effects.log_lr(&rest, pair.effects)
        };
        pairs.iter().map(log_lr).collect()
    };
    let rated = rated_plans(bench, done, (&effects, &old), base, &rate)?;
    let mut out = Vec::new();
    for (place, plan) in select(&rated, pairs.len()).into_iter().enumerate() {
        let [first, second] = pairs[place].effects.map(|effect| &suspects[effect]);
        let separates = [first.to_string(), second.to_string()];
        let reached = rated[plan].log_lr[place];
        if reached >= CANNOT_TELL {
            out.push(rated[plan].proposed(place, separates.clone()));
        }
        // A check by hand is one of a robot.
        if reached < CAN_TELL
            && !bench.is_of_part()
            && let Some((plan, minutes)) = advice(first, second)
        {
            out.push(NextMeasurement::check(plan, minutes, separates));
        }
    }
    Ok(out)
}

/// For each pair the plan to follow: the quickest that tells it apart, else the one that comes nearest to it; one for all that can be decided,
/// if it is quicker than a plan for each.
fn select(rated: &[Rated], pairs: usize) -> Vec<usize> {
    let of_pair = |pair: usize| {
        let reached = |plan: usize| rated[plan].log_lr[pair];
        let enough = |least: f64| quickest(rated, |plan| plan.log_lr[pair] >= least);
        let best = || (0..rated.len()).max_by(|&a, &b| reached(a).total_cmp(&reached(b)));
        let found = enough(CAN_TELL).or_else(|| enough(CANNOT_TELL));
        found.or_else(best).unwrap_or(0)
    };
    let mut each: Vec<usize> = (0..pairs).map(of_pair).collect();
    let decides = |plan: &Rated, pair: usize| plan.log_lr[pair] >= CAN_TELL;
    let decided = (0..pairs).filter(|&pair| decides(&rated[each[pair]], pair));
    let decided: Vec<usize> = decided.collect();
    let apart: BTreeSet<usize> = decided.iter().map(|&pair| each[pair]).collect();
    let apart = apart.into_iter().map(|plan| rated[plan].plan.minutes);
    let apart: f64 = apart.sum();
    let together = quickest(rated, |plan| {
        decided.iter().all(|&pair| decides(plan, pair))
    });
    if let Some(together) = together.filter(|&plan| rated[plan].plan.minutes < apart) {
        for pair in decided {
            each[pair] = together;
        }
    }
    each
}

/// For each finding the quickest new measurement that shows its effect by itself, or its absence: one that would be expected to, with a log
/// likelihood ratio of 5, and without the readings in which it was found.
///
/// What happened in one run does not happen again, and what has no size in these poses is not seen in them: for such findings there is none.
fn confirmations(
    bench: &DesignBench<'_>,
    done: &Observations,
    findings: &[Finding],
    base: &Procedure,
) -> Result<Vec<NextMeasurement>, MismatchError> {
    let found = findings.iter().map(|finding| &finding.effect);
    let lasting = found.filter(|effect| !effect.law.is_of_one_run());
    let lasting: Vec<Effect> = lasting.cloned().collect();
    if lasting.is_empty() {
        return Ok(Vec::new());
    }
    let places = 0..lasting.len();
    let rate = |projected: &Projected| -> Vec<f64> {
        let alone = |place: usize| {
            let others = places.clone().filter(|other| *other != place);
            let alone = others.fold(projected.clone(), |rest, other| rest.without(other));
            0.5 * alone.square(place)
        };
        places.clone().map(alone).collect()
    };
    let effects = Effects::plain(lasting.clone());
    let rated = rated_plans(bench, done, (&effects, &[]), base, &rate)?;
    let confirmed = lasting.iter().enumerate().filter_map(|(place, effect)| {
        let plan = quickest(&rated, |plan| plan.log_lr[place] >= CAN_TELL)?;
        let separates = [title(effect.law, &effect.place), NOTHING.to_owned()];
        Some(rated[plan].proposed(place, separates))
    });
    Ok(confirmed.collect())
}

/// What would show most of what a session could not: the way of loading that it lacks, else the poses that it did not measure.
///
/// # Arguments
/// - `decided`: whether the readings already made were enough to decide; if not, the same poses with enough repeats come first.
fn further(
    bench: &DesignBench<'_>,
    done: &Observations,
    base: &Procedure,
    decided: bool,
) -> Option<NextMeasurement> {
    let coverages = coverages(bench, done);
    let [measured, others @ ..] = &coverages[..] else {
        return None;
    };
    let mut readings = done.readings.iter();
    let unloaded = readings.any(|one| one.branch == Branch::Unloading);
    let is_new = |pose: &usize| !measured.poses.contains(pose);
    let new = others.iter().find(|other| other.poses.iter().all(is_new));
    let (coverage, name) = match new {
        _ if !decided => (measured, "sweeps"),
        _ if !unloaded => (measured, "load-unload"),
        Some(new) => (new, "again"),
        None => (measured, "both-signs"),
    };
    let separates = if decided {
        ["that nothing is missing", NOTHING]
    } else {
        ["missing physics", "the scatter of readings"]
    };
    let mut loadings = loadings(base).into_iter();
    let loading = loadings.find(|loading| loading.name == name)?;
    Some(coverage.proposed(bench, &loading, separates.map(str::to_owned)))
}

/// Which poses and directions a plan measures.
struct Coverage {
    words: String,
    poses: Vec<usize>,
    directions: Vec<Direction>,
}

/// Most poses of one plan: with five repeats along three axes about a day's work. Of more, as many that lie evenly among them.
const MOST_POSES: usize = 12;

/// All that was measured, each pose by itself, each cell by itself, and all that was not measured.
fn coverages(bench: &DesignBench<'_>, done: &Observations) -> Vec<Coverage> {
    let of = |words: String, poses: Vec<usize>, directions: &[Direction]| Coverage {
        words,
        poses,
        directions: directions.to_vec(),
    };
    let some = bench.may_be_measured.len() < bench.poses.len();
    let rules = if some { " that may be taken" } else { "" };
    let evenly = |poses: Vec<usize>, which: &str| {
        let which = format!("{which}{rules}");
        let count = poses.len();
        let kept = count.min(MOST_POSES);
        let words = if count > MOST_POSES {
            format!("{MOST_POSES} of the {which}")
        } else {
            format!("all {which}")
        };
        let poses = (0..kept).map(|place| poses[place * count / kept]).collect();
        of(words, poses, bench.directions())
    };
    let [old, new] = bench.measured_and_further(done);
    if bench.is_of_part() {
        return vec![of("the same part".to_owned(), old, bench.directions())];
    }
    let mut out = Vec::new();
    let poses = [&old[..], &new].concat();
    if !old.is_empty() {
        out.push(evenly(old, "measured poses"));
    }
    if new.len() > 1 {
        out.push(evenly(new, "poses not measured yet"));
    }
    for pose in poses {
        let name = &bench.poses[pose];
        out.push(of(format!("pose {name}"), vec![pose], &Direction::ALL));
        out.extend(Direction::ALL.map(|direction| {
            let words = format!("pose {name} in {direction}");
            of(words, vec![pose], &[direction])
        }));
    }
    out
}

impl Coverage {
    fn covers(&self, cell: &CellInformation) -> bool {
        self.poses.contains(&cell.pose) && self.directions.contains(&cell.direction)
    }

    /// A way of loading there.
    fn proposed(
        &self,
        bench: &DesignBench<'_>,
        loading: &Procedure,
        separates: [String; 2],
    ) -> NextMeasurement {
        let way = loading.text.as_deref().unwrap_or_default();
        let words = format!("{}, {way}", self.words);
        let there = (bench.named(&self.poses), &self.directions[..]);
        proposed(bench, loading, words, there, separates)
    }
}
