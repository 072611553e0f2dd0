//! Figures of a fit to load cases.

use crate::fit::FitOutcome;
use crate::fit::PosedLoadCases;
use crate::plot::{
    ComponentPoint, Figure, LoadCaseComponents, LoadCaseResiduals, ResidualVector,
    load_case_components, load_case_residuals,
};
use crate::robot::Robot;

use super::figures::correlation_figure;
use super::robot_pose::drawn_axes;

/// Measured against predicted displacements, what is left of them as vectors, and the correlations of the parameters, each with the name of
/// its file.
pub(super) fn component_figures(
    fit: &FitOutcome,
    posed: &PosedLoadCases,
    robot: &Robot,
) -> Vec<(&'static str, Figure)> {
    let prediction = format!("fitted model of mechanism {}", fit.mechanism);
    let displacements = fit.components.iter().filter(|one| !one.is_rotation);
    let points = displacements.map(|one| ComponentPoint {
        pose: one.pose.clone(),
        axis: one.axis,
        measured_m: one.measured,
        predicted_m: one.predicted,
        held_out: one.held_out,
    });
    let components = load_case_components(&LoadCaseComponents {
        prediction: prediction.clone(),
        points: points.collect(),
    });
    let residuals = load_case_residuals(&LoadCaseResiduals {
        prediction,
        axes: drawn_axes(robot),
        vectors: residual_vectors(fit, posed, robot),
    });
    [("components", components), ("residual-vectors", residuals)]
        .into_iter()
        .chain(correlation_figure(fit.correlation.as_ref()))
        .collect()
}

/// Measured less model of every load case, along the axes of the base.
fn residual_vectors(
    fit: &FitOutcome,
    posed: &PosedLoadCases,
    robot: &Robot,
) -> Vec<ResidualVector> {
    let mut components = fit.components.iter();
    let frames = fit.frames.as_ref().map(|fitted| &fitted.frames);
    let mut vectors = Vec::with_capacity(posed.cases.len());
    for case in &posed.cases {
        let Ok(tool) = robot.tool_pose(&posed.poses[case.pose]) else {
            components
                .by_ref()
                .take(case.components.len())
                .for_each(drop);
            continue;
        };
        let mut vector = ResidualVector {
            at_m: tool.position_m,
            rigid_m: [0.0; 3],
            fitted_m: [0.0; 3],
            held_out: false,
        };
        for (read, one) in case.components.iter().zip(components.by_ref()) {
            if read.is_rotation() {
                continue;
            }
            vector.held_out = one.held_out;
            let [x, y, z, ..] = read.unit;
            // Positions stand along the axes of the tracker: turned back by the rows of the rotation.
            let unit = match frames.filter(|_| read.is_position()) {
                None => [x, y, z],
                Some(frames) => [0, 1, 2].map(|axis| {
                    let rows = frames.rotation.iter().zip([x, y, z]);
                    rows.map(|(row, share)| row[axis] * share).sum()
                }),
            };
            for axis in 0..3 {
                vector.rigid_m[axis] += unit[axis] * (one.measured - one.rigid);
                vector.fitted_m[axis] += unit[axis] * (one.measured - one.predicted);
            }
        }
        vectors.push(vector);
    }
    vectors
}
