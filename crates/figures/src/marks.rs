//! Drawing the marks of a series in its frame.

use super::canvas::{Canvas, Stroke};
use super::figure::{FigurePoint, Marks, Style};
use super::layout::Frame;
use super::palette::{Colour, Marker};

/// Half the width of the cap of a bar, px.
const CAP_PX: f64 = 2.6;
/// Length and half width of an arrow's head, px.
const HEAD_PX: [f64; 2] = [9.0, 4.0];

impl Frame {
    /// Place of a point; `None` if it has none.
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        Some([self.x.place(x)?, self.y.place(y)?])
    }

    /// Whether a point lies in the plot area.
    pub(super) fn holds(&self, [x, y]: [f64; 2]) -> bool {
        self.x.holds(x) && self.y.holds(y)
    }
}

/// How many points of a series cannot be drawn.
pub(super) fn undrawn(frame: &Frame, marks: &Marks) -> usize {
    match marks {
        Marks::Points(points) => points
            .iter()
            .filter(|point| !frame.holds([point.x, point.y]))
            .count(),
        _ => 0,
    }
}

/// Draws a series, cut at the border of the plot area.
pub(super) fn draw(canvas: &mut Canvas<'_>, frame: &Frame, style: &Style, marks: &Marks) {
    let stroke = Stroke {
        colour: style.colour,
        width_px: style.stroke_px,
        dash_px: style.dash_px,
    };
    match marks {
        Marks::Points(points) => draw_points(canvas, frame, style, points),
        Marks::Line(points) => draw_line(canvas, frame, points, stroke),
        Marks::Steps(points) => draw_line(canvas, frame, &staircase(points), stroke),
        Marks::Segments(pairs) => {
            for pair in pairs {
                draw_line(canvas, frame, pair, stroke);
            }
        }
        Marks::Band(points) => {
            let there = points.iter().map(|[x, low, _]| [*x, *low]);
            let back = points.iter().rev().map(|[x, _, high]| [*x, *high]);
            draw_area(
                canvas,
                frame,
                &there.chain(back).collect::<Vec<_>>(),
                style.colour,
            );
        }
        Marks::Polygons(polygons) => {
            for polygon in polygons {
                draw_area(canvas, frame, &polygon.corners, polygon.colour);
            }
        }
        Marks::Arrows(pairs) => {
            for [from, to] in pairs {
                if let (Some(from), Some(to)) = (frame.place(*from), frame.place(*to)) {
                    draw_arrow(canvas, from, to, stroke);
                }
            }
        }
        Marks::LevelAt(value) => {
            if let Some(y) = frame.y.place(*value).filter(|_| frame.y.holds(*value)) {
                let [left, _, width, _] = frame.area;
                canvas.line([left, y], [left + width, y], stroke);
            }
        }
        Marks::UprightAt(value) => {
            if let Some(x) = frame.x.place(*value).filter(|_| frame.x.holds(*value)) {
                let [_, top, _, height] = frame.area;
                canvas.line([x, top], [x, top + height], stroke);
            }
        }
    }
}

/// Draws the hollow points of a series: after all other marks of the panel, so that a flagged reading is never covered.
pub(super) fn draw_hollow(canvas: &mut Canvas<'_>, frame: &Frame, style: &Style, marks: &Marks) {
    let Marks::Points(points) = marks else {
        return;
    };
    for (_, at) in placed(frame, points).filter(|(point, _)| point.hollow) {
        draw_marker(canvas, at, style, true);
    }
}

/// Points that lie in the plot area, with their places.
fn placed<'a>(
    frame: &'a Frame,
    points: &'a [FigurePoint],
) -> impl Iterator<Item = (&'a FigurePoint, [f64; 2])> {
    points
        .iter()
        .filter(|point| frame.holds([point.x, point.y]))
        .filter_map(|point| Some((point, frame.place([point.x, point.y])?)))
}

/// Bars of all points, then the filled points.
fn draw_points(canvas: &mut Canvas<'_>, frame: &Frame, style: &Style, points: &[FigurePoint]) {
    let stroke = Stroke::new(style.colour, 1.0);
    for (point, [x, y]) in placed(frame, points) {
        if let Some(ends) = point.y_bar {
            let ends = ends.map(|end| (frame.y.stopped(end), frame.y.holds(end)));
            canvas.line([x, ends[0].0], [x, ends[1].0], stroke);
            for (end, _) in ends.into_iter().filter(|(_, whole)| *whole) {
                canvas.line([x - CAP_PX, end], [x + CAP_PX, end], stroke);
            }
        }
        if let Some(ends) = point.x_bar {
            let ends = ends.map(|end| (frame.x.stopped(end), frame.x.holds(end)));
            canvas.line([ends[0].0, y], [ends[1].0, y], stroke);
            for (end, _) in ends.into_iter().filter(|(_, whole)| *whole) {
                canvas.line([end, y - CAP_PX], [end, y + CAP_PX], stroke);
            }
        }
    }
    for (_, at) in placed(frame, points).filter(|(point, _)| !point.hollow) {
        draw_marker(canvas, at, style, false);
    }
}

/// One marker; the legend uses it too.
pub(super) fn draw_marker(canvas: &mut Canvas<'_>, at: [f64; 2], style: &Style, hollow: bool) {
    let [x, y] = at;
    let r = style.marker_px;
    let outline = Stroke::new(style.colour, 1.3);
    // Shapes of equal radius differ in area; these factors make them look equally large.
    let corners: Vec<[f64; 2]> = match style.marker {
        Marker::Circle | Marker::Dot => {
            let r = if style.marker == Marker::Dot {
                0.5 * r
            } else {
                r
            };
            if hollow {
                canvas.disc(at, r, Colour::WHITE);
                canvas.ring(at, r, outline);
            } else {
                canvas.disc(at, r, style.colour);
            }
            return;
        }
        Marker::Cross => {
            canvas.line([x - r, y - r], [x + r, y + r], outline);
            canvas.line([x - r, y + r], [x + r, y - r], outline);
            return;
        }
        Marker::Dash => {
            let stroke = Stroke::new(style.colour, 2.4);
            canvas.line([x - 2.2 * r, y], [x + 2.2 * r, y], stroke);
            return;
        }
        Marker::Ground => return draw_ground(canvas, at, r, style.colour),
        Marker::Square => {
            let r = 0.9 * r;
            vec![
                [x - r, y - r],
                [x + r, y - r],
                [x + r, y + r],
                [x - r, y + r],
            ]
        }
        Marker::Triangle => vec![
            [x, y - 1.25 * r],
            [x + 1.15 * r, y + 0.8 * r],
            [x - 1.15 * r, y + 0.8 * r],
        ],
        Marker::Nabla => vec![
            [x, y + 1.25 * r],
            [x + 1.15 * r, y - 0.8 * r],
            [x - 1.15 * r, y - 0.8 * r],
        ],
        Marker::Diamond => vec![
            [x, y - 1.3 * r],
            [x + 1.3 * r, y],
            [x, y + 1.3 * r],
            [x - 1.3 * r, y],
        ],
    };
    if hollow {
        canvas.polygon(&corners, Colour::WHITE);
        // The second corner once more, so that the joint at the first is not left open.
        let closed: Vec<[f64; 2]> = corners.iter().chain(&corners[..2]).copied().collect();
        canvas.path(&closed, outline);
    } else {
        canvas.polygon(&corners, style.colour);
    }
}

/// A held node: triangle, ground line, hatching below.
fn draw_ground(canvas: &mut Canvas<'_>, [x, y]: [f64; 2], r: f64, colour: Colour) {
    let ground = y + 1.8 * r;
    canvas.polygon(
        &[[x, y], [x + 1.3 * r, ground], [x - 1.3 * r, ground]],
        colour,
    );
    let stroke = Stroke::new(colour, 1.2);
    canvas.line([x - 2.2 * r, ground], [x + 2.2 * r, ground], stroke);
    for i in -2..=2 {
        let start = x + f64::from(i) * r;
        canvas.line(
            [start, ground],
            [start - 0.9 * r, ground + 1.1 * r],
            Stroke::new(colour, 0.9),
        );
    }
}

/// An arrow whose tip is at `to`; a short one keeps its head.
pub(super) fn draw_arrow(canvas: &mut Canvas<'_>, from: [f64; 2], to: [f64; 2], stroke: Stroke) {
    let along = [to[0] - from[0], to[1] - from[1]];
    let length = along[0].hypot(along[1]);
    // Less than half a pixel has no direction that could be seen.
    if length < 0.5 {
        return;
    }
    let unit = along.map(|c| c / length);
    let [head, half] = HEAD_PX;
    let neck = [to[0] - head * unit[0], to[1] - head * unit[1]];
    if length > head {
        canvas.line(from, neck, stroke);
    }
    canvas.polygon(
        &[
            to,
            [neck[0] - half * unit[1], neck[1] + half * unit[0]],
            [neck[0] + half * unit[1], neck[1] - half * unit[0]],
        ],
        stroke.colour,
    );
}

/// A line cut at the border; it is broken at points that have no place.
fn draw_line(canvas: &mut Canvas<'_>, frame: &Frame, points: &[[f64; 2]], stroke: Stroke) {
    let mut run: Vec<[f64; 2]> = Vec::new();
    let placed: Vec<Option<[f64; 2]>> = points.iter().map(|p| frame.place(*p)).collect();
    for pair in placed.windows(2) {
        let piece = match (pair[0], pair[1]) {
            (Some(from), Some(to)) => clipped(frame.area, from, to),
            _ => None,
        };
        let Some([from, to]) = piece else {
            canvas.path(&std::mem::take(&mut run), stroke);
            continue;
        };
        if run.last() != Some(&from) {
            canvas.path(&std::mem::take(&mut run), stroke);
            run.push(from);
        }
        run.push(to);
    }
    canvas.path(&run, stroke);
}

/// The part of a straight piece inside a rectangle.
///
/// # Source
/// Y.-D. Liang and B. A. Barsky, A new concept and method for line clipping, ACM Trans. Graphics 3 (1984) 1-22.
pub(super) fn clipped(
    [left, top, width, height]: [f64; 4],
    from: [f64; 2],
    to: [f64; 2],
) -> Option<[[f64; 2]; 2]> {
    let along = [to[0] - from[0], to[1] - from[1]];
    let mut span = [0.0_f64, 1.0_f64];
    for (p, q) in [
        (-along[0], from[0] - left),
        (along[0], left + width - from[0]),
        (-along[1], from[1] - top),
        (along[1], top + height - from[1]),
    ] {
        if p == 0.0 {
            if q < 0.0 {
                return None;
            }
        } else if p < 0.0 {
            span[0] = span[0].max(q / p);
        } else {
            span[1] = span[1].min(q / p);
        }
    }
    // A whole piece keeps its ends bit by bit, so that pieces join.
    let at = |t: f64| {
        if t == 0.0 {
            from
        } else if t == 1.0 {
            to
        } else {
            [from[0] + t * along[0], from[1] + t * along[1]]
        }
    };
    (span[0] <= span[1]).then(|| span.map(at))
}

/// An area; a corner beyond the border is moved straight onto it, so an edge that crosses the border slantwise bends there.
fn draw_area(canvas: &mut Canvas<'_>, frame: &Frame, corners: &[[f64; 2]], colour: Colour) {
    let placed: Option<Vec<[f64; 2]>> = corners.iter().map(|c| frame.place(*c)).collect();
    let Some(placed) = placed else {
        return;
    };
    let [left, top, width, height] = frame.area;
    let moved: Vec<[f64; 2]> = placed
        .iter()
        .map(|[x, y]| [x.clamp(left, left + width), y.clamp(top, top + height)])
        .collect();
    canvas.polygon(&moved, colour);
}

/// A staircase through points: level until the next.
fn staircase(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut corners = Vec::with_capacity(2 * points.len());
    for (index, point) in points.iter().enumerate() {
        if index > 0 {
            corners.push([point[0], points[index - 1][1]]);
        }
        corners.push(*point);
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: [f64; 4] = [0.0, 0.0, 10.0, 10.0];

    #[test]
    fn lines_are_cut_at_the_border() {
        assert_eq!(
            clipped(AREA, [-5.0, 5.0], [15.0, 5.0]),
            Some([[0.0, 5.0], [10.0, 5.0]])
        );
        assert_eq!(
            clipped(AREA, [2.0, 2.0], [3.0, 3.0]),
            Some([[2.0, 2.0], [3.0, 3.0]])
        );
        assert_eq!(clipped(AREA, [-5.0, 11.0], [15.0, 11.0]), None);
        assert_eq!(clipped(AREA, [-2.0, 1.0], [1.0, -2.0]), None);
    }

    #[test]
    fn a_staircase_is_level_between_points() {
        assert_eq!(
            staircase(&[[0.0, 1.0], [2.0, 3.0]]),
            [[0.0, 1.0], [2.0, 1.0], [2.0, 3.0]]
        );
    }
}
