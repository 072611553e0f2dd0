//! Residuals of every reading without and with what was found, one above the other.

use stiffbench_units_and_text::test_point::Direction;

use super::caption::{counted_sentence, flagged_entry, hollow_sentence, joined};
use super::figure::{Axis, Figure, FigurePoint, Marks, Panel, Sharing, Style};
use super::palette::{Colour, Marker};
use super::quantities::{AxisQuantity, Quantities};
use super::residuals::mark_style;
use super::ticks::signed;

/// Readings of other directions over which a noise band goes on.
const LONGEST_GAP: usize = 10;
/// Share of readings that a normal error leaves within one standard deviation, percent.
const WITHIN_ONE_SD_PERCENT: f64 = 68.3;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualsBeforeAfter {
    /// What was added to the prediction, for example `joint-backlash at A3`.
    pub found: String,
    /// What runs across.
    pub against: ResidualsAgainst,
    /// What loads and readings are.
    pub quantities: Quantities,
    /// One point for each reading.
    pub points: Vec<BeforeAfterPoint>,
}

/// What runs across.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResidualsAgainst {
    /// Force, N.
    Force,
    /// Place of the reading in the session.
    Order,
}

/// The residuals of one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeforeAfterPoint {
    /// Direction of load and displacement.
    pub direction: Direction,
    /// Target load, N: readings of one target share a piece of the noise band.
    pub target_n: f64,
    /// Signed force, N.
    pub force_n: f64,
    /// Place of the reading in the session, from 0.
    pub sequence: usize,
    /// Measured minus predicted displacement without what was found, m.
    pub before_m: f64,
    /// The same with it, m.
    pub after_m: f64,
    /// Standard deviation of the reading in the noise model, m; `None` if it is unknown.
    pub noise_sd_m: Option<f64>,
    /// Whether the reading is flagged.
    pub flagged: bool,
}

/// One of the two rows of panels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PanelRow {
    Before,
    After,
}

impl PanelRow {
    fn residual_m(self, point: &BeforeAfterPoint) -> f64 {
        match self {
            Self::Before => point.before_m,
            Self::After => point.after_m,
        }
    }
}

/// The figure: a column for each direction, before above after with one scale; the grey band is what noise alone would do.
#[must_use]
pub fn residuals_before_after(input: &ResidualsBeforeAfter) -> Figure {
    let directions: Vec<Direction> = Direction::ALL
        .into_iter()
        .filter(|direction| input.points.iter().any(|p| p.direction == *direction))
        .collect();
    let panels = [PanelRow::Before, PanelRow::After]
        .into_iter()
        .flat_map(|row| {
            let directions = &directions;
            directions.iter().map(move |d| panel(input, row, *d))
        });
    let flagged = input.points.iter().filter(|point| point.flagged).count();
    Figure {
        columns: directions.len().max(1),
        panel_px: [if directions.len() > 1 { 232.0 } else { 420.0 }, 170.0],
        share_x: Sharing::Column,
        share_y: Sharing::Column,
        panels: panels.collect(),
        legend: flagged_entry(flagged),
        ..Figure::new(
            format!("Residuals without and with {}", input.found),
            caption(input, flagged),
        )
    }
}

fn across(input: &ResidualsBeforeAfter, point: &BeforeAfterPoint) -> f64 {
    match input.against {
        ResidualsAgainst::Force => input.quantities.load.shown(point.force_n),
        ResidualsAgainst::Order => point.sequence as f64,
    }
}

fn panel(input: &ResidualsBeforeAfter, row: PanelRow, direction: Direction) -> Panel {
    let points: Vec<&BeforeAfterPoint> = input
        .points
        .iter()
        .filter(|point| point.direction == direction)
        .collect();
    let Quantities {
        load,
        reading,
        has_directions,
    } = &input.quantities;
    let rms = rms_m(points.iter().copied(), row).map_or_else(
        || "no rms".to_owned(),
        |rms| format!("rms {}", of_three_digits(reading, rms)),
    );
    let x = match input.against {
        ResidualsAgainst::Force => load.axis(),
        ResidualsAgainst::Order => Axis::linear("reading number", ""),
    };
    let y = match row {
        PanelRow::Before => "residual, without",
        PanelRow::After => "residual, with",
    };
    let (title, label) = if *has_directions {
        (format!("{direction}: {rms}"), direction.to_string())
    } else {
        (rms, "readings".to_owned())
    };
    let mut panel = Panel::new(title, x, reading.axis_of(y));
    for band in bands(input, &points) {
        panel.draw_named(
            "± one standard deviation of the noise",
            Style::new(Colour::GREY.with_opacity(0.35), Marker::Square),
            Marks::Band(band),
        );
    }
    panel.draw(Style::line(Colour::INK, 1.0), Marks::LevelAt(0.0));
    let drawn = points.iter().map(|point| {
        FigurePoint::new(across(input, point), reading.shown(row.residual_m(point)))
            .hollow(point.flagged)
    });
    panel.draw_named(label, mark_style(direction), Marks::Points(drawn.collect()));
    panel
}

/// The noise band in pieces: at every target load the quadratic mean over its readings, or reading by reading along their order,
/// broken where the session was elsewhere.
fn bands(input: &ResidualsBeforeAfter, points: &[&BeforeAfterPoint]) -> Vec<Vec<[f64; 3]>> {
    let mut known: Vec<(&BeforeAfterPoint, f64)> = points
        .iter()
        .filter_map(|point| Some((*point, input.quantities.reading.shown(point.noise_sd_m?))))
        .filter(|(point, sd)| sd.is_finite() && across(input, point).is_finite())
        .collect();
    match input.against {
        ResidualsAgainst::Order => {
            known.sort_by_key(|(point, _)| point.sequence);
            let elsewhere =
                |a: &BeforeAfterPoint, b: &BeforeAfterPoint| b.sequence - a.sequence > LONGEST_GAP;
            known
                .chunk_by(|(a, _), (b, _)| !elsewhere(a, b))
                .map(|piece| {
                    let ends =
                        |(point, sd): &(&BeforeAfterPoint, f64)| [point.sequence as f64, -sd, *sd];
                    piece.iter().map(ends).collect()
                })
                .collect()
        }
        ResidualsAgainst::Force => {
            known.sort_by(|(a, _), (b, _)| a.target_n.total_cmp(&b.target_n));
            let steps = known.chunk_by(|(a, _), (b, _)| a.target_n == b.target_n);
            let band: Vec<[f64; 3]> = steps
                .map(|step| {
                    let n = step.len() as f64;
                    let load = step
                        .iter()
                        .map(|(point, _)| across(input, point))
                        .sum::<f64>()
                        / n;
                    let sd = (step.iter().map(|(_, sd)| sd * sd).sum::<f64>() / n).sqrt();
                    [load, -sd, sd]
                })
                .collect();
            if band.is_empty() {
                Vec::new()
            } else {
                vec![band]
            }
        }
    }
}

/// Root of the mean square of the finite residuals that are not flagged, m.
fn rms_m<'a>(points: impl Iterator<Item = &'a BeforeAfterPoint>, row: PanelRow) -> Option<f64> {
    let (n, sum) = points
        .filter(|point| !point.flagged)
        .map(|point| row.residual_m(point))
        .filter(|residual| residual.is_finite())
        .fold((0_usize, 0.0), |(n, sum), r| (n + 1, sum + r * r));
    (n > 0).then(|| (sum / n as f64).sqrt())
}

/// A value in SI in the unit of its quantity.
fn of_three_digits(quantity: &AxisQuantity, si: f64) -> String {
    quantity.with_unit(&three_digits(quantity.shown(si)))
}

/// A number with two or three digits that matter.
pub(super) fn three_digits(value: f64) -> String {
    let size = value.abs();
    let decimals = if size < 9.95 {
        2
    } else {
        usize::from(size < 99.5)
    };
    signed(value, decimals)
}

fn caption(input: &ResidualsBeforeAfter, flagged: usize) -> String {
    let mut directions = input.points.iter().map(|point| point.direction);
    let first = directions.next();
    let several = directions.any(|direction| Some(direction) != first);
    let reading = &input.quantities.reading;
    let all = |row| rms_m(input.points.iter(), row).map(|rms| of_three_digits(reading, rms));
    let overall = all(PanelRow::Before)
        .zip(all(PanelRow::After))
        .map(|(before, after)| {
            format!("All directions together: rms {before} without, {after} with.")
        });
    let unknown = input
        .points
        .iter()
        .filter(|p| p.noise_sd_m.is_none())
        .count();
    joined([
        Some(format!(
            "n\u{a0}=\u{a0}{} readings, one point each, no bars; residual: measured minus predicted {}. Both rows \
             have the same scale{}.",
            input.points.len(),
            reading.name,
            if several {
                ", every direction its own"
            } else {
                ""
            }
        )),
        overall.filter(|_| several),
        (flagged > 0).then(|| "Flagged readings are not in the rms.".to_owned()),
        within(input),
        hollow_sentence(flagged),
        counted_sentence(
            unknown,
            ["reading has", "readings have"],
            "no standard deviation and no part in the band.",
        ),
    ])
}

/// How many readings lie within one standard deviation, before and after.
fn within(input: &ResidualsBeforeAfter) -> Option<String> {
    let share = |row: PanelRow| {
        let known: Vec<bool> = input
            .points
            .iter()
            .filter(|point| !point.flagged && row.residual_m(point).is_finite())
            .filter_map(|point| Some(row.residual_m(point).abs() <= point.noise_sd_m?))
            .collect();
        let inside = known.iter().filter(|inside| **inside).count();
        (!known.is_empty()).then(|| 100.0 * inside as f64 / known.len() as f64)
    };
    let (before, after) = share(PanelRow::Before).zip(share(PanelRow::After))?;
    Some(format!(
        "Within one standard deviation of their own: {before:.0}\u{a0}% without, {after:.0}\u{a0}% with; normal noise alone leaves \
         {WITHIN_ONE_SD_PERCENT:.0}\u{a0}%."
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;
    use crate::reading::{assert_says, points_of};

    fn point(
        direction: Direction,
        sequence: usize,
        before_m: f64,
        after_m: f64,
    ) -> BeforeAfterPoint {
        BeforeAfterPoint {
            direction,
            target_n: -10.0 * (sequence % 2) as f64,
            force_n: -10.1 * (sequence % 2) as f64,
            sequence,
            before_m,
            after_m,
            noise_sd_m: Some(2e-6),
            flagged: false,
        }
    }

    fn input() -> ResidualsBeforeAfter {
        ResidualsBeforeAfter {
            quantities: Quantities::default(),
            found: "joint-backlash at A3".to_owned(),
            against: ResidualsAgainst::Force,
            points: vec![
                point(Direction::X, 0, 30e-6, 1e-6),
                point(Direction::X, 1, -40e-6, 3e-6),
                point(Direction::Z, 2, 1e-6, 1e-6),
                BeforeAfterPoint {
                    flagged: true,
                    noise_sd_m: None,
                    ..point(Direction::Z, 3, 500e-6, f64::NAN)
                },
            ],
        }
    }

    /// The points, which come last.
    fn drawn(panel: &Panel) -> &[FigurePoint] {
        points_of(panel.series.last().unwrap())
    }

    #[test]
    fn before_stands_above_after_with_its_rms_in_the_heading() {
        let figure = residuals_before_after(&input());
        assert_eq!((figure.columns, figure.panels.len()), (2, 4));
        // sqrt((30² + 40²)/2) = 35.36 and sqrt((1² + 3²)/2) = 2.236.
        let titles: Vec<String> = figure
            .panels
            .iter()
            .map(|panel| panel.title.replace('\u{a0}', " "))
            .collect();
        assert_eq!(
            titles,
            [
                "x: rms 35.4 µm",
                "z: rms 1.00 µm",
                "x: rms 2.24 µm",
                "z: rms 1.00 µm"
            ]
        );
        let before: Vec<f64> = drawn(&figure.panels[0]).iter().map(|p| p.y).collect();
        assert!((before[0] - 30.0).abs() < 1e-9 && (before[1] + 40.0).abs() < 1e-9);
        let after: Vec<f64> = drawn(&figure.panels[2]).iter().map(|p| p.y).collect();
        assert!((after[0] - 1.0).abs() < 1e-9 && (after[1] - 3.0).abs() < 1e-9);
        assert!(drawn(&figure.panels[1])[1].hollow);
        assert_eq!(figure.share_y, Sharing::Column);
    }

    #[test]
    fn the_caption_counts_what_is_outside_and_what_is_missing() {
        let figure = residuals_before_after(&input());
        assert_says(&figure, "33 % without, 67 % with");
        assert_says(&figure, "1 reading has no standard deviation");
        assert_says(&figure, "The hollow point is flagged.");
        let svg = figure.to_svg();
        assert!(svg.contains("1 point has no place on the axes"));
        parse(&svg).unwrap();
    }

    #[test]
    fn the_band_is_the_quadratic_mean_at_each_target() {
        let mut input = input();
        input.points = vec![
            point(Direction::X, 0, 0.0, 0.0),
            point(Direction::X, 1, 0.0, 0.0),
            BeforeAfterPoint {
                noise_sd_m: Some(14e-6),
                ..point(Direction::X, 2, 0.0, 0.0)
            },
        ];
        let band_of = |figure: &Figure| match &figure.panels[0].series[0].marks {
            Marks::Band(band) => band.clone(),
            other => panic!("the band comes first: {other:?}"),
        };
        // Targets -10 and 0; at 0 sqrt((2² + 14²)/2) = 10.
        let band = band_of(&residuals_before_after(&input));
        assert_eq!(band.len(), 2);
        assert!((band[0][0] + 10.1).abs() < 1e-9 && (band[0][2] - 2.0).abs() < 1e-9);
        assert!((band[1][0]).abs() < 1e-9 && (band[1][2] - 10.0).abs() < 1e-9);
        input.against = ResidualsAgainst::Order;
        let band = band_of(&residuals_before_after(&input));
        let highs: Vec<f64> = band.iter().map(|[_, _, high]| high.round()).collect();
        assert_eq!(highs, [2.0, 2.0, 14.0]);
        // Far away in the session a new piece begins.
        input.points[2].sequence = 100;
        assert_eq!(band_of(&residuals_before_after(&input)).len(), 2);
    }

    #[test]
    fn no_readings_make_an_empty_figure() {
        let empty = ResidualsBeforeAfter {
            quantities: Quantities::default(),
            points: Vec::new(),
            ..input()
        };
        parse(&residuals_before_after(&empty).to_svg()).unwrap();
    }
}
