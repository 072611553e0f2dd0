//! The smallest effect that would have been found, for every law at its best and worst place.

use super::before_after::three_digits;
use super::caption::{counted_sentence, joined};
use super::figure::{Axis, Figure, FigureNote, FigurePoint, Marks, NotePlacement, Panel, Style};
use super::font;
use super::palette::{Colour, Marker, qualitative};
use super::quantities::AxisQuantity;
use super::text_room::{Reach, range_with_texts};

/// Width of the plot area, height of a row, size of the names of places, px.
const WIDTH_PX: f64 = 470.0;
const ROW_PX: f64 = 25.0;
const TEXT_PX: f64 = 9.5;
/// Between a point and the name of its place, px; the notes of a panel keep this distance.
const TEXT_GAP_PX: f64 = 15.0;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectionLimits {
    /// One entry for each law and place, in any order.
    pub limits: Vec<DetectionLimitBar>,
    /// Standard deviation of one reading, m, for comparison.
    pub reading_sd_m: Option<f64>,
    /// What is read.
    pub reading: AxisQuantity,
}

/// The smallest effect of a law at a place that is found in 80 % of sessions.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectionLimitBar {
    /// Name of the law.
    pub law: String,
    /// Place, for example `A3`; empty for a law that has only one.
    pub place: String,
    /// Largest change of a reading, m; `None` if the data cannot show the effect at this place.
    pub end_effect_m: Option<f64>,
}

impl DetectionLimitBar {
    /// Effect in the unit of the readings, if it has a place on a logarithmic axis.
    fn effect(&self, reading: &AxisQuantity) -> Option<f64> {
        let effect = reading.shown(self.end_effect_m?);
        (effect.is_finite() && effect > 0.0).then_some(effect)
    }
}

/// A law with its places, the smallest effect first.
struct LawRow<'a> {
    law: &'a str,
    known: Vec<(f64, &'a str)>,
    unknown: usize,
}

/// The figure: a row for each law, the most easily found at the top, with its best and its worst place named.
#[must_use]
pub fn detection_limits(input: &DetectionLimits) -> Figure {
    let rows = rows(input);
    let range = range(input, &rows);
    let mut panel = Panel::new(
        "",
        Axis {
            range,
            ..Axis::log10(
                "smallest end effect found in 80 % of sessions",
                &input.reading.unit,
            )
        },
        Axis::rows(rows.iter().map(|row| row.law.to_owned()).collect()),
    );
    if let Some(sd_m) = input.reading_sd_m {
        panel.draw_named(
            "standard deviation of one reading",
            Style::line(Colour::GREY, 1.2).dashed(),
            Marks::UprightAt(input.reading.shown(sd_m)),
        );
    }
    push_points(&mut panel, &rows);
    // Where the note of a row without points is placed: in the middle of the axis.
    let middle = range.map_or(1.0, |[low, high]| (low * high).sqrt());
    panel.notes = rows
        .iter()
        .enumerate()
        .flat_map(|(place, row)| notes(place as f64, middle, row))
        .collect();
    Figure {
        panel_px: [WIDTH_PX, ROW_PX * rows.len().max(3) as f64],
        panels: vec![panel],
        ..Figure::new(
            "Smallest effects that would have been found",
            caption(&rows, &input.reading),
        )
    }
}

/// Laws from the smallest effect to the largest; those that cannot be determined anywhere come last.
fn rows(input: &DetectionLimits) -> Vec<LawRow<'_>> {
    let mut rows: Vec<LawRow<'_>> = Vec::new();
    for limit in &input.limits {
        let found = rows.iter().position(|row| row.law == limit.law);
        let place = found.unwrap_or_else(|| {
            rows.push(LawRow {
                law: &limit.law,
                known: Vec::new(),
                unknown: 0,
            });
            rows.len() - 1
        });
        match limit.effect(&input.reading) {
            Some(effect) => rows[place].known.push((effect, &limit.place)),
            None => rows[place].unknown += 1,
        }
    }
    for row in &mut rows {
        row.known.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let best = |row: &LawRow<'_>| {
        row.known
            .first()
            .map_or(f64::INFINITY, |(effect, _)| *effect)
    };
    rows.sort_by(|a, b| best(a).total_cmp(&best(b)));
    rows
}

fn push_points(panel: &mut Panel, rows: &[LawRow<'_>]) {
    let mut spans = Vec::new();
    let [mut best, mut worst, mut between] = [Vec::new(), Vec::new(), Vec::new()];
    for (place, row) in rows.iter().enumerate() {
        let at = |effect: f64| FigurePoint::new(effect, place as f64);
        let Some(((first, _), others)) = row.known.split_first() else {
            continue;
        };
        best.push(at(*first));
        if let Some(((last, _), others)) = others.split_last() {
            spans.push([[*first, place as f64], [*last, place as f64]]);
            worst.push(at(*last));
            between.extend(others.iter().map(|(effect, _)| at(*effect)));
        }
    }
    panel.draw(Style::line(Colour::GREY, 1.2), Marks::Segments(spans));
    let looks = [
        (
            "best place",
            best,
            Style::new(qualitative(0), Marker::Circle).marker_size(4.2),
        ),
        (
            "worst place",
            worst,
            Style::new(qualitative(4), Marker::Square).marker_size(4.2),
        ),
        (
            "other places",
            between,
            Style::new(Colour::GREY, Marker::Dot).marker_size(4.4),
        ),
    ];
    for (label, points, style) in looks {
        panel.draw_named(label, style, Marks::Points(points));
    }
}

/// Texts to the left and to the right of a row's points.
fn texts(row: &LawRow<'_>) -> Option<[(f64, String); 2]> {
    let with = |(effect, place): &(f64, &str)| {
        let number = three_digits(*effect);
        if place.is_empty() {
            number
        } else {
            format!("{place}: {number}")
        }
    };
    let [first, last] = [row.known.first()?, row.known.last()?];
    Some(if row.known.len() == 1 {
        [(first.0, String::new()), (last.0, with(last))]
    } else {
        [(first.0, with(first)), (last.0, with(last))]
    })
}

fn notes(place: f64, middle: f64, row: &LawRow<'_>) -> Vec<FigureNote> {
    let note = |effect: f64, text: String, side: f64| {
        FigureNote::new(
            [effect, place],
            text,
            TEXT_PX,
            NotePlacement::Toward([side, 0.0]),
        )
    };
    let Some([(first, left), (last, right)]) = texts(row) else {
        let mut untestable = note(middle, "not testable with these data".to_owned(), 1.0);
        untestable.placement = NotePlacement::Centred;
        return vec![untestable];
    };
    [note(first, left, -1.0), note(last, right, 1.0)]
        .into_iter()
        .filter(|note| !note.text.is_empty())
        .collect()
}

/// Range in which all points and the names of their places lie.
fn range(input: &DetectionLimits, rows: &[LawRow<'_>]) -> Option<[f64; 2]> {
    let mut reaches: Vec<Reach> = Vec::new();
    for [(first, left), (last, right)] in rows.iter().filter_map(texts) {
        let wide = |text: &str| {
            if text.is_empty() {
                8.0
            } else {
                TEXT_GAP_PX + font::width_px(text, TEXT_PX)
            }
        };
        reaches.push(Reach {
            place: first.log10(),
            left_px: wide(&left),
            right_px: 8.0,
        });
        reaches.push(Reach {
            place: last.log10(),
            left_px: 8.0,
            right_px: wide(&right),
        });
    }
    let sd = input
        .reading_sd_m
        .map(|sd_m| input.reading.shown(sd_m).log10());
    reaches.extend(sd.map(|place| Reach {
        place,
        left_px: 8.0,
        right_px: 8.0,
    }));
    Some(range_with_texts(&reaches, WIDTH_PX)?.map(|end| 10f64.powf(end)))
}

fn caption(rows: &[LawRow<'_>], reading: &AxisQuantity) -> String {
    let unit = if reading.unit.is_empty() {
        String::new()
    } else {
        format!(", in {}", reading.unit)
    };
    let unknown: usize = rows.iter().map(|row| row.unknown).sum();
    joined([
        Some(format!(
            "End effect: largest change of a reading{unit}; the number stands beside its place. A line joins the best and the worst place of a law."
        )),
        counted_sentence(
            unknown,
            [
                "combination of law and place is",
                "combinations of law and place are",
            ],
            "not testable with these data and not drawn.",
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Quantities;
    use crate::png::parse;
    use crate::reading::{assert_says, labelled, notes_of, points_of};

    fn limit(law: &str, place: &str, end_effect_m: Option<f64>) -> DetectionLimitBar {
        DetectionLimitBar {
            law: law.to_owned(),
            place: place.to_owned(),
            end_effect_m,
        }
    }

    fn input() -> DetectionLimits {
        DetectionLimits {
            reading: Quantities::default().reading,
            limits: vec![
                limit("joint-compliance", "A3", Some(20e-6)),
                limit("joint-compliance", "B1", Some(7e-6)),
                limit("joint-compliance", "A1", Some(9e-6)),
                limit("joint-compliance", "D2", None),
                limit("slip", "", None),
                limit("creep", "", Some(3e-6)),
                limit("setting-in", "", Some(0.0)),
            ],
            reading_sd_m: Some(6e-6),
        }
    }

    #[test]
    fn laws_stand_from_the_smallest_effect_down_with_best_and_worst_place() {
        let figure = detection_limits(&input());
        let places = |label: &str| -> Vec<(f64, f64)> {
            let points = points_of(labelled(&figure.panels[0], label)).iter();
            points.map(|p| (p.x.round(), p.y)).collect()
        };
        assert_eq!(places("best place"), [(3.0, 0.0), (7.0, 1.0)]);
        assert_eq!(places("worst place"), [(20.0, 1.0)]);
        assert_eq!(places("other places"), [(9.0, 1.0)]);
        let texts = notes_of(&figure.panels[0]);
        let untestable = "not testable with these data";
        assert_eq!(
            texts,
            ["3.00", "B1: 7.00", "A3: 20.0", untestable, untestable]
        );
    }

    #[test]
    fn undecidable_places_are_counted() {
        let figure = detection_limits(&input());
        assert_says(&figure, "3 combinations");
        let svg = figure.to_svg();
        assert!(!svg.contains("no place on the axes"));
        parse(&svg).unwrap();
    }

    #[test]
    fn nothing_to_draw_still_makes_a_figure() {
        for limits in [vec![], vec![limit("slip", "", None)]] {
            let empty = DetectionLimits {
                reading: Quantities::default().reading,
                limits,
                reading_sd_m: None,
            };
            parse(&detection_limits(&empty).to_svg()).unwrap();
        }
    }
}
