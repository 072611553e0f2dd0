//! Fitting factors with their intervals and bounds.

use super::caption::{if_any, joined};
use super::figure::{Axis, Figure, FigurePoint, Marks, Panel, Polygon, Style};
use super::palette::{Colour, Marker, qualitative};

/// Colour of what the bounds allow.
const ALLOWED: Colour = Colour::GREY.with_opacity(0.5);

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorIntervals {
    /// One entry for each factor, the first at the top.
    pub factors: Vec<DrawnFactor>,
}

/// One fitting factor.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnFactor {
    /// Name, for example `beam Iy`.
    pub name: String,
    /// Value, dimensionless.
    pub value: f64,
    /// 95 % interval, or the separate parts that it consists of; empty for none.
    pub ci95: Vec<[f64; 2]>,
    /// Between which values the fit could choose.
    pub bounds: Option<[f64; 2]>,
    /// What became of it in the fit.
    pub fate: FactorFate,
}

/// What became of a factor in the fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FactorFate {
    /// Fitted.
    Free,
    /// Held.
    Fixed,
    /// Moves with another.
    Tied,
    /// Fitted, and ended at one of its bounds.
    AtBound,
    /// The data do not determine it.
    NotIdentified,
}

impl DrawnFactor {
    fn part_with_value(&self) -> Option<[f64; 2]> {
        let holds = |[low, high]: &&[f64; 2]| (*low..=*high).contains(&self.value);
        self.ci95.iter().find(holds).copied()
    }
}

impl FactorFate {
    const ALL: [Self; 5] = [
        Self::Free,
        Self::Fixed,
        Self::Tied,
        Self::AtBound,
        Self::NotIdentified,
    ];

    fn mark_style(self) -> (&'static str, Style) {
        let (label, colour, marker) = match self {
            Self::Free => ("fitted", qualitative(0), Marker::Circle),
            Self::Fixed => ("held", Colour::GREY, Marker::Square),
            Self::Tied => ("tied to another", qualitative(2), Marker::Diamond),
            Self::AtBound => ("fitted, at its bound", qualitative(4), Marker::Triangle),
            Self::NotIdentified => ("not determined by the data", Colour::BLACK, Marker::Cross),
        };
        (label, Style::new(colour, marker).marker_size(3.4))
    }
}

/// The figure: factors on a logarithmic axis; a wide pale bar is what the bounds allow.
#[must_use]
pub fn factor_intervals(input: &FactorIntervals) -> Figure {
    let names: Vec<String> = input.factors.iter().map(|f| f.name.clone()).collect();
    let mut panel = Panel::new(
        "",
        Axis::log10("fitting factor, multiple of the nominal constant", ""),
        Axis::rows(names),
    );
    let bounds: Vec<Polygon> = input
        .factors
        .iter()
        .enumerate()
        .filter_map(|(place, factor)| {
            let place = place as f64;
            let across = [place - 0.3, place + 0.3];
            Some(Polygon::rectangle(factor.bounds?, across, ALLOWED))
        })
        .collect();
    panel.draw_named(
        "allowed by the bounds",
        Style::new(ALLOWED, Marker::Square),
        Marks::Polygons(bounds),
    );
    for fate in FactorFate::ALL {
        let points: Vec<FigurePoint> = input
            .factors
            .iter()
            .enumerate()
            .filter(|(_, factor)| factor.fate == fate)
            .map(|(place, factor)| FigurePoint {
                x_bar: factor.part_with_value(),
                ..FigurePoint::new(factor.value, place as f64)
            })
            .collect();
        let (label, style) = fate.mark_style();
        let others = other_parts(&input.factors, fate);
        panel.draw(style, Marks::Segments(others));
        panel.draw_named(label, style, Marks::Points(points));
    }
    let without = input
        .factors
        .iter()
        .filter(|f| f.ci95.is_empty() && matches!(f.fate, FactorFate::Free | FactorFate::AtBound))
        .count();
    let apart = input.factors.iter().filter(|f| f.ci95.len() > 1).count();
    let caption = joined([
        Some("Bars: 95 % intervals of the fitted factors. A bar shorter than its point is covered by it.".to_owned()),
        if_any(
            apart,
            "Several bars beside each other are separate parts of one interval; values between them are excluded.".to_owned(),
        ),
        if_any(
            without,
            format!("{without} fitted factors have no interval."),
        ),
    ]);
    Figure {
        panel_px: [420.0, 30.0 * input.factors.len().max(2) as f64],
        panels: vec![panel],
        ..Figure::new("Fitting factors", caption)
    }
}

/// The parts without the value, of the factors with a fate.
fn other_parts(factors: &[DrawnFactor], fate: FactorFate) -> Vec<[[f64; 2]; 2]> {
    let of_fate = factors
        .iter()
        .enumerate()
        .filter(|(_, factor)| factor.fate == fate);
    let parts = of_fate.flat_map(|(place, factor)| {
        let others = factor
            .ci95
            .iter()
            .filter(|part| Some(**part) != factor.part_with_value());
        others.map(move |part| part.map(|end| [end, place as f64]))
    });
    parts.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;
    use crate::reading::{assert_says, points_of};

    #[test]
    fn every_status_has_its_own_mark_and_the_given_numbers() {
        let factor = |name: &str, value, fate| DrawnFactor {
            name: name.to_owned(),
            value,
            ci95: Vec::from_iter((fate == FactorFate::Free).then_some([0.5 * value, 2.0 * value])),
            bounds: Some([0.1 * value, 10.0 * value]),
            fate,
        };
        let figure = factor_intervals(&FactorIntervals {
            factors: FactorFate::ALL
                .into_iter()
                .map(|fate| factor("A", 0.003, fate))
                .collect(),
        });
        let series = &figure.panels[0].series;
        assert_eq!(series.len(), 6);
        let points = points_of(&series[1]);
        assert_eq!((points[0].x, points[0].y), (0.003, 0.0));
        assert_eq!(points[0].x_bar, Some([0.0015, 0.006]));
        for pair in series[1..].windows(2) {
            assert_ne!(pair[0].style.marker, pair[1].style.marker);
        }
        assert_says(&figure, "1 fitted factors have no interval");
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn no_factors_make_an_empty_figure() {
        parse(
            &factor_intervals(&FactorIntervals {
                factors: Vec::new(),
            })
            .to_svg(),
        )
        .unwrap();
    }
}
