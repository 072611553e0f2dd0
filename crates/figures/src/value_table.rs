//! A coloured table of signed values, and the colour bar beside it.

use super::figure::{Axis, FigureNote, Marks, NotePlacement, Panel, Polygon, Style};
use super::font;
use super::palette::{Colour, Marker, diverging};
use super::range::{spread, unspread};
use super::ticks::signed;

/// Share of the scale beyond which a square without room for its number shows its sign: paler ones read as zero anyway.
pub(super) const SIGNED_SHARE: f64 = 0.25;
/// Sizes of the numbers in the squares that are tried, px.
const NUMBER_PX: [f64; 3] = [9.5, 8.5, 7.5];
/// Half the side of a square: a thin gap parts it from its neighbours.
pub(super) const HALF: f64 = 0.485;
/// Shades of the colour bar.
const SHADES: usize = 80;

/// Squares of a table.
pub(super) struct ValueTable<'a> {
    /// Rows and columns.
    pub(super) size: [usize; 2],
    /// Place of the first row on the vertical axis.
    pub(super) first_row: f64,
    /// Value of the darkest shade.
    pub(super) limit: f64,
    /// Width of a square, px.
    pub(super) square_px: f64,
    /// Value at a row and column; `None` makes a hatched square.
    pub(super) value: &'a dyn Fn(usize, usize) -> Option<f64>,
}

impl ValueTable<'_> {
    /// Adds squares, hatching and numbers to a panel; false if only signs had room in the squares.
    pub(super) fn push_to(&self, panel: &mut Panel) -> bool {
        let [rows, columns] = self.size;
        let mut squares = Vec::with_capacity(rows * columns);
        let mut hatching = Vec::new();
        let mut numbers = Vec::new();
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |c| (row, c))) {
            let at = [column as f64, row as f64 + self.first_row];
            let value = (self.value)(row, column);
            let colour = value.map_or(Colour::FAINT, |value| diverging(value / self.limit));
            squares.push(Polygon::square(at, HALF, colour));
            match value {
                None => hatching.extend(hatched(at)),
                Some(value) => numbers.push((at, value)),
            }
        }
        panel.draw(
            Style::new(Colour::INK, Marker::Square),
            Marks::Polygons(squares),
        );
        panel.draw(
            Style::new(Colour::GREY, Marker::Square).stroke(0.8),
            Marks::Segments(hatching),
        );
        self.push_numbers(panel, &numbers)
    }

    fn push_numbers(&self, panel: &mut Panel, numbers: &[([f64; 2], f64)]) -> bool {
        let fits = |size_px: &f64| {
            numbers
                .iter()
                .all(|(_, value)| font::width_px(&number(*value), *size_px) <= self.square_px - 3.0)
        };
        let fitting_px = NUMBER_PX.into_iter().find(|size_px| fits(size_px));
        for (at, value) in numbers {
            let text = match fitting_px {
                Some(_) => number(*value),
                None if value.abs() < SIGNED_SHARE * self.limit => continue,
                None if *value < 0.0 => "−".to_owned(),
                None => "+".to_owned(),
            };
            panel.notes.push(FigureNote {
                colour: diverging(value / self.limit).readable_ink(),
                ..FigureNote::new(
                    *at,
                    text,
                    fitting_px.unwrap_or(NUMBER_PX[0]),
                    NotePlacement::Centred,
                )
            });
        }
        fitting_px.is_some()
    }
}

/// A number of a square: two digits are enough to compare.
pub(super) fn number(value: f64) -> String {
    signed(value, usize::from(value.abs() < 9.95))
}

/// Three slanting lines over a square.
fn hatched([x, y]: [f64; 2]) -> [[[f64; 2]; 2]; 3] {
    [
        [[x - HALF, y], [x, y - HALF]],
        [[x - HALF, y + HALF], [x + HALF, y - HALF]],
        [[x, y + HALF], [x + HALF, y]],
    ]
}

/// The colour scale with its numbers, from the least to the greatest value along `axis`.
pub(super) fn colour_bar(axis: Axis, range: [f64; 2], colour: impl Fn(f64) -> Colour) -> Panel {
    let [low, high] = range.map(|end| spread(&axis.scale, end).unwrap_or(0.0));
    let value = |shade: f64| unspread(&axis.scale, low + (high - low) * shade / SHADES as f64);
    let shades = (0..SHADES).map(|shade| {
        let [from, middle] = [0.0, 0.5].map(|part| value(shade as f64 + part));
        // A shade reaches to the end and is covered by the next: side by side they would show seams.
        Polygon::rectangle([-0.5, 0.5], [from, range[1]], colour(middle))
    });
    let shades = shades.collect();
    let mut panel = Panel::new(
        "",
        Axis::categories("", vec![String::new()]),
        Axis {
            range: Some(range),
            grid: false,
            ..axis
        },
    );
    panel.draw(
        Style::new(Colour::INK, Marker::Square),
        Marks::Polygons(shades),
    );
    panel
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::areas_of;

    #[test]
    fn the_colour_bar_darkens_to_both_ends() {
        let bar = colour_bar(Axis::linear("residual", "µm"), [-12.0, 12.0], |value| {
            diverging(value / 12.0)
        });
        let shades = areas_of(&bar.series[0]);
        assert_eq!(shades.len(), SHADES);
        assert_eq!(shades[0].corners[0], [-0.5, -12.0]);
        let middle = SHADES / 2;
        assert!(shades[0].colour.grey() < shades[middle].colour.grey());
        assert!(shades[SHADES - 1].colour.grey() < shades[middle].colour.grey());
        assert_eq!(bar.y.range, Some([-12.0, 12.0]));
    }

    #[test]
    fn hatching_stays_in_its_square() {
        for [x, y] in hatched([2.0, 5.0]).into_iter().flatten() {
            let reach = HALF + 1e-12;
            assert!((x - 2.0).abs() <= reach && (y - 5.0).abs() <= reach);
        }
    }
}
