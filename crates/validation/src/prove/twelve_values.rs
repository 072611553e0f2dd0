//! What the paper's twelve stiffness values can show of missing physics, and what they cannot.
//!
//! The paper's finite elements and its bench differ by a factor of 2 to 4 (Table V against Table VI). Two questions are asked of every linear
//! law: how much of that gap it closes alone, the finite elements left as they are; and whether it still improves anything once the beam
//! factors have been fitted to the bench, as the paper does.

use rayon::prelude::*;
use serde::Deserialize;

use stiffbench_beams::physics::{Mechanics, PoseMechanics, title};
use stiffbench_beams::robot::{Pose, Robot};
use stiffbench_diagnosis::search::constants::STRONG_EVIDENCE;
use stiffbench_diagnosis::search::{
    Covariance, LinearCandidate, NullDistribution, NullNoise, WhiteSpace, null_maxima,
};
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::error::ProveError;
use super::linear_model::{
    LinearFit, LinearLaw, ListedStiffness, StiffnessProblem, compliance, grid,
};
use super::smallest::smallest;

/// Poses that the paper fits; it judges on the others.
const TRAIN: [&str; 2] = ["P1", "P3"];

/// Null samples.
const NULL_SAMPLES: usize = 20_000;

/// Level of the search over all laws.
const LEVEL: f64 = 0.04;

/// Candidates for which a further measurement is searched for.
const RIVALS: usize = 5;

/// A law and what it does to the fit of the twelve values.
#[derive(Debug, Clone, PartialEq)]
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
    /// Chance that noise alone gives any law as much.
    pub p_family: f64,
    /// Logarithm of the likelihood ratio of the best candidate to this one.
    pub behind: f64,
    /// Largest error of the cells left out pose by pose, percent.
    pub worst_left_out_percent: f64,
    /// Largest error of P2 and P4 with P1 and P3 fitted, percent.
    pub worst_held_out_percent: f64,
    /// Share of the mean square gap between finite elements and bench (in ln K) that it closes alone.
    pub closes: f64,
    /// Value at which it does.
    pub value_alone: f64,
}

/// A cell that would distinguish two candidates.
#[derive(Debug, Clone, PartialEq)]
pub struct FurtherCell {
    /// The rival of the best candidate.
    pub rival: String,
    /// Angles of the pose, name and degrees.
    pub pose: Vec<(String, f64)>,
    /// The direction.
    pub direction: Direction,
    /// How far the predictions differ, percent.
    pub difference_percent: f64,
    /// Error of ln K that the best candidate leaves in the twelve values, percent.
    pub rms_percent: f64,
}

/// What the twelve values say.
#[derive(Debug, Clone, PartialEq)]
pub struct TwelveValues {
    /// Finite elements over bench, cell by cell: pose, direction, ratio of stiffness.
    pub gap: Vec<(PoseId, Direction, f64)>,
    /// The beam factors alone.
    pub baseline: FittedLaw,
    /// The laws, the best fit first.
    pub candidates: Vec<FittedLaw>,
    /// F that noise alone exceeds in 4 % of searches.
    pub f_limit: f64,
    /// Largest error on P2 and P4 that the paper prints for its own model, percent.
    pub paper_worst_percent: f64,
    /// Laws that are not distinguishable from the best.
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
        .map(|(cell, soft)| {
            let ratio = 1.0 / (soft * cell.ln_stiffness.exp());
            (names[cell.pose].clone(), cell.direction, ratio)
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
        let (baseline_fit, mut baseline) = self.candidate(None)?;
        let null = self.largest_f(&mut mechanics, &laws, &baseline_fit, seed)?;
        let alone: Vec<(f64, f64)> = self.alone(&mut mechanics, &laws)?;
        let mut fitted: Vec<(usize, LinearFit, FittedLaw)> = (0..laws.len())
            .into_par_iter()
            .map(|index| {
                let (fit, candidate) = self.candidate(Some(&laws[index]))?;
                Ok((index, fit, candidate))
            })
            .collect::<Result<_, ProveError>>()?;
        fitted.sort_by(|a, b| a.1.squares.total_cmp(&b.1.squares));
        let values = self.problem.cells.len() as f64;
        let best = fitted.first().map_or(f64::NAN, |(_, fit, _)| fit.squares);
        for (index, fit, candidate) in &mut fitted {
            let dof = values - 5.0;
            let delta_chi2 = (baseline_fit.squares - fit.squares).max(0.0);
            candidate.f = delta_chi2 / (fit.squares / dof);
            candidate.p_family = null.p(candidate.f);
            candidate.behind = 0.5 * values * (fit.squares / best).ln();
            (candidate.closes, candidate.value_alone) = alone[*index];
        }
        baseline.behind = 0.5 * values * (baseline_fit.squares / best).ln();
        let near: Vec<usize> = (0..fitted.len())
            .filter(|&place| fitted[place].2.behind < STRONG_EVIDENCE)
            .collect();
        let further = self.further(&laws, &fitted, &near)?;
        Ok(TwelveValues {
            gap: Vec::new(),
            baseline,
            f_limit: null.quantile(1.0 - LEVEL),
            paper_worst_percent: 0.0,
            not_distinguishable: near.len(),
            further,
            candidates: fitted.into_iter().map(|(_, _, c)| c).collect(),
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

    /// Largest F of any law on noise alone: the linear problem at the fitted factors.
    fn largest_f(
        &self,
        mechanics: &mut Mechanics<'_>,
        laws: &[LinearLaw],
        fit: &LinearFit,
        seed: u64,
    ) -> Result<NullDistribution, ProveError> {
        self.problem.predict(mechanics, None, fit)?;
        let cells = &self.problem.cells;
        let column = |of: &dyn Fn(&PoseMechanics, Direction) -> f64| -> Vec<f64> {
            let relative = |cell: &ListedStiffness| {
                let pose = mechanics.pose(cell.pose);
                of(pose, cell.direction) / compliance(pose, cell.direction)
            };
            cells.iter().map(relative).collect()
        };
        let factor = |factor: usize| {
            column(&|pose, direction| pose.compliance_gradient[factor][direction.index()])
        };
        let factors: Vec<Vec<f64>> = (0..4).map(factor).collect();
        let candidate = |law: &LinearLaw| LinearCandidate {
            family: (),
            columns: vec![column(&|pose, direction| law.softening(pose, direction))],
            multiples: if law.size_range()[0] < 0.0 {
                [f64::NEG_INFINITY, f64::INFINITY]
            } else {
                [0.0, f64::INFINITY]
            },
        };
        let candidates: Vec<LinearCandidate<()>> = laws.iter().map(candidate).collect();
        let space = WhiteSpace::new(Covariance::equal(cells.len(), 1.0), &[], &factors);
        let dof = (cells.len() - space.basis().len() - 1) as f64;
        let noise = NullNoise::normal(NULL_SAMPLES, seed);
        let (_, maxima) = null_maxima(&space, &candidates, &noise);
        let of_samples = maxima.families.first().into_iter().flatten();
        let f = of_samples
            .zip(&maxima.squares)
            .map(|(delta_chi2, squares)| delta_chi2 / ((squares - delta_chi2) / dof));
        Ok(NullDistribution::new(f.collect()))
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
    fn further(
        &self,
        laws: &[LinearLaw],
        fitted: &[(usize, LinearFit, FittedLaw)],
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
        let mut predicted = |place: usize| {
            let (law, fit, _) = &fitted[place];
            problem.predict(&mut mechanics, Some(&laws[*law]), fit)
        };
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
                rival: fitted[rival].2.title.clone(),
                pose: self
                    .problem
                    .robot
                    .variables
                    .iter()
                    .zip(&problem.poses[cell.pose].angles_deg)
                    .map(|(variable, angle)| (variable.name.clone(), *angle))
                    .collect(),
                direction: cell.direction,
                difference_percent: 100.0 * (difference.exp() - 1.0),
                rms_percent: fitted[best].2.rms_percent,
            });
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests;
