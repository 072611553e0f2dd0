//! Which further pose and load would determine the parameters that a fit leaves open.

use indexmap::IndexMap;
use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_beams::physics::{Mechanics, PoseMechanics};
use stiffbench_beams::robot::{
    FittingFactors, JointMotion, Mechanism, ModelParameter, Pose, Robot, RobotError,
};
use stiffbench_measurement::load_cases::{
    JointColumn, JointUnit, LoadAxes, LoadCase, LoadCaseTable,
};
use stiffbench_numeric::statistics::{even_share, golden_ratio, median};
use stiffbench_numeric::vector::{along6, dot6};
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::load_cases::problem::LoadCaseModel;
use crate::fit::{FactorEstimate, FactorStatus, FitError, FitOutcome, FitProblem};

/// Poses that are tried beside the named ones and those of the table, spread evenly over the limits.
const SPREAD_POSES: usize = 200;

/// A parameter whose interval reaches further, upper end over lower end, is open.
const WIDE: f64 = 2.0;

/// A load case is planned if some standard error falls below this share of itself.
const WORTH: f64 = 0.99;

/// Information on a parameter that is a smaller share of that on the best known one is rounding, in units of what bounds allow (1).
const NOT_SEEN: f64 = 1e-12;

/// Scatter of a further displacement where the load cases state none, m: a dial gauge.
const USUAL_SCATTER_M: f64 = 10e-6;

/// Size of a planned force where the table has none, N.
const USUAL_FORCE_N: f64 = 70.0;

/// Compliance that a spring may have of which nothing is known, rad/(N·m).
const USUAL_COMPLIANCE: f64 = 1e-5;

/// A further load case, and what it does for a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "NextLoadCase")]
pub struct PlannedLoadCase {
    /// Name of the pose in the robot file or the table, else a new one.
    #[serde(rename = "pose")]
    pub name: PoseId,
    /// The pose.
    #[serde(skip)]
    pub pose: Pose,
    /// Values of the variables of the robot file in this pose, degrees or m, without what rounding left.
    pub joints_deg: IndexMap<String, f64>,
    /// Axis of the base along which to load.
    pub direction: Direction,
    /// Size of the force, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// What becomes of the standard errors of the open parameters.
    pub errors: Vec<NextStandardError>,
}

/// The standard error of a parameter before and with this and all earlier planned load cases, in its unit; of a factor that of its logarithm.
///
/// It is that of the fit, in which parameters at a bound stay there; where no load shows a parameter that of what its bounds allow.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct NextStandardError {
    /// The parameter.
    pub name: String,
    /// Now.
    pub now: f64,
    /// With this load case.
    pub then: f64,
}

/// Information on the free parameters, in the units of their bounds.
#[derive(Clone)]
struct ParameterInformation {
    matrix: DMatrix<f64>,
    /// Half the width of the bounds, in the parameter's unit.
    prior: Vec<f64>,
}

/// What a fit knows of its parameters, and what it was made from.
#[derive(Debug, Clone)]
pub struct FitKnowledge<'a> {
    robot: &'a Robot,
    mechanism: &'a Mechanism,
    factors: &'a FittingFactors,
    estimates: &'a [FactorEstimate],
    poses: Vec<MeasuredPose>,
    /// Standard deviation of a further displacement, m.
    scatter_m: f64,
    /// Size of a further force, N.
    force_n: f64,
}

/// A pose with what was measured in it.
#[derive(Debug, Clone)]
struct MeasuredPose {
    name: PoseId,
    pose: Pose,
    components: Vec<MeasuredMotion>,
}

/// A motion of the end under a load.
#[derive(Debug, Clone)]
struct MeasuredMotion {
    /// Its unit vector: displacements, then rotations.
    unit: [f64; 6],
    /// Force and moment.
    load: [f64; 6],
    /// Its standard deviation, m or rad.
    sd: f64,
}

/// Six by six: displacement and rotation per force and moment of the end, SI.
pub(super) type EndCompliance = [[f64; 6]; 6];

/// A pose with the compliance of the end and its derivatives to the parameters.
pub(super) struct TriedPose {
    pub(super) name: PoseId,
    pub(super) pose: Pose,
    pub(super) mechanics: PoseMechanics,
}

impl TriedPose {
    /// Solves poses that can be reached.
    ///
    /// # Errors
    /// [`RobotError`] for a structure that carries nothing.
    pub(super) fn all(
        (robot, mechanism): (&Robot, &Mechanism),
        parameters: &[ModelParameter],
        factors: &FittingFactors,
        named: Vec<(PoseId, Pose)>,
    ) -> Result<Vec<Self>, RobotError> {
        let poses: Vec<Pose> = named.iter().map(|(_, pose)| pose.clone()).collect();
        let mut mechanics = Mechanics::rigid_with(robot, mechanism, parameters, factors, &poses)?;
        mechanics.differentiate_whole()?;
        let named = named.into_iter().enumerate();
        let all = named.map(|(place, (name, pose))| Self {
            name,
            pose,
            mechanics: mechanics.pose(place).clone(),
        });
        Ok(all.collect())
    }
}

/// Component of the end's motion along a unit vector of six under a load.
pub(super) fn motion_along(matrix: &EndCompliance, unit: &[f64; 6], load: &[f64; 6]) -> f64 {
    dot6(*unit, matrix.map(|row| dot6(row, *load)))
}

/// The further load cases that determine the open parameters of a fit to load cases best; none beside positions.
///
/// # Errors
/// As [`FitKnowledge::plan`].
pub fn plan_load_cases(
    model: &LoadCaseModel<'_>,
    fit: &FitOutcome,
    count: usize,
) -> Result<Vec<PlannedLoadCase>, FitError> {
    if model.posed.has_positions() {
        return Ok(Vec::new());
    }
    FitKnowledge::of_load_cases(model, fit).plan(count)
}

impl<'a> FitKnowledge<'a> {
    fn of_load_cases(model: &LoadCaseModel<'a>, fit: &'a FitOutcome) -> Self {
        let agreement = fit.agreement.as_ref();
        let sd = agreement.map_or([None; 2], |agreement| agreement.component_sd);
        let [scatter, _] = sd.map(|sd| sd.filter(|sd| *sd > 0.0));
        let scatter_m = scatter.unwrap_or(USUAL_SCATTER_M);
        let posed = model.posed;
        let of_pose = |pose: &Pose| MeasuredPose {
            name: PoseId::new(""),
            pose: pose.clone(),
            components: Vec::new(),
        };
        let mut poses: Vec<MeasuredPose> = posed.poses.iter().map(of_pose).collect();
        // Components of a case made white are motions along other unit vectors.
        let mut units: [Vec<f64>; 6] = std::array::from_fn(|part| {
            let rows = posed.rows();
            rows.map(|(_, read)| read.unit[part]).collect()
        });
        if let Some(scatter) = &fit.scatter {
            for part in &mut units {
                scatter.whiten(part);
            }
        }
        for (row, (case, _)) in posed.rows().enumerate() {
            let pose = &mut poses[case.pose];
            pose.name = posed.labels[case.label].clone();
            pose.components.push(MeasuredMotion {
                unit: std::array::from_fn(|part| units[part][row]),
                load: case.load,
                sd: 1.0,
            });
        }
        Self {
            robot: model.robot,
            mechanism: model.mechanism,
            factors: &fit.factors,
            estimates: &fit.estimates,
            poses,
            scatter_m,
            force_n: usual_force(posed.usual_force_n()),
        }
    }

    /// Of a fit to stiffnesses and compliances.
    ///
    /// # Arguments
    /// - `force_n`: size of the largest loads.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`] for a pose.
    pub fn of_cells(
        problem: &FitProblem<'a>,
        outcome: &'a FitOutcome,
        force_n: f64,
    ) -> Result<Self, RobotError> {
        let force_n = usual_force(force_n);
        let is_held_out = |pose: &PoseId| {
            let mut held_out = outcome.cells.iter().filter(|cell| cell.held_out);
            held_out.any(|cell| cell.cell.pose == *pose)
        };
        let along = outcome.cells.iter().map(|cell| {
            let u = cell.ln_uncertainty.map(|u| u / cell.measured_n_per_m);
            (&cell.cell, cell.cell.direction.unit_vector(), u)
        });
        let across = outcome.across.iter().zip(&problem.measured.across);
        let across = across.map(|(one, measured)| {
            let u = outcome.agreement.as_ref().map(|_| one.u_m_per_n);
            (&one.cell, measured.load.unit_vector(), u)
        });
        let usual = USUAL_SCATTER_M / force_n;
        let mut poses: Vec<MeasuredPose> = Vec::new();
        let mut known = Vec::new();
        for (cell, load, u) in along.chain(across) {
            // What took no part tells nothing of the parameters.
            if is_held_out(&cell.pose) {
                continue;
            }
            let place = poses.iter().position(|pose| pose.name == cell.pose);
            if place.is_none() {
                poses.push(MeasuredPose {
                    name: cell.pose.clone(),
                    pose: problem.robot.pose(&cell.pose)?.clone(),
                    components: Vec::new(),
                });
            }
            let place = place.unwrap_or(poses.len() - 1);
            let sd = u.filter(|u| *u > 0.0).unwrap_or(usual);
            known.push(sd);
            poses[place].components.push(MeasuredMotion {
                unit: along6(cell.direction.unit_vector()),
                load: along6(load),
                sd,
            });
        }
        Ok(Self {
            robot: problem.robot,
            mechanism: problem.mechanism,
            factors: &outcome.factors,
            estimates: &outcome.estimates,
            poses,
            scatter_m: force_n * median(&mut known).unwrap_or(usual),
            force_n,
        })
    }

    /// The further load cases that determine the open parameters best, one after the other; none if no parameter is open.
    ///
    /// All displacements of the end are read. What is made least is the sum of the variances of the open parameters, each in units of what its
    /// bounds allow (weighted A-optimality: Pukelsheim, Optimal Design of Experiments, 2006, section 6.5).
    ///
    /// # Errors
    /// [`FitError`] for a structure that carries nothing; poses that cannot be reached are passed over.
    pub fn plan(&self, count: usize) -> Result<Vec<PlannedLoadCase>, FitError> {
        let free: Vec<usize> = (0..self.estimates.len())
            .filter(|&place| {
                let estimate = &self.estimates[place];
                estimate.bounds.is_some() || is_unloaded(estimate)
            })
            .collect();
        // Of one at a bound no load case says more before the bound is wider.
        let is_open = |place: &usize| {
            let estimate = &self.estimates[*place];
            let interval = estimate.interval_95;
            !matches!(estimate.status, FactorStatus::AtBound { .. })
                && interval.is_none_or(|[low, high]| high > WIDE * low)
        };
        let open: Vec<usize> = (0..free.len()).filter(|&i| is_open(&free[i])).collect();
        if open.is_empty() {
            return Ok(Vec::new());
        }
        let parameters: Vec<_> = free
            .iter()
            .map(|&place| self.estimates[place].parameter.clone())
            .collect();
        let mut known = ParameterInformation {
            matrix: DMatrix::identity(free.len(), free.len()),
            prior: prior_widths(self.estimates, &free),
        };
        let tried = self.tried_poses(&parameters, &mut known)?;
        let at_bound: Vec<bool> = free
            .iter()
            .map(|&place| matches!(self.estimates[place].status, FactorStatus::AtBound { .. }))
            .collect();
        let mut planned = Vec::new();
        for _ in 0..count {
            let now = known.standard_errors(&open);
            let best = tried
                .iter()
                .flat_map(|pose| Direction::ALL.map(|axis| (pose, axis)))
                .map(|(pose, axis)| {
                    let derivatives = &pose.mechanics.gradient;
                    let with = known.with_load(derivatives, axis, self.force_n, self.scatter_m);
                    let errors = with.standard_errors(&open);
                    let shares = errors.iter().zip(&open);
                    let shares = shares.map(|(error, &i)| (error / with.prior[i]).powi(2));
                    (shares.sum::<f64>(), pose, axis, with, errors)
                })
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, pose, direction, with, errors)) = best else {
                break;
            };
            let helps = errors
                .iter()
                .zip(&now)
                .any(|(then, now)| *then < WORTH * now);
            if !helps {
                break;
            }
            let variables = self.robot.variables.iter();
            planned.push(PlannedLoadCase {
                name: pose.name.clone(),
                pose: pose.pose.clone(),
                joints_deg: variables
                    .zip(&pose.pose.angles_deg)
                    .map(|(variable, angle)| (variable.name.clone(), (angle * 1e6).round() / 1e6))
                    .collect(),
                direction,
                force_n: self.force_n,
                errors: open
                    .iter()
                    .map(|&i| {
                        let [now, then] = [&known, &with].map(|one| one.error_of_fit(i, &at_bound));
                        let name = self.estimates[free[i]].name.clone();
                        NextStandardError { name, now, then }
                    })
                    .collect(),
            });
            known = with;
        }
        Ok(planned)
    }

    /// Measured poses, whose components join what is known, those of the robot file, and poses spread over the limits.
    fn tried_poses(
        &self,
        parameters: &[ModelParameter],
        known: &mut ParameterInformation,
    ) -> Result<Vec<TriedPose>, FitError> {
        let (robot, mechanism) = (self.robot, self.mechanism);
        let measured = self.poses.iter();
        let measured = measured.map(|one| (one.name.clone(), one.pose.clone()));
        let poses = measured.chain(further_poses(robot, mechanism, SPREAD_POSES));
        let robot = (robot, mechanism);
        let tried = TriedPose::all(robot, parameters, self.factors, poses.collect())?;
        for (measured, tried) in self.poses.iter().zip(&tried) {
            for one in &measured.components {
                known.add(&tried.mechanics.gradient, &one.unit, &one.load, one.sd);
            }
        }
        Ok(tried)
    }
}

/// The size of a further force.
fn usual_force(measured_n: f64) -> f64 {
    if measured_n > 0.0 {
        measured_n
    } else {
        USUAL_FORCE_N
    }
}

/// What the bounds allow the free parameters: half their width. A spring on which no load acted may be as soft as the softest of the others.
fn prior_widths(estimates: &[FactorEstimate], free: &[usize]) -> Vec<f64> {
    let width = |estimate: &FactorEstimate| {
        let [low, high] = estimate.bounds?;
        Some(if estimate.parameter.is_factor() {
            0.5 * (high / low).ln()
        } else {
            0.5 * (high - low)
        })
    };
    let widest = |unit: &str| {
        let alike = estimates.iter().filter(|one| one.parameter.unit() == unit);
        let widest = alike.filter_map(width).fold(0.0, f64::max);
        if widest > 0.0 {
            widest
        } else {
            USUAL_COMPLIANCE
        }
    };
    free.iter()
        .map(|&place| {
            let estimate = &estimates[place];
            width(estimate).unwrap_or_else(|| widest(estimate.parameter.unit()))
        })
        .collect()
}

/// Whether no load acts on a parameter that was to be fitted.
fn is_unloaded(estimate: &FactorEstimate) -> bool {
    matches!(estimate.status, FactorStatus::NotIdentified { .. })
}

/// Named poses of the robot, and poses spread over its limits; those that cannot be reached are passed over.
pub(super) fn further_poses<'a>(
    robot: &'a Robot,
    mechanism: &'a Mechanism,
    spread: usize,
) -> impl Iterator<Item = (PoseId, Pose)> + use<'a> {
    let named = robot.poses.iter();
    let named = named.map(|named| (named.id.clone(), named.pose.clone()));
    let ratio = golden_ratio(robot.variables.len());
    let spread = (1..=spread as u32).map(move |k| {
        let angle = |(place, variable): (usize, &stiffbench_beams::robot::Variable)| {
            let share = even_share(ratio, k, place);
            let angle = variable.min_deg + share * (variable.max_deg - variable.min_deg);
            let steps = if variable.motion == JointMotion::Turns {
                10.0
            } else {
                1e3
            };
            (angle * steps).round() / steps
        };
        let angles_deg = robot.variables.iter().enumerate().map(angle).collect();
        (PoseId::new(&format!("new{k}")), Pose { angles_deg })
    });
    let spread = spread.filter(|(_, pose)| robot.is_within_limits(pose));
    let reached = |(_, pose): &(PoseId, Pose)| robot.end_pose(mechanism, pose).is_ok();
    named.chain(spread).filter(reached)
}

/// Adds the product of a row with itself.
pub(super) fn add_outer(matrix: &mut DMatrix<f64>, row: &[f64]) {
    for (i, a) in row.iter().enumerate() {
        for (j, b) in row.iter().enumerate() {
            matrix[(i, j)] += a * b;
        }
    }
}

impl ParameterInformation {
    /// Adds what a component says.
    fn add(
        &mut self,
        derivatives: &[EndCompliance],
        unit: &[f64; 6],
        load: &[f64; 6],
        scatter: f64,
    ) {
        let slopes: Vec<f64> = derivatives
            .iter()
            .zip(&self.prior)
            .map(|(matrix, prior)| motion_along(matrix, unit, load) * prior / scatter)
            .collect();
        add_outer(&mut self.matrix, &slopes);
    }

    /// The same with a force along an axis, all displacements read.
    fn with_load(
        &self,
        derivatives: &[EndCompliance],
        axis: Direction,
        force_n: f64,
        scatter: f64,
    ) -> Self {
        let mut with = self.clone();
        let mut load = [0.0; 6];
        load[axis.index()] = force_n;
        for read in Direction::ALL {
            let unit = along6(read.unit_vector());
            with.add(derivatives, &unit, &load, scatter);
        }
        with
    }

    /// The standard error of a parameter from the load cases alone, in its unit. Parameters at a bound stay there, and those that no load
    /// shows are kept, as in a fit; of those themselves it is what the bounds allow where nothing else does.
    fn error_of_fit(&self, i: usize, at_bound: &[bool]) -> f64 {
        let data = &self.matrix - DMatrix::identity(self.prior.len(), self.prior.len());
        let largest = data.diagonal().max();
        let is_seen = |j: usize| data[(j, j)] > NOT_SEEN * largest;
        let moves = |j: usize| is_seen(j) && (j == i || !at_bound[j]);
        let kept: Vec<usize> = (0..self.prior.len()).filter(|j| moves(*j)).collect();
        let matrix = DMatrix::from_fn(kept.len(), kept.len(), |a, b| data[(kept[a], kept[b])]);
        let own = kept.iter().position(|j| *j == i);
        let factor = matrix.cholesky();
        let variance = own
            .zip(factor)
            .map(|(own, factor)| factor.inverse()[(own, own)]);
        // Beyond this the inverse is rounding.
        let known = variance.filter(|variance| variance * data[(i, i)] * f64::EPSILON < 1e-3);
        known.map_or_else(
            || {
                self.standard_errors(&[i])
                    .first()
                    .copied()
                    .unwrap_or_default()
            },
            |variance| variance.sqrt() * self.prior[i],
        )
    }

    /// Standard errors of some parameters beside what their bounds allow, in their unit.
    fn standard_errors(&self, of: &[usize]) -> Vec<f64> {
        let inverse = self
            .matrix
            .clone()
            .cholesky()
            .map(|factor| factor.inverse());
        let error = |&i: &usize| {
            let variance = inverse.as_ref().map_or(1.0, |inverse| inverse[(i, i)]);
            variance.sqrt() * self.prior[i]
        };
        of.iter().map(error).collect()
    }
}

/// Planned load cases as a table to be filled in: each row lacks its displacements.
#[must_use]
pub fn planned_table(robot: &Robot, planned: &[PlannedLoadCase]) -> LoadCaseTable {
    let variables = &robot.variables;
    let joints = variables.iter().map(|variable| JointColumn {
        variable: variable.name.clone(),
        unit: match variable.motion {
            JointMotion::Turns => JointUnit::Angle,
            JointMotion::Slides => JointUnit::Length,
        },
    });
    let cases = planned.iter().map(|one| LoadCase {
        line: 0,
        pose: one.name.clone(),
        joints: variables
            .iter()
            .zip(&one.pose.angles_deg)
            .map(|(variable, value)| match variable.motion {
                JointMotion::Turns => value.to_radians(),
                JointMotion::Slides => *value,
            })
            .collect(),
        repeat: 1,
        axes: LoadAxes::Base,
        force_n: one.direction.unit_vector().map(|share| share * one.force_n),
        moment_nm: [0.0; 3],
        displacement_m: [None; 3],
        rotation_rad: [None; 3],
        position_m: [None; 3],
    });
    LoadCaseTable {
        source: "planned".to_owned(),
        joints: joints.collect(),
        cases: cases.collect(),
        ..LoadCaseTable::default()
    }
}
