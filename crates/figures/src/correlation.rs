//! Correlations of a fit as a coloured table with its numbers.

use super::caption::{if_any, joined};
use super::figure::{Axis, Figure, FigureNote, Marks, NotePlacement, Panel, Polygon, Style};
use super::palette::{Colour, Marker, diverging};
use super::ticks::signed;
use super::value_table::HALF;
use stiffbench_numeric::least_squares::STRONG_CORRELATION;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Correlation {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Correlation of every pair, row by row, from -1 to 1; NaN or a missing entry where there is none.
    pub matrix: Vec<Vec<f64>>,
}

/// The figure: a cell for each pair; blue is negative, orange positive, and the number stands in it.
#[must_use]
pub fn correlation(input: &Correlation) -> Figure {
    let n = input.names.len();
    let cell_px = (560.0 / n.max(1) as f64).clamp(26.0, 58.0);
    let size_px = (0.27 * cell_px).clamp(8.0, 13.0);
    let mut polygons = Vec::with_capacity(n * n);
    let mut notes = Vec::with_capacity(n * n);
    let mut unknown = 0;
    let mut strong = 0;
    for row in 0..n {
        for column in 0..n {
            let entry = input
                .matrix
                .get(row)
                .and_then(|entries| entries.get(column))
                .copied()
                .filter(|entry| entry.is_finite());
            let colour = entry.map_or(Colour::FAINT, diverging);
            unknown += usize::from(entry.is_none());
            strong +=
                usize::from(column > row && entry.is_some_and(|e| e.abs() > STRONG_CORRELATION));
            let at = [column as f64, row as f64];
            polygons.push(Polygon::square(at, HALF, colour));
            notes.push(FigureNote {
                colour: colour.readable_ink(),
                ..FigureNote::new(
                    at,
                    entry.map_or_else(|| "–".to_owned(), |entry| signed(entry, 2)),
                    size_px,
                    NotePlacement::Centred,
                )
            });
        }
    }
    let pairs = n * n.saturating_sub(1) / 2;
    let caption = joined([
        Some("Blue: negative; orange: positive; white: none.".to_owned()),
        Some(format!(
            "Pairs beyond ±{STRONG_CORRELATION}: {strong} of {pairs}."
        )),
        if_any(unknown, format!("{unknown} entries marked – are unknown.")),
    ]);
    let mut panel = Panel::new(
        "",
        Axis::categories("", input.names.clone()),
        Axis::rows(input.names.clone()),
    );
    panel.draw(
        Style::new(Colour::INK, Marker::Square),
        Marks::Polygons(polygons),
    );
    panel.notes = notes;
    Figure {
        panel_px: [cell_px * n.max(1) as f64; 2],
        panels: vec![panel],
        ..Figure::new("Correlation of the fitted parameters", caption)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;
    use crate::reading::{assert_says, notes_of};

    #[test]
    fn every_pair_has_its_number_and_shade() {
        let figure = correlation(&Correlation {
            names: vec!["A".to_owned(), "Iy".to_owned()],
            matrix: vec![vec![1.0, -0.954], vec![-0.954, 1.0]],
        });
        let texts = notes_of(&figure.panels[0]);
        assert_eq!(texts, ["1.00", "−0.95", "−0.95", "1.00"]);
        assert_says(&figure, "Pairs beyond ±0.95: 1 of 1.");
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn unknown_entries_are_marked_and_counted() {
        let figure = correlation(&Correlation {
            names: vec!["A".to_owned(), "J".to_owned()],
            matrix: vec![vec![1.0, f64::NAN], vec![0.5]],
        });
        assert_says(&figure, "2 entries marked –");
        assert_eq!(figure.panels[0].notes[1].text, "–");
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn no_parameters_make_an_empty_figure() {
        let empty = Correlation {
            names: Vec::new(),
            matrix: Vec::new(),
        };
        parse(&correlation(&empty).to_svg()).unwrap();
    }
}
