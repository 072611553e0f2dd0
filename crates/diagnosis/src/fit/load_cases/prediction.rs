//! What a model says of every load case and component, and how it changes with the parameters.

use stiffbench_beams::physics::{JointRotations, LawSet, LoadPoint, Mechanics, RunLoads};
use stiffbench_beams::robot::{FittingFactors, RobotError, TrackedPoses};
use stiffbench_numeric::vector::dot6;
use stiffbench_units_and_text::read_axis::ReadAxis;

use super::posed::{PosedLoad, PosedLoadCases};
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

/// What a component reads.
#[derive(Debug, Clone, Copy)]
pub(in crate::fit) struct SeenRow {
    /// Number of its load case.
    pub(in crate::fit) case: usize,
    /// Number of its pose.
    pub(in crate::fit) pose: usize,
    /// What it reads of motions of the tool centre.
    pub(in crate::fit) axis: ReadAxis,
    /// What it reads of the rigid robot, m; nothing of displacements.
    rigid_m: f64,
}

/// What all components of load cases read, in the order of the rows.
#[derive(Debug, Clone)]
pub(in crate::fit) struct SeenRows(Vec<SeenRow>);

impl SeenRows {
    /// # Arguments
    /// - `tracker`: sees the positions.
    pub(in crate::fit) fn of(posed: &PosedLoadCases, tracker: Option<&TrackedPoses>) -> Self {
        let cases = posed.cases.iter().enumerate();
        let rows = cases.flat_map(|(number, case)| {
            case.components.iter().map(move |read| {
                let (axis, rigid_m) = case.seen(read, tracker);
                SeenRow {
                    case: number,
                    pose: case.pose,
                    axis,
                    rigid_m,
                }
            })
        });
        Self(rows.collect())
    }

    /// The rows.
    pub(in crate::fit) fn iter(&self) -> impl Iterator<Item = &SeenRow> {
        self.0.iter()
    }

    /// One value a row, each from the motion of its load case.
    pub(in crate::fit) fn each(
        &self,
        motions: &[ToolMotion],
        value: impl Fn(&SeenRow, &ToolMotion) -> f64,
    ) -> Vec<f64> {
        let rows = self.iter();
        rows.map(|row| value(row, &motions[row.case])).collect()
    }

    /// What is read, m and rad.
    pub(in crate::fit) fn read(&self, motions: &[ToolMotion]) -> Vec<f64> {
        self.each(motions, |row, motion| {
            row.rigid_m + dot6(row.axis.unit(), *motion)
        })
    }

    /// What changes of the motions change of that.
    pub(in crate::fit) fn changed(&self, changes: &[ToolMotion]) -> Vec<f64> {
        self.each(changes, |row, change| dot6(row.axis.unit(), *change))
    }

    /// What the rigid robot leaves of measured values, m and rad.
    pub(in crate::fit) fn left_by_rigid_robot(&self, measured: &[f64]) -> Vec<f64> {
        let rows = self.iter().zip(measured);
        rows.map(|(row, measured)| row.rigid_m - measured).collect()
    }
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

    /// One value a row, m or rad.
    ///
    /// # Errors
    /// [`RobotError::Structure`].
    pub(in crate::fit) fn rows(
        &mut self,
        mechanics: &mut Mechanics<'_>,
        factors: &FittingFactors,
        seen: &SeenRows,
    ) -> Result<Vec<f64>, RobotError> {
        mechanics.set_factors(factors)?;
        let mut added = Vec::new();
        for row in seen.iter() {
            let case = &self.posed.cases[row.case];
            let (load, amount) = case.load_along();
            let pose = mechanics.pose(row.pose);
            let applied = LoadPoint {
                force_n: amount,
                step: 1,
                ..LoadPoint::default()
            };
            let run = RunLoads {
                pose: &self.posed.labels[case.label],
                load: &load,
                read: row.axis,
                repeat: case.repeat,
                release_n: None,
                loads: &[applied],
            };
            let mut moved = [0.0];
            self.laws
                .displacements_m(pose, &run, &mut self.joint_rotations, &mut moved);
            let unloaded = dot6(row.axis.unit(), pose.unloaded.motion);
            added.push(moved[0] - unloaded - amount * pose.compliance(&row.axis, &load));
        }
        Ok(added)
    }
}
