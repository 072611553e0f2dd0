//! The measurement to make next: for each pair that is still open the quickest plan that tells it apart.

use crate::mismatch::diagnosis::{Diagnosis, Finding, Verdict};
use crate::mismatch::error::MismatchError;
use crate::mismatch::observations::Observations;
use crate::mismatch::ranked_candidate::same;
use crate::search::constants::{CAN_TELL, CANNOT_TELL, MOST_PAIRS};
use stiffbench_beams::physics::Effect;
use stiffbench_measurement::procedure::Procedure;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::Direction;

use super::advice::advice;
use super::bench::{DesignBench, LawAtPlace};
use super::confirm::{confirmations, further};
use super::plans::{LoadingPlan, ProposedMeasurement, loadings};
use super::separation::{CellGram, Effects};
use super::unexplained::refine_scores;

/// Two explanations that are indistinguishable.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OpenPair {
    pub(super) effects: [usize; 2],
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
) -> Result<Vec<ProposedMeasurement>, MismatchError> {
    match diagnosis.verdict {
        Verdict::NothingMissing => {
            return Ok(further(bench, done, base, true)?.into_iter().collect());
        }
        Verdict::InsufficientData => {
            return Ok(further(bench, done, base, false)?.into_iter().collect());
        }
        _ => {}
    }
    let (fitted, pairs) = open_pairs(&diagnosis.findings);
    if pairs.is_empty() && diagnosis.verdict == Verdict::Explained {
        return confirmations(bench, done, &diagnosis.findings, base);
    }
    let closer = if diagnosis.verdict == Verdict::Unknown {
        refine_scores(bench, done, &diagnosis.unexplained, base)
    } else {
        None
    };
    let mut out: Vec<ProposedMeasurement> = closer.into_iter().collect();
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
    let all: f64 = open.pairs.iter().map(|pair| pair.weight).sum();
    for pair in &mut open.pairs {
        pair.weight /= all;
    }
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
            let [first, second] = self.pairs[index].effects;
            let of_pair = |finding: &&Finding| {
                same(&finding.effect, &self.effects[first])
                    || same(&finding.effect, &self.effects[second])
            };
            let own: Vec<&Finding> = findings.iter().filter(of_pair).collect();
            let mut besides: Vec<&Finding> = Vec::new();
            for finding in findings {
                let known = |other: &&&Finding| {
                    same(&other.effect, &finding.effect) || exclude_each_other(other, finding)
                };
                if own.iter().chain(&besides).find(known).is_none() {
                    besides.push(finding);
                }
            }
            let besides: Vec<usize> = besides.iter().map(|f| self.place(&f.effect)).collect();
            self.pairs[index].besides = besides;
        }
    }
}

/// A plan with what it reaches for each pair.
struct Rated {
    words: String,
    procedure: Procedure,
    minutes: f64,
    log_lr: Vec<f64>,
}

pub(super) fn plan_for(
    bench: &DesignBench<'_>,
    done: &Observations,
    fitted: Vec<Effect>,
    pairs: &[OpenPair],
    base: &Procedure,
) -> Result<Vec<ProposedMeasurement>, MismatchError> {
    if pairs.is_empty() {
        return Ok(Vec::new());
    }
    let suspects: Vec<LawAtPlace> = fitted.iter().map(LawAtPlace::from).collect();
    let done = bench.in_order(done)?;
    let effects = Effects::new(bench, &done, fitted)?;
    let old = bench.cells(&effects, &done, false)?;
    let rate = |cells: &mut dyn Iterator<Item = &CellGram>| -> Vec<f64> {
        let projected = bench.whole(&effects, cells).projected();
        let log_lr = |pair: &OpenPair| {
            let [first, second] = pair.effects;
            let besides = pair.besides.iter();
            let rest = besides.fold(projected.clone(), |rest, &effect| rest.without(effect));
            effects.log_lr(&rest, first, second)
        };
        pairs.iter().map(log_lr).collect()
    };
    let now = rate(&mut old.iter());
    let mut rated: Vec<Rated> = Vec::new();
    for loading in loadings(base) {
        let everywhere = Procedure {
            poses: Some(bench.poses.to_vec()),
            directions: LoadDirection::axes(),
            ..loading.procedure.clone()
        };
        let new = bench.cells(&effects, &bench.observations(&everywhere)?, true)?;
        for coverage in coverages(bench, &done) {
            let (words, procedure) = coverage.of(bench, &loading);
            let covered = new.iter().filter(|cell| coverage.covers(cell));
            rated.push(Rated {
                minutes: procedure.minutes(&bench.pace, coverage.poses.len()),
                log_lr: rate(&mut old.iter().chain(covered)),
                words,
                procedure,
            });
        }
    }
    let selected = select(&rated, pairs.len());
    let mut out = Vec::new();
    for (place, pair) in pairs.iter().enumerate() {
        let [first, second] = pair.effects.map(|effect| &suspects[effect]);
        let separates = [first.to_string(), second.to_string()];
        let plan = &rated[selected[place]];
        let reached = plan.log_lr[place];
        if reached >= CANNOT_TELL {
            out.push(ProposedMeasurement {
                plan: plan.words.clone(),
                separates: separates.clone(),
                expected_log_lr: Some(reached),
                log_lr_now: now[place],
                minutes: plan.minutes,
                procedure: Some(plan.procedure.clone()),
                weight: pair.weight,
            });
        }
        if reached < CAN_TELL
            && let Some((plan, minutes)) = advice(first, second)
        {
            out.push(ProposedMeasurement {
                plan,
                separates,
                expected_log_lr: None,
                log_lr_now: now[place],
                minutes,
                procedure: None,
                weight: pair.weight,
            });
        }
    }
    Ok(out)
}

/// For each pair the plan to follow.
fn select(rated: &[Rated], pairs: usize) -> Vec<usize> {
    let quickest = |wanted: &dyn Fn(&Rated) -> bool| {
        (0..rated.len())
            .filter(|&plan| wanted(&rated[plan]))
            .min_by(|&a, &b| rated[a].minutes.total_cmp(&rated[b].minutes))
    };
    let best = |pair: usize| {
        let reached = |plan: &usize| rated[*plan].log_lr[pair];
        (0..rated.len()).max_by(|a, b| reached(a).total_cmp(&reached(b)))
    };
    let each: Vec<usize> = (0..pairs)
        .map(|pair| {
            let enough = |least: f64| quickest(&|plan: &Rated| plan.log_lr[pair] >= least);
            enough(CAN_TELL)
                .or_else(|| enough(CANNOT_TELL))
                .or_else(|| best(pair))
                .unwrap_or(0)
        })
        .collect();
    // One plan for all that can be decided, if it is quicker than a plan for each.
    let decided: Vec<usize> = (0..pairs)
        .filter(|&pair| rated[each[pair]].log_lr[pair] >= CAN_TELL)
        .collect();
    let mut plans: Vec<usize> = decided.iter().map(|&pair| each[pair]).collect();
    plans.sort_unstable();
    plans.dedup();
    let minutes: f64 = plans.iter().map(|&plan| rated[plan].minutes).sum();
    let together =
        quickest(&|plan: &Rated| decided.iter().all(|&pair| plan.log_lr[pair] >= CAN_TELL));
    match together {
        Some(plan) if plans.len() > 1 && rated[plan].minutes < minutes => (0..pairs)
            .map(|pair| {
                if decided.contains(&pair) {
                    plan
                } else {
                    each[pair]
                }
            })
            .collect(),
        _ => each,
    }
}

/// Which poses and directions a plan measures.
pub(super) struct Coverage {
    words: String,
    pub(super) poses: Vec<usize>,
    directions: Vec<Direction>,
}

/// Most poses of one plan: with five repeats along three axes about a day's work. Of more, as many that lie evenly among them.
const MOST_POSES: usize = 12;

/// All that was measured, each pose by itself, each cell by itself, and all that was not measured.
pub(super) fn coverages(bench: &DesignBench<'_>, done: &Observations) -> Vec<Coverage> {
    let measured = |pose: &usize| done.cells.iter().any(|cell| cell.pose == *pose);
    let (old, new): (Vec<usize>, Vec<usize>) = (0..bench.poses.len()).partition(measured);
    let all = Direction::ALL.to_vec();
    let of = |poses: Vec<usize>, which: &str| {
        let count = poses.len();
        let words = if count > MOST_POSES {
            format!("{MOST_POSES} of the {which}")
        } else {
            format!("all {which}")
        };
        let kept = count.min(MOST_POSES);
        Coverage {
            words,
            poses: (0..kept).map(|place| poses[place * count / kept]).collect(),
            directions: all.clone(),
        }
    };
    let mut out = vec![of(old, "measured poses")];
    if new.len() > 1 {
        out.push(of(new, "poses not measured yet"));
    }
    for (pose, name) in bench.poses.iter().enumerate() {
        let only = |words: String, directions: Vec<Direction>| Coverage {
            words,
            poses: vec![pose],
            directions,
        };
        out.push(only(format!("pose {name}"), all.clone()));
        out.extend(
            Direction::ALL
                .map(|direction| only(format!("pose {name} in {direction}"), vec![direction])),
        );
    }
    out
}

impl Coverage {
    pub(super) fn covers(&self, cell: &CellGram) -> bool {
        self.poses.contains(&cell.pose) && self.directions.contains(&cell.direction)
    }

    /// The plan in words, and as a procedure.
    pub(super) fn of(&self, bench: &DesignBench<'_>, loading: &LoadingPlan) -> (String, Procedure) {
        let words = format!("{}, {}", self.words, loading.words);
        let poses = self.poses.iter().map(|&pose| bench.poses[pose].clone());
        let procedure = Procedure {
            name: format!("next-{}", loading.procedure.name),
            text: Some(words.clone()),
            poses: Some(poses.collect()),
            directions: self.directions.iter().map(|axis| (*axis).into()).collect(),
            ..loading.procedure.clone()
        };
        (words, procedure)
    }
}
