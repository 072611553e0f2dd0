//! Residuals against load, direction, pose, order and time, side by side with one scale.

use stiffbench_units_and_text::quantity::METRES_PER_MICROMETRE;
use stiffbench_units_and_text::test_point::{Cell, Direction};

use super::caption::{flagged_entry, hollow_sentence, if_any, joined};
use super::figure::{Axis, Figure, FigurePoint, Marks, Panel, Sharing, Style};
use super::palette::{Colour, Marker, qualitative};
use super::quantities::Quantities;
use super::range::distinct;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Residuals {
    /// Name of what was subtracted, for example `fitted beam structure`.
    pub prediction: String,
    /// What loads and readings are.
    pub quantities: Quantities,
    /// In which measure.
    pub measure: ResidualMeasure,
    /// One point for each reading.
    pub points: Vec<ResidualPoint>,
}

/// Measure of a residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResidualMeasure {
    /// µm.
    Micrometres,
    /// Multiples of the standard uncertainty of the reading, for directions that differ much in stiffness.
    StandardUncertainties,
}

/// The residual of one reading.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualPoint {
    /// Pose and direction.
    pub cell: Cell,
    /// Signed force, N.
    pub force_n: f64,
    /// Measured minus predicted displacement, m.
    pub residual_m: f64,
    /// Standard uncertainty of the reading, m.
    pub standard_uncertainty_m: Option<f64>,
    /// Place of the reading in the session, from 0.
    pub sequence: usize,
    /// Seconds since the session began.
    pub time_s: Option<f64>,
    /// Whether the reading is flagged.
    pub flagged: bool,
}

/// The figure: panels with one vertical scale, the last over time where there is any; a direction has its own shape and colour.
#[must_use]
pub fn residuals(input: &Residuals) -> Figure {
    let poses = distinct(input.points.iter().map(|point| point.cell.pose.clone()));
    let longest_s = input
        .points
        .iter()
        .filter_map(|point| point.time_s)
        .fold(0.0, f64::max);
    let (time_unit, unit_s) = time_unit(longest_s);
    let y = match input.measure {
        ResidualMeasure::Micrometres => Axis::linear("measured − predicted", "µm"),
        ResidualMeasure::StandardUncertainties => {
            Axis::linear("residual / standard uncertainty", "")
        }
    };
    let names = poses.iter().map(ToString::to_string).collect();
    let pose_place = |point: &ResidualPoint| {
        let pose = poses.iter().position(|pose| *pose == point.cell.pose)?;
        // Directions stand side by side within a pose, so that they do not hide each other.
        let aside = 0.24 * (point.cell.direction.index() as f64 - 1.0);
        Some(pose as f64 + aside)
    };
    let direction_axis = match poses.as_slice() {
        [first, .., last] => format!("direction; in each {first} to {last} from left to right"),
        _ => "direction".to_owned(),
    };
    let directions = Direction::ALL.iter().map(ToString::to_string).collect();
    let direction_place = |point: &ResidualPoint| {
        let pose = poses.iter().position(|pose| *pose == point.cell.pose)?;
        // Poses stand side by side within a direction.
        let aside = 0.6 * ((pose as f64 + 0.5) / poses.len() as f64 - 0.5);
        Some(point.cell.direction.index() as f64 + aside)
    };
    let Quantities {
        load,
        has_directions,
        ..
    } = &input.quantities;
    let against = format!("against {}", load.name);
    let mut panels = vec![panel(input, &against, load.axis(), &y, &|p| {
        Some(load.shown(p.force_n))
    })];
    if *has_directions {
        panels.push(panel(
            input,
            "against direction",
            Axis::categories(&direction_axis, directions),
            &y,
            &direction_place,
        ));
    }
    if *has_directions || poses.len() > 1 {
        let place = if *has_directions {
            "pose"
        } else {
            "configuration"
        };
        panels.push(panel(
            input,
            &format!("against {place}"),
            Axis::categories(place, names),
            &y,
            &pose_place,
        ));
    }
    panels.push(panel(
        input,
        "against order",
        Axis::linear("reading number", ""),
        &y,
        &|p| Some(p.sequence as f64),
    ));
    if input.points.iter().any(|point| point.time_s.is_some()) {
        panels.push(panel(
            input,
            "against time",
            Axis::linear("time since the session began", time_unit),
            &y,
            &|p| p.time_s.map(|time_s| time_s / unit_s),
        ));
    }
    let flagged = input.points.iter().filter(|point| point.flagged).count();
    Figure {
        columns: 2,
        panel_px: [320.0, 200.0],
        share_y: Sharing::All,
        panels,
        legend: flagged_entry(flagged),
        ..Figure::new(
            format!("Residuals of the {}", input.prediction),
            caption(input, flagged),
        )
    }
}

fn caption(input: &Residuals, flagged: usize) -> String {
    let measure = match input.measure {
        ResidualMeasure::Micrometres => "",
        ResidualMeasure::StandardUncertainties => {
            ", as a multiple of the standard uncertainty of the reading"
        }
    };
    let timeless = input.points.iter().filter(|p| p.time_s.is_none()).count();
    let has_clock = timeless < input.points.len();
    joined([
        Some(format!(
            "n\u{a0}=\u{a0}{} readings, one point each, no bars.",
            input.points.len()
        )),
        Some(format!(
            "Residual: measured minus predicted {}{measure}.",
            input.quantities.reading.name
        )),
        hollow_sentence(flagged),
        if_any(
            if has_clock { timeless } else { 0 },
            format!("{timeless} readings have no time and are missing in the last panel."),
        ),
    ])
}

/// Unit in which a session of this length reads well, and its seconds.
pub(super) fn time_unit(longest_s: f64) -> (&'static str, f64) {
    if longest_s > 2.0 * 3600.0 {
        ("h", 3600.0)
    } else if longest_s > 180.0 {
        ("min", 60.0)
    } else {
        ("s", 1.0)
    }
}

fn panel(
    input: &Residuals,
    title: &str,
    x: Axis,
    y: &Axis,
    x_of: &dyn Fn(&ResidualPoint) -> Option<f64>,
) -> Panel {
    let mut panel = Panel::new(title, x, y.clone());
    panel.draw(Style::line(Colour::INK, 1.0), Marks::LevelAt(0.0));
    for direction in Direction::ALL {
        let points: Vec<FigurePoint> = input
            .points
            .iter()
            .filter(|point| point.cell.direction == direction)
            .filter_map(|point| {
                Some(
                    FigurePoint::new(x_of(point)?, measured(input.measure, point))
                        .hollow(point.flagged),
                )
            })
            .collect();
        let label = if input.quantities.has_directions {
            direction.to_string()
        } else {
            "readings".to_owned()
        };
        panel.draw_named(label, mark_style(direction), Marks::Points(points));
    }
    panel
}

/// Residual in the measure of the figure; NaN, which is counted as not drawn, if the uncertainty it needs is unknown.
fn measured(measure: ResidualMeasure, point: &ResidualPoint) -> f64 {
    match measure {
        ResidualMeasure::Micrometres => point.residual_m / METRES_PER_MICROMETRE,
        ResidualMeasure::StandardUncertainties => point
            .standard_uncertainty_m
            .map_or(f64::NAN, |u| point.residual_m / u),
    }
}

/// Shape and colour of a direction.
pub(super) fn mark_style(direction: Direction) -> Style {
    let n = direction.index();
    let marker = [Marker::Circle, Marker::Square, Marker::Triangle][n];
    let colour = [qualitative(0), qualitative(1), qualitative(2)][n];
    // Readings pile up at the loads of the procedure: what lies beneath should shine through.
    Style::new(colour.with_opacity(0.7), marker).marker_size(2.6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;
    use crate::reading::{all_points, assert_says};

    fn point(sequence: usize, residual_m: f64, time_s: Option<f64>) -> ResidualPoint {
        ResidualPoint {
            cell: Cell::new(
                ["P1", "P2"][sequence % 2].into(),
                Direction::ALL[sequence % 3],
            ),
            force_n: -10.0 * sequence as f64,
            residual_m,
            standard_uncertainty_m: (sequence > 0).then_some(2e-6),
            sequence,
            time_s,
            flagged: sequence == 4,
        }
    }

    fn input(measure: ResidualMeasure) -> Residuals {
        Residuals {
            quantities: Quantities::default(),
            prediction: "fitted structure".to_owned(),
            measure,
            points: (0..6)
                .map(|i| point(i, 1e-6 * i as f64, (i != 2).then_some(60.0 * i as f64)))
                .collect(),
        }
    }

    #[test]
    fn every_reading_stands_in_every_panel_it_can() {
        let figure = residuals(&input(ResidualMeasure::Micrometres));
        let counts: Vec<usize> = figure.panels.iter().map(|p| all_points(p).len()).collect();
        assert_eq!(counts, [6, 6, 6, 6, 5]);
        // Of two poses one stands left and one right of the middle of its direction.
        let places: Vec<f64> = all_points(&figure.panels[1]).iter().map(|p| p.x).collect();
        assert_eq!(places, [-0.15, 0.15, 1.15, 0.85, 1.85, 2.15]);
        assert_eq!(figure.share_y, Sharing::All);
        assert_says(&figure, "1 readings have no time");
        let load = all_points(&figure.panels[0]);
        let fourth = load.iter().find(|p| p.hollow).unwrap();
        assert_eq!((fourth.x, fourth.y), (-40.0, 4.0));
        let times: Vec<f64> = all_points(&figure.panels[4]).iter().map(|p| p.x).collect();
        assert!(times.contains(&5.0), "minutes: {times:?}");
    }

    #[test]
    fn standardised_residuals_without_uncertainty_are_counted_as_not_drawn() {
        let figure = residuals(&input(ResidualMeasure::StandardUncertainties));
        assert!(all_points(&figure.panels[0]).iter().any(|p| p.y == 2.5));
        let svg = figure.to_svg();
        assert!(
            svg.contains("5 points have no place on the axes"),
            "one in each panel"
        );
        parse(&svg).unwrap();
    }
}
