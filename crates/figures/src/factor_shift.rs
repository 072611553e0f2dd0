//! Fitting factors without and with what was found.

use super::caption::{counted_sentence, joined};
use super::figure::{Axis, Figure, FigurePoint, Marks, Panel, Series, Style};
use super::palette::{Colour, Marker, qualitative};
use super::ticks::signed;

/// Half the distance between the two points of a factor, in rows.
const ASIDE: f64 = 0.17;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorShift {
    /// What was added to the prediction, for example `joint-backlash at A3`.
    pub found: String,
    /// One entry for each factor, the first at the top.
    pub factors: Vec<ShiftedFactor>,
}

/// One fitting factor, fitted twice.
#[derive(Debug, Clone, PartialEq)]
pub struct ShiftedFactor {
    /// Name, for example `beam Iy`.
    pub name: String,
    /// Fitted without what was found.
    pub before: FactorValue,
    /// Fitted with it.
    pub after: FactorValue,
}

/// A factor and its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FactorValue {
    /// Value, dimensionless.
    pub value: f64,
    /// 95 % interval; `None` for a factor that was held or that the data do not determine.
    pub ci95: Option<[f64; 2]>,
}

/// The figure: every factor as a multiple of its value before, which stands above its value after; factors that differ by
/// thousands would hide a shift of a few percent on a common axis.
#[must_use]
pub fn factor_shift(input: &FactorShift) -> Figure {
    let names = input.factors.iter().map(row_name).collect();
    let mut panel = Panel::new(
        "",
        Axis::log10("fitting factor, multiple of its value before", ""),
        Axis::rows(names),
    );
    panel.draw(
        Style::line(Colour::GREY, 1.0).dashed(),
        Marks::UprightAt(1.0),
    );
    for place in 1..input.factors.len() {
        panel.draw(
            Style::line(Colour::FAINT, 0.8),
            Marks::LevelAt(place as f64 - 0.5),
        );
    }
    let before = Style::new(qualitative(1), Marker::Circle);
    let after = Style::new(qualitative(0), Marker::Square);
    push_values(&mut panel, input, ("without", before, -ASIDE), |f| f.before);
    push_values(&mut panel, input, ("with", after, ASIDE), |f| f.after);
    Figure {
        panel_px: [400.0, 36.0 * input.factors.len().max(2) as f64],
        panels: vec![panel],
        ..Figure::new(
            format!("Fitting factors without and with {}", input.found),
            caption(input),
        )
    }
}

/// Name of a factor with its two values.
fn row_name(factor: &ShiftedFactor) -> String {
    let [before, after] = [factor.before, factor.after].map(|v| three_digits(v.value));
    format!("{}: {before} → {after}", factor.name)
}

/// A factor with three digits that matter.
fn three_digits(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let magnitude = if value == 0.0 {
        0.0
    } else {
        value.abs().log10().floor()
    };
    signed(value, (2.0 - magnitude).clamp(0.0, 8.0) as usize)
}

fn push_values(
    panel: &mut Panel,
    input: &FactorShift,
    (label, style, aside): (&str, Style, f64),
    value_of: impl Fn(&ShiftedFactor) -> FactorValue,
) {
    let points = input.factors.iter().enumerate().map(|(place, factor)| {
        let value = value_of(factor);
        let relative = |v: f64| v / factor.before.value;
        FigurePoint {
            x_bar: value.ci95.map(|ends| ends.map(relative)),
            ..FigurePoint::new(relative(value.value), place as f64 + aside)
        }
    });
    panel.series.push(Series::labelled(
        label,
        style.marker_size(3.6),
        Marks::Points(points.collect()),
    ));
}

fn caption(input: &FactorShift) -> String {
    let both = || input.factors.iter().flat_map(|f| [f.before, f.after]);
    let without = both().filter(|value| value.ci95.is_none()).count();
    // Where a value lies outside the other's interval, the factor had soaked up part of what was found.
    let outside = |value: &FactorValue, other: &FactorValue| {
        other
            .ci95
            .is_some_and(|[low, high]| value.value < low || value.value > high)
    };
    let moved = input
        .factors
        .iter()
        .filter(|f| outside(&f.before, &f.after) && outside(&f.after, &f.before))
        .count();
    joined([
        Some(
            "Bars: 95 % intervals; one shorter than its point is covered by it. The names carry the values without and with what was found."
                .to_owned(),
        ),
        Some(format!(
            "{moved} of {} factors moved so far that each value lies outside the other's interval.",
            input.factors.len()
        )),
        counted_sentence(without, ["value has", "values have"], "no interval."),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;
    use crate::reading::assert_says;

    fn factor(name: &str, before: f64, after: f64) -> ShiftedFactor {
        let value = |value: f64| FactorValue {
            value,
            ci95: Some([value / 1.1, value * 1.1]),
        };
        ShiftedFactor {
            name: name.to_owned(),
            before: value(before),
            after: value(after),
        }
    }

    #[test]
    fn before_stands_above_after_and_moved_factors_are_counted() {
        let mut held = factor("beam J", 1.0, 1.0);
        held.before.ci95 = None;
        held.after.ci95 = None;
        let figure = factor_shift(&FactorShift {
            found: "joint-backlash at A3".to_owned(),
            factors: vec![
                factor("beam Iy", 0.004, 0.008),
                factor("beam Iz", 1.0, 1.05),
                held,
            ],
        });
        let drawn: Vec<&Vec<FigurePoint>> = figure.panels[0]
            .series
            .iter()
            .filter_map(|series| match &series.marks {
                Marks::Points(points) => Some(points),
                _ => None,
            })
            .collect();
        assert_eq!((drawn[0][0].x, drawn[1][0].x), (1.0, 2.0));
        let [low, high] = drawn[1][0].x_bar.unwrap();
        assert!((low - 2.0 / 1.1).abs() < 1e-12 && (high - 2.2).abs() < 1e-12);
        assert!(drawn[0][1].y < 1.0 && drawn[1][1].y > 1.0);
        assert_says(&figure, "1 of 3 factors moved");
        assert_says(&figure, "2 values have no interval");
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn values_are_written_with_three_digits() {
        let names = [0.0021, 0.964, 100.0, 0.0, f64::NAN].map(three_digits);
        assert_eq!(names, ["0.00210", "0.964", "100", "0.00", "–"]);
        assert_eq!(
            row_name(&factor("beam A", 0.0021, 0.003)),
            "beam A: 0.00210 → 0.00300"
        );
    }

    #[test]
    fn a_factor_without_a_value_before_is_counted_as_not_drawn() {
        let figure = factor_shift(&FactorShift {
            found: "creep".to_owned(),
            factors: vec![factor("beam A", f64::NAN, 1.0), factor("beam J", 1.0, 1.0)],
        });
        assert!(
            figure
                .to_svg()
                .contains("2 points have no place on the axes")
        );
    }

    #[test]
    fn no_factors_make_an_empty_figure() {
        let empty = FactorShift {
            found: String::new(),
            factors: Vec::new(),
        };
        parse(&factor_shift(&empty).to_svg()).unwrap();
    }
}
