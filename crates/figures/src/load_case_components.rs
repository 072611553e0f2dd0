//! Components of load cases, measured against predicted, and what a fit leaves of them pose by pose.

use stiffbench_units_and_text::quantity::METRES_PER_MICROMETRE;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::caption::{held_out_sentence, joined};
use super::figure::{Axis, Figure, FigurePoint, Marks, Panel, Style};
use super::palette::Colour;
use super::range::distinct;
use super::residuals::mark_style;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCaseComponents {
    /// Name of the prediction, for example `fitted model of mechanism F`.
    pub prediction: String,
    /// One point for each displacement that was read.
    pub points: Vec<ComponentPoint>,
}

/// A displacement that was read along an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct ComponentPoint {
    /// The pose.
    pub pose: PoseId,
    /// The axis.
    pub axis: Direction,
    /// What was read, m.
    pub measured_m: f64,
    /// What the model predicts, m.
    pub predicted_m: f64,
    /// Whether the prediction was made without this pose.
    pub held_out: bool,
}

/// The figure: measured against predicted on the left, the rest pose by pose on the right; an axis has its own shape and colour.
#[must_use]
pub fn load_case_components(input: &LoadCaseComponents) -> Figure {
    let poses = distinct(input.points.iter().map(|point| &point.pose));
    let um = |metres: f64| metres / METRES_PER_MICROMETRE;
    let mut compared = Panel::new(
        "measured against predicted",
        Axis::linear("predicted displacement", "µm"),
        Axis::linear("measured displacement", "µm"),
    );
    let both = input
        .points
        .iter()
        .flat_map(|p| [p.measured_m, p.predicted_m]);
    let (low, high) = both.fold((0.0_f64, 0.0_f64), |(low, high), m| {
        (low.min(um(m)), high.max(um(m)))
    });
    compared.draw(
        Style::line(Colour::INK, 1.0).dashed(),
        Marks::Line(vec![[low, low], [high, high]]),
    );
    // Poses have names, too many of them to be written: their place in the table stands below.
    let mut rest = Panel::new(
        "measured − predicted",
        Axis::linear("pose, in the order of the table", ""),
        Axis::linear("measured − predicted", "µm"),
    );
    rest.draw(Style::line(Colour::INK, 1.0), Marks::LevelAt(0.0));
    let place = |pose: &PoseId| {
        let place = poses.iter().position(|known| *known == pose);
        place.map_or(0.0, |place| place as f64 + 1.0)
    };
    for axis in Direction::ALL {
        let own = || input.points.iter().filter(move |point| point.axis == axis);
        if own().next().is_none() {
            continue;
        }
        let point = |at: [f64; 2], held_out: bool| FigurePoint::new(at[0], at[1]).hollow(held_out);
        let pairs = own().map(|p| point([um(p.predicted_m), um(p.measured_m)], p.held_out));
        let left = own().map(|p| {
            let aside = 0.2 * (axis.index() as f64 - 1.0);
            let difference = um(p.measured_m - p.predicted_m);
            point([place(&p.pose) + aside, difference], p.held_out)
        });
        for (panel, points) in [
            (&mut compared, pairs.collect::<Vec<_>>()),
            (&mut rest, left.collect()),
        ] {
            panel.draw_named(axis.to_string(), mark_style(axis), Marks::Points(points));
        }
    }
    let held_out = input.points.iter().filter(|point| point.held_out).count();
    Figure {
        columns: 2,
        panel_px: [330.0, 300.0],
        panels: vec![compared, rest],
        ..Figure::new(
            format!("Load cases and the {}", input.prediction),
            joined([
                Some(format!(
                    "n\u{a0}=\u{a0}{} displacements in {} poses, one point each, no bars. Dashed: measured equals predicted.",
                    input.points.len(),
                    poses.len()
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
    use crate::reading::{all_points, assert_says};

    #[test]
    fn every_component_stands_in_both_panels() {
        let point = |pose: &str, axis, measured_m| ComponentPoint {
            pose: pose.into(),
            axis,
            measured_m,
            predicted_m: 1e-4,
            held_out: pose == "b",
        };
        let figure = load_case_components(&LoadCaseComponents {
            prediction: "fitted model".to_owned(),
            points: vec![
                point("a", Direction::X, 1.5e-4),
                point("a", Direction::Z, -2e-4),
                point("b", Direction::X, 1e-4),
            ],
        });
        let (left, right) = (all_points(&figure.panels[0]), all_points(&figure.panels[1]));
        assert_eq!((left.len(), right.len()), (3, 3));
        assert!((left[0].x - 100.0).abs() < 1e-9 && (left[0].y - 150.0).abs() < 1e-9);
        assert!((right[0].y - 50.0).abs() < 1e-9 && right[1].hollow);
        assert_says(&figure, "1 hollow points");
        parse(&figure.to_svg()).unwrap();
    }
}
