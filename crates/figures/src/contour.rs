//! Lines of equal value over a grid (marching squares).
//!
//! Crossings of the grid's edges have whole numbers as names, so that pieces are joined exactly. A square with three known corners is
//! crossed as a triangle; a saddle is decided by the mean of its corners.

use std::collections::BTreeMap;

/// Values at the corners of a grid of squares, row by row; `None` where there is none.
pub(super) struct Grid {
    /// Columns and rows of corners.
    pub(super) size: [usize; 2],
    pub(super) values: Vec<Option<f64>>,
}

/// A corner of the grid.
type Corner = [usize; 2];
/// An edge that a line crosses: its two corners, the smaller first.
type Crossing = [Corner; 2];

impl Grid {
    fn at(&self, [column, row]: Corner) -> Option<f64> {
        self.values[row * self.size[0] + column]
    }

    /// Lines on which the value is `level`, in corners: closed ones end where they begin.
    pub(super) fn contours(&self, level: f64) -> Vec<Vec<[f64; 2]>> {
        let mut pieces = Vec::new();
        let [columns, rows] = self.size.map(|n| n.saturating_sub(1));
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |c| (row, c))) {
            let corners = [
                [column, row],
                [column + 1, row],
                [column + 1, row + 1],
                [column, row + 1],
            ];
            let known: Vec<(Corner, f64)> = corners
                .into_iter()
                .filter_map(|corner| Some((corner, self.at(corner)?)))
                .collect();
            if known.len() >= 3 {
                push_pieces(&known, level, &mut pieces);
            }
        }
        joined(&pieces)
            .into_iter()
            .map(|line| line.into_iter().map(|c| self.place(c, level)).collect())
            .collect()
    }

    /// Where an edge has the value `level`.
    fn place(&self, [from, to]: Crossing, level: f64) -> [f64; 2] {
        let [a, b] = [from, to].map(|corner| self.at(corner).unwrap_or(level));
        let share = if a == b { 0.5 } else { (level - a) / (b - a) };
        [0, 1].map(|i| from[i] as f64 + share * (to[i] as f64 - from[i] as f64))
    }
}

/// The pieces of line that cross a polygon of three or four corners, which stand in turn around it.
fn push_pieces(corners: &[(Corner, f64)], level: f64, pieces: &mut Vec<[Crossing; 2]>) {
    let n = corners.len();
    let is_above = |i: usize| corners[i % n].1 >= level;
    let crossings: Vec<Crossing> = (0..n)
        .filter(|&i| is_above(i) != is_above(i + 1))
        .map(|i| {
            let mut ends = [corners[i].0, corners[(i + 1) % n].0];
            ends.sort_unstable();
            ends
        })
        .collect();
    match crossings[..] {
        [a, b] => pieces.push([a, b]),
        // All four edges: the lines cut off the two corners that are not on the side of the middle.
        [a, b, c, d] => {
            let middle = corners.iter().map(|(_, value)| value).sum::<f64>() / n as f64;
            if is_above(0) == (middle >= level) {
                pieces.extend([[a, b], [c, d]]);
            } else {
                pieces.extend([[d, a], [b, c]]);
            }
        }
        _ => {}
    }
}

/// Pieces joined to lines, open ones first.
fn joined(pieces: &[[Crossing; 2]]) -> Vec<Vec<Crossing>> {
    let mut meeting: BTreeMap<Crossing, Vec<usize>> = BTreeMap::new();
    for (index, ends) in pieces.iter().enumerate() {
        for end in ends {
            meeting.entry(*end).or_default().push(index);
        }
    }
    let open = meeting.iter().filter(|(_, at)| at.len() == 1);
    let starts: Vec<Crossing> = open
        .map(|(crossing, _)| *crossing)
        .chain(pieces.iter().map(|ends| ends[0]))
        .collect();
    let mut used = vec![false; pieces.len()];
    let mut lines = Vec::new();
    for start in starts {
        let mut line = vec![start];
        let mut here = start;
        while let Some(&next) = meeting[&here].iter().find(|&&piece| !used[piece]) {
            used[next] = true;
            let [a, b] = pieces[next];
            here = if a == here { b } else { a };
            line.push(here);
        }
        if line.len() > 1 {
            lines.push(line);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(size: [usize; 2], value: impl Fn(f64, f64) -> Option<f64>) -> Grid {
        let places = (0..size[1]).flat_map(|row| (0..size[0]).map(move |c| (c as f64, row as f64)));
        Grid {
            size,
            values: places.map(|(x, y)| value(x, y)).collect(),
        }
    }

    #[test]
    fn a_circle_is_one_closed_line_around_its_area() {
        let field = grid([41, 41], |x, y| Some((x - 20.0).hypot(y - 20.0)));
        let lines = field.contours(15.3);
        assert_eq!(lines.len(), 1);
        let line = &lines[0];
        assert_eq!(line.first(), line.last());
        let area: f64 = line
            .windows(2)
            .map(|p| 0.5 * (p[0][0] * p[1][1] - p[1][0] * p[0][1]))
            .sum();
        let exact = std::f64::consts::PI * 15.3 * 15.3;
        // Chords of at most 1.4 under arcs of radius 15 take off a thousandth.
        assert!((area.abs() / exact - 1.0).abs() < 3e-3, "{area} {exact}");
    }

    #[test]
    fn a_slope_has_a_straight_line_from_border_to_border() {
        let field = grid([5, 4], |x, _| Some(x));
        assert_eq!(
            field.contours(2.25),
            [[[2.25, 0.0], [2.25, 1.0], [2.25, 2.0], [2.25, 3.0]]]
        );
        assert!(field.contours(9.0).is_empty());
    }

    #[test]
    fn unknown_corners_cut_the_line_and_a_triangle_is_crossed() {
        // The corner (1, 0) is unknown: the line of the slope in y begins in the triangle beside it.
        let field = grid([3, 2], |x, y| (!(x == 1.0 && y == 0.0)).then_some(y));
        let lines = field.contours(0.5);
        assert_eq!(lines.len(), 2);
        assert!(lines.iter().all(|line| line.len() == 2), "{lines:?}");
    }

    #[test]
    fn a_saddle_is_parted_by_its_middle() {
        let saddle = |high: f64| {
            grid([2, 2], |x, y| Some(if x == y { high } else { 0.0 }))
                .contours(1.0)
                .concat()
        };
        // Middle 0.75 is below: the high corners (0, 0) and (1, 1) are cut off, each by its own line.
        let low = saddle(1.5);
        let third = 1.0 / 3.0;
        for point in &low {
            let near = [0, 1].map(|i| point[i].min(1.0 - point[i]));
            assert!(near[0].max(near[1]) < third + 1e-12, "{low:?}");
        }
        assert_eq!((low.len(), saddle(4.0).len()), (4, 4));
        let ends: Vec<bool> = low.iter().map(|p| p[0] + p[1] < 1.0).collect();
        assert_eq!(ends.iter().filter(|near| **near).count(), 2, "{low:?}");
        assert_eq!(ends[0], ends[1], "each line stays at its corner: {low:?}");
    }
}
