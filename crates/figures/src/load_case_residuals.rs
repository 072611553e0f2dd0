//! What the rigid robot and a fitted model leave of displacements, as vectors where the tool was.

use stiffbench_numeric::vector::norm;
use stiffbench_units_and_text::quantity::METRES_PER_MICROMETRE;

use super::before_after::three_digits;
use super::caption::{held_out_sentence, joined};
use super::figure::{Axis, Figure, FigurePoint, Marks, Panel, Sharing, Style};
use super::palette::{Colour, Marker, qualitative};
use super::range::finite_ends;
use super::robot_views::DrawnAxes;

/// Length of the longest vector of a row of panels, as a share of the largest extent of the tool positions.
const LONGEST: f64 = 0.25;

/// Extent of tool positions that are one point, m.
const LEAST_EXTENT_M: f64 = 0.1;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCaseResiduals {
    /// Name of the prediction, for example `fitted model of mechanism F`.
    pub prediction: String,
    /// The axes of the world.
    pub axes: DrawnAxes,
    /// One vector a load case.
    pub vectors: Vec<ResidualVector>,
}

/// Measured less model of a load case, in the axes of the base; a component that was not read is zero.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualVector {
    /// Where the tool was, m.
    pub at_m: [f64; 3],
    /// Of the rigid robot, m.
    pub rigid_m: [f64; 3],
    /// Of the fitted model, m.
    pub fitted_m: [f64; 3],
    /// Whether the fit did not know this pose.
    pub held_out: bool,
}

/// The figure: vectors from the side and from above; those rigid robot over those of the fitted model, each row at its own scale.
#[must_use]
pub fn load_case_residuals(input: &LoadCaseResiduals) -> Figure {
    let extent_m = [0, 1, 2]
        .map(|axis| {
            let places = input.vectors.iter().map(|vector| vector.at_m[axis]);
            finite_ends(places).map_or(0.0, |[low, high]| high - low)
        })
        .into_iter()
        .fold(LEAST_EXTENT_M, f64::max);
    let rows = [
        ("rigid robot", false, Colour::INK),
        ("after the fit", true, qualitative(0)),
    ];
    let panels = rows.into_iter().flat_map(|(row, is_fitted, colour)| {
        let of = |vector: &ResidualVector| {
            if is_fitted {
                vector.fitted_m
            } else {
                vector.rigid_m
            }
        };
        let lengths = input.vectors.iter().map(|vector| norm(of(vector)));
        let longest = lengths.fold(0.0, f64::max);
        let scale = if longest > 0.0 {
            LONGEST * extent_m / longest
        } else {
            0.0
        };
        let longest = three_digits(longest / METRES_PER_MICROMETRE);
        let views = input.axes.views().into_iter();
        views
            .map(|view| {
                let [across, upward] = view.drawn();
                let axis = |place: usize| Axis::linear(&input.axes.names[place], "m");
                let mut panel = Panel::new(
                    format!("{row}, {}: longest {longest} µm", view.title),
                    axis(across),
                    axis(upward),
                );
                panel.equal_aspect = true;
                let lines = input.vectors.iter().map(|vector| {
                    let residual = of(vector);
                    let tip = [0, 1, 2].map(|axis| vector.at_m[axis] + scale * residual[axis]);
                    [view.project(vector.at_m), view.project(tip)]
                });
                panel.draw(
                    Style::new(colour, Marker::Dot),
                    Marks::Segments(lines.collect()),
                );
                let places = input.vectors.iter().map(|vector| {
                    let [x, y] = view.project(vector.at_m);
                    FigurePoint::new(x, y).hollow(vector.held_out)
                });
                panel.draw(
                    Style::new(colour, Marker::Dot).marker_size(2.6),
                    Marks::Points(places.collect()),
                );
                panel
            })
            .collect::<Vec<_>>()
    });
    let held_out = input.vectors.iter().filter(|one| one.held_out).count();
    Figure {
        columns: input.axes.views().len(),
        panel_px: [330.0, 300.0],
        share_x: Sharing::Column,
        share_y: Sharing::Column,
        panels: panels.collect(),
        ..Figure::new(
            format!("Residual vectors and the {}", input.prediction),
            joined([
                Some(format!(
                    "Measured − model, n\u{a0}=\u{a0}{} load cases: a line from the place of the tool, the dot. Each row has its own scale; components that were not read count as zero.",
                    input.vectors.len()
                )),
                held_out_sentence(held_out),
            ]),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;

    #[test]
    fn vectors_keep_their_ratios_within_a_row() {
        let vector = |at_m, rigid_m, fitted_m| ResidualVector {
            at_m,
            rigid_m,
            fitted_m,
            held_out: false,
        };
        let figure = load_case_residuals(&LoadCaseResiduals {
            prediction: "fitted model".to_owned(),
            axes: DrawnAxes::default(),
            vectors: vec![
                vector([0.0; 3], [1e-3, 0.0, 0.0], [0.0, 0.0, 1e-5]),
                vector([0.0, 2.0, 1.0], [0.0, -5e-4, 0.0], [0.0; 3]),
            ],
        });
        let lines = |panel: &Panel| -> Vec<[[f64; 2]; 2]> {
            let series = panel.series.iter();
            let lines = series.filter_map(|series| match &series.marks {
                Marks::Segments(lines) => Some(lines.clone()),
                _ => None,
            });
            lines.flatten().collect()
        };
        assert_eq!(figure.panels.len(), 4);
        let near = |panel: usize, vector: usize, expected: [[f64; 2]; 2]| {
            let line = lines(&figure.panels[panel])[vector];
            let pairs = line.as_flattened().iter().zip(expected.as_flattened());
            for (found, expected) in pairs {
                assert!((found - expected).abs() < 1e-12, "{line:?}");
            }
        };
        // From the side z runs across and y upward, from above x upward. The longest vector is a quarter of 2 m.
        near(0, 0, [[0.0, 0.0], [0.0, 0.0]]);
        near(0, 1, [[1.0, 2.0], [1.0, 1.75]]);
        near(1, 0, [[0.0, 0.0], [0.0, 0.5]]);
        near(2, 0, [[0.0, 0.0], [0.5, 0.0]]);
        assert!(figure.panels[0].title.contains("longest 1000 µm"));
        assert!(figure.panels[2].title.contains("longest 10.0 µm"));
        parse(&figure.to_svg()).unwrap();
    }
}
