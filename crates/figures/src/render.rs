//! From a figure and its layout to SVG.

use super::canvas::{Align, Canvas, Stroke, sheet};
use super::figure::{Figure, LegendEntry, LegendMark, Marks, Panel};
use super::font;
use super::labels;
use super::layout::{
    CAPTION_PX, Frame, HEADING_PX, LABEL_PX, LEGEND_PX, LINE, Layout, SAMPLE_PX, Side,
    TICK_LENGTH_PX, TICK_PX, TITLE_PX, layout,
};
use super::marks;
use super::palette::{Colour, Marker};
use super::range::Ruler;

/// Draws a figure.
pub(super) fn svg(figure: &Figure) -> String {
    let caption = full_caption(figure);
    let layout = layout(figure, &caption);
    sheet(layout.size_px, &figure.title, &caption, |canvas| {
        for line in &layout.title {
            canvas.text(line.at, &line.text, TITLE_PX, Colour::INK, Align::Start);
        }
        for (at, entry) in &layout.legend {
            draw_legend_entry(canvas, *at, entry);
        }
        for (panel, frame) in figure.panels.iter().zip(&layout.frames) {
            draw_panel(canvas, panel, frame);
        }
        for line in &layout.caption {
            canvas.text(line.at, &line.text, CAPTION_PX, Colour::INK, Align::Start);
        }
    })
}

/// The caption, with what could not be drawn.
fn full_caption(figure: &Figure) -> String {
    // Where things stand does not depend on the caption's text, so a first layout without it finds the points that have no place.
    let Layout { frames, .. } = layout(figure, "");
    let undrawn: usize = figure
        .panels
        .iter()
        .zip(&frames)
        .flat_map(|(panel, frame)| {
            panel
                .series
                .iter()
                .map(move |series| marks::undrawn(frame, &series.marks))
        })
        .sum();
    match undrawn {
        0 => figure.caption.clone(),
        1 => format!(
            "{} 1 point has no place on the axes and is not drawn.",
            figure.caption
        ),
        n => format!(
            "{} {n} points have no place on the axes and are not drawn.",
            figure.caption
        ),
    }
}

fn draw_panel(canvas: &mut Canvas<'_>, panel: &Panel, frame: &Frame) {
    let [left, top, width, height] = frame.area;
    draw_grid(canvas, panel, frame);
    for series in &panel.series {
        marks::draw(canvas, frame, &series.style, &series.marks);
    }
    for series in &panel.series {
        marks::draw_hollow(canvas, frame, &series.style, &series.marks);
    }
    let border = Stroke::new(Colour::GREY, 1.0);
    let corners = [
        [left, top],
        [left + width, top],
        [left + width, top + height],
        [left, top + height],
        [left, top],
    ];
    if panel.bordered {
        canvas.path(&corners, border);
    }
    draw_ticks(canvas, frame);
    draw_names(canvas, panel, frame);
    // A reference line is not data.
    let is_data = |marks: &Marks| {
        !marks.is_empty() && !matches!(marks, Marks::LevelAt(_) | Marks::UprightAt(_))
    };
    if !panel.series.iter().any(|series| is_data(&series.marks)) {
        canvas.text(
            [left + 0.5 * width, top + 0.5 * height],
            "no data",
            LABEL_PX,
            Colour::GREY,
            Align::Middle,
        );
    }
    labels::draw(canvas, panel, frame);
}

fn draw_grid(canvas: &mut Canvas<'_>, panel: &Panel, frame: &Frame) {
    let [left, top, width, height] = frame.area;
    let thin = Stroke::new(Colour::FAINT, 0.8);
    let places = |side: &Side, ruler: &Ruler| -> Vec<f64> {
        let labelled = side.ticks.iter().filter(|tick| !tick.text.is_empty());
        labelled
            .filter_map(|tick| ruler.place(tick.value))
            .collect()
    };
    if panel.x.grid {
        for x in places(&frame.x_side, &frame.x) {
            canvas.line([x, top], [x, top + height], thin);
        }
    }
    if panel.y.grid {
        for y in places(&frame.y_side, &frame.y) {
            canvas.line([left, y], [left + width, y], thin);
        }
    }
}

fn draw_ticks(canvas: &mut Canvas<'_>, frame: &Frame) {
    let [left, top, _, height] = frame.area;
    let bottom = top + height;
    let stroke = Stroke::new(Colour::GREY, 1.0);
    let length = |text: &str| {
        if text.is_empty() {
            0.5 * TICK_LENGTH_PX
        } else {
            TICK_LENGTH_PX
        }
    };
    let half_height = 0.5 * font::CAPITAL_HEIGHT * TICK_PX;
    for tick in &frame.x_side.ticks {
        let Some(x) = frame.x.place(tick.value) else {
            continue;
        };
        canvas.line([x, bottom], [x, bottom + length(&tick.text)], stroke);
        if !frame.x_side.texts {
            continue;
        }
        let below = bottom + TICK_LENGTH_PX + 3.0;
        if frame.x_side.upward {
            let at = [x + half_height, below];
            canvas.text_upward(at, &tick.text, TICK_PX, Colour::INK, Align::End);
        } else {
            let at = [x, below + 2.0 * half_height];
            canvas.text(at, &tick.text, TICK_PX, Colour::INK, Align::Middle);
        }
    }
    for tick in &frame.y_side.ticks {
        let Some(y) = frame.y.place(tick.value) else {
            continue;
        };
        canvas.line([left, y], [left - length(&tick.text), y], stroke);
        if frame.y_side.texts {
            let at = [left - TICK_LENGTH_PX - 3.0, y + half_height];
            canvas.text(at, &tick.text, TICK_PX, Colour::INK, Align::End);
        }
    }
}

/// Heading of the panel and names of its axes.
fn draw_names(canvas: &mut Canvas<'_>, panel: &Panel, frame: &Frame) {
    let [left, top, width, height] = frame.area;
    let middle = [left + 0.5 * width, top + 0.5 * height];
    canvas.text(
        [left, top - 5.0],
        &panel.title,
        fitting_px(&panel.title, width),
        Colour::INK,
        Align::Start,
    );
    let beyond = |side: &Side| TICK_LENGTH_PX + 3.0 + if side.texts { side.depth_px } else { 0.0 };
    if frame.x_side.named {
        let y = top + height + beyond(&frame.x_side) + LABEL_PX * LINE;
        canvas.text(
            [middle[0], y],
            &panel.x.label,
            fitting_px(&panel.x.label, width),
            Colour::INK,
            Align::Middle,
        );
    }
    if frame.y_side.named {
        let x = left - beyond(&frame.y_side) - 6.0;
        canvas.text_upward(
            [x, middle[1]],
            &panel.y.label,
            fitting_px(&panel.y.label, height),
            Colour::INK,
            Align::Middle,
        );
    }
}

/// Size at which the name of an axis or a heading is hardly longer than the axis; both have the same size otherwise.
fn fitting_px(name: &str, length_px: f64) -> f64 {
    let room = length_px + HEADING_PX;
    let wide = font::width_px(name, LABEL_PX);
    LABEL_PX * (room / wide.max(room))
}

fn draw_legend_entry(canvas: &mut Canvas<'_>, [x, y]: [f64; 2], entry: &LegendEntry) {
    let middle = y - 0.5 * font::CAPITAL_HEIGHT * LEGEND_PX;
    // The ground of a support hangs below its node.
    let raised = if entry.style.marker == Marker::Ground {
        5.0
    } else {
        0.0
    };
    let centre = [x + 0.5 * SAMPLE_PX, middle - raised];
    let ends = [[x, middle], [x + SAMPLE_PX, middle]];
    let stroke = Stroke {
        colour: entry.style.colour,
        width_px: entry.style.stroke_px,
        dash_px: entry.style.dash_px,
    };
    match entry.sample {
        LegendMark::Point => marks::draw_marker(canvas, centre, &entry.style, false),
        LegendMark::HollowPoint => marks::draw_marker(canvas, centre, &entry.style, true),
        LegendMark::Line => canvas.path(&ends, stroke),
        LegendMark::PointOnLine => {
            canvas.path(&ends, stroke);
            marks::draw_marker(canvas, centre, &entry.style, false);
        }
        LegendMark::Area => {
            let area = [x + 6.0, middle - 5.0, SAMPLE_PX - 12.0, 10.0];
            canvas.rectangle(area, entry.style.colour);
        }
        LegendMark::Arrow => marks::draw_arrow(canvas, ends[0], ends[1], stroke),
    }
    canvas.text(
        [x + SAMPLE_PX + 6.0, y],
        &entry.label,
        LEGEND_PX,
        Colour::INK,
        Align::Start,
    );
}
