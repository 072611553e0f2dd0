//! How often an effect is found, and found under its right name, against its size.

use super::caption::{count_range, counted_sentence, if_any, joined};
use super::figure::{Axis, Figure, FigurePoint, Marks, Panel, Sharing, Style};
use super::palette::{Colour, Marker, qualitative};

/// Shares that are marked, percent.
const MARKS_PERCENT: [f64; 2] = [80.0, 95.0];
/// Distance between the points at one size, so that their bars do not hide each other, standard errors.
const ASIDE: f64 = 0.15;
/// Sizes that the axis shows at least, standard errors: where chance and certainty begin.
const SHOWN: [f64; 2] = [2.0, 9.0];
/// Room beside the outermost size, standard errors.
const ROOM: f64 = 0.7;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct PowerCurves {
    /// One panel for each law.
    pub laws: Vec<LawPower>,
}

/// Trials of one law.
#[derive(Debug, Clone, PartialEq)]
pub struct LawPower {
    /// Name of the law, with its place if it has one.
    pub name: String,
    /// One entry for each size that was tried, in any order.
    pub sizes: Vec<PowerAtSize>,
}

/// Trials of one size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerAtSize {
    /// Injected size in standard errors of its estimate; 0 for benches without the effect.
    pub size_standard_errors: f64,
    /// Benches that were tried.
    pub trials: usize,
    /// Share of trials in which something was found.
    pub detected: Rate,
    /// Share of trials in which it was found under its right name; `None` where there is no right name.
    pub named: Option<Rate>,
    /// Share, 0 to 1, that an observer with known noise finds under its right name; `None` where it was not computed.
    pub ideal: Option<f64>,
    /// Share of named effects whose size lies in its 95 % interval; `None` where none was named or it has no size.
    pub covered: Option<Rate>,
}

/// A share of trials.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rate {
    /// 0 to 1.
    pub share: f64,
    /// 95 % binomial interval, 0 to 1.
    pub ci95: Option<[f64; 2]>,
}

/// The figure: a small panel for each law with one scale.
#[must_use]
pub fn power_curves(input: &PowerCurves) -> Figure {
    let (columns, panel_px) = match input.laws.len() {
        0 | 1 => (1, [440.0, 280.0]),
        2 | 4 => (2, [300.0, 190.0]),
        _ => (3, [226.0, 140.0]),
    };
    Figure {
        columns,
        panel_px,
        share_x: Sharing::All,
        share_y: Sharing::All,
        panels: input
            .laws
            .iter()
            .map(|law| panel(law, shown(input)))
            .collect(),
        ..Figure::new(
            "How often an effect is found and rightly named",
            caption(input),
        )
    }
}

/// Sizes that all panels show.
fn shown(input: &PowerCurves) -> [f64; 2] {
    let sizes = input.laws.iter().flat_map(|law| &law.sizes);
    sizes.fold(SHOWN, |[low, high], size| {
        let size = size.size_standard_errors;
        [low.min(size - ROOM), high.max(size + ROOM)]
    })
}

fn panel(law: &LawPower, shown: [f64; 2]) -> Panel {
    let mut panel = Panel::new(
        law.name.clone(),
        Axis::linear("size in standard errors", "").within(shown),
        Axis {
            range: Some([-4.0, 104.0]),
            grid: false,
            ..Axis::linear("share of trials", "%")
        },
    );
    for (place, mark) in MARKS_PERCENT.into_iter().enumerate() {
        let style = Style::line(Colour::GREY, 0.9);
        let style = if place == 0 { style.dashed() } else { style };
        panel.draw_named(format!("{mark:.0} %"), style, Marks::LevelAt(mark));
    }
    let mut sizes: Vec<&PowerAtSize> = law.sizes.iter().collect();
    sizes.sort_by(|a, b| a.size_standard_errors.total_cmp(&b.size_standard_errors));
    let detected = sizes.iter().map(|size| point(size, &size.detected, -ASIDE));
    push_curve(
        &mut panel,
        "something found",
        Style::new(qualitative(0), Marker::Circle),
        detected.collect(),
    );
    let named = sizes
        .iter()
        .filter_map(|size| Some(point(size, size.named.as_ref()?, 0.0)));
    push_curve(
        &mut panel,
        "found under its right name",
        Style::new(qualitative(4), Marker::Square),
        named.collect(),
    );
    let covered = sizes
        .iter()
        .filter_map(|size| Some(point(size, size.covered.as_ref()?, ASIDE)));
    push_curve(
        &mut panel,
        "of these the size in its 95 % interval",
        Style::new(qualitative(2), Marker::Triangle),
        covered.collect(),
    );
    let ideal = sizes
        .iter()
        .filter_map(|size| Some([size.size_standard_errors, 100.0 * size.ideal?]));
    panel.draw_named(
        "right names with known noise",
        Style::new(qualitative(4), Marker::Square)
            .stroke(0.8)
            .dashed(),
        Marks::Line(ideal.collect()),
    );
    panel
}

/// A share in percent, a little beside its size.
fn point(size: &PowerAtSize, rate: &Rate, aside: f64) -> FigurePoint {
    FigurePoint {
        y_bar: rate.ci95.map(|ends| ends.map(|end| 100.0 * end)),
        ..FigurePoint::new(size.size_standard_errors + aside, 100.0 * rate.share)
    }
}

fn push_curve(panel: &mut Panel, label: &str, style: Style, points: Vec<FigurePoint>) {
    let line = points.iter().map(|point| [point.x, point.y]).collect();
    panel.draw_named(label, style.stroke(1.1), Marks::Line(line));
    panel.draw_named(label, style.marker_size(3.0), Marks::Points(points));
}

fn caption(input: &PowerCurves) -> String {
    let sizes = || input.laws.iter().flat_map(|law| &law.sizes);
    let rates = || {
        sizes().flat_map(|size| {
            let further = size.named.into_iter().chain(size.covered);
            std::iter::once(size.detected).chain(further)
        })
    };
    let without = rates().filter(|rate| rate.ci95.is_none()).count();
    let empty = input.laws.iter().filter(|law| law.sizes.is_empty()).count();
    joined([
        Some(format!(
            "Bars: 95 % binomial intervals of {} trials a point, for intervals of those named; the points of one size are drawn a little apart.",
            count_range(sizes().map(|size| size.trials))
        )),
        if_any(
            sizes()
                .filter(|size| size.size_standard_errors == 0.0)
                .count(),
            "At size 0 nothing is there, and what is found is a false alarm.".to_owned(),
        ),
        counted_sentence(without, ["point has", "points have"], "no interval."),
        counted_sentence(empty, ["law has", "laws have"], "no trials."),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;
    use crate::reading::{assert_says, points_of};

    fn size(size_standard_errors: f64, detected: f64, named: Option<f64>) -> PowerAtSize {
        let rate = |share: f64| Rate {
            share,
            ci95: (share < 1.0).then_some([0.9 * share, 1.1 * share]),
        };
        PowerAtSize {
            size_standard_errors,
            trials: 200,
            detected: rate(detected),
            named: named.map(rate),
            ideal: named.map(|share| 0.5 * share),
            covered: None,
        }
    }

    #[test]
    fn shares_are_percent_in_order_of_size() {
        let figure = power_curves(&PowerCurves {
            laws: vec![LawPower {
                name: "creep".to_owned(),
                sizes: vec![
                    size(4.5, 1.0, Some(0.8)),
                    size(0.0, 0.04, None),
                    size(2.25, 0.5, Some(0.4)),
                ],
            }],
        });
        let curves: Vec<Vec<[f64; 2]>> = figure.panels[0]
            .series
            .iter()
            .filter_map(|series| match &series.marks {
                Marks::Line(line) => Some(line.clone()),
                _ => None,
            })
            .collect();
        let expected = [
            vec![[-ASIDE, 4.0], [2.25 - ASIDE, 50.0], [4.5 - ASIDE, 100.0]],
            vec![[2.25, 40.0], [4.5, 80.0]],
            vec![[2.25, 20.0], [4.5, 40.0]],
        ];
        assert_eq!(curves, expected);
        assert_eq!(figure.panels[0].x.range, Some([-ROOM, 9.0]));
        let points = points_of(&figure.panels[0].series[3]);
        let [low, high] = points[1].y_bar.unwrap();
        assert!((low - 45.0).abs() < 1e-9 && (high - 55.0).abs() < 1e-9);
        assert_says(&figure, "n = 200 trials");
        assert_says(&figure, "1 point has no interval");
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn both_marks_are_in_every_panel_and_once_in_the_legend() {
        let law = |name: &str| LawPower {
            name: name.to_owned(),
            sizes: Vec::new(),
        };
        let figure = power_curves(&PowerCurves {
            laws: vec![law("creep"), law("slip"), law("setting-in")],
        });
        for panel in &figure.panels {
            let levels: Vec<f64> = panel
                .series
                .iter()
                .filter_map(|series| match series.marks {
                    Marks::LevelAt(level) => Some(level),
                    _ => None,
                })
                .collect();
            assert_eq!(levels, MARKS_PERCENT);
        }
        assert_says(&figure, "3 laws have no trials");
        assert_eq!(figure.to_svg().matches("80 %").count(), 1);
        parse(&power_curves(&PowerCurves { laws: vec![] }).to_svg()).unwrap();
    }
}
