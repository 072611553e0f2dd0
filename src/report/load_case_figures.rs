//! Figures of a fit to load cases.

use crate::elastostatics::LoadCaseFit;
use crate::plot::{ComponentPoint, Figure, LoadCaseComponents, load_case_components};

use super::figures::correlations_drawn;

/// Measured against predicted displacements, and the correlations of the parameters, each with the name of its file.
#[must_use]
pub fn load_case_figures(fit: &LoadCaseFit) -> Vec<(&'static str, Figure)> {
    let displacements = fit.components.iter().filter(|one| !one.is_rotation);
    let points = displacements.map(|one| ComponentPoint {
        pose: one.pose.clone(),
        axis: one.axis,
        measured_m: one.measured,
        predicted_m: one.predicted,
        held_out: one.held_out,
    });
    let components = load_case_components(&LoadCaseComponents {
        prediction: format!("fitted model of mechanism {}", fit.mechanism),
        points: points.collect(),
    });
    let correlation = correlations_drawn(fit.correlation.as_ref());
    let correlation = correlation.map(|figure| ("correlation", figure));
    std::iter::once(("components", components))
        .chain(correlation)
        .collect()
}
