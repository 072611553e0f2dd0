//! Measured against predicted stiffness, cell by cell.

use stiffbench_units_and_text::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE;
use stiffbench_units_and_text::test_point::Cell;

use super::caption::{count_range, flagged_entry, hollow_sentence, if_any, joined};
use super::figure::{Axis, Figure, FigurePoint, Marks, Panel, Series, Sharing, Style};
use super::palette::{Colour, Marker, qualitative};

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffnessComparison {
    /// Name of the prediction for the legend, for example `model fitted on P1, P3`.
    pub prediction: String,
    /// Whether the intervals come from the scatter of all cells, not from that of each cell by itself.
    pub pooled: bool,
    /// Cells in the order in which they stand.
    pub cells: Vec<ComparedCell>,
}

/// Stiffness of one cell, measured and predicted.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedCell {
    /// Pose and direction.
    pub cell: Cell,
    /// Measured stiffness, N/m.
    pub measured_n_per_m: f64,
    /// Its 95 % interval, N/m; `None` if there is none.
    pub measured_ci95_n_per_m: Option<[f64; 2]>,
    /// Runs behind the measured value.
    pub n_runs: usize,
    /// Whether a reading behind the measured value is flagged.
    pub flagged: bool,
    /// Predicted stiffness, N/m.
    pub predicted_n_per_m: f64,
    /// Whether the prediction was made without this cell.
    pub held_out: bool,
}

impl ComparedCell {
    /// Predicted over measured, percent, and what becomes of it at the ends of the measured interval.
    fn ratio_percent(&self) -> (f64, Option<[f64; 2]>) {
        let at = |measured: f64| 100.0 * self.predicted_n_per_m / measured;
        let ends = self
            .measured_ci95_n_per_m
            .map(|[low, high]| [at(high), at(low)]);
        (at(self.measured_n_per_m), ends)
    }
}

/// The figure: stiffness on a logarithmic axis above, predicted over measured below; held-out cells have their own marker.
#[must_use]
pub fn stiffness_comparison(input: &StiffnessComparison) -> Figure {
    let names: Vec<String> = input
        .cells
        .iter()
        .map(|compared| compared.cell.to_string())
        .collect();
    let width = (54.0 * names.len() as f64).clamp(380.0, 900.0);
    let flagged = input.cells.iter().filter(|cell| cell.flagged).count();
    Figure {
        columns: 1,
        panel_px: [width, 230.0],
        row_heights_px: vec![230.0, 160.0],
        share_x: Sharing::Column,
        panels: vec![stiffness_panel(input, &names), ratio_panel(input, &names)],
        legend: flagged_entry(flagged),
        ..Figure::new("Measured and predicted stiffness", caption(input, flagged))
    }
}

fn caption(input: &StiffnessComparison, flagged: usize) -> String {
    let all = input.cells.len();
    let count =
        |which: &dyn Fn(&ComparedCell) -> bool| input.cells.iter().filter(|c| which(c)).count();
    let held_out = count(&|cell| cell.held_out);
    let without = count(&|cell| cell.measured_ci95_n_per_m.is_none());
    let counted = input.cells.iter().map(|cell| cell.n_runs);
    let counted: Vec<usize> = counted.filter(|runs| *runs > 0).collect();
    let runs = if counted.is_empty() {
        String::new()
    } else {
        format!(" ({} runs a cell)", count_range(counted))
    };
    joined([
        Some(format!(
            "Bars: 95 % interval of the measured stiffness, {}{runs}; in the lower panel it is carried to the ratio, the prediction taken as exact.",
            if input.pooled {
                "from the scatter between runs pooled over all cells: not the U of a cell's own runs in the table of stiffness"
            } else {
                "from the scatter of each cell by itself"
            }
        )),
        hollow_sentence(flagged),
        if_any(
            held_out,
            format!("{held_out} of {all} cells are predicted without their pose."),
        ),
        if_any(
            without,
            format!("{without} of {all} cells have no interval."),
        ),
    ])
}

fn stiffness_panel(input: &StiffnessComparison, names: &[String]) -> Panel {
    let mut panel = Panel::new(
        "",
        Axis::categories("pose and direction", names.to_vec()),
        Axis::log10("stiffness", "N/µm"),
    );
    let per_um = |n_per_m: f64| n_per_m / NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE;
    let predicted = input
        .cells
        .iter()
        .enumerate()
        .map(|(place, cell)| FigurePoint::new(place as f64, per_um(cell.predicted_n_per_m)))
        .collect();
    panel.series.push(Series::labelled(
        input.prediction.clone(),
        Style::new(qualitative(4), Marker::Dash),
        Marks::Points(predicted),
    ));
    push_borders(&mut panel, input);
    push_by_fate(&mut panel, input, "measured", |cell| {
        (
            per_um(cell.measured_n_per_m),
            cell.measured_ci95_n_per_m.map(|ends| ends.map(per_um)),
        )
    });
    panel
}

fn ratio_panel(input: &StiffnessComparison, names: &[String]) -> Panel {
    let mut panel = Panel::new(
        "",
        Axis::categories("pose and direction", names.to_vec()),
        Axis::linear("predicted / measured", "%"),
    );
    panel.draw(
        Style::line(Colour::INK, 1.0).dashed(),
        Marks::LevelAt(100.0),
    );
    push_borders(&mut panel, input);
    push_by_fate(&mut panel, input, "measured", ComparedCell::ratio_percent);
    panel
}

/// Thin lines where the direction changes from one cell to the next.
fn push_borders(panel: &mut Panel, input: &StiffnessComparison) {
    for (place, pair) in input.cells.windows(2).enumerate() {
        if pair[0].cell.direction != pair[1].cell.direction {
            panel.draw(
                Style::line(Colour::GREY, 0.8),
                Marks::UprightAt(place as f64 + 0.5),
            );
        }
    }
}

/// Two series of points: cells the fit has seen and cells it has not.
fn push_by_fate(
    panel: &mut Panel,
    input: &StiffnessComparison,
    what: &str,
    value: impl Fn(&ComparedCell) -> (f64, Option<[f64; 2]>),
) {
    for held_out in [false, true] {
        let points: Vec<FigurePoint> = input
            .cells
            .iter()
            .enumerate()
            .filter(|(_, cell)| cell.held_out == held_out)
            .map(|(place, cell)| {
                let (y, y_bar) = value(cell);
                FigurePoint {
                    y_bar,
                    hollow: cell.flagged,
                    ..FigurePoint::new(place as f64, y)
                }
            })
            .collect();
        let (label, style) = if held_out {
            (
                format!("{what}, held out"),
                Style::new(qualitative(1), Marker::Square),
            )
        } else {
            (
                format!("{what}, used in the fit"),
                Style::new(qualitative(0), Marker::Circle),
            )
        };
        panel.draw_named(label, style.marker_size(4.2), Marks::Points(points));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;
    use crate::reading::{assert_says, points_of};
    use stiffbench_units_and_text::test_point::Direction;

    fn cell(measured: f64, predicted: f64, held_out: bool) -> ComparedCell {
        ComparedCell {
            cell: Cell::new("P1".into(), Direction::Y),
            measured_n_per_m: measured,
            measured_ci95_n_per_m: Some([0.8 * measured, 1.25 * measured]),
            n_runs: 5,
            flagged: false,
            predicted_n_per_m: predicted,
            held_out,
        }
    }

    #[test]
    fn the_ratio_of_the_first_cell_is_that_of_table_vi() {
        // Table VI, P1, the paper's x: 0.26727 over 0.29181 N/µm is printed as 91.59 %.
        let (ratio, ends) = cell(0.29181e6, 0.26727e6, false).ratio_percent();
        assert!((ratio - 91.59).abs() < 0.005, "{ratio}");
        let [low, high] = ends.unwrap();
        assert!((low - ratio / 1.25).abs() < 1e-9 && (high - ratio / 0.8).abs() < 1e-9);
    }

    #[test]
    fn held_out_cells_are_a_series_of_their_own_in_both_panels() {
        let figure = stiffness_comparison(&StiffnessComparison {
            pooled: true,
            prediction: "fitted".to_owned(),
            cells: vec![
                cell(2e4, 2e4, false),
                cell(3e5, 2e5, true),
                cell(1e4, 1e4, true),
            ],
        });
        for panel in &figure.panels {
            let points = points_of(panel.series.last().unwrap());
            assert_eq!(points.iter().map(|p| p.x).collect::<Vec<_>>(), [1.0, 2.0]);
        }
        let predicted = points_of(&figure.panels[0].series[0]);
        assert!((predicted[1].y - 0.2).abs() < 1e-12);
        assert_says(&figure, "2 of 3 cells are predicted without");
    }

    #[test]
    fn cells_without_interval_are_counted_and_the_svg_parses() {
        let figure = stiffness_comparison(&StiffnessComparison {
            pooled: true,
            prediction: "fitted".to_owned(),
            cells: vec![ComparedCell {
                measured_ci95_n_per_m: None,
                flagged: true,
                ..cell(2e4, 2e4, false)
            }],
        });
        assert_says(&figure, "1 of 1 cells have no interval");
        parse(&figure.to_svg()).unwrap();
    }
}
