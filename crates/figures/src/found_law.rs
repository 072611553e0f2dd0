//! The law that was found, over what the readings show without it.

use stiffbench_units_and_text::test_point::Branch;

use super::caption::{
    Bar, counted, counted_sentence, flagged_entry, hollow_sentence, if_any, joined,
};
use super::figure::{Axis, Figure, FigurePoint, Marks, Panel, Series, Style};
use super::palette::{Colour, qualitative};
use super::quantities::Quantities;
use super::range::finite_ends;
use super::residuals::time_unit;

/// Panels that are drawn; more would shrink below what can be read.
const MOST_PANELS: usize = 6;
/// Repeats up to which each has its own tick.
const MOST_REPEATS: f64 = 40.0;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundLaw {
    /// The law and where it acts, for example `joint-backlash at A3`.
    pub found: String,
    /// What drives it.
    pub driving: DrivingQuantity,
    /// What loads and readings are.
    pub quantities: Quantities,
    /// What the bars of all points are.
    pub bar: Bar,
    /// One panel for a cell, or one for several pooled; those where the law stands out most are drawn.
    pub panels: Vec<LawPanel>,
}

/// What drives a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DrivingQuantity {
    /// Signed force, N.
    Force,
    /// Signed displacement, m.
    Displacement,
    /// Seconds since the zero of the run or the start of the session.
    Clock,
    /// Seconds under the load.
    Hold,
    /// Number of the repeat.
    Repeat,
    /// What the law itself does to the reading, m: of readings that are each under a load of their own.
    Change,
}

/// Points and curves of one cell, or of several pooled.
#[derive(Debug, Clone, PartialEq)]
pub struct LawPanel {
    /// Heading, for example `P3 y` or `all cells`.
    pub heading: String,
    /// What the readings leave when everything but the law is subtracted.
    pub points: Vec<LawPoint>,
    /// The law as fitted, one curve or more.
    pub curves: Vec<LawCurve>,
}

/// Mean of readings at one value of the driving quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawPoint {
    /// Value of the driving quantity, SI.
    pub at: f64,
    /// Measured displacement minus the prediction without the law, m.
    pub residual_m: f64,
    /// Half the length of the bar, m.
    pub bar_m: Option<f64>,
    /// Readings behind the point.
    pub n: usize,
    /// Loading or unloading.
    pub branch: Branch,
    /// Whether a reading behind it is flagged.
    pub flagged: bool,
}

/// A curve of the law.
#[derive(Debug, Clone, PartialEq)]
pub struct LawCurve {
    /// Entry in the legend, for example `law, 95 % interval`.
    pub name: String,
    /// How its points are joined.
    pub shape: CurveShape,
    /// Driving quantity (SI) and displacement (m), in the order in which they are passed.
    pub points: Vec<[f64; 2]>,
}

/// How the points of a curve are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurveShape {
    /// By a line.
    Line,
    /// By a line that ends where it began.
    Loop,
    /// Level until the next.
    Steps,
}

/// The figure: up to six panels, the one where the law stands out most from the scatter first, each with its own scale.
#[must_use]
pub fn found_law(input: &FoundLaw) -> Figure {
    let mut order: Vec<&LawPanel> = input.panels.iter().collect();
    // The sort is stable: panels where it stands out alike stay in the given order.
    order.sort_by(|a, b| standing_out(b).total_cmp(&standing_out(a)));
    let left_out = order.len().saturating_sub(MOST_PANELS);
    order.truncate(MOST_PANELS);
    let scaled = Across::of(input, &order);
    let has_unloading = order
        .iter()
        .flat_map(|panel| &panel.points)
        .any(|point| point.branch == Branch::Unloading);
    let flagged = order
        .iter()
        .flat_map(|panel| &panel.points)
        .filter(|point| point.flagged)
        .count();
    let (columns, panel_px) = match order.len() {
        0 | 1 => (1, [440.0, 280.0]),
        2 | 4 => (2, [320.0, 200.0]),
        _ => (3, [226.0, 170.0]),
    };
    Figure {
        columns,
        panel_px,
        panels: order
            .iter()
            .map(|law| panel(law, (&scaled, &input.quantities), has_unloading))
            .collect(),
        legend: flagged_entry(flagged),
        ..Figure::new(
            format!("What {} does to the readings", input.found),
            caption(input, &order, left_out, flagged),
        )
    }
}

fn caption(input: &FoundLaw, drawn: &[&LawPanel], left_out: usize, flagged: usize) -> String {
    let points = || drawn.iter().flat_map(|panel| &panel.points);
    let with_bar = points().filter(|point| point.bar_m.is_some());
    let without = points().filter(|point| point.bar_m.is_none()).count();
    joined([
        Some(format!(
            "Points: measured {} minus the prediction without {}.",
            input.quantities.reading.name, input.found
        )),
        Some(input.bar.sentence(with_bar.map(|point| point.n))),
        counted_sentence(without, ["point has", "points have"], "no bar."),
        (drawn.len() > 1).then(|| "Every panel has its own scale.".to_owned()),
        if_any(
            left_out,
            format!(
                "Where the law stands out less, {} not drawn.",
                counted(left_out, "further panel is", "further panels are")
            ),
        ),
        hollow_sentence(flagged),
    ])
}

/// How far a law reaches compared with the bars of its points; a stiff direction shows a small effect better than a soft one.
///
/// Panels without bars are compared by their reach alone.
fn standing_out(panel: &LawPanel) -> f64 {
    let bars: Vec<f64> = panel.points.iter().filter_map(|p| p.bar_m).collect();
    let mean = bars.iter().sum::<f64>() / bars.len() as f64;
    if mean > 0.0 {
        reach_m(panel) / mean
    } else {
        reach_m(panel)
    }
}

/// How far the curves of a panel reach from their lowest to their highest point, m.
fn reach_m(panel: &LawPanel) -> f64 {
    let points = panel.curves.iter().flat_map(|curve| &curve.points);
    finite_ends(points.map(|[_, y]| *y)).map_or(0.0, |[low, high]| high - low)
}

/// The horizontal axis: its name and how SI values come onto it.
struct Across {
    axis: Axis,
    /// SI value at the place 0.
    origin: f64,
    /// SI units in a unit of the axis.
    unit: f64,
}

impl Across {
    fn of(input: &FoundLaw, panels: &[&LawPanel]) -> Self {
        let values = panels.iter().flat_map(|panel| {
            let curves = panel.curves.iter().flat_map(|curve| &curve.points);
            let points = panel.points.iter().map(|point| point.at);
            points.chain(curves.map(|[x, _]| *x))
        });
        let [low, high] = finite_ends(values).unwrap_or([f64::MAX, f64::MIN]);
        let plain = |axis, unit| Self {
            axis,
            origin: 0.0,
            unit,
        };
        let Quantities { load, reading, .. } = &input.quantities;
        match input.driving {
            DrivingQuantity::Force => plain(load.axis(), load.si),
            DrivingQuantity::Change => plain(reading.axis_of("change by the law"), reading.si),
            DrivingQuantity::Displacement => plain(reading.axis(), reading.si),
            DrivingQuantity::Hold => plain(Axis::linear("time under load", "s"), 1.0),
            DrivingQuantity::Clock => {
                let (name, unit_s) = time_unit(high);
                plain(Axis::linear("time", name), unit_s)
            }
            // A name for every repeat: an even axis would mark halves of them.
            DrivingQuantity::Repeat if low <= high && high - low <= MOST_REPEATS => {
                let origin = low.floor();
                let count = (high.ceil() - origin) as usize + 1;
                let names = (0..count).map(|place| format!("{}", origin + place as f64));
                Self {
                    axis: Axis::categories("repeat", names.collect()),
                    origin,
                    unit: 1.0,
                }
            }
            DrivingQuantity::Repeat => plain(Axis::linear("repeat", ""), 1.0),
        }
    }

    fn place(&self, value: f64) -> f64 {
        (value - self.origin) / self.unit
    }
}

fn panel(
    law: &LawPanel,
    (across, quantities): (&Across, &Quantities),
    has_unloading: bool,
) -> Panel {
    let reading = &quantities.reading;
    let mut panel = Panel::new(
        law.heading.clone(),
        across.axis.clone(),
        reading.axis_of("residual without the law"),
    );
    panel.draw(Style::line(Colour::INK, 0.8), Marks::LevelAt(0.0));
    for (place, curve) in law.curves.iter().enumerate() {
        let at = |&[x, y]: &[f64; 2]| [across.place(x), reading.shown(y)];
        let points = curve.points.iter().map(at).collect();
        panel.series.push(curve_series(place, curve, points));
    }
    for (place, branch) in [Branch::Loading, Branch::Unloading].into_iter().enumerate() {
        let points: Vec<FigurePoint> = law
            .points
            .iter()
            .filter(|point| point.branch == branch)
            .map(|point| {
                let at = across.place(point.at);
                let bar = point.bar_m.map(|bar| reading.shown(bar));
                FigurePoint::of_reading(at, reading.shown(point.residual_m), bar, point.flagged)
            })
            .collect();
        let label = if has_unloading {
            format!("readings, {branch}")
        } else {
            "readings".to_owned()
        };
        let style = Style::nth(place).marker_size(3.0);
        panel.draw_named(label, style, Marks::Points(points));
    }
    panel
}

/// A curve with its points in the units of the axes; the first is a full line, all others are broken.
fn curve_series(place: usize, curve: &LawCurve, mut points: Vec<[f64; 2]>) -> Series {
    let style = match place {
        0 => Style::line(qualitative(4), 1.8),
        1 => Style::line(Colour::BLACK, 1.3).dashed(),
        n => Style::line(qualitative(n), 1.3).dashed(),
    };
    let marks = match curve.shape {
        CurveShape::Line => Marks::Line(points),
        CurveShape::Loop => {
            points.extend(points.first().copied());
            Marks::Line(points)
        }
        CurveShape::Steps => Marks::Steps(points),
    };
    Series::labelled(curve.name.clone(), style, marks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::AxisScale;
    use crate::png::parse;
    use crate::reading::{assert_says, line_of, points_of};

    fn law(heading: &str, size_m: f64, shape: CurveShape) -> LawPanel {
        let point = |at, branch| LawPoint {
            at,
            residual_m: size_m,
            bar_m: (at < 0.0).then_some(1e-6),
            n: 5,
            branch,
            flagged: false,
        };
        LawPanel {
            heading: heading.to_owned(),
            points: vec![
                point(0.0, Branch::Loading),
                point(-70.0, Branch::Loading),
                point(-30.0, Branch::Unloading),
            ],
            curves: vec![LawCurve {
                name: "law".to_owned(),
                shape,
                points: vec![[0.0, 0.0], [-70.0, -size_m], [-30.0, -0.5 * size_m]],
            }],
        }
    }

    fn input(panels: Vec<LawPanel>) -> FoundLaw {
        FoundLaw {
            found: "joint-friction at A3".to_owned(),
            driving: DrivingQuantity::Force,
            quantities: Quantities::default(),
            bar: Bar::StandardUncertainty,
            panels,
        }
    }

    #[test]
    fn six_panels_are_drawn_where_the_law_reaches_farthest() {
        let sizes = [1e-6, 8e-6, 3e-6, 5e-6, 2e-6, 7e-6, 9e-6, 4e-6];
        let panels = sizes
            .iter()
            .map(|size| law(&format!("{:.0}", size / 1e-6), *size, CurveShape::Line));
        let figure = found_law(&input(panels.collect()));
        let headings: Vec<&str> = figure.panels.iter().map(|p| p.title.as_str()).collect();
        assert_eq!(headings, ["9", "8", "7", "5", "4", "3"]);
        assert_says(&figure, "2 further panels");
        assert_says(&figure, "6 points have no bar");
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn a_loop_is_closed_and_steps_are_steps_in_micrometres() {
        let curve = |shape| {
            let figure = found_law(&input(vec![law("P1 y", 20e-6, shape)]));
            figure.panels[0].series[1].clone()
        };
        let closed = curve(CurveShape::Loop);
        let line = line_of(&closed);
        assert_eq!(line.len(), 4);
        assert_eq!(line[0], line[3]);
        assert!((line[1][1] + 20.0).abs() < 1e-9);
        assert_eq!(line_of(&curve(CurveShape::Line)).len(), 3);
        let steps = curve(CurveShape::Steps).marks;
        assert!(matches!(steps, Marks::Steps(points) if points.len() == 3));
    }

    #[test]
    fn branches_have_their_own_marks_and_bars_their_own_length() {
        let figure = found_law(&input(vec![law("P1 y", 20e-6, CurveShape::Loop)]));
        let [loading, unloading] = [&figure.panels[0].series[2], &figure.panels[0].series[3]];
        assert_eq!(unloading.label.as_deref(), Some("readings, unloading"));
        assert_ne!(loading.style.marker, unloading.style.marker);
        let points = points_of(loading);
        let [low, high] = points[1].y_bar.unwrap();
        assert!((low - 19.0).abs() < 1e-9 && (high - 21.0).abs() < 1e-9);
        assert_eq!(points[0].y_bar, None);
    }

    #[test]
    fn every_driving_quantity_has_its_unit() {
        let at = |driving, at: f64| {
            let mut panel = law("all cells", 20e-6, CurveShape::Line);
            panel.points.truncate(1);
            panel.points[0].at = at;
            panel.curves[0].points = vec![[at, 0.0]];
            let figure = found_law(&FoundLaw {
                driving,
                ..input(vec![panel])
            });
            let points = points_of(&figure.panels[0].series[2]);
            (figure.panels[0].x.label.clone(), points[0].x)
        };
        assert_eq!(
            at(DrivingQuantity::Force, -70.0),
            ("load (N)".to_owned(), -70.0)
        );
        for (driving, name) in [
            (DrivingQuantity::Displacement, "displacement (µm)"),
            (DrivingQuantity::Change, "change by the law (µm)"),
        ] {
            let (label, x) = at(driving, -3e-4);
            assert_eq!(label, name);
            assert!((x + 300.0).abs() < 1e-9);
        }
        assert_eq!(at(DrivingQuantity::Clock, 7200.5).0, "time (h)");
        assert_eq!(
            at(DrivingQuantity::Clock, 600.0),
            ("time (min)".to_owned(), 10.0)
        );
        assert_eq!(
            at(DrivingQuantity::Hold, 60.0),
            ("time under load (s)".to_owned(), 60.0)
        );
        assert_eq!(at(DrivingQuantity::Repeat, 3.0), ("repeat".to_owned(), 0.0));
        assert_eq!(at(DrivingQuantity::Repeat, f64::INFINITY).0, "repeat");
    }

    #[test]
    fn repeats_are_named_from_the_first_to_the_last() {
        let mut panel = law("all cells", 20e-6, CurveShape::Line);
        for (place, point) in panel.points.iter_mut().enumerate() {
            point.at = 2.0 + place as f64;
        }
        panel.curves.clear();
        let figure = found_law(&FoundLaw {
            driving: DrivingQuantity::Repeat,
            ..input(vec![panel])
        });
        assert_eq!(
            figure.panels[0].x.scale,
            AxisScale::Categories(["2", "3", "4"].map(str::to_owned).to_vec())
        );
    }

    #[test]
    fn nothing_found_makes_an_empty_figure() {
        parse(&found_law(&input(Vec::new())).to_svg()).unwrap();
    }
}
