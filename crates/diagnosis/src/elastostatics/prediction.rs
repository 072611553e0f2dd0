//! What a model says of every component that was read, and how it changes with the parameters.

use stiffbench_beams::robot::{FittingFactors, RobotError};

use super::compliances::{ComplianceSolver, PoseCompliance, motion_along};
use super::posed::PosedLoadCases;

/// Predicted rows, in the order of [`PosedLoadCases::rows`].
#[derive(Debug, Clone)]
pub(super) struct PredictedRows {
    /// Each component, m or rad.
    pub(super) values: Vec<f64>,
    /// For each parameter the derivative of every component: to ln a of a factor, to the compliance of a spring.
    pub(super) columns: Vec<Vec<f64>>,
}

impl PredictedRows {
    /// The values at a point, of rows whose derivatives are the same everywhere.
    pub(super) fn at(&self, point: &[f64]) -> Vec<f64> {
        let mut values = self.values.clone();
        let columns = self.columns.iter().zip(point);
        for (column, coordinate) in columns.filter(|(_, coordinate)| **coordinate != 0.0) {
            for (value, slope) in values.iter_mut().zip(column) {
                *value += coordinate * slope;
            }
        }
        values
    }
}

/// Predicts all rows.
///
/// # Errors
/// [`RobotError`] for a pose that cannot be reached, or in which the structure carries nothing.
pub(super) fn predict_rows(
    solver: &mut ComplianceSolver<'_>,
    posed: &PosedLoadCases,
    factors: &FittingFactors,
    derivatives: bool,
) -> Result<PredictedRows, RobotError> {
    let solved = posed
        .poses
        .iter()
        .map(|pose| solver.solve(pose, factors, derivatives))
        .collect::<Result<Vec<PoseCompliance>, _>>()?;
    let along = |of: &dyn Fn(&PoseCompliance) -> super::compliances::EndCompliance| -> Vec<f64> {
        let matrices: Vec<_> = solved.iter().map(of).collect();
        let rows = posed.rows();
        rows.map(|(case, read)| motion_along(&matrices[case.pose], &read.unit, &case.load))
            .collect()
    };
    let parameters = solved.first().map_or(0, |pose| pose.derivatives.len());
    Ok(PredictedRows {
        values: along(&|pose| pose.compliance),
        columns: (0..parameters)
            .map(|parameter| along(&|pose| pose.derivatives[parameter]))
            .collect(),
    })
}
