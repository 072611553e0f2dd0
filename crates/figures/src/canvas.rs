//! Drawing in pixels through the SVG backend of plotters.
//!
//! Decision. Only the backend of plotters is used, not its charts: those place labels by guessed text sizes and offer no legend
//! outside the data. The backend takes whole numbers only, so everything is drawn in tenths of a pixel and the head of the file
//! states it in its `viewBox`.

use plotters::backend::{DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    Color, FontDesc, FontFamily, FontStyle, FontTransform, RGBAColor, ShapeStyle, TextStyle,
};

use super::font;
use super::palette::Colour;

/// Units of the drawing in a pixel.
const UNITS_PER_PX: f64 = 10.0;
/// Largest coordinate that is written, px: farther points are brought back to it, so that no number overflows.
const FARTHEST_PX: f64 = 1e6;

/// A sheet to draw on; y grows downward from the upper left corner.
pub(super) struct Canvas<'a> {
    backend: SVGBackend<'a>,
}

/// Look of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    pub(super) colour: Colour,
    pub(super) width_px: f64,
    /// Stroke and gap.
    pub(super) dash_px: Option<[f64; 2]>,
}

impl Stroke {
    pub(super) fn new(colour: Colour, width_px: f64) -> Self {
        Self {
            colour,
            width_px,
            dash_px: None,
        }
    }
}

/// Which part of a text stands at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Align {
    Start,
    Middle,
    End,
}

/// Draws a sheet and gives its SVG text with title and description for screen readers.
pub(super) fn sheet(
    size_px: [f64; 2],
    title: &str,
    description: &str,
    draw: impl FnOnce(&mut Canvas<'_>),
) -> String {
    let [width, height] = size_px.map(f64::ceil);
    let [wide, high] = [width, height].map(|px| units(px).unsigned_abs());
    let mut drawn = String::new();
    {
        let mut canvas = Canvas {
            backend: SVGBackend::with_string(&mut drawn, (wide, high)),
        };
        canvas.rectangle([0.0, 0.0, width, height], Colour::WHITE);
        draw(&mut canvas);
        canvas.backend.present().expect(NEVER_FAILS);
    }
    // The head as plotters writes it is one line; ours has the size in pixels and the two texts.
    let body = drawn.split_once('\n').map_or("", |(_, body)| body);
    format!(
        "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {wide} {high}\" xmlns=\"http://www.w3.org/2000/svg\" \
         role=\"img\">\n<title>{}</title>\n<desc>{}</desc>\n{body}",
        escaped(title),
        escaped(description)
    )
}

const NEVER_FAILS: &str = "drawing into a string cannot fail";

impl Canvas<'_> {
    /// A line through points.
    pub(super) fn path(&mut self, points: &[[f64; 2]], stroke: Stroke) {
        if points.len() < 2 {
            return;
        }
        let style = shape(stroke.colour, stroke.width_px);
        let pieces = match stroke.dash_px {
            None => vec![points.to_vec()],
            Some(pattern) => dashes(points, pattern),
        };
        for piece in pieces {
            self.backend
                .draw_path(piece.into_iter().map(place), &style)
                .expect(NEVER_FAILS);
        }
    }

    /// A straight line.
    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2], stroke: Stroke) {
        if stroke.dash_px.is_some() {
            self.path(&[from, to], stroke);
            return;
        }
        self.backend
            .draw_line(
                place(from),
                place(to),
                &shape(stroke.colour, stroke.width_px),
            )
            .expect(NEVER_FAILS);
    }

    /// A filled polygon.
    pub(super) fn polygon(&mut self, corners: &[[f64; 2]], colour: Colour) {
        if corners.len() < 3 {
            return;
        }
        self.backend
            .fill_polygon(corners.iter().copied().map(place), &shape(colour, 0.0))
            .expect(NEVER_FAILS);
    }

    /// A filled rectangle: left, top, width, height.
    pub(super) fn rectangle(&mut self, [left, top, width, height]: [f64; 4], colour: Colour) {
        self.backend
            .draw_rect(
                place([left, top]),
                place([left + width, top + height]),
                &shape(colour, 0.0),
                true,
            )
            .expect(NEVER_FAILS);
    }

    /// A filled disc.
    pub(super) fn disc(&mut self, centre: [f64; 2], radius_px: f64, colour: Colour) {
        self.circle(centre, radius_px, shape(colour, 0.0), true);
    }

    /// A circle's outline.
    pub(super) fn ring(&mut self, centre: [f64; 2], radius_px: f64, stroke: Stroke) {
        let style = shape(stroke.colour, stroke.width_px);
        self.circle(centre, radius_px, style, false);
    }

    fn circle(&mut self, centre: [f64; 2], radius_px: f64, style: ShapeStyle, is_filled: bool) {
        let radius = units(radius_px).unsigned_abs();
        self.backend
            .draw_circle(place(centre), radius, &style, is_filled)
            .expect(NEVER_FAILS);
    }

    /// One line of text whose baseline runs through `at`.
    pub(super) fn text(
        &mut self,
        at: [f64; 2],
        text: &str,
        size_px: f64,
        colour: Colour,
        align: Align,
    ) {
        // The backend shifts a text with this anchor down by 0.76 of its size.
        let top = [at[0], at[1] - 0.76 * size_px];
        self.draw_text(top, text, size_px, colour, align, FontTransform::None);
    }

    /// One line of text that reads upward, whose baseline runs through `at`.
    pub(super) fn text_upward(
        &mut self,
        at: [f64; 2],
        text: &str,
        size_px: f64,
        colour: Colour,
        align: Align,
    ) {
        let left = [at[0] - 0.76 * size_px, at[1]];
        self.draw_text(left, text, size_px, colour, align, FontTransform::Rotate270);
    }

    fn draw_text(
        &mut self,
        at: [f64; 2],
        text: &str,
        size_px: f64,
        colour: Colour,
        align: Align,
        transform: FontTransform,
    ) {
        if text.is_empty() {
            return;
        }
        let horizontal = match align {
            Align::Start => HPos::Left,
            Align::Middle => HPos::Center,
            Align::End => HPos::Right,
        };
        // The backend divides font sizes by 1.24.
        let description = FontDesc::new(
            FontFamily::Name(font::FAMILIES),
            (size_px * UNITS_PER_PX).round() * 1.24,
            FontStyle::Normal,
        )
        .transform(transform);
        let ink = colour_of(colour);
        let style = TextStyle::from(description)
            .color(&ink)
            .pos(Pos::new(horizontal, VPos::Top));
        self.backend
            .draw_text(text, &style, place(at))
            .expect(NEVER_FAILS);
    }
}

fn units(px: f64) -> i32 {
    (px.clamp(-FARTHEST_PX, FARTHEST_PX) * UNITS_PER_PX).round() as i32
}

fn place([x, y]: [f64; 2]) -> (i32, i32) {
    (units(x), units(y))
}

fn colour_of(colour: Colour) -> RGBAColor {
    let [red, green, blue] = colour.rgb;
    RGBAColor(red, green, blue, colour.opacity)
}

fn shape(colour: Colour, width_px: f64) -> ShapeStyle {
    colour_of(colour).stroke_width(units(width_px).unsigned_abs())
}

fn escaped(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '&' => "&amp;".to_owned(),
            '<' => "&lt;".to_owned(),
            '>' => "&gt;".to_owned(),
            other => other.to_string(),
        })
        .collect()
}

/// The drawn pieces of a broken line.
fn dashes(points: &[[f64; 2]], [stroke_px, gap_px]: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut pieces = Vec::new();
    let mut piece = vec![points[0]];
    let mut drawing = true;
    let mut left_px = stroke_px;
    for pair in points.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let mut done = 0.0;
        while length - done > left_px {
            done += left_px;
            let t = done / length;
            let here = [0, 1].map(|i| from[i] + t * (to[i] - from[i]));
            if drawing {
                piece.push(here);
                pieces.push(std::mem::take(&mut piece));
            } else {
                piece = vec![here];
            }
            drawing = !drawing;
            left_px = if drawing { stroke_px } else { gap_px };
        }
        left_px -= length - done;
        if drawing {
            piece.push(to);
        }
    }
    if drawing && piece.len() > 1 {
        pieces.push(piece);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_head_has_size_title_and_description() {
        let svg = sheet([100.0, 50.0], "a < b", "c & d", |canvas| {
            canvas.text([10.25, 20.0], "5 µm", 11.0, Colour::INK, Align::Start);
        });
        assert!(svg.starts_with(
            "<svg width=\"100\" height=\"50\" viewBox=\"0 0 1000 500\" xmlns=\"http://www.w3.org/2000/svg\" role=\"img\">\n\
             <title>a &lt; b</title>\n<desc>c &amp; d</desc>\n"
        ));
        assert!(svg.contains("font-size=\"110\""), "{svg}");
        assert!(svg.trim_end().ends_with("</svg>"));
    }

    #[test]
    fn dashes_cover_their_share_of_the_line() {
        let pieces = dashes(&[[0.0, 0.0], [60.0, 0.0], [60.0, 40.0]], [6.0, 4.0]);
        let drawn: f64 = pieces
            .iter()
            .flat_map(|piece| piece.windows(2))
            .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
            .sum();
        assert!((drawn - 60.0).abs() < 1e-9, "{drawn}");
        assert_eq!(pieces.len(), 10);
    }

    #[test]
    fn far_and_impossible_points_do_not_overflow() {
        let svg = sheet([10.0, 10.0], "", "", |canvas| {
            canvas.line(
                [f64::NEG_INFINITY, f64::NAN],
                [1e300, 3.0],
                Stroke::new(Colour::BLACK, 1.0),
            );
        });
        assert!(svg.contains("10000000"));
    }
}
