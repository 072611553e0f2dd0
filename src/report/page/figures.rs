//! The figures of a report.

use crate::analysis::DiagnosisReport;
use crate::plot::Figure;
use crate::report::{diagnosis_figures, load_displacement_figure};
use crate::stiffness::StiffnessTable;

use super::PageFigure;
use super::packed::lean;
use super::results::PageCell;

/// Figures of a diagnosis that a report has, by the beginning of their names, the most important first. The limits of detection stand in a table.
const OF_DIAGNOSIS: [&str; 7] = [
    "mismatch_map",
    "found_law",
    "load_displacement",
    "misfit_shares",
    "held_out_error",
    "evidence_bars",
    "residuals",
];

pub(super) fn page_figure(name: impl Into<String>, figure: &Figure) -> PageFigure {
    let svg = lean(&figure.to_svg());
    PageFigure {
        name: name.into(),
        title: figure.title.clone(),
        tall: is_tall(&svg),
        svg,
    }
}

/// Whether a drawing is higher than wide.
fn is_tall(svg: &str) -> bool {
    let side = |name: &str| {
        let (_, value) = svg.split_once(&format!(" {name}=\""))?;
        value.split('"').next()?.parse::<f64>().ok()
    };
    side("height") > side("width")
}

/// Load against displacement; with the stiffness of each cell in its panel.
///
/// # Arguments
/// - `cells`: the results of the session; none of several sessions, which share their panels.
pub(super) fn readings_figure(
    sessions: &[(&str, &StiffnessTable)],
    cells: &[PageCell],
) -> PageFigure {
    let mut figure = load_displacement_figure(sessions);
    for cell in cells {
        let title = format!("{}, {}", cell.pose, cell.direction);
        let panel = figure.panels.iter_mut().find(|panel| panel.title == title);
        if let Some(panel) = panel {
            panel.title = format!("{} {}: {}", cell.pose, cell.direction, cell.words());
        }
    }
    if !cells.is_empty() {
        figure
            .caption
            .push_str(" Above each panel: K ± U for 95 %.");
    }
    page_figure("load-displacement", &figure)
}

/// Those of a fit but for the correlations, which stand in a table.
pub(super) fn figures_of_fit(figures: &[(&str, Figure)]) -> Vec<PageFigure> {
    let shown = figures.iter().filter(|(name, _)| *name != "correlation");
    shown
        .map(|(name, figure)| page_figure(*name, figure))
        .collect()
}

/// Where model and readings differ, before and after what was found.
pub(super) fn figures_of_diagnosis(report: &DiagnosisReport) -> Vec<PageFigure> {
    let all = diagnosis_figures(report);
    let wanted = OF_DIAGNOSIS.iter().flat_map(|wanted| {
        let own = all.iter();
        own.filter(move |(name, _)| name.starts_with(wanted))
    });
    wanted
        .map(|(name, figure)| page_figure(name, figure))
        .collect()
}
