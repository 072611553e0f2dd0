//! Stiffness of the cells of a robot with one linear law in it: what stiffness values alone can be fitted with.

use stiffbench_beams::physics::{Law, Mechanics, Place, PoseMechanics, laws};
use stiffbench_beams::robot::{FittingFactors, Mechanism, Pose, Robot, RobotError};
use stiffbench_numeric::least_squares::{
    EvaluationFailure, JacobianView, LeastSquaresFit, LeastSquaresSettings, Parameter,
    ParameterSet, ResidualFunction, minimise,
};
use stiffbench_units_and_text::test_point::Direction;

use super::error::ProveError;

/// Bounds of the beam factors, as multiples of their start, logarithms.
const FACTOR_ROOM: f64 = std::f64::consts::LN_10;

/// Largest size: the law alone is this many times as soft as the structure in the cell where it matters most.
const LARGEST_SIZE: f64 = 50.0;

/// Largest angle of a load, rad.
const LARGEST_ANGLE: f64 = 0.3;

/// Sizes to start from; the better minimum counts.
const STARTS: [f64; 2] = [0.03, 1.0];

/// Step of the differences that give derivatives.
const STEP: f64 = 1e-5;

/// A linear law at a place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LinearLaw {
    pub(super) law: Law,
    pub(super) place: Place,
    /// Place among the joints of the mechanics, for a joint.
    joint: usize,
    /// Value of the law's parameter per unit of size.
    pub(super) unit: f64,
}

/// A measured stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ListedStiffness {
    pub(super) pose: usize,
    pub(super) direction: Direction,
    pub(super) ln_stiffness: f64,
}

/// What is known of a candidate's fit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LinearFit {
    /// Logarithms of the beam factors.
    pub(super) ln_factors: [f64; 4],
    /// Size in units of the law.
    pub(super) size: f64,
    /// Sum of the squared residuals of ln K.
    pub(super) squares: f64,
}

/// Whether a law turns the force.
fn is_turn(law: Law) -> bool {
    law == laws::LOAD_MISALIGNMENT
}

impl LinearLaw {
    /// Every linear law at every place that matters in some cell.
    pub(super) fn all(mechanics: &Mechanics<'_>, cells: &[ListedStiffness]) -> Vec<Self> {
        let mut found = Vec::new();
        for (joint, name) in mechanics.joint_names().enumerate() {
            let place = Place::Joint(name.to_owned());
            found.push((laws::JOINT_COMPLIANCE, place, joint));
        }
        for axis in mechanics.robot().rocking_axes() {
            found.push((laws::BASE_COMPLIANCE, Place::Axis(axis), 0));
        }
        for direction in Direction::ALL {
            found.push((laws::GAUGE_STAND_COMPLIANCE, Place::Direction(direction), 0));
            for toward in Direction::ALL.into_iter().filter(|t| *t != direction) {
                let place = Place::Toward { direction, toward };
                found.push((laws::LOAD_MISALIGNMENT, place, 0));
            }
        }
        found
            .into_iter()
            .filter_map(|(law, place, joint)| {
                let mut one = Self {
                    law,
                    place,
                    joint,
                    unit: 1.0,
                };
                let largest = cells
                    .iter()
                    .map(|cell| {
                        let pose = mechanics.pose(cell.pose);
                        one.softening(pose, cell.direction).abs() / compliance(pose, cell.direction)
                    })
                    .fold(0.0, f64::max);
                // Below a millionth nothing is there but rounding.
                if largest < 1e-6 {
                    return None;
                }
                if !is_turn(law) {
                    one.unit = 1.0 / largest;
                }
                Some(one)
            })
            .collect()
    }

    /// Compliance in a cell per small value of the parameter.
    pub(super) fn softening(&self, pose: &PoseMechanics, direction: Direction) -> f64 {
        let axis = direction.index();
        match &self.place {
            Place::Joint(_) => pose.influence.levers[self.joint][axis].powi(2),
            Place::Axis(about) => pose.base_levers[about.index()][axis].powi(2),
            Place::Direction(own) => f64::from(u8::from(*own == direction)),
            Place::Toward {
                direction: own,
                toward,
            } if *own == direction => pose.influence.compliance[axis][toward.index()],
            _ => 0.0,
        }
    }

    /// Compliance of a cell with the law at a size, m/N.
    pub(super) fn compliance(&self, pose: &PoseMechanics, direction: Direction, size: f64) -> f64 {
        let rigid = compliance(pose, direction);
        let value = size * self.unit;
        match &self.place {
            Place::Joint(_) => {
                let held = pose.influence.stiffness(self.joint, self.joint).max(0.0);
                rigid + value * self.softening(pose, direction) / (1.0 + value * held)
            }
            Place::Toward { direction: own, .. } if *own == direction => {
                rigid * value.cos() + self.softening(pose, direction) * value.sin()
            }
            _ => rigid + value * self.softening(pose, direction),
        }
    }

    pub(super) fn size_range(&self) -> [f64; 2] {
        if is_turn(self.law) {
            [-LARGEST_ANGLE, LARGEST_ANGLE]
        } else {
            [0.0, LARGEST_SIZE]
        }
    }
}

/// Compliance of the structure alone, m/N.
pub(super) fn compliance(pose: &PoseMechanics, direction: Direction) -> f64 {
    let axis = direction.index();
    pose.influence.compliance[axis][axis]
}

/// A robot in its poses, to be fitted to stiffness values.
pub(super) struct StiffnessProblem<'a> {
    pub(super) robot: &'a Robot,
    pub(super) mechanism: &'a Mechanism,
    pub(super) start: FittingFactors,
    pub(super) poses: Vec<Pose>,
    pub(super) cells: Vec<ListedStiffness>,
}

impl StiffnessProblem<'_> {
    /// The mechanics at the start.
    ///
    /// # Errors
    /// [`ProveError::Robot`].
    pub(super) fn mechanics(&self) -> Result<Mechanics<'_>, ProveError> {
        let poses = &self.poses;
        Ok(Mechanics::new(
            self.robot,
            self.mechanism,
            &self.start,
            poses,
        )?)
    }

    /// Fits beam factors, and the size of a law, to the cells of some poses.
    ///
    /// # Errors
    /// [`ProveError`].
    pub(super) fn fit(
        &self,
        mechanics: &mut Mechanics<'_>,
        law: Option<&LinearLaw>,
        train: &dyn Fn(usize) -> bool,
    ) -> Result<LinearFit, ProveError> {
        let cells: Vec<ListedStiffness> = self
            .cells
            .iter()
            .filter(|cell| train(cell.pose))
            .copied()
            .collect();
        let mut best: Option<LeastSquaresFit> = None;
        let starts: &[f64] = if law.is_some() { &STARTS } else { &[0.0] };
        for start in starts {
            let set = self.parameters(law, *start)?;
            let mut residuals = StiffnessResiduals {
                mechanics,
                factors: self.start.clone(),
                cells: &cells,
                law,
            };
            let settings = LeastSquaresSettings::for_refits();
            let fit = minimise(&mut residuals, &set, &settings)?;
            if best.as_ref().is_none_or(|b| fit.objective < b.objective) {
                best = Some(fit);
            }
        }
        let fit = best.ok_or_else(|| ProveError::Form {
            file: "stiffness values".to_owned(),
            problem: "there is no start to fit from".to_owned(),
        })?;
        let mut ln_factors = [0.0; 4];
        ln_factors.copy_from_slice(&fit.values[..4]);
        Ok(LinearFit {
            ln_factors,
            size: fit.values[4],
            squares: 2.0 * fit.objective,
        })
    }

    fn parameters(&self, law: Option<&LinearLaw>, start: f64) -> Result<ParameterSet, ProveError> {
        let mut parameters: Vec<Parameter> = ["A", "Iy", "Iz", "J"]
            .into_iter()
            .zip(self.start.beam)
            .map(|(name, factor)| {
                let ln = factor.ln();
                Parameter::free(name, ln, ln - FACTOR_ROOM, ln + FACTOR_ROOM)
            })
            .collect();
        parameters.push(match law {
            None => Parameter::fixed("size", 0.0),
            Some(law) => {
                let [low, high] = law.size_range();
                let start = if is_turn(law.law) {
                    0.1 * start * high
                } else {
                    start
                };
                Parameter::free("size", start, low, high)
            }
        });
        Ok(ParameterSet::new(parameters)?)
    }

    /// ln of the predicted stiffness of the cells of all poses.
    ///
    /// # Errors
    /// [`ProveError::Robot`].
    pub(super) fn predict(
        &self,
        mechanics: &mut Mechanics<'_>,
        law: Option<&LinearLaw>,
        fit: &LinearFit,
    ) -> Result<Vec<f64>, ProveError> {
        set_factors(mechanics, self.start.clone(), &fit.ln_factors)?;
        Ok(self
            .cells
            .iter()
            .map(|cell| ln_stiffness(mechanics, law, cell, fit.size))
            .collect())
    }
}

fn set_factors(
    mechanics: &mut Mechanics<'_>,
    start: FittingFactors,
    ln_factors: &[f64],
) -> Result<(), RobotError> {
    let mut factors = start;
    for (factor, ln) in factors.beam.iter_mut().zip(ln_factors) {
        *factor = ln.exp();
    }
    mechanics.set_factors(&factors)
}

fn ln_stiffness(
    mechanics: &Mechanics<'_>,
    law: Option<&LinearLaw>,
    cell: &ListedStiffness,
    size: f64,
) -> f64 {
    let pose = mechanics.pose(cell.pose);
    let soft = match law {
        None => compliance(pose, cell.direction),
        Some(law) => law.compliance(pose, cell.direction, size),
    };
    -soft.ln()
}

/// ln K predicted less measured.
struct StiffnessResiduals<'p, 'm> {
    mechanics: &'p mut Mechanics<'m>,
    factors: FittingFactors,
    cells: &'p [ListedStiffness],
    law: Option<&'p LinearLaw>,
}

impl StiffnessResiduals<'_, '_> {
    fn at(&mut self, parameters: &[f64], out: &mut [f64]) -> Result<(), EvaluationFailure> {
        set_factors(self.mechanics, self.factors.clone(), &parameters[..4])
            .map_err(EvaluationFailure::of_model)?;
        for (value, cell) in out.iter_mut().zip(self.cells) {
            *value =
                ln_stiffness(self.mechanics, self.law, cell, parameters[4]) - cell.ln_stiffness;
        }
        Ok(())
    }
}

impl ResidualFunction for StiffnessResiduals<'_, '_> {
    fn residual_count(&self) -> usize {
        self.cells.len()
    }

    fn evaluate(
        &mut self,
        parameters: &[f64],
        residuals: &mut [f64],
        jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        if let Some(jacobian) = jacobian {
            let mut moved = parameters.to_vec();
            let (mut up, mut down) = (residuals.to_vec(), residuals.to_vec());
            for parameter in 0..parameters.len() {
                let Some(column) = jacobian.column_mut(parameter) else {
                    continue;
                };
                let step = STEP * parameters[parameter].abs().max(1.0);
                moved[parameter] = parameters[parameter] + step;
                self.at(&moved, &mut up)?;
                moved[parameter] = parameters[parameter] - step;
                self.at(&moved, &mut down)?;
                moved[parameter] = parameters[parameter];
                for ((entry, up), down) in column.iter_mut().zip(&up).zip(&down) {
                    *entry = (up - down) / (2.0 * step);
                }
            }
        }
        self.at(parameters, residuals)
    }
}

/// Values of each variable that are tried for a further measurement.
const GRID: usize = 5;

/// Poses over the ranges of the variables that differ between the measured poses, within the robot's limits and within reach.
pub(super) fn grid(robot: &Robot, problem: &StiffnessProblem<'_>) -> Vec<Pose> {
    let Some(first) = problem.poses.first() else {
        return Vec::new();
    };
    let mut poses = vec![first.clone()];
    for (place, variable) in robot.variables.iter().enumerate() {
        let moves = problem
            .poses
            .iter()
            .any(|pose| pose.angles_deg[place] != first.angles_deg[place]);
        if !moves {
            continue;
        }
        poses = poses
            .iter()
            .flat_map(|pose| {
                (0..GRID).map(|step| {
                    let share = step as f64 / (GRID - 1) as f64;
                    let mut pose = pose.clone();
                    pose.angles_deg[place] =
                        variable.min_deg + share * (variable.max_deg - variable.min_deg);
                    pose
                })
            })
            .collect();
    }
    poses.retain(|pose| {
        let one = std::slice::from_ref(pose);
        robot.violated_limits(pose).is_empty()
            && Mechanics::new(robot, problem.mechanism, &problem.start, one).is_ok()
    });
    poses
}
