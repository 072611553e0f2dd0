//! Which further pose and load would determine the parameters that a fit leaves open.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_beams::physics::{Mechanics, PoseMechanics};
use stiffbench_beams::robot::{
    FittingFactors, JointMotion, Mechanism, ModelParameter, Pose, Robot, RobotError,
};
use stiffbench_numeric::statistics::median;
use stiffbench_numeric::vector::{along6, dot6};
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::load_cases::problem::LoadCaseModel;
use super::proposed_poses::{PoseRules, ProposedPose, ProposedWithin};
use crate::fit::{FactorEstimate, FactorStatus, FitError, FitOutcome, FitProblem};
use crate::parameters::place_of;
use crate::search::Information;

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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// How each of them moves.
    #[serde(skip)]
    pub motions: Vec<JointMotion>,
    /// Axis of the base along which to load.
    pub direction: Direction,
    /// The tool centre in this pose, in the axes of the base, m.
    pub tool_m: [f64; 3],
    /// Size of the force, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// What becomes of the standard errors of the open parameters.
    pub errors: Vec<NextStandardError>,
}

/// Load cases that are planned one after the other, none twice, and the rules that their poses keep; without rules where none is planned.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlannedLoadCases {
    /// The load cases.
    pub planned: Vec<PlannedLoadCase>,
    /// The rules.
    pub within: Option<ProposedWithin>,
}

/// The standard error of a parameter before and with this and all earlier planned load cases, in its unit; of a factor that of its logarithm.
///
/// It is that of the fit, in which parameters at a bound stay there; none where no load shows the parameter beside the others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NextStandardError {
    /// The parameter.
    pub name: String,
    /// Now.
    pub now: Option<f64>,
    /// With this load case.
    pub then: Option<f64>,
}

/// A motion of the end that is yet to be read.
pub(super) struct PlannedMotion {
    /// Its unit vector: displacements, then rotations.
    pub(super) unit: [f64; 6],
    /// Force and moment.
    pub(super) load: [f64; 6],
    /// Its standard deviation, m or rad.
    pub(super) sd: f64,
}

/// A pose that may be proposed, with the compliance of the end and its derivatives to the parameters.
pub(super) struct TriedPose {
    pub(super) at: ProposedPose,
    pub(super) mechanics: PoseMechanics,
}

impl TriedPose {
    /// Solves poses.
    ///
    /// # Errors
    /// [`RobotError`] for a structure that carries nothing.
    pub(super) fn all(
        (robot, mechanism): (&Robot, &Mechanism),
        parameters: &[ModelParameter],
        factors: &FittingFactors,
        proposed: Vec<ProposedPose>,
    ) -> Result<Vec<Self>, RobotError> {
        let poses: Vec<Pose> = proposed.iter().map(|one| one.pose.clone()).collect();
        let mut mechanics = Mechanics::rigid_with(robot, mechanism, parameters, factors, &poses)?;
        mechanics.differentiate_whole()?;
        let proposed = proposed.into_iter().enumerate();
        let all = proposed.map(|(place, at)| Self {
            at,
            mechanics: mechanics.pose(place).clone(),
        });
        Ok(all.collect())
    }

    /// What motions say of the parameters, and behind these of a spring that every load moves along itself.
    pub(super) fn says(&self, motions: &[PlannedMotion]) -> Information {
        let parameters = self.mechanics.gradient.len();
        let slope = |parameter: usize, one: &PlannedMotion| {
            let moved = if parameter < parameters {
                self.mechanics.motion_derivative(parameter, one.load)
            } else {
                one.load
            };
            dot6(one.unit, moved) / one.sd
        };
        let column = |parameter| motions.iter().map(|one| slope(parameter, one)).collect();
        let columns: Vec<Vec<f64>> = (0..=parameters).map(column).collect();
        Information::of_columns(&columns)
    }
}

/// The further load cases that determine the open parameters of a fit to load cases best; none beside positions.
///
/// # Arguments
/// - `wanted`: what is stated of the poses, and how many load cases.
///
/// # Errors
/// [`FitError`] for a structure that carries nothing, or if no pose keeps the rules.
pub fn plan_load_cases(
    model: &LoadCaseModel<'_>,
    fit: &FitOutcome,
    wanted: (&PoseRules, usize),
) -> Result<PlannedLoadCases, FitError> {
    let posed = model.posed;
    if posed.has_positions() {
        return Ok(PlannedLoadCases::default());
    }
    let mut poses = Vec::new();
    for case in &posed.cases {
        let (label, pose) = (&posed.labels[case.label], &posed.poses[case.pose]);
        place_of(&mut poses, &(label.clone(), pose.clone()));
    }
    let sd = fit.agreement.as_ref().and_then(|fit| fit.component_sd[0]);
    let scatter_m = sd.filter(|sd| *sd > 0.0).unwrap_or(USUAL_SCATTER_M);
    let load = [usual_force(posed.usual_force_n()), scatter_m];
    let robot = (model.robot, model.mechanism);
    plan(robot, fit, poses, load, wanted)
}

/// The same of a fit to stiffnesses and compliances.
///
/// # Arguments
/// - `force_n`: size of the largest loads.
/// - `wanted`: what is stated of the poses, and how many load cases.
///
/// # Errors
/// [`FitError`] for a pose that is not there, for a structure that carries nothing, or if no pose keeps the rules.
pub fn plan_beside_cells(
    problem: &FitProblem<'_>,
    fit: &FitOutcome,
    force_n: f64,
    wanted: (&PoseRules, usize),
) -> Result<PlannedLoadCases, FitError> {
    let force_n = usual_force(force_n);
    let along = fit.cells.iter().map(|cell| {
        let u = cell.ln_uncertainty.map(|u| u / cell.measured_n_per_m);
        (&cell.cell.pose, u)
    });
    let across = fit.across.iter().map(|one| {
        let u = fit.agreement.as_ref().map(|_| one.u_m_per_n);
        (&one.cell.pose, u)
    });
    let usual = USUAL_SCATTER_M / force_n;
    let (mut poses, mut known) = (Vec::new(), Vec::new());
    for (pose, u) in along.chain(across) {
        let mut held_out = fit.cells.iter().filter(|cell| cell.held_out);
        // What took no part tells nothing of the parameters.
        if held_out.any(|cell| cell.cell.pose == *pose) {
            continue;
        }
        place_of(
            &mut poses,
            &(pose.clone(), problem.robot.pose(pose)?.clone()),
        );
        known.push(u.filter(|u| *u > 0.0).unwrap_or(usual));
    }
    let scatter_m = force_n * median(&mut known).unwrap_or(usual);
    let robot = (problem.robot, problem.mechanism);
    plan(robot, fit, poses, [force_n, scatter_m], wanted)
}

/// The further load cases that determine the open parameters best, one after the other; none if no parameter is open.
///
/// All displacements of the end are read. What is made least is the sum of the variances of the open parameters, each in units of what its
/// bounds allow (weighted A-optimality: Pukelsheim, Optimal Design of Experiments, 2006, section 6.5).
///
/// # Arguments
/// - `measured`: poses that were measured, tried before those of the robot file and poses spread over the limits.
/// - `load`: size of a further force, N, and standard deviation of a further displacement, m.
fn plan(
    robot: (&Robot, &Mechanism),
    fit: &FitOutcome,
    measured: Vec<(PoseId, Pose)>,
    [force_n, scatter_m]: [f64; 2],
    (rules, count): (&PoseRules, usize),
) -> Result<PlannedLoadCases, FitError> {
    let estimates = &fit.estimates;
    let may_move = |place: &usize| {
        let one = &estimates[*place];
        one.bounds.is_some() || matches!(one.status, FactorStatus::NotIdentified { .. })
    };
    let free: Vec<usize> = (0..estimates.len()).filter(may_move).collect();
    let at_bound = |i: usize| matches!(estimates[free[i]].status, FactorStatus::AtBound { .. });
    // Of one at a bound no load case says more before the bound is wider.
    let is_open = |i: &usize| {
        let interval = estimates[free[*i]].interval_95;
        !at_bound(*i) && interval.is_none_or(|[low, high]| high > WIDE * low)
    };
    let open: Vec<usize> = (0..free.len()).filter(is_open).collect();
    if open.is_empty() {
        return Ok(PlannedLoadCases::default());
    }
    let parameters = free.iter().map(|&place| estimates[place].parameter.clone());
    let parameters: Vec<ModelParameter> = parameters.collect();
    let widths = prior_widths(estimates, &free);
    let factors = &fit.factors;
    let (proposed, within) = ProposedWithin::poses(robot, rules, measured, SPREAD_POSES)?;
    let tried = TriedPose::all(robot, &parameters, factors, proposed)?;
    let loads = |pose| Direction::ALL.map(|axis| (pose, axis));
    let tried: Vec<(&TriedPose, Direction)> = tried.iter().flat_map(loads).collect();
    let places: Vec<usize> = (0..free.len()).collect();
    let says = |(pose, axis): &(&TriedPose, Direction)| {
        let motions = Direction::ALL.map(|read| PlannedMotion {
            unit: along6(read.unit_vector()),
            load: along6(axis.unit_vector()).map(|share| share * force_n),
            sd: scatter_m,
        });
        pose.says(&motions).of_some(&places, &widths)
    };
    let says: Vec<Information> = tried.iter().map(says).collect();
    // Beside the rows stands what the bounds allow.
    let bounds = Information::of_prior(&vec![1.0; free.len()], 0);
    let variances = |rows: &Information| {
        let variances = bounds.with(rows).variances();
        variances.unwrap_or_else(|| vec![1.0; free.len()])
    };
    let sum = |variances: Vec<f64>| open.iter().map(|&i| variances[i]).sum::<f64>();
    let worth = |rows: &Information| -sum(variances(rows));
    let mut rows = fit.information.as_ref().map_or_else(
        || Information::of_prior(&[], free.len()),
        |information| information.of_some(&free, &widths),
    );
    let errors = |rows: &Information| -> Vec<Option<f64>> {
        let error = |&i: &usize| {
            let of_fit = rows.standard_error(i, |other| !at_bound(other));
            of_fit.map(|error| error * widths[i])
        };
        open.iter().map(error).collect()
    };
    let (mut planned, mut chosen) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let Some((_, best)) = rows.best_further(&says, &chosen, &worth) else {
            break;
        };
        chosen.push(best);
        let with = rows.with(&says[best]);
        let (now, then) = (variances(&rows), variances(&with));
        if !open.iter().any(|&i| then[i] < WORTH * WORTH * now[i]) {
            break;
        }
        let (TriedPose { at, .. }, direction) = tried[best];
        let names = open.iter().map(|&i| estimates[free[i]].name.clone());
        let errors = names.zip(errors(&rows).into_iter().zip(errors(&with)));
        planned.push(PlannedLoadCase {
            name: at.name.clone(),
            joints_deg: joints_deg(robot.0, &at.pose),
            motions: robot.0.variables.iter().map(|own| own.motion).collect(),
            pose: at.pose.clone(),
            tool_m: at.tool_m,
            direction,
            force_n,
            errors: errors
                .map(|(name, (now, then))| NextStandardError { name, now, then })
                .collect(),
        });
        rows = with;
    }
    let within = (!planned.is_empty()).then_some(within);
    Ok(PlannedLoadCases { planned, within })
}

/// Values of the variables of a robot in a pose, degrees or m, without what rounding left.
fn joints_deg(robot: &Robot, pose: &Pose) -> IndexMap<String, f64> {
    let joints = robot.variables.iter().zip(&pose.angles_deg);
    joints
        .map(|(variable, angle)| (variable.name.clone(), (angle * 1e6).round() / 1e6))
        .collect()
}

/// The size of a further force.
fn usual_force(measured_n: f64) -> f64 {
    if measured_n > 0.0 {
        // In three digits: nobody sets more.
        let digit = 10_f64.powi(2 - measured_n.log10().floor() as i32);
        (measured_n * digit).round() / digit
    } else {
        USUAL_FORCE_N
    }
}

/// What the bounds allow the free parameters: half their width. A spring on which no load acted may be as soft as the softest of the others.
fn prior_widths(estimates: &[FactorEstimate], free: &[usize]) -> Vec<f64> {
    let width = |one: &FactorEstimate| {
        let [low, high] = one.bounds?;
        let is_factor = one.parameter.is_factor();
        Some(
            0.5 * if is_factor {
                (high / low).ln()
            } else {
                high - low
            },
        )
    };
    let widest = |unit: &str| {
        let alike = estimates.iter().filter(|one| one.parameter.unit() == unit);
        let widest = alike.filter_map(width).fold(0.0, f64::max);
        Some(widest).filter(|widest| *widest > 0.0)
    };
    let free = free.iter().map(|&place| &estimates[place]);
    let allowed = free.map(|one| width(one).or_else(|| widest(one.parameter.unit())));
    allowed
        .map(|width| width.unwrap_or(USUAL_COMPLIANCE))
        .collect()
}
