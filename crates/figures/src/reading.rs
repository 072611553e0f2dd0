//! What tests read out of a figure.

use super::figure::{Figure, FigurePoint, Marks, Panel, Polygon, Series};

/// The texts of the notes of a panel.
pub(super) fn notes_of(panel: &Panel) -> Vec<&str> {
    panel.notes.iter().map(|note| note.text.as_str()).collect()
}

/// The series of a panel that the legend names so.
pub(super) fn labelled<'a>(panel: &'a Panel, label: &str) -> &'a Series {
    let mut series = panel.series.iter();
    series
        .find(|series| series.label.as_deref() == Some(label))
        .unwrap_or_else(|| panic!("`{label}` is drawn"))
}

pub(super) fn points_of(series: &Series) -> &[FigurePoint] {
    match &series.marks {
        Marks::Points(points) => points,
        other => panic!("no points: {other:?}"),
    }
}

pub(super) fn line_of(series: &Series) -> &[[f64; 2]] {
    match &series.marks {
        Marks::Line(line) => line,
        other => panic!("no line: {other:?}"),
    }
}

pub(super) fn areas_of(series: &Series) -> &[Polygon] {
    match &series.marks {
        Marks::Polygons(areas) => areas,
        other => panic!("no areas: {other:?}"),
    }
}

/// The points of all series of a panel.
pub(super) fn all_points(panel: &Panel) -> Vec<FigurePoint> {
    let drawn = panel
        .series
        .iter()
        .filter_map(|series| match &series.marks {
            Marks::Points(points) => Some(points.clone()),
            _ => None,
        });
    drawn.flatten().collect()
}

/// Fails if the caption does not contain some words; its blanks may be narrow or hard.
pub(super) fn assert_says(figure: &Figure, words: &str) {
    let caption = figure.caption.replace('\u{a0}', " ");
    assert!(caption.contains(words), "`{words}` is not in {caption}");
}
