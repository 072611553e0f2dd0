//! What a model says of every load case and component, and how it changes with the parameters.

use stiffbench_beams::physics::{JointRotations, LawSet, LoadPoint, Mechanics, RunLoads};
use stiffbench_beams::robot::{FittingFactors, Mechanism, ModelParameter, Robot, RobotError};
use stiffbench_numeric::vector::dot6;
use stiffbench_units_and_text::read_axis::ReadAxis;

use super::posed::{PosedLoad, PosedLoadCases, ReadComponent};
use super::problem::LoadCaseModel;

/// Displacement, m, and rotation, rad, of the tool centre in the axes of the base.
pub(in crate::fit) type ToolMotion = [f64; 6];

/// Predicted motions of the tool centre, in the order of the load cases.
#[derive(Debug, Clone)]
pub(in crate::fit) struct PredictedMotions {
    /// Under the load of each case; beside positions under own weight too.
    pub(in crate::fit) values: Vec<ToolMotion>,
    /// For each parameter the derivative of every motion: to ln a of a factor, to the compliance of a spring.
    pub(in crate::fit) columns: Vec<Vec<ToolMotion>>,
}

impl PredictedMotions {
    /// Those of all load cases under the values set last, with their derivatives where they are asked for.
    pub(in crate::fit) fn of(
        mechanics: &Mechanics<'_>,
        posed: &PosedLoadCases,
        derivatives: bool,
    ) -> Self {
        let cases = || posed.cases.iter();
        let pose = |case: &PosedLoad| mechanics.pose(case.pose);
        let first = mechanics.pose(0).gradient.len();
        let parameters = if derivatives { first } else { 0 };
        let column = |parameter: usize| {
            let changes = cases().map(|case| pose(case).motion_derivative(parameter, case.load));
            changes.collect()
        };
        Self {
            values: cases().map(|case| pose(case).motion(case.load)).collect(),
            columns: (0..parameters).map(column).collect(),
        }
    }

    /// The motions at a point, of motions whose derivatives are the same everywhere.
    pub(in crate::fit) fn at(&self, point: &[f64]) -> Vec<ToolMotion> {
        let mut values = self.values.clone();
        let columns = self.columns.iter().zip(point);
        for (column, coordinate) in columns.filter(|(_, coordinate)| **coordinate != 0.0) {
            for (value, slope) in values.iter_mut().zip(column) {
                for (value, slope) in value.iter_mut().zip(slope) {
                    *value += coordinate * slope;
                }
            }
        }
        values
    }
}

/// A mechanism in the poses of load cases, under own weight where positions were read.
///
/// # Arguments
/// - `parameters`: to which its motions are differentiated; springs among them may be rigid.
///
/// # Errors
/// [`RobotError`] for a pose that cannot be reached, or in which the structure carries nothing.
pub(in crate::fit) fn mechanics_of<'a>(
    (robot, mechanism): (&'a Robot, &'a Mechanism),
    posed: &PosedLoadCases,
    parameters: &[ModelParameter],
    factors: &FittingFactors,
) -> Result<Mechanics<'a>, RobotError> {
    let poses = &posed.poses;
    let mut mechanics = Mechanics::rigid_with(robot, mechanism, parameters, factors, poses)?;
    if !parameters.is_empty() {
        mechanics.differentiate_whole()?;
    }
    if posed.has_positions() {
        mechanics.weigh(parameters)?;
    }
    Ok(mechanics)
}

/// One value a component, each from the motion of its load case.
pub(in crate::fit) fn rows_of(
    posed: &PosedLoadCases,
    motions: &[ToolMotion],
    row: impl Fn(usize, &ReadComponent, &ToolMotion) -> f64,
) -> Vec<f64> {
    let cases = posed.cases.iter().zip(motions);
    cases
        .flat_map(|(case, motion)| {
            let row = &row;
            let components = case.components.iter();
            components.map(move |read| row(case.pose, read, motion))
        })
        .collect()
}

/// Component of a motion along a unit vector of six.
pub(in crate::fit) fn along(unit: &[f64; 6], motion: &ToolMotion) -> f64 {
    let shares = unit.iter().zip(motion).filter(|(unit, _)| **unit != 0.0);
    shares.map(|(unit, motion)| unit * motion).sum()
}

/// The motion of its load case along the unit vector of each component.
pub(in crate::fit) fn rows_along(posed: &PosedLoadCases, motions: &[ToolMotion]) -> Vec<f64> {
    rows_of(posed, motions, |_, read, motion| along(&read.unit, motion))
}

/// What laws add to the linear structure in load cases, each load from the unloaded state.
#[derive(Debug)]
pub(in crate::fit) struct AddedByLaws<'a> {
    laws: &'a LawSet,
    posed: &'a PosedLoadCases,
    joint_rotations: JointRotations,
}

impl<'a> AddedByLaws<'a> {
    /// Those of a model; `None` if no law acts.
    pub(in crate::fit) fn of(model: &LoadCaseModel<'a>) -> Option<Self> {
        Some(Self {
            laws: &model.physics?.laws,
            posed: model.posed,
            joint_rotations: JointRotations::default(),
        })
    }

    /// One value a component, m or rad, in the order of [`PosedLoadCases::rows`].
    ///
    /// # Arguments
    /// - `axis_of`: what a position reads of motions.
    ///
    /// # Errors
    /// [`RobotError::Structure`].
    pub(in crate::fit) fn rows(
        &mut self,
        mechanics: &mut Mechanics<'_>,
        factors: &FittingFactors,
        axis_of: &dyn Fn(&PosedLoad, &ReadComponent) -> ReadAxis,
    ) -> Result<Vec<f64>, RobotError> {
        mechanics.set_factors(factors)?;
        let mut added = Vec::new();
        for case in &self.posed.cases {
            let (load, amount) = case.load_along();
            let pose = mechanics.pose(case.pose);
            for read in &case.components {
                let read = axis_of(case, read);
                let applied = LoadPoint {
                    force_n: amount,
                    step: 1,
                    ..LoadPoint::default()
                };
                let run = RunLoads {
                    pose: &self.posed.labels[case.label],
                    load: &load,
                    read,
                    repeat: case.repeat,
                    release_n: None,
                    loads: &[applied],
                };
                let mut moved = [0.0];
                self.laws
                    .displacements_m(pose, &run, &mut self.joint_rotations, &mut moved);
                let unloaded = dot6(read.unit(), pose.unloaded.motion);
                added.push(moved[0] - unloaded - amount * pose.compliance(&read, &load));
            }
        }
        Ok(added)
    }
}
