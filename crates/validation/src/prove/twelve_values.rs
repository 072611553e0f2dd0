//! What the paper's twelve stiffness values can show of missing physics, and what they cannot.
//!
//! The paper's finite elements and its bench differ by a factor of 2 to 4 (Table V against Table VI). Two questions are asked of every linear
//! law: how much of that gap it closes alone, the finite elements left as they are; and whether it still improves anything once the beam
//! factors have been fitted to the bench, as the paper does.

use std::convert::Infallible;

use indexmap::IndexMap;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_beams::physics::{Mechanics, title};
use stiffbench_beams::robot::{Pose, Robot};
use stiffbench_diagnosis::search::{ForwardProblem, forward_selection, rivals};
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::error::ProveError;
use super::linear_model::{
    LinearFit, LinearLaw, ListedStiffness, StiffnessProblem, compliance, grid,
};
use super::smallest::smallest;
use super::stiffness_search::{FittedCandidate, StiffnessSearch};

/// Poses that the paper fits; it judges on the others.
const TRAIN: [&str; 2] = ["P1", "P3"];

/// Candidates for which a further measurement is searched for.
const RIVALS: usize = 5;

/// A law and what it does to the fit of the twelve values.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FittedLaw {
    /// Law and place in words.
    pub title: String,
    /// Value of its parameter, SI, and its unit.
    pub value: f64,
    /// The unit.
    pub unit: &'static str,
    /// Root mean square error of ln K in percent, all twelve values fitted.
    pub rms_percent: f64,
    /// F of the improvement, 1 and 7 degrees of freedom.
    pub f: f64,
    /// Chance that noise alone gives any law as much, by the smaller of fitted and linear F.
    pub p_family: f64,
    /// Logarithm of the likelihood ratio of the best candidate to this one, under the variance that the best leaves.
    #[serde(rename = "log_likelihood_behind")]
    pub behind: f64,
    /// Largest error of the cells left out pose by pose, percent.
    pub worst_left_out_percent: f64,
    /// Largest error of P2 and P4 with P1 and P3 fitted, percent.
    pub worst_held_out_percent: f64,
    /// Share of the mean square gap between finite elements and bench (in ln K) that it closes alone.
    #[serde(rename = "closes_of_gap")]
    pub closes: f64,
    /// Value at which it does.
    pub value_alone: f64,
}

/// A cell that would distinguish two candidates.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FurtherCell {
    /// The rival of the best candidate.
    pub rival: String,
    /// Angles of the pose by name, degrees.
    pub pose_deg: IndexMap<String, f64>,
    /// The direction.
    pub direction: Direction,
    /// How far the predictions differ, percent.
    pub difference_percent: f64,
    /// Error of ln K that the best candidate leaves in the twelve values, percent.
    #[serde(skip)]
    pub rms_percent: f64,
}

/// Finite elements over bench in one cell.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CellRatio {
    /// The pose.
    pub pose: PoseId,
    /// The direction.
    pub direction: Direction,
    /// Ratio of their stiffness.
    pub ratio: f64,
}

/// What the twelve values say.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct TwelveValues {
    /// Finite elements over bench, cell by cell.
    #[serde(rename = "elements_over_bench")]
    pub gap: Vec<CellRatio>,
    /// F that noise alone exceeds in 4 % of searches.
    pub f_limit: f64,
    /// The law that forward selection names.
    pub named: Option<String>,
    /// The beam factors alone.
    pub baseline: FittedLaw,
    /// The laws, the best fit first.
    pub candidates: Vec<FittedLaw>,
    /// Largest error on P2 and P4 that the paper prints for its own model, percent.
    pub paper_worst_percent: f64,
    /// Laws that are not distinguishable from the best.
    #[serde(rename = "not_told_apart")]
    pub not_distinguishable: usize,
    /// What would distinguish them.
    pub further: Vec<FurtherCell>,
}

#[derive(Debug, Deserialize)]
struct BenchRow {
    pose: String,
    direction: Direction,
    #[serde(rename = "experiment_N_per_um")]
    bench: f64,
    #[serde(rename = "m_fsd_N_per_um")]
    paper: f64,
}

#[derive(Debug, Deserialize)]
#[expect(non_snake_case, reason = "names of columns, which carry units")]
struct ReferenceReading {
    pose: String,
    direction: Direction,
    force_N: f64,
    displacement_um: f64,
}

fn rows<T: serde::de::DeserializeOwned>(name: &str, text: &str) -> Result<Vec<T>, ProveError> {
    csv::Reader::from_reader(text.as_bytes())
        .deserialize()
        .collect::<Result<_, _>>()
        .map_err(|error| ProveError::Form {
            file: name.to_owned(),
            problem: error.to_string(),
        })
}

/// Tries every linear law on the twelve stiffness values.
///
/// # Arguments
/// - `robot`: with the factor sets `m_fsd` and `s_fsd` and the paper's poses.
/// - `bench`: the paper's Table VI, measured and fitted (`data/paper/experiment-table-vi.csv`).
/// - `reference`: displacements of its finite elements (`data/paper/reference.csv`).
///
/// # Errors
/// [`ProveError`].
pub fn twelve_values(
    robot: &Robot,
    bench: &str,
    reference: &str,
    seed: u64,
) -> Result<TwelveValues, ProveError> {
    values_under(robot, bench, reference, seed, &|_| true)
}

/// The same with some of the laws.
fn values_under(
    robot: &Robot,
    bench: &str,
    reference: &str,
    seed: u64,
    is_asked_for: &dyn Fn(&LinearLaw) -> bool,
) -> Result<TwelveValues, ProveError> {
    let bench: Vec<BenchRow> = rows("experiment-table-vi.csv", bench)?;
    let reference: Vec<ReferenceReading> = rows("reference.csv", reference)?;
    let mut names: Vec<PoseId> = Vec::new();
    for row in &bench {
        let name = PoseId::new(&row.pose);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let place = |pose: &str| names.iter().position(|name| name.as_str() == pose);
    let cells: Vec<ListedStiffness> = bench
        .iter()
        .filter_map(|row| {
            Some(ListedStiffness {
                pose: place(&row.pose)?,
                direction: row.direction,
                ln_stiffness: (1e6 * row.bench).ln(),
            })
        })
        .collect();
    let poses: Vec<Pose> = names
        .iter()
        .map(|name| robot.pose(name).cloned())
        .collect::<Result<_, _>>()?;
    let problem = StiffnessProblem {
        robot,
        mechanism: robot.mechanism(None)?,
        start: robot.factor_set("m_fsd")?,
        poses,
        cells,
    };
    let elements: Vec<f64> = problem
        .cells
        .iter()
        .map(|cell| {
            let row = reference
                .iter()
                .find(|row| Some(cell.pose) == place(&row.pose) && row.direction == cell.direction);
            row.map_or(f64::NAN, |row| 1e-6 * row.displacement_um / row.force_N)
        })
        .collect();
    let judged = |pose: usize| !TRAIN.contains(&names[pose].as_str());
    let study = Study {
        problem: &problem,
        elements_m_per_n: &elements,
        judged: &judged,
    };
    let mut found = study.run(seed, is_asked_for)?;
    found.gap = problem
        .cells
        .iter()
        .zip(&elements)
        .map(|(cell, soft)| CellRatio {
            pose: names[cell.pose].clone(),
            direction: cell.direction,
            ratio: 1.0 / (soft * cell.ln_stiffness.exp()),
        })
        .collect();
    found.paper_worst_percent = bench
        .iter()
        .filter(|row| !TRAIN.contains(&row.pose.as_str()))
        .map(|row| 100.0 * (row.paper / row.bench - 1.0).abs())
        .fold(0.0, f64::max);
    Ok(found)
}

struct Study<'a> {
    problem: &'a StiffnessProblem<'a>,
    elements_m_per_n: &'a [f64],
    judged: &'a (dyn Fn(usize) -> bool + Sync),
}

impl Study<'_> {
    fn run(
        &self,
        seed: u64,
        is_asked_for: &dyn Fn(&LinearLaw) -> bool,
    ) -> Result<TwelveValues, ProveError> {
        let mut mechanics = self.problem.mechanics()?;
        let mut laws = LinearLaw::all(&mechanics, &self.problem.cells);
        laws.retain(is_asked_for);
        let (start, mut baseline) = self.candidate(None)?;
        let mut fitted: Vec<(LinearFit, FittedLaw)> = laws
            .par_iter()
            .map(|law| self.candidate(Some(law)))
            .collect::<Result<_, _>>()?;
        let fits: Vec<&LinearFit> = fitted.iter().map(|(fit, _)| fit).collect();
        let search =
            StiffnessSearch::new(self.problem, &mut mechanics, &laws, (&start, &fits), seed)?;
        let (selected, ranked) = selected(&search);
        let fall = |place: usize| {
            ranked
                .get(place)
                .map_or(0.0, |one| search.evidence(one).delta_chi2)
        };
        baseline.behind = 0.5 * fall(0);
        for (place, one) in ranked.iter().enumerate() {
            let (evidence, p) = search.weighed(one.law);
            let candidate = &mut fitted[one.law].1;
            candidate.f = evidence.delta_chi2;
            candidate.p_family = p;
            candidate.behind = 0.5 * (fall(0) - fall(place));
        }
        let alone = self.alone(&mut mechanics, &laws)?;
        for ((_, candidate), alone) in fitted.iter_mut().zip(alone) {
            (candidate.closes, candidate.value_alone) = alone;
        }
        let near = search.not_distinguishable(&ranked);
        Ok(TwelveValues {
            gap: Vec::new(),
            baseline,
            f_limit: search.critical_value(),
            named: selected.map(|law| fitted[law].1.title.clone()),
            paper_worst_percent: 0.0,
            not_distinguishable: near.len(),
            further: self.further(&laws, &fitted, &near)?,
            candidates: ranked.iter().map(|one| fitted[one.law].1.clone()).collect(),
        })
    }

    /// All fits of one law: to all values, with each pose left out, and to the paper's two poses.
    fn candidate(&self, law: Option<&LinearLaw>) -> Result<(LinearFit, FittedLaw), ProveError> {
        let mut mechanics = self.problem.mechanics()?;
        let all = self.problem.fit(&mut mechanics, law, &|_| true)?;
        let mut left_out = 0.0_f64;
        for pose in 0..self.problem.poses.len() {
            let fit = self.problem.fit(&mut mechanics, law, &|p| p != pose)?;
            let worst = self.worst(&mut mechanics, law, &fit, &|p| p == pose)?;
            left_out = left_out.max(worst);
        }
        let fit = self
            .problem
            .fit(&mut mechanics, law, &|p| !(self.judged)(p))?;
        let held_out = self.worst(&mut mechanics, law, &fit, self.judged)?;
        let values = self.problem.cells.len() as f64;
        let parameter = law.and_then(|law| law.law.parameters.first());
        let candidate = FittedLaw {
            title: law.map_or_else(
                || "beam factors alone".to_owned(),
                |law| title(law.law, &law.place),
            ),
            value: law.map_or(0.0, |law| law.unit * all.size),
            unit: parameter.map_or("1", |parameter| parameter.unit()),
            rms_percent: 100.0 * (all.squares / values).sqrt(),
            f: 0.0,
            p_family: 1.0,
            behind: 0.0,
            worst_left_out_percent: left_out,
            worst_held_out_percent: held_out,
            closes: 0.0,
            value_alone: 0.0,
        };
        Ok((all, candidate))
    }

    /// Largest |predicted/measured - 1| in some poses, percent.
    fn worst(
        &self,
        mechanics: &mut Mechanics<'_>,
        law: Option<&LinearLaw>,
        fit: &LinearFit,
        judged: &dyn Fn(usize) -> bool,
    ) -> Result<f64, ProveError> {
        let predicted = self.problem.predict(mechanics, law, fit)?;
        Ok(predicted
            .iter()
            .zip(&self.problem.cells)
            .filter(|(_, cell)| judged(cell.pose))
            .map(|(ln, cell)| 100.0 * ((ln - cell.ln_stiffness).exp() - 1.0).abs())
            .fold(0.0, f64::max))
    }

    /// For each law: share of the gap between finite elements and bench that it closes alone, and the value at which it does.
    fn alone(
        &self,
        mechanics: &mut Mechanics<'_>,
        laws: &[LinearLaw],
    ) -> Result<Vec<(f64, f64)>, ProveError> {
        let elements = self.problem.robot.factor_set("s_fsd")?;
        mechanics.set_factors(&elements)?;
        let gap = |added: &dyn Fn(usize) -> f64| -> f64 {
            self.problem
                .cells
                .iter()
                .enumerate()
                .map(|(place, cell)| {
                    let soft = self.elements_m_per_n[place] + added(place);
                    (soft.max(f64::MIN_POSITIVE).ln() + cell.ln_stiffness).powi(2)
                })
                .sum()
        };
        let before = gap(&|_| 0.0);
        Ok(laws
            .iter()
            .map(|law| {
                let at = |size: f64| {
                    gap(&|place| {
                        let cell = &self.problem.cells[place];
                        let pose = mechanics.pose(cell.pose);
                        law.compliance(pose, cell.direction, size)
                            - compliance(pose, cell.direction)
                    })
                };
                let size = smallest(&at, law.size_range());
                (1.0 - at(size) / before, law.unit * size)
            })
            .collect())
    }

    /// Cells in which the best candidate and its nearest rivals differ most, over a grid of poses.
    ///
    /// # Arguments
    /// - `near`: numbers of the laws, the best first.
    fn further(
        &self,
        laws: &[LinearLaw],
        fitted: &[(LinearFit, FittedLaw)],
        near: &[usize],
    ) -> Result<Vec<FurtherCell>, ProveError> {
        let poses = grid(self.problem.robot, self.problem);
        let cells: Vec<ListedStiffness> = (0..poses.len())
            .flat_map(|pose| {
                Direction::ALL.map(|direction| ListedStiffness {
                    pose,
                    direction,
                    ln_stiffness: 0.0,
                })
            })
            .collect();
        let problem = StiffnessProblem {
            robot: self.problem.robot,
            mechanism: self.problem.mechanism,
            start: self.problem.start.clone(),
            poses,
            cells,
        };
        let mut mechanics = problem.mechanics()?;
        let mut predicted =
            |law: usize| problem.predict(&mut mechanics, Some(&laws[law]), &fitted[law].0);
        let Some((&best, rivals)) = near.split_first() else {
            return Ok(Vec::new());
        };
        let own = predicted(best)?;
        let mut found = Vec::new();
        for &rival in rivals.iter().take(RIVALS) {
            let other = predicted(rival)?;
            let widest = own
                .iter()
                .zip(&other)
                .map(|(a, b)| (a - b).abs())
                .enumerate()
                .max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((place, difference)) = widest else {
                continue;
            };
            let cell = &problem.cells[place];
            found.push(FurtherCell {
                rival: fitted[rival].1.title.clone(),
                pose_deg: self
                    .problem
                    .robot
                    .variables
                    .iter()
                    .zip(&problem.poses[cell.pose].angles_deg)
                    .map(|(variable, angle)| (variable.name.clone(), *angle))
                    .collect(),
                direction: cell.direction,
                difference_percent: 100.0 * (difference.exp() - 1.0),
                rms_percent: fitted[best].1.rms_percent,
            });
        }
        Ok(found)
    }
}

/// The law that forward selection names, and all laws under the variance that the best of them leaves, the largest evidence first.
fn selected(search: &StiffnessSearch) -> (Option<usize>, Vec<FittedCandidate>) {
    let found = || {
        let start = search.start();
        let scores = search.score(&start)?;
        let named = forward_selection(search, &start, &scores)?.model.law;
        let ranked = search.rank(&start, &scores, f64::NEG_INFINITY)?;
        let best = match ranked.first() {
            Some(first) => search.with(first)?,
            None => None,
        };
        let ranked = match &best {
            Some(best) => rivals(search, best, 0)?,
            None => ranked,
        };
        Ok((named, ranked))
    };
    found().unwrap_or_else(|never: Infallible| match never {})
}

#[cfg(test)]
mod tests;
