//! The cheapest change of the sections that lifts the least or the mean stiffness by a wanted share.
//!
//! The stiffness in every pose is linearised in the logarithms of the section constants, the cheapest change that lifts the
//! linearised ones is found, all poses are solved again with it, those that are lowest now join, and so on until nothing moves.

use crate::distribution::map::{MapColumn, MapModel, NoMap, StiffnessMap};
use crate::distribution::pose_set::PoseSet;
use stiffbench_beams::robot::{JointModel, Masses, MechanismModel, Robot, RobotError, Theory};

use super::cheapest::{Demand, Price, cheapest};
use super::sensitivity::{log_gradients, of_mean, poses_of, rows_of_mean, sections_of};

/// No constant is changed by more than this factor, up or down: what is wanted beyond that is another robot.
const LARGEST_FACTOR: f64 = 10.0;
/// Poses with the least stiffness that join at each step.
const JOINING: usize = 24;
/// Poses kept at most.
const MOST_KEPT: usize = 120;
/// Steps before giving up. Some five to ten are usual.
const MOST_STEPS: usize = 60;
/// A step that changes every constant by less than this share is the last.
const SETTLED: f64 = 1e-6;
/// What is aimed at lies this share above what is wanted, so that rounding leaves nothing missing.
const MARGIN: f64 = 1e-7;

/// What is to rise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DesignGoal {
    /// The least stiffness over all poses.
    Smallest,
    /// The mean stiffness.
    Mean,
}

/// What is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lift {
    /// Of what.
    pub goal: DesignGoal,
    /// Axis of the stiffness: 0 is x.
    pub axis: usize,
    /// Wanted rise as a share: 0.2 is 20 %.
    pub by: f64,
}

/// What a change costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DesignCost {
    /// Half the sum of the squares of ln factor over all constants of all sections: many small changes are cheaper than one large.
    Change,
    /// Added mass. A section keeps its shape: where its area grows by a factor, Iy, Iz and J grow by its square. Nothing shrinks.
    Mass,
}

/// Factors on the constants of a section, order A, Iy, Iz, J.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionChange {
    /// The section.
    pub section: String,
    /// The factors.
    pub factors: [f64; 4],
}

/// A change that does what is wanted.
#[derive(Debug, Clone)]
pub struct LiftedDesign {
    /// What was wanted.
    pub wanted: Lift,
    /// What cost was made least.
    pub cost: DesignCost,
    /// That cost: half the sum of squares, or kg.
    pub cost_value: f64,
    /// Stiffness before, N/m.
    pub before_n_per_m: f64,
    /// Stiffness that the derivatives at the start predict for the change, N/m; for the least stiffness, of the poses that came into
    /// question.
    pub predicted_n_per_m: f64,
    /// Stiffness of the changed robot, solved again in all poses, N/m.
    pub after_n_per_m: f64,
    /// Every section of the mechanism.
    pub changes: Vec<SectionChange>,
    /// Steps it took.
    pub steps: usize,
    /// The changed robot.
    pub robot: Robot,
}

/// Why there is no design.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum NoDesign {
    /// The robot cannot be built or solved.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Robot(#[from] RobotError),
    /// There is no map of it.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Map(#[from] NoMap),
    /// Laws that are not linear have no derivatives here.
    #[error("the model has a law that is not linear: its stiffness has no derivatives to follow")]
    #[diagnostic(
        code(stiffbench::distribution::design_not_linear),
        help("design with the linear laws alone, and map the result with all of them")
    )]
    NotLinear,
    /// No change is enough.
    #[error(
        "no change of the sections within a factor of {LARGEST_FACTOR} lifts it by {percent} %"
    )]
    #[diagnostic(
        code(stiffbench::distribution::design_out_of_reach),
        help("ask for less; `map --design` without --lift shows what the stiffness depends on")
    )]
    OutOfReach {
        /// What was wanted.
        percent: f64,
    },
    /// It did not settle.
    #[error("the change did not settle in {MOST_STEPS} steps")]
    #[diagnostic(
        code(stiffbench::distribution::design_unsettled),
        help("ask for a smaller lift, or try the other cost")
    )]
    Unsettled,
    /// A cost in mass without masses.
    #[error("these sections have no mass: {}", sections.join(", "))]
    #[diagnostic(
        code(stiffbench::distribution::design_no_mass),
        help(
            "add mass_per_m (kg/m) to these sections of the robot file, or density (kg/m3) to their material"
        )
    )]
    NoMass {
        /// Sections of the mechanism without mass.
        sections: Vec<String>,
    },
}

/// The variables of the search and how they move the constants.
struct Variables {
    /// Sections by index.
    sections: Vec<usize>,
    prices: Vec<Price>,
    cost: DesignCost,
}

impl Variables {
    fn of(model: &MapModel<'_>, poses: &PoseSet, cost: DesignCost) -> Result<Self, NoDesign> {
        let (robot, mechanism) = (model.robot(), model.mechanism());
        let sections = sections_of(robot, mechanism);
        let prices = match cost {
            DesignCost::Change => vec![Price::Square; 4 * sections.len()],
            DesignCost::Mass => growth_prices(model, poses, &sections)?,
        };
        Ok(Self {
            sections,
            prices,
            cost,
        })
    }

    /// Factors on A, Iy, Iz, J of each section.
    fn factors(&self, x: &[f64]) -> Vec<[f64; 4]> {
        match self.cost {
            DesignCost::Change => x
                .chunks(4)
                .map(|x| std::array::from_fn(|i| x[i].exp()))
                .collect(),
            DesignCost::Mass => x
                .iter()
                .map(|x| [x.exp(), (2.0 * x).exp(), (2.0 * x).exp(), (2.0 * x).exp()])
                .collect(),
        }
    }

    /// Gradient to the variables from that to the logarithms of the constants.
    fn gains(&self, by_constant: &[[f64; 4]]) -> Vec<f64> {
        match self.cost {
            DesignCost::Change => by_constant.concat(),
            DesignCost::Mass => by_constant
                .iter()
                .map(|[a, iy, iz, j]| a + 2.0 * (iy + iz + j))
                .collect(),
        }
    }

    fn cost(&self, x: &[f64]) -> f64 {
        let pairs = self.prices.iter().zip(x);
        pairs
            .map(|(price, x)| match price {
                Price::Square => 0.5 * x * x,
                Price::Growth { weight } => weight * x.exp_m1(),
            })
            .sum()
    }

    /// The robot with its sections changed.
    fn changed(&self, robot: &Robot, x: &[f64]) -> Robot {
        let mut changed = robot.clone();
        for (&section, factors) in self.sections.iter().zip(self.factors(x)) {
            let section = &mut changed.sections[section];
            section.section = section.section.scaled(factors);
            let [area, ..] = factors;
            section.mass_kg_per_m = section.mass_kg_per_m.map(|mass| mass * area);
        }
        changed
    }

    fn changes(&self, robot: &Robot, x: &[f64]) -> Vec<SectionChange> {
        let names = robot.sections.keys().collect::<Vec<_>>();
        let pairs = self.sections.iter().zip(self.factors(x));
        pairs
            .map(|(&section, factors)| SectionChange {
                section: names[section].clone(),
                factors,
            })
            .collect()
    }

    /// Largest change of a variable: none of its constants passes the largest factor.
    fn bound(&self) -> f64 {
        match self.cost {
            DesignCost::Change => LARGEST_FACTOR.ln(),
            DesignCost::Mass => 0.5 * LARGEST_FACTOR.ln(),
        }
    }
}

/// Price of each section's growth: the mass of its members, kg.
fn growth_prices(
    model: &MapModel<'_>,
    poses: &PoseSet,
    sections: &[usize],
) -> Result<Vec<Price>, NoDesign> {
    let (robot, mechanism) = (model.robot(), model.mechanism());
    let lacking = Masses::of(robot, mechanism).unweighed;
    if !lacking.is_empty() {
        return Err(NoDesign::NoMass { sections: lacking });
    }
    let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
    let mut placed = MechanismModel::new(robot, mechanism, &joints, theory, model.factors())?;
    // Members keep their length from pose to pose.
    placed.place(&poses.pose(0))?;
    let masses = placed.masses_of_members_kg();
    let mass = |section: &usize| {
        let members = mechanism.members.iter().zip(&masses);
        let own = members.filter(|(member, _)| robot.members[**member].section == *section);
        own.map(|(_, mass)| mass).sum()
    };
    let prices = sections.iter().map(|section| Price::Growth {
        weight: mass(section),
    });
    Ok(prices.collect())
}

/// What is to rise at one change of the robot, and how the change moves it.
struct Point {
    /// Stiffness that is to rise, N/m.
    goal_n_per_m: f64,
    /// Stiffness and gradient of its logarithm, of all that must rise: a mean is one, a minimum every pose that may be it.
    parts: Vec<(f64, Vec<f64>)>,
}

impl Point {
    /// Σ gain (x' - x) ≥ ln target - ln K for every part.
    fn demands(&self, x: &[f64], target: f64) -> Vec<Demand> {
        let demand = |(value, gains): &(f64, Vec<f64>)| Demand {
            at_least: (target / value).ln() + product(gains, x),
            gains: gains.clone(),
        };
        self.parts.iter().map(demand).collect()
    }

    /// Stiffness that the gradients here predict for a change by x, N/m.
    fn predicted_n_per_m(&self, x: &[f64]) -> f64 {
        let parts = self.parts.iter();
        let predicted = parts.map(|(value, gains)| value * product(gains, x).exp());
        predicted.fold(f64::INFINITY, f64::min)
    }
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A search for the cheapest change.
struct Search<'m, 'a> {
    model: &'m MapModel<'a>,
    poses: &'m PoseSet,
    wanted: Lift,
    variables: Variables,
    /// Rows that were among the lowest once.
    kept: Vec<usize>,
}

impl Search<'_, '_> {
    /// Solves all poses of the robot as it is changed by x, and linearises what is to rise.
    fn point(&mut self, robot: &Robot) -> Result<Point, NoDesign> {
        let model = self.model.of_robot(robot)?;
        let joints = model.joints().ok_or(NoDesign::NotLinear)?;
        let columns = [MapColumn::axes().swap_remove(self.wanted.axis)];
        let map = StiffnessMap::over(&model, self.poses, &columns)?;
        let rows = match self.wanted.goal {
            DesignGoal::Mean => rows_of_mean(&map),
            DesignGoal::Smallest => {
                keep_lowest(&map, &mut self.kept);
                self.kept.clone()
            }
        };
        let poses = poses_of(&map, self.poses, &rows);
        let gradients = log_gradients(&model, joints, &poses, self.wanted.axis)?;
        let gains = gradients
            .iter()
            .map(|gradient| self.variables.gains(gradient));
        let values = rows.iter().map(|&row| map.stiffness_n_per_m(row, 0));
        Ok(match self.wanted.goal {
            DesignGoal::Mean => {
                let mean = map.column(0).sum::<f64>() / map.len() as f64;
                let gains = of_mean(&gains.collect::<Vec<_>>(), &values.collect::<Vec<_>>());
                Point {
                    goal_n_per_m: mean,
                    parts: vec![(mean, gains)],
                }
            }
            DesignGoal::Smallest => Point {
                goal_n_per_m: map.column(0).fold(f64::INFINITY, f64::min),
                parts: values.zip(gains).collect(),
            },
        })
    }
}

/// The cheapest change that lifts the stiffness.
///
/// # Errors
/// [`NoDesign`].
pub fn lift(
    model: &MapModel<'_>,
    poses: &PoseSet,
    wanted: Lift,
    cost: DesignCost,
) -> Result<LiftedDesign, NoDesign> {
    let mut search = Search {
        model,
        poses,
        wanted,
        variables: Variables::of(model, poses, cost)?,
        kept: Vec::new(),
    };
    let start = search.point(model.robot())?;
    let found = search.settle(&start)?;
    Ok(LiftedDesign {
        wanted,
        cost,
        cost_value: search.variables.cost(&found.x),
        before_n_per_m: start.goal_n_per_m,
        predicted_n_per_m: start.predicted_n_per_m(&found.x),
        after_n_per_m: found.after_n_per_m,
        changes: search.variables.changes(model.robot(), &found.x),
        steps: found.steps,
        robot: found.robot,
    })
}

/// Where a search ended.
struct Settled {
    x: Vec<f64>,
    robot: Robot,
    after_n_per_m: f64,
    steps: usize,
}

impl Search<'_, '_> {
    /// Goes from linearisation to linearisation until nothing moves.
    fn settle(&mut self, start: &Point) -> Result<Settled, NoDesign> {
        let mut x = vec![0.0; self.variables.prices.len()];
        let mut robot = self.model.robot().clone();
        let mut here_n_per_m = start.goal_n_per_m;
        let least_n_per_m = start.goal_n_per_m * (1.0 + self.wanted.by);
        let target_n_per_m = least_n_per_m * (1.0 + MARGIN);
        let mut demands = start.demands(&x, target_n_per_m);
        for steps in 0..MOST_STEPS {
            let (prices, bound) = (&self.variables.prices, self.variables.bound());
            let next = cheapest(prices, &demands, bound).ok_or(NoDesign::OutOfReach {
                percent: 100.0 * self.wanted.by,
            })?;
            let moves = x.iter().zip(&next).map(|(a, b)| (a - b).abs());
            if moves.fold(0.0, f64::max) < SETTLED && here_n_per_m >= least_n_per_m {
                return Ok(Settled {
                    x,
                    robot,
                    after_n_per_m: here_n_per_m,
                    steps,
                });
            }
            // Half steps once it should have settled: it may be swinging between two sets of lowest poses.
            let share = if steps < MOST_STEPS / 3 { 1.0 } else { 0.5 };
            for (x, next) in x.iter_mut().zip(&next) {
                *x += share * (next - *x);
            }
            robot = self.variables.changed(self.model.robot(), &x);
            let here = self.point(&robot)?;
            here_n_per_m = here.goal_n_per_m;
            demands = here.demands(&x, target_n_per_m);
        }
        Err(NoDesign::Unsettled)
    }
}

/// Adds the rows that are lowest now to those that ever were.
fn keep_lowest(map: &StiffnessMap, kept: &mut Vec<usize>) {
    let mut rows: Vec<usize> = (0..map.len()).collect();
    let value = |row: &usize| map.stiffness_n_per_m(*row, 0);
    let count = JOINING.min(rows.len());
    if count < rows.len() {
        rows.select_nth_unstable_by(count, |a, b| value(a).total_cmp(&value(b)));
    }
    rows.truncate(count);
    rows.sort_unstable();
    for row in rows {
        if !kept.contains(&row) {
            kept.push(row);
        }
    }
    if kept.len() > MOST_KEPT {
        kept.sort_unstable_by(|a, b| value(a).total_cmp(&value(b)));
        kept.truncate(MOST_KEPT);
    }
}
