//! Which further pose and load would determine the parameters that load cases leave open.

use indexmap::IndexMap;
use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_beams::robot::{FittingFactors, JointMotion, Pose, Robot, RobotError};
use stiffbench_measurement::load_cases::{
    JointColumn, JointUnit, LoadAxes, LoadCase, LoadCaseTable,
};
use stiffbench_numeric::statistics::{even_share, golden_ratio};
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use crate::fit::{FactorEstimate, FactorStatus};

use super::compliances::{ComplianceSolver, EndCompliance, motion_along};
use super::error::LoadCaseFitError;
use super::outcome::{LoadCaseAgreement, LoadCaseFit};
use super::problem::LoadCaseModel;

/// Poses that are tried beside the named ones and those of the table, spread evenly over the limits.
const SPREAD_POSES: usize = 200;

/// A parameter whose interval reaches further, upper end over lower end, is open.
const WIDE: f64 = 2.0;

/// A load case is planned if some standard error falls below this share of itself.
const WORTH: f64 = 0.99;

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

/// A pose with the derivatives of its compliance to the free parameters.
struct TriedPose {
    name: PoseId,
    pose: Pose,
    derivatives: Vec<EndCompliance>,
}

/// The further load cases that determine the open parameters best, one after the other; none if no parameter is open, and none beside positions.
///
/// All displacements of the end are read. What is made least is the sum of the variances of the open parameters, each in units of what its
/// bounds allow (weighted A-optimality: Pukelsheim, Optimal Design of Experiments, 2006, section 6.5).
///
/// # Errors
/// [`LoadCaseFitError`] for a structure that carries nothing; poses that cannot be reached are passed over.
pub fn plan_load_cases(
    model: &LoadCaseModel<'_>,
    fit: &LoadCaseFit,
    count: usize,
) -> Result<Vec<PlannedLoadCase>, LoadCaseFitError> {
    let free: Vec<usize> = (0..fit.estimates.len())
        .filter(|&place| {
            let estimate = &fit.estimates[place];
            estimate.bounds.is_some() || is_unloaded(estimate)
        })
        .collect();
    if model.posed.has_positions() {
        return Ok(Vec::new());
    }
    let is_open = |place: &usize| {
        let estimate = &fit.estimates[*place];
        estimate
            .interval_95
            .is_none_or(|[low, high]| high > WIDE * low)
    };
    let open: Vec<usize> = (0..free.len()).filter(|&i| is_open(&free[i])).collect();
    if open.is_empty() {
        return Ok(Vec::new());
    }
    let parameters: Vec<_> = free
        .iter()
        .map(|&place| fit.estimates[place].parameter.clone())
        .collect();
    let (robot, mechanism) = (model.robot, model.mechanism);
    let mut solver = ComplianceSolver::new(robot, mechanism, &parameters, &fit.factors)?;
    let agreement = fit.agreement.as_ref();
    let sd = agreement.map_or([None; 2], LoadCaseAgreement::sd);
    let [scatter, of_rotations] = sd.map(|sd| sd.filter(|sd| *sd > 0.0));
    let scatter = scatter.unwrap_or(USUAL_SCATTER_M);
    let mut known = ParameterInformation {
        matrix: DMatrix::identity(free.len(), free.len()),
        prior: prior_widths(fit, &free),
    };
    let tried = tried_poses(
        model,
        &fit.factors,
        &mut solver,
        &mut known,
        [Some(scatter), of_rotations],
    )?;
    let usual = model.posed.usual_force_n();
    let force_n = if usual > 0.0 { usual } else { USUAL_FORCE_N };
    let at_bound: Vec<bool> = free
        .iter()
        .map(|&place| matches!(fit.estimates[place].status, FactorStatus::AtBound { .. }))
        .collect();
    let mut planned = Vec::new();
    for _ in 0..count {
        let now = known.standard_errors(&open);
        let best = tried
            .iter()
            .flat_map(|pose| Direction::ALL.map(|axis| (pose, axis)))
            .map(|(pose, axis)| {
                let with = known.with_load(&pose.derivatives, axis, force_n, scatter);
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
        planned.push(PlannedLoadCase {
            name: pose.name.clone(),
            pose: pose.pose.clone(),
            joints_deg: robot
                .variables
                .iter()
                .zip(&pose.pose.angles_deg)
                .map(|(variable, angle)| (variable.name.clone(), (angle * 1e6).round() / 1e6))
                .collect(),
            direction,
            force_n,
            errors: open
                .iter()
                .map(|&i| {
                    let [now, then] = [&known, &with].map(|one| one.error_of_fit(i, &at_bound));
                    let name = fit.estimates[free[i]].name.clone();
                    NextStandardError { name, now, then }
                })
                .collect(),
        });
        known = with;
    }
    Ok(planned)
}

/// What the bounds allow the free parameters: half their width. A spring on which no load acted may be as soft as the softest of the others.
fn prior_widths(fit: &LoadCaseFit, free: &[usize]) -> Vec<f64> {
    let width = |estimate: &FactorEstimate| {
        let [low, high] = estimate.bounds?;
        Some(if estimate.parameter.is_factor() {
            0.5 * (high / low).ln()
        } else {
            0.5 * (high - low)
        })
    };
    let widest = |unit: &str| {
        let estimates = fit.estimates.iter();
        let alike = estimates.filter(|one| one.parameter.unit() == unit);
        let widest = alike.filter_map(width).fold(0.0, f64::max);
        if widest > 0.0 {
            widest
        } else {
            USUAL_COMPLIANCE
        }
    };
    free.iter()
        .map(|&place| {
            let estimate = &fit.estimates[place];
            width(estimate).unwrap_or_else(|| widest(estimate.parameter.unit()))
        })
        .collect()
}

/// Poses of the table, whose components join what is known, of the robot file, and poses spread over the limits.
fn tried_poses(
    model: &LoadCaseModel<'_>,
    factors: &FittingFactors,
    solver: &mut ComplianceSolver<'_>,
    known: &mut ParameterInformation,
    scatter: [Option<f64>; 2],
) -> Result<Vec<TriedPose>, LoadCaseFitError> {
    let mut tried: Vec<TriedPose> = Vec::new();
    for (place, pose) in model.posed.poses.iter().enumerate() {
        let solved = solver.solve(pose, factors, true, false)?;
        let cases = model.posed.cases.iter().filter(|case| case.pose == place);
        let mut label = None;
        for case in cases {
            label = Some(case.label);
            for read in &case.components {
                if let Some(scatter) = scatter[usize::from(read.is_rotation())] {
                    known.add(&solved.derivatives, &read.unit, &case.load, scatter);
                }
            }
        }
        tried.push(TriedPose {
            name: label.map_or_else(
                || PoseId::new(""),
                |label| model.posed.labels[label].clone(),
            ),
            pose: pose.clone(),
            derivatives: solved.derivatives,
        });
    }
    for (name, pose) in further_poses(model.robot, SPREAD_POSES) {
        match solver.solve(&pose, factors, true, false) {
            Ok(solved) => tried.push(TriedPose {
                name,
                pose,
                derivatives: solved.derivatives,
            }),
            Err(RobotError::Unreachable { .. }) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(tried)
}

/// Whether no load acts on a parameter that was to be fitted.
fn is_unloaded(estimate: &FactorEstimate) -> bool {
    matches!(estimate.status, FactorStatus::NotIdentified { .. })
}

/// Named poses of the robot, and poses spread over its limits.
pub(super) fn further_poses(robot: &Robot, spread: usize) -> Vec<(PoseId, Pose)> {
    let named = robot
        .poses
        .iter()
        .map(|named| (named.id.clone(), named.pose.clone()));
    let ratio = golden_ratio(robot.variables.len());
    let spread = (1..=spread as u32).map(|k| {
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
    named.chain(spread).collect()
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
        for (i, a) in slopes.iter().enumerate() {
            for (j, b) in slopes.iter().enumerate() {
                self.matrix[(i, j)] += a * b;
            }
        }
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
        for read in 0..3 {
            let mut unit = [0.0; 6];
            unit[read] = 1.0;
            with.add(derivatives, &unit, &load, scatter);
        }
        with
    }

    /// The standard error of a parameter from the load cases alone, in its unit. Parameters at a bound stay there, and those that no load
    /// shows are kept, as in a fit; of those themselves it is what the bounds allow where nothing else does.
    fn error_of_fit(&self, i: usize, at_bound: &[bool]) -> f64 {
        let data = &self.matrix - DMatrix::identity(self.prior.len(), self.prior.len());
        let largest = data.diagonal().max();
        let moves = |j: usize| j == i || !at_bound[j] && data[(j, j)] > f64::EPSILON * largest;
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
pub fn planned_table(model: &LoadCaseModel<'_>, planned: &[PlannedLoadCase]) -> LoadCaseTable {
    let variables = &model.robot.variables;
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
