//! What a model says of every load case and component, and how it changes with the parameters.

use stiffbench_beams::robot::{FittingFactors, RobotError};

use super::compliances::{ComplianceSolver, PoseCompliance};
use super::posed::{PosedLoadCases, ReadComponent};

/// Displacement, m, and rotation, rad, of the tool centre in the axes of the base.
pub(super) type ToolMotion = [f64; 6];

/// Predicted motions of the tool centre, in the order of the load cases.
#[derive(Debug, Clone)]
pub(super) struct PredictedMotions {
    /// Under the load of each case; beside positions under own weight too.
    pub(super) values: Vec<ToolMotion>,
    /// For each parameter the derivative of every motion: to ln a of a factor, to the compliance of a spring.
    pub(super) columns: Vec<Vec<ToolMotion>>,
}

impl PredictedMotions {
    /// The motions at a point, of motions whose derivatives are the same everywhere.
    pub(super) fn at(&self, point: &[f64]) -> Vec<ToolMotion> {
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

/// Predicts the motions of all load cases.
///
/// # Errors
/// [`RobotError`] for a pose that cannot be reached, or in which the structure carries nothing.
pub(super) fn predict_motions(
    solver: &mut ComplianceSolver<'_>,
    posed: &PosedLoadCases,
    factors: &FittingFactors,
    derivatives: bool,
) -> Result<PredictedMotions, RobotError> {
    let weighs = posed.has_positions();
    let solved = posed
        .poses
        .iter()
        .map(|pose| solver.solve(pose, factors, derivatives, weighs))
        .collect::<Result<Vec<PoseCompliance>, _>>()?;
    let parameters = solved.first().map_or(0, |pose| pose.derivatives.len());
    let cases = || posed.cases.iter();
    Ok(PredictedMotions {
        values: cases()
            .map(|case| solved[case.pose].motion(&case.load))
            .collect(),
        columns: (0..parameters)
            .map(|parameter| {
                cases()
                    .map(|case| solved[case.pose].derivative(parameter, &case.load))
                    .collect()
            })
            .collect(),
    })
}

/// One value a component, each from the motion of its load case.
pub(super) fn rows_of(
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
pub(super) fn along(unit: &[f64; 6], motion: &ToolMotion) -> f64 {
    let shares = unit.iter().zip(motion).filter(|(unit, _)| **unit != 0.0);
    shares.map(|(unit, motion)| unit * motion).sum()
}

/// The motion of its load case along the unit vector of each component.
pub(super) fn rows_along(posed: &PosedLoadCases, motions: &[ToolMotion]) -> Vec<f64> {
    rows_of(posed, motions, |_, read, motion| along(&read.unit, motion))
}

/// Predicts all displacements and rotations, in the order of [`PosedLoadCases::rows`]; for a position the motion along its axis in the base.
///
/// # Errors
/// As [`predict_motions`].
pub(super) fn predict_rows(
    solver: &mut ComplianceSolver<'_>,
    posed: &PosedLoadCases,
    factors: &FittingFactors,
) -> Result<Vec<f64>, RobotError> {
    let motions = predict_motions(solver, posed, factors, false)?.values;
    Ok(rows_along(posed, &motions))
}
